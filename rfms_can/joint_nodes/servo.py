"""The joint servo: from errors to torque (Eq. 5.11 as corrected) to DAC codes.

Corrected against the listing of Appendix C: the integral is of the *real* error, with dead band
and anti-windup; the derivative is one; inertia is weighted row times desired accelerations, in
SI; friction is signed by the desired velocity; the bias torque is in the sum.
"""

from collections.abc import Mapping, Sequence
from typing import Final

from rfms_can.wire.vocabulary import Law, Parameter

DAC_MIN: Final = -2048
DAC_MAX: Final = 2047
REVERSAL_S: Final = 0.25
"""Time, s, in which the friction of a resting joint turns to where its error is."""


class Servo:
    """PID, or the inertia-weighted law, with gravity, inertia, friction and bias; one joint.

    Args:
        parameters: the node's configuration.

    Attributes:
        integral: integral part of the torque, Nm.
        saturated: whether the last torque was clamped to the limit.
    """

    __slots__ = (
        "_band",
        "_coulomb",
        "_damping",
        "_integral_limit",
        "_kd",
        "_ki_period",
        "_kp",
        "_negative",
        "_positive",
        "_resting",
        "_reversal",
        "_stiffness",
        "_still",
        "_torque_per_code",
        "_viscous",
        "integral",
        "saturated",
        "torque_limit",
    )

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._kp = p[Parameter.KP]
        self._ki_period = p[Parameter.KI] * p[Parameter.PERIOD]
        self._kd = p[Parameter.KD]
        self._integral_limit = p[Parameter.INTEGRAL_LIMIT]
        self._band = p[Parameter.INTEGRAL_DEADBAND]
        natural = p[Parameter.NATURAL_FREQUENCY]
        self._stiffness = natural * natural
        self._damping = 2.0 * p[Parameter.DAMPING_RATIO] * natural
        self._positive = p[Parameter.COULOMB_POSITIVE]
        self._negative = p[Parameter.COULOMB_NEGATIVE]
        self._viscous = p[Parameter.VISCOUS]
        self._still = p[Parameter.FRICTION_SPEED]
        self._reversal = (self._positive + self._negative) * p[Parameter.PERIOD] / REVERSAL_S
        self._torque_per_code = p[Parameter.TORQUE_PER_CODE]
        self.torque_limit = p[Parameter.TORQUE_LIMIT]
        self.reset()

    def reset(self) -> None:
        """Forget the integral and the direction of the last motion."""
        self.integral = 0.0
        self._coulomb = 0.0
        self._resting = True
        self.saturated = False

    def friction(self, speed: float) -> float:
        """Torque that overcomes friction at a desired speed (rad/s), Nm.

        Signed by the desired velocity; at rest it stays as the last motion left it. A joint that
        stops a little short then still has its friction overcome in the direction it came from
        and creeps home, instead of sticking until the integral has grown to the stiction.
        """
        self._resting = False
        if speed > self._still:
            self._coulomb = self._positive
        elif speed < -self._still:
            self._coulomb = -self._negative
        else:
            self._resting = True
        return self._coulomb + self._viscous * speed

    def torque(
        self,
        errors: Sequence[float],
        rates: Sequence[float],
        accelerations: Sequence[float],
        compliance: Sequence[float],
        weighted: Sequence[float],
        law: int,
        feedforward: float,
    ) -> float:
        """Joint torque, Nm, clamped to the limit.

        Args:
            errors: the six joint errors, rad.
            rates: their rates, rad/s.
            accelerations: the six desired accelerations, rad/s2.
            compliance: own row of C_theta.
            weighted: own row of M C_theta, kg m2.
            law: ``Law``: PID, or ``M C (wn^2 e + 2 zeta wn e_dot)``.
            feedforward: gravity, friction and bias torque, Nm.
        """
        m1, m2, m3, m4, m5, m6 = weighted
        a1, a2, a3, a4, a5, a6 = accelerations
        total = feedforward + m1 * a1 + m2 * a2 + m3 * a3 + m4 * a4 + m5 * a5 + m6 * a6
        e1, e2, e3, e4, e5, e6 = errors
        v1, v2, v3, v4, v5, v6 = rates
        if law == Law.WEIGHTED:
            k, d = self._stiffness, self._damping
            total += m1 * (k * e1 + d * v1) + m2 * (k * e2 + d * v2) + m3 * (k * e3 + d * v3)
            total += m4 * (k * e4 + d * v4) + m5 * (k * e5 + d * v5) + m6 * (k * e6 + d * v6)
            return self._clamp(total)
        c1, c2, c3, c4, c5, c6 = compliance
        error = c1 * e1 + c2 * e2 + c3 * e3 + c4 * e4 + c5 * e5 + c6 * e6
        rate = c1 * v1 + c2 * v2 + c3 * v3 + c4 * v4 + c5 * v5 + c6 * v6
        total += self._kp * error + self._kd * rate
        return self._clamp(total + self._integrate(error, total))

    def alone(self, error: float, rate: float, feedforward: float) -> float:
        """Torque of the PID on this joint's own error, Nm: homing and stopping need no others."""
        total = feedforward + self._kp * error + self._kd * rate
        return self._clamp(total + self._integrate(error, total))

    def _integrate(self, error: float, others: float) -> float:
        """One step of the integral, frozen in the dead band and against a clamped torque.

        A joint that rests beyond its goal is held there by friction and by its own compensation
        of it: that turns first, and the integral has nothing to wind up for.
        """
        if -self._band <= error <= self._band or (self._resting and self._turn_friction(error)):
            return self.integral
        limit = self.torque_limit
        winds_up = (others + self.integral) * error > 0.0 and abs(others + self.integral) >= limit
        if not winds_up:
            bound = self._integral_limit
            step = self.integral + self._ki_period * error
            self.integral = bound if step > bound else -bound if step < -bound else step
        return self.integral

    def _turn_friction(self, error: float) -> bool:
        """Turn friction a step towards where the error is; False if it points there already."""
        before = self._coulomb
        if error > 0.0:
            self._coulomb = min(before + self._reversal, self._positive)
        else:
            self._coulomb = max(before - self._reversal, -self._negative)
        return self._coulomb != before

    def _clamp(self, torque: float) -> float:
        limit = self.torque_limit
        self.saturated = not -limit <= torque <= limit
        if self.saturated:
            return limit if torque > 0.0 else -limit
        return torque

    def code(self, torque: float) -> int:
        """Motor-current DAC code of a joint torque (Nm)."""
        code = round(torque / self._torque_per_code)
        return DAC_MIN if code < DAC_MIN else DAC_MAX if code > DAC_MAX else code
