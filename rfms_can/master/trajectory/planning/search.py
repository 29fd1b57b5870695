"""Times that would do, for a move that breaks a limit as it is."""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

from rfms_can.errors import JointLimitError, KinematicsError
from rfms_can.master.trajectory.planning.base_path import Base, Frame
from rfms_can.master.trajectory.planning.departure import DepartedSegment
from rfms_can.master.trajectory.planning.effort import PREVIEW, Effort
from rfms_can.master.trajectory.planning.limits import (
    Excess,
    LimitedArm,
    check_ranges,
    worst_excess,
)
from rfms_can.master.trajectory.planning.preview import Preview, preview
from rfms_can.master.trajectory.planning.speed_jump import speed_jump
from rfms_can.master.trajectory.segment import Transition

TRIES: Final = 12
"""Times that are tried before giving up."""

MUCH_SLOWER: Final = (2, 4, 10, 40)
"""Factors of a segment time that are tried last."""

GAP: Final = 1.25
"""A segment time that does, over the longest that does not: from more, times between are tried."""

HALVED: Final = 6
"""How often the gap to one that does not do is halved then."""

GROWTH: Final = 1.002
"""Least fraction by which a time grows from one try to the next."""


class Times(NamedTuple):
    """t_seg and t_acc, periods."""

    segment: int
    acceleration: int


class Outcome(NamedTuple):
    """What the joints would do with some times, and the limit that breaks."""

    base: Base
    preview: Preview
    excess: Excess | None


class Trial(NamedTuple):
    """A move to be tried with several times.

    Attributes:
        arm: and its limits.
        frame: of the plan.
        departed: the segment that it follows.
        base: of its own segment.
        ends: how it comes to rest.
        parts: in how many it is moved.
        effort: that looking at it takes.
        again: it again with another t_acc, periods, where its path depends on that: out of a goal
            that moves.
    """

    arm: LimitedArm
    frame: Frame
    departed: DepartedSegment
    base: Base
    ends: Transition
    parts: int
    effort: Effort
    again: "Callable[[int], Trial] | None" = None

    @property
    def times(self) -> Times:
        """As the mode has them."""
        move = self.base.segment.move
        return Times(move.segment_ticks, move.acceleration_ticks)

    def least(self, acceleration: int) -> int:
        """Least segment time in which each part can hold its transitions, periods."""
        move = self.base.segment.move
        return self.parts * move._replace(acceleration_ticks=acceleration).least_ticks

    def run(self, times: Times) -> Outcome:
        """Look what the joints would do.

        Raises:
            KinematicsError: they cannot, or leave their ranges.
        """
        if self.again is not None and times.acceleration != self.times.acceleration:
            return self.again(times.acceleration)._run(times)
        return self._run(times)

    def _run(self, times: Times) -> Outcome:
        self.effort.spend(PREVIEW)
        base = self.base if times == self.times else self.base.with_time(*times)
        jump = None if base.whole else speed_jump(base, self.frame)
        if jump is not None:
            raise JointLimitError(f"move {base.segment.move.sequence}: {jump}")
        seen = preview(self.frame, self.departed, base, self.ends)
        phases = [phase for phase in seen if phase is not None]
        check_ranges(self.arm, phases, base.segment.move.sequence)
        return Outcome(base, seen, worst_excess(self.arm, phases))

    def slowed(self, excess: Excess, longest: int) -> Outcome | None:
        """The outcome with a segment time up to ``longest`` that does; None without one.

        The acceleration of a transition is that of the change of velocity: a constant and a part
        that is inverse to the time. As the largest of such it is convex in the inverse of time, so
        that what two trials leave of it at rest is never too much. Where it is not (a goal that
        moves with h), times much longer are tried before giving up.
        """
        segment, acceleration = self.times
        last: tuple[float, float] | None = None
        for _ in range(TRIES):
            longer = segment * excess.slower
            here = (1.0 / segment, excess.ratio)
            if excess.blending:
                if last is not None:
                    slope = (last[1] - here[1]) / (last[0] - here[0])
                    at_rest = here[1] - slope * here[0]
                    if at_rest >= 1.0:
                        return self._much_slower(longest)
                    longer = slope / (1.0 - at_rest)
                last = here
            breaks = segment
            segment = max(segment + 1, math.ceil(longer), math.ceil(segment * GROWTH))
            outcome = self._within(Times(segment, acceleration), longest, acceleration)
            if outcome is None:
                return None
            if outcome.excess is None:
                return outcome if segment <= GAP * breaks else self._nearer(breaks, outcome)
            excess = outcome.excess
        return self._much_slower(longest)

    def _much_slower(self, longest: int) -> Outcome | None:
        """The outcome with the least of some segment times that does, about; None without one."""
        segment, acceleration = self.times
        breaks = segment
        for factor in MUCH_SLOWER:
            outcome = self._within(Times(factor * segment, acceleration), longest, acceleration)
            if outcome is not None and outcome.excess is None:
                break
            breaks = factor * segment
        else:
            return None
        return self._nearer(breaks, outcome)

    def _nearer(self, breaks: int, outcome: Outcome) -> Outcome:
        """The outcome with the least segment time over ``breaks`` that does, about, from one."""
        move = outcome.base.segment.move
        keeps, acceleration = move.segment_ticks, move.acceleration_ticks
        for _ in range(HALVED):
            middle = (breaks + keeps) // 2
            nearer = self._within(Times(middle, acceleration), keeps, acceleration)
            if nearer is not None and nearer.excess is None:
                outcome, keeps = nearer, middle
            else:
                breaks = middle
        return outcome

    def eased(self, excess: Excess, longest: int, longest_acceleration: int) -> Outcome | None:
        """The same where the acceleration time may grow as well."""
        segment, acceleration = self.times
        for _ in range(TRIES):
            if excess.blending:
                acceleration = max(acceleration + 1, math.ceil(acceleration * excess.ratio))
                segment = max(segment, self.least(acceleration))
            else:
                segment = math.ceil(segment * max(excess.slower, GROWTH))
            times = Times(segment, acceleration)
            outcome = self._within(times, longest, longest_acceleration)
            if outcome is None or outcome.excess is None:
                return outcome
            excess = outcome.excess
        return None

    def attempt(self, segment: int, acceleration: int) -> Outcome | None:
        """The outcome with these times, periods; None if it breaks a limit."""
        try:
            outcome = self.run(Times(segment, acceleration))
        except KinematicsError:
            return None
        return outcome if outcome.excess is None else None

    def _within(self, times: Times, longest: int, longest_acceleration: int) -> Outcome | None:
        if times.segment > longest or times.acceleration > longest_acceleration:
            return None
        try:
            return self.run(times)
        except KinematicsError:
            return None
