"""What a refusal tries before it offers it: the same move, with one thing about it changed."""

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple, Self

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.planning.remedy import Remedy, told
from rfms_can.master.trajectory.planning.times import LONGEST_S, PlannedMode
from rfms_can.master.trajectory.segment import Segment, Transition
from rfms_can.messages import FARTHEST_CORNER
from rfms_can.wire.vocabulary import Mode

MOST: Final = {
    "segment_time": LONGEST_S,
    "acceleration_time": LONGEST_S,
    "deviation": FARTHEST_CORNER,
}
"""What a mode can have at most of what a refusal offers, s and m."""


class ChangedMode(NamedTuple):
    """A mode as a refusal would have it; its attributes are those of ``PlannedMode``."""

    mode: Mode
    acceleration_time: float
    segment_time: float | None
    speed: float | None
    angular_speed: float | None
    joint_speed: float | None
    lengthen: bool
    lengthen_at_most: float
    transition: Transition
    deviation: float | None
    configuration: Configuration | None

    @classmethod
    def of(cls, mode: PlannedMode, change: Mapping[str, Any]) -> Self:
        """A mode with what a program would change of it, by the names of its settings.

        A segment time takes the place of the speeds. ``wait`` changes nothing of the mode.

        Raises:
            MoveError: a mode cannot have so much.
        """
        for name in MOST.keys() & change.keys():
            if change[name] > MOST[name]:
                raise MoveError(f"that is over {MOST[name]:g}, the most of a mode")
        changed = cls(*(getattr(mode, name) for name in cls._fields))
        for name, value in change.items():
            changed = changed._replace(**_CHANGES[name](value))
        return changed


_CHANGES: Final[dict[str, Callable[[Any], dict[str, Any]]]] = {
    "interpolation": lambda word: {"mode": Mode[word.upper()]},
    "transition": lambda word: {"transition": Transition[word.upper()]},
    "config": lambda _: {"configuration": None},
    "acceleration_time": lambda time: {"acceleration_time": time},
    "segment_time": lambda time: {
        **{"segment_time": time, "speed": None, "angular_speed": None, "joint_speed": None},
    },
    "lengthen_at_most": lambda factor: {"lengthen_at_most": factor},
    "deviation": lambda distance: {"deviation": distance},
    "wait": lambda _: {},
}
"""What each setting in an offer is in a mode that is planned."""


def alternatives(before: Segment, mode: PlannedMode, period_s: float) -> list[Remedy]:
    """What may be tried instead of a move that is refused, the least change first.

    Args:
        before: the segment it was to follow.
        mode: as asked for.
        period_s: tau, s.
    """
    others: list[Remedy] = []
    if not before.rests:
        number = before.move.sequence
        others.append(Remedy(f"wait until move {number} is complete", {"wait": number}))
    if mode.transition is Transition.CARTESIAN:
        others.append(Remedy("use a joint transition", {"transition": "joint"}))
    if mode.mode is Mode.CARTESIAN:
        in_joints = {"interpolation": "joint", "transition": "joint"}
        others.append(Remedy("move in joint mode", in_joints))
    if mode.configuration is not None:
        others.append(Remedy("leave the configuration to the position", {"config": None}))
    half = told(mode.acceleration_time / 2.0)
    if half >= 2.0 * period_s:
        others.append(Remedy(f"accelerate in {half:g} s", {"acceleration_time": half}))
    return others
