"""What a refusal tries before it offers it: the same move, with one thing about it changed."""

from collections.abc import Callable
from typing import Any, Final

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.planning.remedy import Alternative, Remedy
from rfms_can.master.trajectory.planning.times import PlannedMode
from rfms_can.master.trajectory.segment import Segment, Transition
from rfms_can.wire.vocabulary import Mode


class ChangedMode:
    """As another mode, but for its interpolation, acceleration time, transition or configuration.

    Attributes:
        mode, acceleration_time, transition: as changed; in joint mode the transition is one of the
            joints.
        segment_time, speed, angular_speed, joint_speed, lengthen, lengthen_at_most, deviation,
            configuration: of the other; no configuration unless ``configured``.
    """

    def __init__(
        self,
        other: PlannedMode,
        mode: Mode,
        acceleration_time: float | None = None,
        transition: Transition | None = None,
        *,
        configured: bool = True,
    ) -> None:
        self.mode: Final = mode
        self.acceleration_time: Final = acceleration_time or other.acceleration_time
        in_joints = mode is Mode.JOINT
        self.transition: Final = Transition.JOINT if in_joints else transition or other.transition
        self.segment_time: Final = other.segment_time
        self.speed: Final = other.speed
        self.angular_speed: Final = other.angular_speed
        self.joint_speed: Final = other.joint_speed
        self.lengthen: Final = other.lengthen
        self.lengthen_at_most: Final = other.lengthen_at_most
        self.deviation: Final = other.deviation
        self.configuration: Final[Configuration | None] = (
            other.configuration if configured else None
        )


Attempt = Callable[[Segment, PlannedMode], object]
"""Plans the move after a segment with a mode; raises as planning does."""


def alternatives(
    before: Segment, mode: PlannedMode, period_s: float, attempt: Attempt
) -> list[Alternative]:
    """What may be tried instead of a move that is refused, the least change first.

    Args:
        before: the segment it was to follow.
        mode: as asked for.
        period_s: tau, s.
        attempt: plans the same move otherwise.
    """

    def after(changed: PlannedMode, segment: Segment = before) -> Callable[[], object]:
        return lambda: attempt(segment, changed)

    others: list[Alternative] = []

    def may(words: str, change: dict[str, Any], trial: Callable[[], object]) -> None:
        others.append(Alternative(Remedy(words, change), trial))

    if not before.rests:
        number = before.move.sequence
        rested = after(mode, before.to_rest())
        may(f"wait until move {number} is complete", {"wait": number}, rested)
    if mode.transition is Transition.CARTESIAN:
        blended = after(ChangedMode(mode, mode.mode, transition=Transition.JOINT))
        may("use a joint transition", {"transition": "joint"}, blended)
    if mode.mode is Mode.CARTESIAN:
        in_joints = after(ChangedMode(mode, Mode.JOINT))
        may("move in joint mode", {"interpolation": "joint", "transition": "joint"}, in_joints)
    if mode.configuration is not None:
        free = after(ChangedMode(mode, mode.mode, configured=False))
        may("leave the configuration to the position", {"config": None}, free)
    half = mode.acceleration_time / 2.0
    if half >= 2.0 * period_s:
        sooner = after(ChangedMode(mode, mode.mode, half))
        may(f"accelerate in {half:.6g} s", {"acceleration_time": half}, sooner)
    return others
