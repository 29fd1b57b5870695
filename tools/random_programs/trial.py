"""One random program through planner, trajectory generator and six joints, without a plant."""

from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Final

import numpy as np

from random_programs.draw import Move, Program
from random_programs.joints import NodeJoints, RefusedError
from rfms_can.arm import Arm
from rfms_can.errors import KinematicsError, MoveError
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
REACHED: Final = 1e-6
"""Rad a joint may be off the angle it was asked for ..."""
HEARD: Final = 4e-6
"""... and a node, which solves T6 of float32 where the wrist is bent by 0.05 or more."""
LONGEST: Final = 60_000
"""Cycles until a program counts as one that never ends."""
TOOL: Final = Transform.translation(0.0, 0.0, 0.1)
REMEDIES: Final = 3
"""Remedies that are taken one after the other for one move."""


@dataclass
class Result:
    """What became of a program.

    Attributes:
        seed: of the program.
        moves: it has.
        accepted: moves that were accepted as they were asked for.
        refused: why the first that was not was refused, or "".
        kind: where that one goes, and how.
        remedies: taken, by what was changed.
        broken: what of the promise was broken, or "".
        speed, acceleration: largest second and first differences over the joints' limits.
        joint: that accelerated most.
        cycles: run.
        lagged: of them, in which a joint lagged behind its path.
    """

    seed: int
    moves: int
    accepted: int = 0
    refused: str = ""
    kind: str = ""
    remedies: dict[str, int] = field(default_factory=dict)
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
    """

    def __init__(self, arm: Arm, program: Program, seed: int) -> None:
        self._program = program
        self._motion = Motion(arm, PERIOD_S, Blend.CONTINUOUS, lambda *_: None)
        self._nodes = NodeJoints(_wire(), arm, program.start, PERIOD_S)
        self._paces: dict[int, float] = {}
        self._tick = 0
        self._bend_limits = np.array(arm.acceleration_limits) * PERIOD_S**2
        self._step_limits = np.array(arm.speed_limits) * PERIOD_S
        self._before = np.array(program.start)
        self._step = np.zeros(6)
        self._remedies: Counter[str] = Counter()
        self._asked: Joints | None = None  # of the last move that was accepted
        self._behind = False  # whether a joint lags behind its path
        self.result = Result(seed, len(program.moves))
        self.setpoints: list[Any] | None = None
        self._motion.enable(program.start)
        self._motion.handle(TransformMessage("tool", TOOL))

    def run(self) -> Result:
        """Run it to its end."""
        result = self.result
        try:
            for number, move in enumerate(self._program.moves):
                if not self._ask(number, move):
                    break
                self._go_on(move)
            self._finish()
        except (RefusedError, AssertionError) as error:
            result.broken = str(error)
        result.remedies = dict(self._remedies)
        result.cycles = self._tick
        return result

    def _ask(self, number: int, move: Move) -> bool:
        """Ask for a move, with the remedies offered where it is refused; whether it was taken."""
        motion, result = self._motion, self.result
        name = self._define(number, move)
        settings = dict(move.mode)
        for attempt in range(REMEDIES + 1):
            mode = f"{name}.{attempt}"
            motion.handle(ModeMessage(name=mode, **settings))
            try:
                motion.handle(MoveRequest(name, mode))
            except (MoveError, KinematicsError) as error:
                remedy = _remedy(error)
                if not result.refused:
                    result.refused = str(error)
                    result.kind = f"{move.kind}, {settings['interpolation']}"
                if attempt and not result.broken:
                    result.broken = f"remedy {dict(self._remedies)} refused: {error}"
                if not remedy:
                    return False
                self._remedies.update(remedy.keys())
                if "wait" in remedy:
                    self._finish()
                settings = _changed(settings, remedy)
            else:
                result.accepted += not attempt
                self._asked = None if move.angles is None else with_straight_wrist(move.angles)
                return True
        return False

    def _define(self, number: int, move: Move) -> str:
        """The position a move goes to; its name."""
        motion = self._motion
        name = f"n{number}"
        if move.angles is not None:
            motion.handle(JointPositionMessage(name, move.angles))
            return name
        target = move.target @ TOOL
        motion.handle(TransformMessage(f"at {name}", target))
        right = [f"at {name}"]
        if move.function is not None:
            unit = Transform.identity()
            motion.handle(
                TransformMessage(f"by {name}", unit, "functional", function=move.function)
            )
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
        if self._asked is None or self.result.broken:
            return
        rests = [("commanded", self._motion.commanded.theta, REACHED)]
        if not self._behind:
            rests.append(("solved by the nodes", _joints(self._before), HEARD))
        for what, theta, bound in rests:
            off = np.abs(np.subtract(theta, self._asked))
            if off.max() > bound:
                joint = int(off.argmax())
                raise RefusedError(
                    f"joint {joint + 1} rests at {theta[joint]:.9g} rad ({what}), and "
                    f"{self._asked[joint]:.9g} rad was asked for"
                )

    def step(self) -> None:
        """One cycle."""
        motion, result = self._motion, self.result
        if self._tick in self._paces:
            rate = self._paces[self._tick]
            motion.handle(FeedRequest(rate) if rate else PauseRequest())
            if rate and motion.generator.paused:
                motion.handle(ResumeRequest())
        setpoint = motion.next_setpoint()
        if self.setpoints is not None:
            self.setpoints.append(setpoint)
        if motion.stopped_short is not None and not result.broken:
            result.broken = motion.stopped_short
        told, displacement = motion.commanded.told, motion.displaced(None)
        theta = np.array(self._nodes.take(setpoint, told, displacement, self._tick))
        self._behind = displacement is not None
        result.lagged += self._behind
        step = theta - self._before
        bends = np.abs(step - self._step) / self._bend_limits
        if not self._tick:  # its pose is where the arm stands, but for rounding
            bends[:] = 0.0
        result.speed = max(result.speed, float((np.abs(step) / self._step_limits).max()))
        if bends.max() > result.acceleration:
            result.acceleration = float(bends.max())
            result.joint = int(bends.argmax()) + 1
        self._before, self._step = theta, step
        self._tick += 1


def _joints(values: Any) -> Joints:
    q1, q2, q3, q4, q5, q6 = (float(value) for value in values)
    return (q1, q2, q3, q4, q5, q6)


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
