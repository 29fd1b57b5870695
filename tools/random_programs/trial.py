"""One random program through planner, trajectory generator and six joints, without a plant."""

from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from random_programs.draw import Move, Program
from random_programs.fine import Case, evidence
from random_programs.joints import NodeJoints, RefusedError
from random_programs.judge import Judge
from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, MoveError, TrackingError
from rfms_can.kinematics import Joints
from rfms_can.master.motion import Motion
from rfms_can.master.trajectory.planning import with_straight_wrist
from rfms_can.messages import (
    FeedRequest,
    JointPositionMessage,
    ModeMessage,
    MoveRequest,
    PauseRequest,
    PositionMessage,
    ResumeRequest,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Blend

PERIOD_S: Final = 0.004
PAUSE_TICKS: Final = 250
REACHED: Final = 4e-6
"""Largest distance of a joint from the angle it was asked for, rad, at rest: what a pose of float32
leaves of it where the wrist is just not near enough for joints to be told their angles."""
LONGEST: Final = 150_000
"""Cycles until a program counts as one that never ends."""
TOOL: Final = Transform.translation(0.0, 0.0, 0.1)
REMEDIES: Final = 3
"""Remedies that are taken one after the other for one move."""


class Result(NamedTuple):
    """What became of a program.

    Attributes:
        arm: its name.
        seed: of the program.
        moves: it has.
        accepted: moves that were accepted as they were asked for.
        refused: why the first that was not was refused, or "".
        kind: where that one goes, and how.
        remedies: taken: what was changed.
        broken: what of the promise was broken, or "".
        speed, acceleration: largest second and first differences over the joints' limits.
        joint: that accelerated most.
        cycles: run.
        lagged: of them, in which a joint lagged behind its path.
    """

    arm: str
    seed: int
    moves: int
    accepted: int = 0
    refused: str = ""
    kind: str = ""
    remedies: tuple[str, ...] = ()
    broken: str = ""
    speed: float = 0.0
    acceleration: float = 0.0
    joint: int = 0
    cycles: int = 0
    lagged: int = 0


@cache
def _wire() -> Wire:
    return Wire()


class Trial:
    """Runs a program.

    Args:
        arm: the arm.
        program: to run.
        seed: of it.
        looks: whether to look if the first refusal was due.

    Attributes:
        case: the first refusal.
        due: why it was due, if that was looked at; None if it was not due.
    """

    def __init__(self, arm: Arm, program: Program, seed: int, *, looks: bool = False) -> None:
        self.looks = looks
        self.case: Case | None = None
        self.due: str | None = None
        self._arm = arm
        self._program = program
        self._seed = seed
        self._motion = Motion(arm, PERIOD_S, Blend.CONTINUOUS, lambda *_: None)
        self._nodes = NodeJoints(_wire(), arm, program.start, PERIOD_S)
        self._paces: dict[int, float] = {}
        self._tick = 0
        self._judge = Judge(arm, program.start, PERIOD_S)
        self._accepted = self._lagged = 0
        self._refused = self._kind = self._broken = ""
        self._remedies: list[str] = []
        self._asked: Joints | None = None  # of the last move that was accepted
        self._behind = False  # whether a joint lags behind its path
        self._motion.enable(program.start)
        self._motion.handle(TransformMessage("tool", TOOL))

    def run(self) -> Result:
        """Run it to its end."""
        try:
            for number, move in enumerate(self._program.moves):
                if not self._ask(number, move):
                    break
                self._go_on(move)
            self._finish()
        except (RefusedError, TrackingError, AssertionError) as error:
            self._broken = self._broken or str(error)
        judge = self._judge
        return Result(
            *(self._arm.name, self._seed, len(self._program.moves), self._accepted),
            *(self._refused, self._kind, tuple(self._remedies), self._broken),
            *(judge.speed, judge.acceleration),
            *(judge.joint, self._tick, self._lagged),
        )

    def _ask(self, number: int, move: Move) -> bool:
        """Ask for a move, with the remedies offered where it is refused; whether it was taken."""
        motion = self._motion
        name = self._define(number, move)
        settings = dict(move.mode)
        for attempt in range(REMEDIES + 1):
            mode = f"{name}.{attempt}"
            motion.handle(ModeMessage(name=mode, **settings))
            try:
                motion.handle(MoveRequest(name, mode))
            except (MoveError, KinematicsError) as error:
                remedy = _remedy(error)
                kind = f"{move.kind}, {settings['interpolation']}"
                self._note_refusal(error, kind, name, mode)
                if attempt and not self._broken:
                    self._broken = f"remedies {self._remedies} taken, and refused: {error}"
                if not remedy:
                    return False
                self._remedies += remedy
                if "wait" in remedy:
                    self._finish()
                settings = _changed(settings, remedy)
            else:
                self._accepted += not attempt
                self._asked = None if move.angles is None else with_straight_wrist(move.angles)
                return True
        return False

    def _note_refusal(self, error: Exception, kind: str, name: str, mode: str) -> None:
        """The first refusal, with all that is needed to look whether it was due."""
        if self._refused:
            return
        self._refused, self._kind = str(error), kind
        motion = self._motion
        generator, world = motion.generator, motion.world
        self.case = Case(str(error), generator.entry, world.position(name), world.mode(mode))
        if self.looks:
            self.due = evidence(self._arm, motion.planner, self.case, PERIOD_S)

    def _define(self, number: int, move: Move) -> str:
        """The position a move goes to; its name."""
        motion = self._motion
        name = f"n{number}"
        if move.angles is not None:
            motion.handle(JointPositionMessage(name, move.angles))
            return name
        motion.handle(TransformMessage(f"at {name}", move.target @ TOOL))
        right = [f"at {name}"]
        if move.function is not None:
            by = Transform.identity()
            motion.handle(TransformMessage(f"by {name}", by, "functional", function=move.function))
            right.append(f"by {name}")
        motion.handle(
            PositionMessage(name, ["t6", "tool"], right, "tool", configuration=move.configuration)
        )
        return name

    def _go_on(self, move: Move) -> None:
        if move.pace is not None:
            after, rate = move.pace
            self._paces[self._tick + after] = rate
            if not rate:
                self._paces[self._tick + after + PAUSE_TICKS] = 1.0
        if move.waits:
            self._finish()
        else:
            for _ in range(move.after):
                self.step()

    def _finish(self) -> None:
        """Run until the arm is at rest and nothing is to come."""
        for _ in range(LONGEST):
            if self._motion.at_rest and not any(k >= self._tick for k in self._paces):
                self._check_reached()
                return
            self.step()
        raise RefusedError(f"not at rest after {LONGEST} cycles")

    def _check_reached(self) -> None:
        """The arm rests at the joint angles it was asked for last, if it was."""
        if self._asked is None or self._broken or self._behind:
            return
        theta = self._motion.commanded.theta
        off = np.abs(np.subtract(theta, self._asked))
        if off.max() > REACHED:
            joint = int(off.argmax())
            raise RefusedError(
                f"joint {joint + 1} rests at {theta[joint]:.9g} rad, and "
                f"{self._asked[joint]:.9g} rad was asked for"
            )

    def step(self) -> None:
        """One cycle."""
        motion = self._motion
        if self._tick in self._paces:
            rate = self._paces[self._tick]
            motion.handle(FeedRequest(rate) if rate else PauseRequest())
            if rate and motion.generator.paused:
                motion.handle(ResumeRequest())
        setpoint = motion.next_setpoint()
        if motion.stopped_short is not None:
            self._broken = self._broken or f"stopped short: {motion.stopped_short}"
        told, displacement = motion.commanded.told, motion.following.displaced(None)
        self._behind = displacement is not None
        self._lagged += self._behind
        angles = self._nodes.take(setpoint, told, displacement, self._tick)
        if not self._behind and tuple(angles) != motion.commanded.theta:
            raise RefusedError(f"the joints are not where the master has them at {self._tick}")
        self._judge.take(angles)
        self._tick += 1


def _changed(settings: dict[str, Any], remedy: dict[str, Any]) -> dict[str, Any]:
    """The settings of a mode as a refusal asks for them."""
    changed = {**settings, **{k: v for k, v in remedy.items() if k != "wait"}}
    if "segment_time" in remedy:
        for speed in ("speed", "angular_speed", "joint_speed"):
            changed.pop(speed, None)
    return changed


def _remedy(error: Exception) -> dict[str, Any]:
    """What a refusal offers; its cause has it where the name of the move was put before."""
    cause: BaseException | None = error
    while cause is not None:
        remedy = getattr(cause, "remedy", {})
        if remedy:
            return dict(remedy)
        cause = cause.__cause__
    return {}
