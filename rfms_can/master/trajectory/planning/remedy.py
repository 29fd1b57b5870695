"""What is done about a move that breaks a limit: another time, or a refusal that names one."""

import math
from typing import Any, Final, NamedTuple

from rfms_can.errors import MoveError
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
        change: of the mode, by the names of its settings; ``wait`` is the move to wait for.
    """

    words: str
    change: dict[str, Any]


class RefusedError(MoveError):
    """A refusal that knows what should do instead.

    Attributes:
        fault: what is wrong, in words.
        offers: what should do: each alone, and the best first. They are tried before a program is
            told (``refusal.py``).
    """

    def __init__(self, fault: str, *offers: Remedy) -> None:
        super().__init__(f"{fault}: {', or '.join(offer.words for offer in offers)}")
        self.fault = fault
        self.offers = offers


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
        RefusedError: it may not, or not by so much; or another acceleration time would do.
        MoveError: no time helps.
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
        f"accelerate in {eased.base.acceleration_time:.{DIGITS}g} s instead of "
        f"{trial.base.acceleration_time:.{DIGITS}g} s{along}"
    )
    raise RefusedError(f"{what}, and no segment time helps", Remedy(words, change))


def _slowed(
    what: str, segment_time: float, slowed: Outcome, *, lengthen: bool, at_most: float
) -> Outcome:
    """What is slow enough, if the mode allows it."""
    needed = slowed.base.segment_time
    if not lengthen:
        raise RefusedError(what, longer(needed, segment_time))
    if needed > at_most * segment_time:
        fault = (
            f"{what}: it would take {needed:.{DIGITS}g} s instead of {segment_time:.{DIGITS}g} s, "
            f"and the mode lengthens {at_most:g} times at most"
        )
        that_time = Remedy("ask for that time", {"segment_time": told(needed)})
        raise RefusedError(fault, lengthened(needed, segment_time), that_time)
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


def longer(needed: float, given: float) -> Remedy:
    """A segment time, s, instead of the one given."""
    words = f"give the segment at least {needed:.{DIGITS}g} s instead of {given:.{DIGITS}g} s"
    return Remedy(words, {"segment_time": told(needed)})


def lengthened(needed: float, given: float) -> Remedy:
    """The bound of a mode that makes a segment time, s, of the one given."""
    factor = math.ceil(10.0 * needed / given) / 10.0
    return Remedy(f"lengthen_at_most={factor:g}", {"lengthen_at_most": factor})


def told(seconds: float) -> float:
    """A time as a message has it."""
    return float(f"{seconds:.{DIGITS}g}")
