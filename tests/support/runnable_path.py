"""Whether the joints can follow a move at all, for programs drawn at random; no plan is made."""

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError
from rfms_can.kinematics import InverseKinematics, Joints
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move, Segment
from rfms_can.wire.vocabulary import Mode

SAMPLES = 24

_solve = InverseKinematics(PUMA_260).solve


def is_runnable(before: Move, move: Move, q: Joints, period_s: float, tick: int = 0) -> bool:
    """Whether the path of ``move``, from the goal of ``before`` at angles near ``q``, has solutions
    that the joints' speeds allow."""
    origin = before.target.pose(Moment(tick))
    segment = Segment.towards(move, origin, Moment(tick, 0.0))
    samples = 1 if move.mode is Mode.JOINT else SAMPLES
    duration = move.segment_ticks * period_s / samples
    try:
        q = _solve(origin, before.configuration, q)
        for sample in range(1, samples + 1):
            h = sample / samples
            ahead = _solve(segment.pose(Moment(tick, h), 1.0 - h), move.configuration, q)
            turns = (abs(b - a) / duration for a, b in zip(q, ahead, strict=True))
            if any(
                speed > limit for speed, limit in zip(turns, PUMA_260.speed_limits, strict=True)
            ):
                return False
            q = ahead
    except KinematicsError:
        return False
    return True
