"""The joint servo: from errors to torque (Eq. 5.11 as corrected) to DAC codes.

Corrected against the listing of Appendix C: the integral is of the *real* error, with dead band
and anti-windup; the derivative is one; inertia is a row times desired accelerations, in SI;
friction is signed by a velocity; the bias torque is in the sum. Added to it: damping of the
directions that comply, which the bare law leaves to drift, and a passage without a step in torque
where what complies changes.
"""

from collections.abc import Mapping, Sequence
from typing import Final

from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.friction import PASSAGE_PART, FrictionCompensation
from rfms_can.wire.vocabulary import Law, Parameter

DAC_MIN: Final = -2048
DAC_MAX: Final = 2047
COMPLYING_BAND: Final = 2.5e-4
"""Dead band of all integrals while the arm complies, rad: 1.5 counts of the coarsest encoder. The
same at all joints: nodes that integrate different errors push into directions that comply."""
COMPLYING_SUM: Final = 2e-3
"""Bound of an error's integral then, rad s; for the same reason."""
COMPLYING_INTEGRAL: Final = 0.3
"""Part of its limit the integral may use while the arm complies: what is blocked is to wait, and
not to jump when it comes free."""
_NOTHING: Final = (0.0,) * 6


class Servo:
    """PID, or the inertia-weighted law, with gravity, inertia, friction and bias; one joint.

    Args:
        parameters: the node's configuration.
        joint: number of the joint, 1 to 6.

    Attributes:
        friction: friction compensation.
        integral: integral part of the torque, Nm.
        push: speed, rad/s, at which the servo would take the joint to where its error is. While the
            arm complies COMPLY takes up what is ignored of an error, so the own one is the real
            one; its torque is not, which accelerates the other joints as well.
        saturated: whether the last torque was clamped to the limit.
    """

    __slots__ = (
        "_band",
        "_complies",
        "_damping",
        "_index",
        "_inertia",
        "_integral_limit",
        "_kd",
        "_ki_period",
        "_kp",
        "_last",
        "_most",
        "_natural",
        "_passage",
        "_specification",
        "_stiffness",
        "_sums",
        "_torque_per_code",
        "_torque_per_force_code",
        "_weighted_integral",
        "friction",
        "integral",
        "push",
        "saturated",
        "torque_limit",
    )

    def __init__(self, parameters: Mapping[Parameter, float], joint: int) -> None:
        p = parameters
        self._index = joint - 1
        self._kp = p[Parameter.KP]
        self._ki_period = p[Parameter.KI] * p[Parameter.PERIOD]
        self._kd = p[Parameter.KD]
        self._integral_limit = p[Parameter.INTEGRAL_LIMIT]
        self._band = p[Parameter.INTEGRAL_DEADBAND]
        self._most = COMPLYING_SUM * p[Parameter.KI]
        natural = p[Parameter.NATURAL_FREQUENCY]
        self._stiffness = natural * natural
        self._damping = 2.0 * p[Parameter.DAMPING_RATIO] * natural
        self._inertia = self._kp / self._stiffness if natural else 0.0
        self._natural = natural
        self._weighted_integral = self._stiffness / self._kp if self._kp else 0.0
        self._torque_per_code = p[Parameter.TORQUE_PER_CODE]
        self._torque_per_force_code = p[Parameter.TORQUE_PER_FORCE_CODE]
        self.torque_limit = p[Parameter.TORQUE_LIMIT]
        self.friction = FrictionCompensation(p)
        self.reset()

    def reset(self) -> None:
        """Forget the integral and the direction of the last motion."""
        self.integral = 0.0
        self._sums = [0.0] * 6
        self._complies = False
        self.push = 0.0
        self.saturated = False
        self._passage = self._last = 0.0
        self._specification: int | None = None
        self.friction.reset()

    def torque(
        self,
        errors: Sequence[float],
        rates: Sequence[float],
        accelerations: Sequence[float],
        rows: RowSets,
        gravity: float,
        overcome: float = 0.0,
        bias: float = 0.0,
    ) -> float:
        """Joint torque without the bias, Nm; clamped so that both together keep the limit.

        Args:
            errors: the six joint errors, rad.
            rates: their rates, rad/s.
            accelerations: the six desired accelerations, rad/s2.
            rows: own rows of the law.
            gravity: holding torque, Nm.
            overcome: friction torque, Nm, which passes over by itself.
            bias: bias torque, Nm, which goes out on the force set-point DAC.
        """
        weighted = rows.law == Law.WEIGHTED
        inertia, law = (rows.first, rows.second) if weighted else (rows.second, rows.first)
        m1, m2, m3, m4, m5, m6 = inertia
        a1, a2, a3, a4, a5, a6 = accelerations
        total = gravity + m1 * a1 + m2 * a2 + m3 * a3 + m4 * a4 + m5 * a5 + m6 * a6
        r1, r2, r3, r4, r5, r6 = law
        e1, e2, e3, e4, e5, e6 = errors
        v1, v2, v3, v4, v5, v6 = rates
        error = r1 * e1 + r2 * e2 + r3 * e3 + r4 * e4 + r5 * e5 + r6 * e6
        rate = r1 * v1 + r2 * v2 + r3 * v3 + r4 * v4 + r5 * v5 + r6 * v6
        if weighted:
            pull = self._stiffness * error + self._damping * rate
        else:
            pull = self._kp * error + self._kd * rate
        if rows.damping:
            own = rates[self._index]
            if weighted:
                all_of_it = m1 * v1 + m2 * v2 + m3 * v3 + m4 * v4 + m5 * v5 + m6 * v6
                total += rows.damping * (all_of_it - rate)
            else:
                total += rows.damping * self._inertia * (own - rate)
        self.push = self._natural * errors[self._index]
        total += pull
        if rows.selection:
            total += self._integrate(errors, law, total + overcome, weighted)
        else:
            total += self._integrate_own(errors[self._index], total + overcome)
        return self._clamp(self._pass(total, rows) + overcome + bias) - bias

    def alone(self, error: float, rate: float, feedforward: float) -> float:
        """Torque of the PID on this joint's own error, Nm: homing and stopping need no others."""
        total = feedforward + self._kp * error + self._kd * rate
        return self._clamp(total + self._integrate_own(error, total))

    def _integrate_own(self, error: float, others: float) -> float:
        """Integral torque of a rigid joint: of its own error, under either law."""
        index, sums = self._index, self._sums
        self._complies = False
        self._sum_up(index, error, others + sums[index], 1.0, self._band, self._integral_limit)
        own = self.integral = sums[index]
        sums[:] = _NOTHING
        sums[index] = own
        return own

    def _integrate(
        self, errors: Sequence[float], row: Sequence[float], others: float, weighted: bool
    ) -> float:
        """Integral torque while the arm complies: the law's row times integrals of all six errors.

        So what the integral holds is split by the same row as the errors are: nothing is left in
        a direction that complies. Each is kept in the torque it would make of an own error.
        """
        sums = self._sums
        if not self._complies:  # what it held as a rigid joint, the others do not know
            self._complies = True
            sums[:], self.integral = _NOTHING, 0.0
        total = others + self.integral
        for j, error in enumerate(errors):
            self._sum_up(j, error, total, row[j], COMPLYING_BAND, self._most)
        s1, s2, s3, s4, s5, s6 = sums
        r1, r2, r3, r4, r5, r6 = row
        integral = r1 * s1 + r2 * s2 + r3 * s3 + r4 * s4 + r5 * s5 + r6 * s6
        if weighted:
            integral *= self._weighted_integral
        bound = COMPLYING_INTEGRAL * self._integral_limit
        if not -bound <= integral <= bound:
            kept = bound / abs(integral)  # of each, so that it comes back at once
            sums[:] = [kept * one for one in sums]
            integral *= kept
        self.integral = integral
        return integral

    def _sum_up(
        self, j: int, error: float, total: float, share: float, band: float, bound: float
    ) -> None:
        """One step of one integral, frozen in the dead band and against a clamped torque.

        A joint that rests beyond its goal is held there by friction and by its own compensation
        of it: that turns first, and the integral has nothing to wind up for.
        """
        if -band <= error <= band:
            return
        if j == self._index and self.friction.resting and self.friction.turn(error):
            return
        if abs(total) >= self.torque_limit and total * share * error > 0.0:
            return
        step = self._sums[j] + self._ki_period * error
        self._sums[j] = bound if step > bound else -bound if step < -bound else step

    def _pass(self, torque: float, rows: RowSets) -> float:
        """Where what complies has changed, go over to the new torque in small steps.

        From what the joint gave to what it can give: a clamped torque would pass unseen.
        """
        if rows.specification != self._specification:
            if self._specification is not None:
                self._passage = self._last - self._clamp(torque)
            self._specification = rows.specification
        if self._passage:
            step = PASSAGE_PART * self.torque_limit
            self._passage -= max(-step, min(step, self._passage))
            torque = self._clamp(torque) + self._passage
        self._last = self._clamp(torque)
        return torque

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

    def force_code(self, torque: float) -> int:
        """Force-set-point DAC code of a bias torque (Nm)."""
        code = round(torque / self._torque_per_force_code) if torque else 0
        return DAC_MIN if code < DAC_MIN else DAC_MAX if code > DAC_MAX else code
