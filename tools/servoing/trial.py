"""One servoing run: world model, trajectory generator and six joints, without a plant."""

import math
from functools import cache
from typing import Final, NamedTuple

from random_programs.joints import NodeJoints, RefusedError
from random_programs.judge import Judge

from rfms_can.arm import Arm
from rfms_can.errors import ProgramError, TrackingError
from rfms_can.kinematics import direct
from rfms_can.master.motion import Motion
from rfms_can.messages import ModeMessage, MoveRequest, PositionMessage, TransformMessage
from rfms_can.messages.world import Predict
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.vocabulary import Blend
from servoing.scene import RUN_S, Scene

PERIOD_S: Final = 0.004
AGAIN_S: Final = 0.5
"""After which a program that heard that the arm stopped short asks for its move again."""


class Result(NamedTuple):
    """What became of a run.

    Attributes:
        arm, seed, kind, predict, rate, noise, jitter: the run.
        fault: what a joint would have stopped for, or what else went wrong; "" if nothing.
        short: how often the arm stopped short.
        speed, acceleration: largest first and second differences over the joints' limits.
        joint: that accelerated most.
        off: of a part that stands still, how far the commanded hand is from it in the two seconds
            after the last observation, m; None of others, and where the arm stopped short.
        lagged: cycles in which a joint lagged behind.
    """

    arm: str
    seed: int
    kind: str
    predict: str
    rate: int
    noise: float
    jitter: float
    fault: str
    short: int
    speed: float
    acceleration: float
    joint: int
    off: float | None
    lagged: int


@cache
def _wire() -> Wire:
    return Wire()


class Servoing:
    """Runs a scene.

    Args:
        arm: the arm.
        scene: to run.
        seed: of it.
    """

    def __init__(self, arm: Arm, scene: Scene, seed: int) -> None:
        self._arm = arm
        self._scene = scene
        self._seed = seed
        self._motion = Motion(arm, PERIOD_S, Blend.CONTINUOUS, lambda *_: None)
        self._nodes = NodeJoints(_wire(), arm, scene.start, PERIOD_S)
        self._judge = Judge(arm, scene.start, PERIOD_S)
        self._pose = direct(arm, scene.start)
        self._short = self._lagged = 0
        self._ask_at: int | None = 0
        self._off = 0.0
        motion = self._motion
        motion.enable(scene.start)
        self._see(self._pose, 0.0)
        motion.handle(PositionMessage("part", ["t6"], ["part"]))
        motion.handle(ModeMessage("follow", "cartesian", 0.15, 0.5))
        motion.handle(ModeMessage("again", "joint", 0.3, 1.0, lengthen=True))

    def run(self) -> Result:
        """Run it to its end."""
        scene, fault = self._scene, ""
        waiting = iter(scene.observations)
        upcoming = next(waiting, None)
        last = scene.observations[-1][0] if scene.observations else 0.0
        try:
            for tick in range(round(max(RUN_S, last + 2.0) / PERIOD_S)):
                now = tick * PERIOD_S
                while upcoming is not None and upcoming[0] <= now:
                    self._see(upcoming[2], upcoming[1])
                    upcoming = next(waiting, None)
                if self._ask_at is not None and tick >= self._ask_at:
                    self._ask(tick)
                self._step(now, now > last)
        except (RefusedError, AssertionError) as error:
            fault = str(error) or type(error).__name__
        judge = self._judge
        still = scene.kind == "still" and not self._short
        return Result(
            *(self._arm.name, self._seed, scene.kind, scene.predict, scene.rate, scene.noise),
            *(scene.jitter, fault, self._short, round(judge.speed, 4)),
            *(round(judge.acceleration, 4), judge.joint, self._off if still else None),
            lagged=self._lagged,
        )

    def _see(self, pose: Transform, taken: float) -> None:
        """One observation; a program hears with it that the arm has stopped short."""
        predict: Predict = "hold" if self._scene.predict == "hold" else "velocity"
        message = TransformMessage("part", pose, "reference", predict=predict, stamp=taken)
        try:
            self._motion.handle(message)
        except TrackingError:
            self._note_short()

    def _note_short(self) -> None:
        self._short += 1
        self._ask_at = self._motion.generator.tick_count + round(AGAIN_S / PERIOD_S)

    def _ask(self, tick: int) -> None:
        """Move to the part, first as it stands; a refusal is asked again later."""
        self._ask_at = None
        try:
            self._motion.handle(MoveRequest("part", "again" if self._short else "follow"))
        except TrackingError:
            self._note_short()
        except ProgramError:
            self._ask_at = tick + round(AGAIN_S / PERIOD_S)

    def _step(self, now: float, silent: bool) -> None:
        """One cycle."""
        motion = self._motion
        outcomes = motion.generator.outcomes
        setpoint = motion.next_setpoint()
        told, displacement = motion.commanded.told, motion.following.displaced(None)
        self._lagged += displacement is not None
        angles = self._nodes.take(setpoint, told, displacement, 0)
        self._judge.take(angles)
        if motion.stopped_short is not None and outcomes.completed:
            last = outcomes.of(outcomes.completed, outcomes.completed)[0]
            if last.how.value == "stopped short" and self._ask_at is None and motion.at_rest:
                self._note_short()
                motion.stopped_short = None
        if silent:
            q1, q2, q3, q4, q5, q6 = angles
            hand = direct(self._arm, (q1, q2, q3, q4, q5, q6))
            pose = self._pose @ self._scene.path(now)
            distance = math.dist((hand.px, hand.py, hand.pz), (pose.px, pose.py, pose.pz))
            self._off = max(self._off, distance)
