"""What is done about a move that breaks a limit: another time, or a refusal that names one.

What a refusal offers has been tried: taken, the same planner accepts it.
"""

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.master.trajectory.planning.limits import Excess
from rfms_can.master.trajectory.planning.search import Outcome, Trial
from rfms_can.master.trajectory.planning.times import LONGEST_S

REFINED: Final = 6
"""How often the gap between an acceleration time that does not do and one that does is halved."""

DIGITS: Final = 6
"""Of a time in a message: taken up from there it must give the same periods."""


class Remedy(NamedTuple):
    """What would do instead.

    Attributes:
        words: of the refusal.
        change: of the mode, by its names; ``wait`` is the move to wait for.
    """

    words: str
    change: dict[str, Any]


class Alternative(NamedTuple):
    """Something else that may be tried.

    Attributes:
        remedy: what it is.
        attempt: plans it; raises as planning does.
    """

    remedy: Remedy
    attempt: Callable[[], object]


def refused(message: str, change: dict[str, Any]) -> MoveError:
    """The refusal of a move that says which change of its mode would do."""
    error = MoveError(message)
    error.remedy = change
    return error


def mended(trial: Trial, excess: Excess, *, lengthen: bool, at_most: float) -> Outcome:
    """The outcome with a longer segment time, where the mode allows it.

    Where no segment time helps, what breaks is the transition from the segment before, which is
    promised already: its speed must change within too short an acceleration time.

    Args:
        trial: the move as its mode has it.
        excess: the limit it breaks.
        lengthen: whether its segment may be lengthened.
        at_most: by which factor.

    Raises:
        MoveError: it may not, by so much, or no segment time helps; the message has the time that
            would do.
    """
    tau = trial.frame.period_s
    longest = round(LONGEST_S / tau)
    slowed = trial.slowed(excess, longest)
    segment_time = trial.base.segment_time
    what = f"move {trial.base.segment.move.sequence}: {excess.what}"
    if slowed is not None:
        return _slowed(what, segment_time, slowed, lengthen=lengthen, at_most=at_most)
    before = trial.departed.segment
    eased = trial.eased(excess, longest, longest if before.rests else before.move.room)
    if eased is None:
        raise MoveError(f"{what}, and no segment time helps")
    eased = _gentlest(trial, eased)
    change = {"acceleration_time": told(eased.base.acceleration_time)}
    along = ""
    if eased.base.segment_time > segment_time:
        change["segment_time"] = told(eased.base.segment_time)
        along = f", with a segment of {eased.base.segment_time:.{DIGITS}g} s"
    words = (
        f"{what}, and no segment time helps: accelerate in "
        f"{eased.base.acceleration_time:.{DIGITS}g} s instead of "
        f"{trial.base.acceleration_time:.{DIGITS}g} s{along}"
    )
    raise refused(words, change)


def instead(
    error: MoveError | KinematicsError, alternatives: list[Alternative]
) -> MoveError | KinematicsError:
    """The refusal ``error``, with the first of some alternatives that can be made.

    One that has its remedy keeps it.
    """
    if error.remedy:
        return error
    further: list[Remedy] = []
    for remedy, attempt in alternatives:
        try:
            attempt()
        except (MoveError, KinematicsError) as other:
            if other.remedy:
                changes = ", ".join(f"{name}={value!r}" for name, value in other.remedy.items())
                words = f"{remedy.words}, with {changes}"
                further.append(Remedy(words, {**remedy.change, **other.remedy}))
        else:
            return _with(error, remedy)
    if further:
        return _with(error, further[0])
    return _with(error, Remedy("place position or path elsewhere", {}))


def _with(error: MoveError | KinematicsError, remedy: Remedy) -> MoveError | KinematicsError:
    """The refusal, with a way out."""
    better = type(error)(f"{error}: {remedy.words}")
    better.remedy = remedy.change
    return better


def _slowed(
    what: str, segment_time: float, slowed: Outcome, *, lengthen: bool, at_most: float
) -> Outcome:
    """What is slow enough, if the mode allows it."""
    needed = slowed.base.segment_time
    if not lengthen:
        words = (
            f"{what}: give the segment at least {needed:.{DIGITS}g} s instead of "
            f"{segment_time:.{DIGITS}g} s"
        )
        raise refused(words, {"segment_time": told(needed)})
    if needed > at_most * segment_time:
        factor = factor_for(needed, segment_time)
        words = (
            f"{what}: it would take {needed:.{DIGITS}g} s instead of {segment_time:.{DIGITS}g} s, "
            f"and the mode lengthens {at_most:g} times at most: ask for that time, or "
            f"lengthen_at_most={factor:g}"
        )
        raise refused(words, {"lengthen_at_most": factor})
    return slowed


def _gentlest(trial: Trial, eased: Outcome) -> Outcome:
    """Nearly the shortest acceleration time that does, with the segment time found for it."""
    low, high = trial.times.acceleration, eased.base.segment.move.acceleration_ticks
    segment = eased.base.segment.move.segment_ticks
    for _ in range(REFINED):
        middle = (low + high) // 2
        if middle in (low, high):
            break
        least = max(trial.times.segment, trial.least(middle))
        outcome = trial.attempt(least, middle) or trial.attempt(segment, middle)
        if outcome is None:
            low = middle
        else:
            eased, high = outcome, middle
            segment = outcome.base.segment.move.segment_ticks
    return eased


def factor_for(needed: float, given: float) -> float:
    """What ``lengthen_at_most`` must be, for a time needed instead of the one given, s."""
    return math.ceil(10.0 * needed / given) / 10.0


def told(seconds: float) -> float:
    """A time as a message has it."""
    return float(f"{seconds:.{DIGITS}g}")
