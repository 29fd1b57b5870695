"""Reference transforms: read in each cycle, changed by what sensors observe (thesis III.3.2)."""

import math
from collections.abc import Callable, Sequence
from typing import Final, Literal, NamedTuple

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.correction import (
    KEPT,
    NO_FADE,
    NOTHING,
    SHORTEST_SPAN_S,
    Fade,
    shortest_span,
)
from rfms_can.master.world.functions import screw
from rfms_can.master.world.modes import Limits
from rfms_can.master.world.numbers import REST_AFTER_S
from rfms_can.master.world.observed import (
    OVERDUE,
    REST,
    Observation,
    Observations,
    Prediction,
    rotation_vector,
)
from rfms_can.master.world.transform_kinds import Inverse
from rfms_can.setpoint.blend import Derivatives
from rfms_can.transform import Transform

TAKE_OVERS: Final = 8
"""Moments until the end of a fade at which the next one may take over, besides now."""

BRAKING: Final = 1.875
"""Largest deceleration of a prediction that comes to rest, times time over velocity: that of the
polynomial (3.18) of a velocity, whose rest lies half the time ahead."""

Aim = Callable[[int], Prediction]
"""The prediction to follow, by the tick at which the fade to it begins."""

_NEAR: Final = (-2, -1, 0, 1, 2)
"""Ticks around a take-over at which the rotation is looked at."""


class Course(NamedTuple):
    """Where a reference goes, as long as nothing more is observed.

    Attributes:
        begin: tick from which on it goes there.
        prediction: of what was observed.
        fade: what is added to it.
    """

    begin: int
    prediction: Prediction
    fade: Fade = NO_FADE

    def at(self, tick: int, period_s: float) -> Transform:
        """The value at a tick."""
        predicted = self.prediction.at(tick * period_s)
        added = self.fade.at(tick)
        if added is NOTHING:
            return predicted
        x, y, z, ex, ey, ez = added
        turned = predicted
        if ex or ey or ez:
            turned = predicted @ screw(REST, (ex, ey, ez))
        return turned._replace(px=predicted.px + x, py=predicted.py + y, pz=predicted.pz + z)

    def less(self, new: Prediction, tick: int, period_s: float) -> tuple[Derivatives, ...]:
        """What to add to a new prediction to go on as before, and its derivatives.

        Of the origin, what is left of the fade and a line. Of the rotation, the rotation vector
        from the new prediction to the value, less that of the fade, is given by central
        differences: all of it is known ahead, so that nothing is estimated from noise.
        """
        old, time = self.prediction, tick * period_s
        here, there = old.at(time), new.at(time)
        places = (here.px - there.px, here.py - there.py, here.pz - there.pz)
        rates = (v - w for v, w in zip(old.velocity, new.velocity, strict=True))
        lines = [(x, v, 0.0, 0.0) for x, v in zip(places, rates, strict=True)]
        middle = self._turn(new, tick, period_s, REST)
        turns = [self._turn(new, tick + k, period_s, middle) for k in _NEAR]
        left = [self.fade.at(tick + k)[3:] for k in _NEAR]
        bends = [
            _central([turn[i] - fade[i] for turn, fade in zip(turns, left, strict=True)], period_s)
            for i in range(3)
        ]
        faded = self.fade.derivatives(tick)
        return tuple(_sum(a, b) for a, b in zip((*lines, *bends), faded, strict=True))

    def _turn(
        self, new: Prediction, tick: int, period_s: float, near: Sequence[float]
    ) -> list[float]:
        """The rotation vector from ``new`` to the value; near pi, the one of two at ``near``."""
        turn = rotation_vector(new.at(tick * period_s).inverse() @ self.at(tick, period_s))
        angle = math.hypot(*turn)
        if angle > 1.0 and sum(a * b for a, b in zip(turn, near, strict=True)) < 0.0:
            factor = 1.0 - 2.0 * math.pi / angle
            return [factor * component for component in turn]
        return list(turn)


class Reference:
    """A transform read in each cycle: a prediction of what was observed, and a fade.

    Its value is a pure function of the tick; an observation changes it between two ticks.

    Args:
        period_s: of the ticks, s.

    Attributes:
        lever: greatest distance, m, at which a rotation of it moves the tool (or, of one on the
            tool's side, T6), over the positions it stands in.
        predict: how it goes on between observations.
        rest_after: time in which it comes to rest once observations stay out, s, if the limits of
            the mode allow.
        silent_from: tick from which on it goes on although an observation is overdue; None while
            it rests.
    """

    cycle_s = 0.0  # what will be observed is not known

    __slots__ = (
        "_course",
        "_inverse",
        "_observations",
        "_period",
        "_tick",
        "_upcoming",
        "_value",
        "lever",
        "predict",
        "rest_after",
        "silent_from",
    )

    def __init__(self, period_s: float) -> None:
        self.lever = 0.0
        self.predict: Literal["hold", "velocity"] = "hold"
        self.rest_after = REST_AFTER_S
        self.silent_from: int | None = None
        self._period: Final = period_s
        self._observations: Final = Observations(0.5 * period_s)
        self._course = Course(0, Prediction(Transform.identity(), 0.0))
        self._upcoming: Course | None = None
        self._inverse: Final = Inverse()
        self._tick: int | None = None
        self._value = Transform.identity()

    def observe(self, observation: Observation, tick: int, limits: Limits | None) -> None:
        """Take an observation, to act from ``tick`` on.

        Args:
            observation: what was seen; the newest by its time counts. One that is far from the
                prediction counts once others have confirmed it: always under ``velocity``, and
                under ``hold`` in a stream of observations. One alone is taken at its word.
            tick: of the next set-point.
            limits: of the mode the arm moves with; None if nothing that moves uses this transform,
                which then jumps, as it does when it is observed first.
        """
        known, moving = self._observations.any, self.predict == "velocity"
        gated = moving or self._observations.is_stream_at(observation.time)
        if not self._observations.add(observation, gated=gated):
            return
        prediction = self._observations.moving() if moving else self._observations.held()
        self.silent_from = None
        if not prediction.rests:
            overdue = OVERDUE * self._observations.interval / self._period
            self.silent_from = tick + math.ceil(overdue - 1e-6)
        self._begin(tick)
        if limits is None or not known:
            self._course = Course(tick, prediction)
            return
        self._follow(self._plan(lambda _: prediction, tick - 1, limits), tick)

    def settle(self, tick: int, limits: Limits | None) -> None:
        """Bring it to rest because no observation comes, within ``rest_after``.

        It rests where it would have been after half that time. At the end nothing is left of a
        fade either.

        Args:
            tick: of the next set-point.
            limits: of the mode the arm moves with, which may need longer; None if nothing that
                moves uses this transform.
        """
        self.silent_from = None
        self._begin(tick)
        old, period = self._course.prediction, self._period
        speed, turning = math.hypot(*old.velocity), math.hypot(*old.turning)
        span = self.rest_after
        if limits is not None:
            linear = (speed + self.lever * turning) / limits.acceleration
            braking = BRAKING / KEPT * max(linear, turning / limits.angular_acceleration)
            span = max(span, braking)

        def resting(begin: int) -> Prediction:
            return Prediction(old.at(begin * period + 0.5 * span), begin * period)

        if limits is None:
            target = resting(tick - 1)
            difference = self._course.less(target, tick - 1, period)
            self._course = Course(tick - 1, target, Fade.over(difference, tick - 1, span, period))
            return
        self._follow(self._plan(resting, tick - 1, limits, span), tick)

    def hold(self, pose: Transform, tick: int, limits: Limits) -> None:
        """Come to a pose within limits and stay, until it is observed again."""
        self.silent_from = None
        self._begin(tick)
        prediction = Prediction(pose, tick * self._period)
        self._follow(self._plan(lambda _: prediction, tick - 1, limits), tick)

    def _begin(self, tick: int) -> None:
        """Go on from what is under way at a tick; what was to come later is given up."""
        if self._upcoming is not None and tick > self._upcoming.begin:
            self._course = self._upcoming
        self._upcoming = self._tick = None

    def _follow(self, course: Course, tick: int) -> None:
        if course.begin < tick:
            self._course = course
        else:
            self._upcoming = course

    @property
    def newest(self) -> Observation:
        """The newest observation by its time."""
        return self._observations.newest

    def at(self, moment: Moment) -> Transform:
        """Its value at the tick; the same object while it does not change."""
        tick = moment.tick
        if tick != self._tick:
            course = self._course
            if self._upcoming is not None and tick >= self._upcoming.begin:
                course = self._upcoming
            value = course.at(tick, self._period)
            if value != self._value:
                self._value = value
            self._tick = tick
        return self._value

    def inverse_at(self, moment: Moment) -> Transform:
        """The inverse of its value."""
        return self._inverse.of(self.at(moment))

    def _plan(
        self, aim: Aim, last: int, limits: Limits, at_least: float = SHORTEST_SPAN_S
    ) -> Course:
        """From the course under way to the new prediction, as soon as the limits allow.

        The two agree at the tick ``last`` of the set-point made last: the next differs already.
        The accelerations of a fade under way, which are within the limits, may add to what the new
        one needs; it then takes over a little later, at its end at the latest, where there are
        none. It also waits for that if it then is over sooner: against an acceleration at the
        limit only a very long fade begins at once.
        """
        course = self._course
        left = max(0, course.fade.end - last)
        begins = [last + left * k // TAKE_OVERS for k in range(TAKE_OVERS + 1)]
        found: Course | None = None
        for begin in dict.fromkeys(begins):
            at_rest = begin == last + left
            if found is not None and not at_rest:
                continue
            prediction = aim(begin)
            difference = course.less(prediction, begin, self._period)
            if not any(map(any, difference)):
                return found or Course(begin, prediction)
            span = shortest_span(difference, limits, self.lever, at_rest=at_rest, at_least=at_least)
            if span is None:
                continue
            planned = Course(begin, prediction, Fade.over(difference, begin, span, self._period))
            if found is None or planned.fade.end < found.fade.end:
                found = planned
            if found.fade.end <= last + left + SHORTEST_SPAN_S / self._period:
                return found
        assert found is not None  # a fade from rest always has a span
        return found


def _central(samples: Sequence[float], period_s: float) -> Derivatives:
    """The middle one of five samples, a period apart, and its derivatives."""
    a, b, c, d, e = samples
    return (
        c,
        (a - 8.0 * b + 8.0 * d - e) / (12.0 * period_s),
        (16.0 * (b + d) - (a + e) - 30.0 * c) / (12.0 * period_s**2),
        (e - a - 2.0 * (d - b)) / (2.0 * period_s**3),
    )


def _sum(a: Derivatives, b: Derivatives) -> Derivatives:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])
