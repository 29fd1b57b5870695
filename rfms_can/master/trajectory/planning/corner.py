"""A corner that keeps a bound: the acceleration time of a transition by the deviation it may have.

Between two straight segments the deviation from the position between them is
5/32 t_acc |v2 - v1| (``via_deviation.py``); else it is measured, as it grows with t_acc in all
modes. So the longest t_acc that keeps the bound comes as near to it as whole periods allow. Only
t_acc and t_seg of the new segment are chosen: the time of the segment before is promised.

A transition takes at most the room both segments have, and half the new one's time at most (or what
its mode needs to come to rest), so that the corner after it has room as well. Where a limit of the
joints breaks with that t_acc, the segment takes longer, its t_acc chosen again; or the move is
refused. A slow segment always deviates less: at the corner the tool nearly stops.
"""

import math
from typing import Final, NamedTuple

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.master.trajectory.planning.limits import Excess
from rfms_can.master.trajectory.planning.preview import entry_motion
from rfms_can.master.trajectory.planning.remedy import (
    RefusedError,
    Remedy,
    lengthened,
    longer,
    told,
)
from rfms_can.master.trajectory.planning.search import Outcome, Times, Trial
from rfms_can.master.trajectory.planning.times import LONGEST_S
from rfms_can.master.trajectory.planning.via_deviation import Deviation, deviation
from rfms_can.master.trajectory.segment import Move, Transition
from rfms_can.setpoint.history import LONG, window_for
from rfms_can.wire.vocabulary import Mode

GROWTH: Final = 0.05
"""Least fraction by which a segment time grows at first; twice that at each further try."""

FINE: Final = 0.05
"""Fraction to which a segment time is looked for; the shortest for its t_acc is found then."""

LONGER: Final = 8
"""Longer segment times that are tried: the last is some hundred times as long."""

FINEST: Final = 0.002
"""Fraction to which that one is found."""

NEIGHBOURS: Final = 5
"""Acceleration times that are tried for that."""

ROUNDING: Final = 1e-9
"""Fraction by which a bound may be passed."""

PROPORTIONAL: Final = 6
"""Tries that take a deviation for proportional to t_acc; later ones halve what is left."""

LOOSER: Final = (1.0, 1.02, 1.1, 1.3)
"""Factors of the deviation that would do as it is measured, tried as the bound of a message."""


def via_deviation(trial: Trial, entry: Floats) -> Deviation:
    """How far a transition with angles ``entry`` (n, 6) stays from the goal it leaves."""
    before = trial.departed.segment
    at_goal, goal = trial.frame.at_goal(before), before.move.target
    return deviation(trial.arm, entry, goal.left(at_goal), goal.right(at_goal))


def longest(before: Move, move: Move, left: float = math.inf) -> int:
    """The longest t_acc that the segment before has room and time for, periods.

    Where joints estimate how they leave a segment, its straight part must be half as long as what
    they fit: from less, float32's noise would move the corner by a per cent. The mode's own t_acc
    is taken where there is room for no more; where that is not in time, the arm rests first.

    Args:
        before: the move of that segment.
        move: the move that follows.
        left: periods until the goal of ``before``, if it is under way.
    """
    still = before.mode is Mode.JOINT and before.target.constant
    fits = move.transition is Transition.JOINT and not (still and move.target.constant)
    room = before.room
    while fits and room > 1 and room + window_for(room) // 2 - 2 > before.room:
        room -= 1
    watch = 2 if move.target.constant else LONG + 2
    in_time = max(left - watch, move.rest_ticks)
    return int(min(max(room, min(before.room, move.rest_ticks)), in_time))


class Corner(NamedTuple):
    """A move to be tried with the acceleration times that keep a bound.

    Attributes:
        trial: of the move; its acceleration time is that of its rest.
        bound: largest deviation, m.
        longest: t_acc the segment before has room for, periods.
    """

    trial: Trial
    bound: float
    longest: int

    def outcome(self, at_most: float) -> Outcome:
        """What keeps the bound and all limits, with a longer segment where that is allowed.

        Args:
            at_most: by which factor it may be longer; 1 where it may not.

        Raises:
            RefusedError: another bound, or a longer segment, would do.
            MoveError: nothing does.
            KinematicsError: a pose has no solution.
        """
        segment = self.trial.times.segment
        ticks = self.ticks(segment)
        outcome = self.trial.run(Times(segment, ticks or 1))
        if ticks and outcome.excess is None:
            return outcome
        slowed = self._slowed(outcome.excess, ticks)
        if slowed is not None and slowed.base.segment_time <= at_most * self._segment_time:
            return slowed
        offers = self._longer(slowed, at_most) if slowed else []
        offers += filter(None, [self._looser(outcome)])
        fault = self._refused(ticks, outcome)
        raise RefusedError(fault, *offers) if offers else MoveError(fault)

    @property
    def _segment_time(self) -> float:
        """As the mode has it, s."""
        return self.trial.base.segment_time

    def ticks(self, segment_ticks: int, near: int = 0) -> int:
        """The longest t_acc that keeps the bound in a segment of ``segment_ticks``; 0 if none.

        It may be ``near`` one that is known.
        """
        keeps, breaks = 0, self._most(segment_ticks) + 1
        ticks, tries = min(near or self.trial.base.segment.move.rest_ticks, breaks - 1), 0
        while breaks - keeps > 1:
            off = self._deviation(Times(segment_ticks, ticks))
            if off <= self.bound * (1.0 + ROUNDING):
                keeps = ticks
            else:
                breaks = ticks
            tries += 1
            guess = (keeps + breaks) // 2
            if tries < PROPORTIONAL and 0.0 < off < math.inf:
                guess = int(min(ticks * self.bound / off, breaks))
            ticks = min(max(guess, keeps + 1), breaks - 1)
        return keeps

    def _most(self, segment_ticks: int) -> int:
        """The longest t_acc both segments have room for."""
        move = self.trial.base.segment.move
        part = segment_ticks // self.trial.parts
        own = part - move.rest_ticks - move.told_ticks - 2
        return min(self.longest, own, max(move.rest_ticks, part // 2))

    def _deviation(self, times: Times) -> float:
        """Of the transition with ``times``, m; infinite where it has no solution."""
        trial = self.trial
        try:
            base = trial.base.with_time(*times)
            entry = entry_motion(trial.frame, trial.departed, base)
        except KinematicsError:
            return math.inf
        return via_deviation(trial, entry[0]).distance

    def _at(self, segment_ticks: int, near: int = 0) -> Outcome | None:
        """The outcome with a segment time; None if the bound cannot be kept, or has no solution."""
        ticks = self.ticks(segment_ticks, near)
        try:
            return self.trial.run(Times(segment_ticks, ticks)) if ticks else None
        except KinematicsError:
            return None

    def _slowed(self, excess: Excess | None, near: int) -> Outcome | None:
        """The outcome with the shortest longer segment time that does; None without one."""
        longest = LONGEST_S / self.trial.frame.period_s
        breaks = segment = self.trial.times.segment
        kept: Outcome | None = None
        growth = GROWTH
        for _ in range(LONGER):
            slower = 1.0 if excess is None else excess.slower
            segment = math.ceil(segment * max(1.0 + growth, slower))
            growth *= 2.0
            outcome = self._at(segment, near) if segment <= longest else None
            near = near if outcome is None else outcome.base.segment.move.acceleration_ticks
            if outcome is not None and outcome.excess is None:
                kept = outcome
                break
            excess, breaks = None if outcome is None else outcome.excess, segment
        while kept is not None and segment - breaks > max(1.0, FINE * segment):
            middle = (segment + breaks) // 2
            outcome = self._at(middle, near)
            if outcome is not None and outcome.excess is None:
                kept, segment = outcome, middle
            else:
                breaks = middle
        return None if kept is None else self._shortest(kept)

    def _shortest(self, kept: Outcome) -> Outcome:
        """The outcome with about the t_acc of ``kept`` and the time that needs, if shorter.

        A longer t_acc asks less of the joints, and may need a slower segment to keep the bound.
        """
        ticks = kept.base.segment.move.acceleration_ticks
        known = set[int]()
        waiting = [ticks, ticks - 1]
        while waiting and len(known) < NEIGHBOURS:
            ticks = waiting.pop(0)
            if ticks < 1 or ticks in known:
                continue
            known.add(ticks)
            found = self._with(ticks, kept.base.segment.move.segment_ticks - 1)
            if found is not None:
                kept = found
                segment = kept.base.segment.move.segment_ticks
                waiting += (self.ticks(segment, ticks), ticks - 1)
        return kept

    def _with(self, ticks: int, longest_segment: int) -> Outcome | None:
        """The outcome with a t_acc, in the segment time that it needs; None if it does not do."""
        trial = self.trial
        try:
            found: Outcome | None = trial.run(Times(trial.times.segment, ticks))
            if found is not None and found.excess is not None:
                found = trial._replace(base=found.base).slowed(found.excess, longest_segment)
            if found is None:
                return None
            limited = found.base.segment.move.segment_ticks
            segment = self._within_bound(ticks, limited, longest_segment)
            if segment is None or ticks > self._most(segment):
                return None
            found = found if segment == limited else trial.run(Times(segment, ticks))
        except KinematicsError:
            return None
        return found if found.excess is None else None

    def _within_bound(self, ticks: int, least: int, most: int) -> int | None:
        """The shortest segment time, to ``FINEST`` of it, in which ``ticks`` keep the bound."""

        def keeps(segment: int) -> bool:
            return self._deviation(Times(segment, ticks)) <= self.bound * (1.0 + ROUNDING)

        if keeps(least):
            return least
        if least >= most or not keeps(most):
            return None
        while most - least > max(1.0, FINEST * most):
            middle = (least + most) // 2
            least, most = (least, middle) if keeps(middle) else (middle, most)
        return most

    # --- refusals -----------------------------------------------------------------------------

    def _refused(self, ticks: int, outcome: Outcome) -> str:
        trial = self.trial
        name, tau = f"move {trial.base.segment.move.sequence}", trial.frame.period_s
        if ticks and outcome.excess is not None:
            return (
                f"{name}: to keep the deviation of {self.bound:g} m it would accelerate in "
                f"{ticks * tau:.6g} s, and {outcome.excess.what}"
            )
        off = via_deviation(trial, outcome.preview.entry.motion[0]).distance
        return (
            f"{name}: even a transition of one period, {tau:g} s, deviates by {off:.3g} m from the "
            f"goal of move {trial.departed.segment.move.sequence}, over {self.bound:g} m"
        )

    def _longer(self, slowed: Outcome, at_most: float) -> list[Remedy]:
        needed, given = slowed.base.segment_time, self._segment_time
        offers = [longer(needed, given)]
        return offers if at_most == 1.0 else [lengthened(needed, given), *offers]

    def _looser(self, outcome: Outcome) -> Remedy | None:
        """A larger deviation that does, in words; None without one."""
        trial, off = self.trial, self._deviation(Times(self.trial.times.segment, 1))
        segment = trial.times.segment
        if outcome.excess is not None:
            longest = round(LONGEST_S / trial.frame.period_s)
            tried = trial._replace(base=outcome.base)
            eased = tried.eased(outcome.excess, longest, self.longest)
            if eased is None:
                return None
            off = via_deviation(trial, eased.preview.entry.motion[0]).distance
            segment = eased.base.segment.move.segment_ticks
        for factor in LOOSER if 0.0 < off < math.inf else ():
            bound = _rounded_up(off * factor)
            looser = self._replace(bound=bound)._at(segment)
            if looser is not None and looser.excess is None:
                along = f", with a segment of {looser.base.segment_time:.6g} s"
                words, change = f"allow a deviation of {bound:g} m", {"deviation": bound}
                if segment > trial.times.segment:
                    words += along
                    change["segment_time"] = told(looser.base.segment_time)
                return Remedy(words, change)
        return None


def _rounded_up(distance: float) -> float:
    """``distance`` in three digits, rounded up."""
    unit = 10.0 ** (math.floor(math.log10(distance)) - 2)
    return math.ceil(distance / unit * (1.0 - ROUNDING)) * unit
