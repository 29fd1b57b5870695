"""How long a segment takes: as its mode says, or as its speeds ask for."""

import math
from collections.abc import Sequence
from typing import Final, Protocol

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.segment import Transition, whole_ticks
from rfms_can.transform import DriveTransform
from rfms_can.wire.vocabulary import Mode

LONGEST_S: Final = 100.0
"""What a mode can say of a segment time, s."""

_ROUNDING: Final = 1e-6
"""Part of a period by which a time may be longer than whole periods."""


class PlannedMode(Protocol):
    """How a segment is to be moved: what planning asks of a mode. Times in s."""

    @property
    def mode(self) -> Mode:
        """Straight in joint angles or in space."""

    @property
    def acceleration_time(self) -> float:
        """t_acc."""

    @property
    def segment_time(self) -> float | None:
        """t_seg; from the speeds, if None."""

    @property
    def speed(self) -> float | None:
        """Of the tool from goal to goal, m/s."""

    @property
    def angular_speed(self) -> float | None:
        """Of the tool from goal to goal, rad/s."""

    @property
    def joint_speed(self) -> float | None:
        """Part of the joints' speed limits."""

    @property
    def lengthen(self) -> bool:
        """Whether a segment that breaks a limit is lengthened; refused otherwise."""

    @property
    def lengthen_at_most(self) -> float:
        """By which factor."""

    @property
    def transition(self) -> Transition:
        """How the segment is entered."""

    @property
    def deviation(self) -> float | None:
        """Largest distance of the tool from the position it passes, m; by t_acc, if None."""

    @property
    def configuration(self) -> Configuration | None:
        """Instead of the position's."""


def least_ticks(acceleration_ticks: int) -> int:
    """What a segment needs for its transitions, in and to rest, periods."""
    return 2 * acceleration_ticks + 2


def segment_ticks(
    mode: PlannedMode,
    drive: DriveTransform,
    turns: Sequence[float],
    speed_limits: Sequence[float],
    period_s: float,
) -> int:
    """Segment time in periods: as given, or the longest any speed asks for, rounded up.

    Args:
        mode: of the move.
        drive: from goal to goal: how far the tool travels and turns.
        turns: how far each joint turns, rad.
        speed_limits: of the joints, rad/s.
        period_s: tau, s.

    Raises:
        MoveError: a given time is not positive; or the speeds need more than 100 s.
    """
    if mode.segment_time is not None:
        return whole_ticks(mode.segment_time, period_s)
    times = [0.0]
    if mode.speed is not None:
        times.append(math.hypot(*drive.p) / mode.speed)
    if mode.angular_speed is not None:
        times.append(drive.psi / mode.angular_speed)
    if mode.joint_speed is not None:
        times += (
            abs(turn) / (limit * mode.joint_speed)
            for turn, limit in zip(turns, speed_limits, strict=True)
        )
    longest = max(times)
    if not longest <= LONGEST_S:
        raise MoveError(
            f"the speeds given ask for a segment of {longest:.4g} s, over {LONGEST_S:g} s: "
            f"move faster, or in several moves"
        )
    ticks = math.ceil(longest / period_s - _ROUNDING)
    return max(ticks, least_ticks(whole_ticks(mode.acceleration_time, period_s)))
