"""The set-point of one joint from the Cartesian set-points of the master (Table 3.3, Appendix C).

Every joint node runs one :class:`JointSetpoint` on the solution of its own joint; the master runs
six as a model of the nodes. This is Appendix C's ``jsetp`` with additions: solutions continue on
their turn, the old goal is solved in the old configuration and the next one in the new, the first
move starts from the encoder, and the rate of the new segment at the hand-over is that of its own
start point, which for a Cartesian segment is not the goal's (3.17).
"""

import math
from collections.abc import Callable
from typing import Final, NamedTuple

from rfms_can.kinematics import Configuration
from rfms_can.setpoint.blend import NO_MATCH, Derivatives, MatchingPolynomial, earlier
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.history import SampleHistory, least_for, matched_for, window_for
from rfms_can.setpoint.succession import may_follow
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

Solve = Callable[[Transform, Configuration, float], float]
"""Solves one joint: pose, configuration, the angle whose turn to continue; NaN if impossible."""

_IDLE: Final = TrajectoryState.IDLE
_LINEAR: Final = TrajectoryState.LINEAR
_START: Final = TrajectoryState.START
_BLEND: Final = TrajectoryState.BLEND

HELD_TOLERANCE: Final = 1e-6
"""Largest distance from its base, rad, at which a transition may end before p = 1."""


class Mark(NamedTuple):
    """A set-point and the two steps to it, rad."""

    theta: float
    step: float
    step_before: float


class JointSetpoint:
    """``jsetp`` for one joint: one call a cycle, the set-point of that cycle.

    The set-point is a *base*, r theta_BC + solve(T6_1) in joint mode (3.12) and solve(T6_1) in
    Cartesian mode (3.23), plus the matching polynomial during a transition (3.18).

    At a hand-over the ``THESIS`` blend extrapolates linearly and matches position and velocity.
    ``CONTINUOUS`` also matches acceleration and jerk, taken from the history of the base, not of
    the set-point: for a joint segment with a resting goal both are exactly zero, and r adds its own
    exact rate (numbers: :mod:`rfms_can.setpoint.history`).

    With a feed rate f the hand-over may fall between two cycles: p of START is then the elapsed
    part. The matched motion is shifted back by that time, and t_acc is 1/f of the move's, so that
    the polynomial is the one of full speed.

    Attributes:
        theta: the set-point, rad.
        rate: its velocity, rad/s, without delay: the slope at the end of a cubic through four
            set-points. Error tau^3/4 of the fourth derivative; float32 noise 2.9e-5 rad/s rms at
            4 ms. Exactly zero at rest.
        acceleration: its acceleration, rad/s2, of the same cubic, without delay. Error 11/12
            tau^2 of the fourth derivative; float32 noise 0.02 rad/s2 rms at 4 ms, 0.013 at 5 ms,
            less than half a per mille of a PUMA's limit. Exactly zero at rest.
    """

    __slots__ = (
        "_base",
        "_entered",
        "_match",
        "_next",
        "_period",
        "_previous",
        "_r",
        "_r_step",
        "_since_transition",
        "_state",
        "_step1",
        "_step2",
        "_theta_BC",
        "acceleration",
        "rate",
        "theta",
    )

    def __init__(self, period_s: float, theta: float = 0.0) -> None:
        """A joint at rest at ``theta``, rad; ``period_s`` is tau, s."""
        self._period: Final = period_s
        self._base = SampleHistory()
        self._next = SampleHistory()
        self.reset(theta)

    def reset(self, theta: float) -> None:
        """Restart from rest at ``theta``, rad: the encoder, before the first set-point."""
        self.theta = self._previous = theta
        self.rate = self.acceleration = 0.0
        self._step1 = self._step2 = 0.0
        self._r = self._r_step = 0.0
        self._entered = 0  # t_acc of the last transition, periods
        self._since_transition = 0  # samples of the base since the last transition
        self._theta_BC = 0.0
        self._match = NO_MATCH
        self._state = _IDLE
        self._base.clear()
        self._next.clear()

    @property
    def step(self) -> float:
        """From the set-point before to this one, rad."""
        return self._step1

    @property
    def bend(self) -> float:
        """Second difference of the set-points, rad: acceleration times the period squared."""
        return self._step1 - self._step2

    def mark(self) -> Mark:
        """Where the set-point is now; see ``return_to``."""
        return Mark(self.theta, self._step1, self._step2)

    def return_to(self, mark: Mark) -> None:
        """Take back set-points that were not sent: go on from ``mark``.

        What the base was has been lost: go on with set-points that bring their own.
        """
        self.theta = self._previous = mark.theta
        self._step1, self._step2 = mark.step, mark.step_before

    def tick(self, setpoint: CartesianSetpoint, solve: Solve) -> float:
        """The joint's set-point for this cycle, rad; NaN if ``setpoint`` cannot be used.

        A refused set-point (no solution, or an invalid sequence of states) changes nothing.
        """
        t6_2 = setpoint.T6_2
        solution_1 = solve(setpoint.T6_1, setpoint.configuration_1, self.turn_1(setpoint))
        if t6_2 is None:
            return self.advance(setpoint, solution_1)
        return self.advance(
            setpoint, solution_1, solve(t6_2, setpoint.configuration_2, self.turn_2)
        )

    def turn_1(self, setpoint: CartesianSetpoint) -> float:
        """The angle whose turn the solution of ``T6_1`` continues, rad.

        That is its own last value, not the set-point: in joint mode the two may differ by more than
        half a turn, and their difference crosses half a turn during the motion.
        """
        if setpoint.state is _IDLE or not self._base or self._leaves_joint_mode(setpoint):
            return self.theta
        return self._base.newest

    @property
    def turn_2(self) -> float:
        """The angle whose turn the solution of ``T6_2`` continues, rad; at first that of T6_1."""
        if self._next:
            return self._next.newest
        return self._base.newest if self._base else self.theta

    def advance(
        self, setpoint: CartesianSetpoint, solution_1: float, solution_2: float = 0.0
    ) -> float:
        """``tick`` with given solutions, rad, on the turns of ``turn_1`` and ``turn_2``."""
        state = setpoint.state
        if not (may_follow(setpoint, self._state) and math.isfinite(solution_1 + solution_2)):
            return math.nan
        if state is not _START:
            theta = self._along(setpoint, solution_1, solution_2)
        elif setpoint.T6_2 is None and setpoint.mode is Mode.JOINT:
            return math.nan
        else:
            theta = self._hand_over(setpoint, solution_1, solution_2)
        self._r = setpoint.r
        self._state = state
        self._differentiate(theta)
        return theta

    def miss(self) -> float:
        """A cycle without a usable set-point: hold the last one (rad) and update the histories.

        The next transition still needs evenly spaced samples: they are extrapolated, the set-point
        is not.
        """
        self._base.extrapolate()
        self._next.extrapolate()
        self._since_transition += 1
        self._r += self._r_step
        step = 2.0 * self._step1 - self._step2
        self._previous += step
        self._step1, self._step2 = step, self._step1
        return self.theta

    def _along(self, setpoint: CartesianSetpoint, solution_1: float, solution_2: float) -> float:
        """All states but START: the base, and in a transition the matching polynomial."""
        state = setpoint.state
        theta = solution_1
        if state is _IDLE:
            self._rest(theta)
        else:
            if self._leaves_joint_mode(setpoint):
                self._base.clear()
                self._theta_BC = 0.0
            if setpoint.mode is Mode.JOINT:
                theta += setpoint.r * self._theta_BC
            if state is _BLEND:
                theta += self._match.at(setpoint.p)
            if setpoint.p:
                self._since_transition = 0
        self._since_transition += 1
        self._base.push(solution_1)
        if setpoint.T6_2 is None:
            self._next.clear()
        else:
            self._next.push(solution_2)
        self._r_step = setpoint.r - self._r
        return theta

    def _leaves_joint_mode(self, setpoint: CartesianSetpoint) -> bool:
        """Whether a Cartesian transition leaves a joint-mode segment: from now on T6_1 is the hand.

        Without START, which tells how any other segment is measured. Where theta_BC is zero the
        base is the set-point already.
        """
        leaves = self._theta_BC != 0.0 and setpoint.mode is Mode.CARTESIAN
        return leaves and setpoint.state is not _START

    def _rest(self, theta: float) -> None:
        """IDLE: the pose alone determines the joint angle."""
        if not self._base:  # the encoder angle was only near this pose
            self._previous = theta
        elif self._rests_before_goal(theta):
            self._base.clear()
        self._theta_BC = 0.0

    def _rests_before_goal(self, theta: float) -> bool:
        """Whether the arm rests before the goal of its base: stopped, or held."""
        if self._state is _LINEAR:
            return self._r != 0.0
        base = self._base.newest
        if self._state is _IDLE or abs(self.theta - base) <= HELD_TOLERANCE:
            return False
        return abs(theta - self.theta) < abs(theta - base)

    def _hand_over(self, setpoint: CartesianSetpoint, theta_B: float, theta_C: float) -> float:
        """START: the set-point at -t_acc, and the matching polynomial of the transition."""
        joint_mode = setpoint.mode is Mode.JOINT
        ticks = round(setpoint.acceleration_time / self._period)
        window = window_for(ticks)
        theta, velocity, acceleration, jerk = (
            self._extrapolated()
            if setpoint.blend is Blend.THESIS
            else self._departing_motion(ticks)
        )
        self._next.push(theta_C if joint_mode else theta_B)
        _, *rates = self._next.at_newest(self._period, window)
        difference = matched_for(
            ticks,
            (theta - theta_B, velocity - rates[0], acceleration - rates[1], jerk - rates[2]),
        )
        if setpoint.p:
            difference = earlier(difference, setpoint.p * 2.0 * setpoint.acceleration_time)
        self._match = MatchingPolynomial.matching(difference, setpoint.acceleration_time)
        self._theta_BC = theta_B - theta_C if joint_mode else 0.0
        if joint_mode and setpoint.p >= 1.0:  # a Cartesian transition is over: nothing to match
            theta = theta_C + setpoint.r * self._theta_BC
        self._base, self._next = self._next, self._base
        self._r_step = 0.0
        self._entered = ticks
        return theta

    def _extrapolated(self) -> Derivatives:
        """The old motion now, by row 3 of Table 3.3: theta + theta-dot tau only."""
        step = self._step1
        return (self._previous + step, step / self._period, 0.0, 0.0)

    def _departing_motion(self, ticks: int) -> Derivatives:
        """The old motion now: its base one period ahead, and r, whose rate is constant there.

        Its window hardly reaches back into the transition, at whose end the fourth derivative of h
        is discontinuous; and not at all out of rest: what it would see there of the motion before,
        a slow transition (t_acc of ``ticks``) multiplies by the third power of its time.
        """
        if not self._base:
            return (self.theta, 0.0, 0.0, 0.0)
        least = 1 if self._state is _IDLE else least_for(ticks, self._entered)
        window = min(window_for(ticks), max(self._since_transition, least))
        theta, velocity, acceleration, jerk = self._base.one_ahead(self._period, window)
        theta_BC, step = self._theta_BC, self._r_step
        return (
            theta + (self._r + step) * theta_BC,
            velocity + step * theta_BC / self._period,
            acceleration,
            jerk,
        )

    def _differentiate(self, theta: float) -> None:
        """Take ``theta`` as this cycle's set-point."""
        step, step1, step2 = theta - self._previous, self._step1, self._step2
        tau = self._period
        self.rate = (11.0 * step - 7.0 * step1 + 2.0 * step2) / (6.0 * tau)
        self.acceleration = (2.0 * step - 3.0 * step1 + step2) / (tau * tau)
        self._step1, self._step2 = step, step1
        self.theta = self._previous = theta
