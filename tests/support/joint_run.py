"""Moves to joint angles: a program whose set-points six joints hear as their nodes do."""

import itertools
from collections.abc import Sequence

from pytest import approx
from random_programs.joints import NodeJoints

from rfms_can.arm import PUMA_260, Arm
from rfms_can.kinematics import Joints, direct
from rfms_can.messages import ModeMessage, TransformMessage
from rfms_can.wire.contract import Wire
from support.motion import PERIOD_S, Program
from support.trajectory import REST

REACHED = 1e-6
"""Rad the commanded trajectory may be off the angles asked for; it ends on their turns."""
HEARD = 4e-6
"""Rad a node may be off: it solves T6 of float32 where the wrist is bent by 0.05 or more."""
TOLD = 5e-7
"""Rad where it is told its angles: float32 of them."""
STRAIGHT = 1e-5
"""Rad of theta5 within which a wrist is taken as straight."""


def at(q: Sequence[float], **joints: float) -> Joints:
    """``q``, with joints by name (``j1`` to ``j6``) elsewhere, rad."""
    q1, q2, q3, q4, q5, q6 = (joints.get(f"j{k}", angle) for k, angle in enumerate(q, 1))
    return (q1, q2, q3, q4, q5, q6)


def by(q: Joints, **joints: float) -> Joints:
    """``q``, with joints by name moved by so much, rad."""
    return at(q, **{name: q[int(name[1]) - 1] + angle for name, angle in joints.items()})


class Run(Program):
    """A program whose set-points six joints hear as their nodes do."""

    def __init__(self, wire: Wire, start: Sequence[float] = REST, arm: Arm = PUMA_260) -> None:
        super().__init__(arm, start)
        q1, q2, q3, q4, q5, q6 = start
        self._nodes = NodeJoints(wire, arm, (q1, q2, q3, q4, q5, q6), PERIOD_S)
        self._cycle = itertools.count()
        self._names = itertools.count()
        self.heard: list[float] = []
        self.modes = {
            "joint": self.mode_of("joint", "joint", joint_speed=0.8),
            "line": self.mode_of("line", "cartesian", speed=0.1),
            "curve": self.mode_of("curve", "cartesian", speed=0.1, transition="cartesian"),
        }

    def mode_of(self, name: str, interpolation: str, **more: object) -> str:
        settings: dict[str, object] = {"lengthen": True, "lengthen_at_most": 1e3, **more}
        message = ModeMessage(name, interpolation, 0.2, **settings)  # type: ignore[arg-type]
        self.motion.handle(message)
        return name

    def equation(self, name: str, angles: Joints) -> None:
        """A position by the equation of the T6 that joint angles have."""
        self.motion.handle(TransformMessage(name, direct(PUMA_260, angles)))
        self.position(name, name)

    def go(self, angles: Joints, mode: str = "joint", cycles: int | None = None) -> None:
        """Ask for a move to joint angles; run to its end, or so many cycles."""
        name = f"angles {next(self._names)}"
        self.joint_position(name, angles)
        self.move(name, mode)
        self.listen(cycles)

    def listen(self, cycles: int | None = None) -> None:
        """Run so many cycles, or until the arm rests."""
        for _ in itertools.count() if cycles is None else range(cycles):
            if cycles is None and self.motion.at_rest:
                break
            self.run(1)
            told, behind = self.motion.commanded.told, self.motion.following.displaced(None)
            self.heard = self._nodes.take(self.setpoints[-1], told, behind, next(self._cycle))

    def has_reached(self, angles: Joints) -> None:
        """Assert that the arm rests there: as commanded, and as the nodes have it."""
        commanded = self.motion.commanded
        assert commanded.theta == approx(angles, abs=REACHED, rel=0.0)
        bound = HEARD if commanded.told is None else REACHED + TOLD
        assert self.heard == approx(angles, abs=bound, rel=0.0)
