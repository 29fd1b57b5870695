"""The joint servo: from errors to torque (Eq. 5.11 as corrected) to DAC codes.

Corrected against the listing of Appendix C: the integral is of the *real* error, with dead band
and anti-windup; the derivative is one; inertia is a row times desired accelerations, in SI;
friction is signed by a velocity; the bias torque is in the sum. Added to it: damping of the
directions that comply, which the bare law leaves to drift, and a bumpless transfer of the torque
where what complies changes.

What a servo is set to (``ServoConfig``), what it remembers (``ServoState``) and what a torque is
made of (``ServoTerms``) are apart; the terms are made only while they are recorded.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.friction import TRANSFER_FRACTION, FrictionCompensation
from rfms_can.tables import complete
from rfms_can.wire.vocabulary import Law, Parameter

DAC_MIN: Final = -2048
DAC_MAX: Final = 2047
DAMPING_FRACTION: Final = 0.2
"""Fraction of the torque limit that damping (R3) may use."""
COMPLYING_BAND: Final = 2.5e-4
"""Dead band of all integrals while the arm complies, rad: 1.5 counts of the coarsest encoder. The
same at all joints: nodes that integrate different errors push into directions that comply."""
COMPLYING_SUM: Final = 2e-3
"""Bound of an error's integral then, rad s; for the same reason."""
COMPLYING_INTEGRAL_FRACTION: Final = 0.3
"""Fraction of its limit the integral may use while the arm complies: a blocked joint has to wait,
and not to jump when it comes free."""
_ZERO6: Final = (0.0,) * 6


@dataclass(frozen=True, slots=True)
class ServoConfig:
    """What a servo is set to; made once, of a node's parameters.

    Attributes:
        index: of the own joint among six, 0 to 5.
        proportional, derivative: K_p, Nm/rad, and K_d, Nm s/rad, of the PID.
        integral_period: K_i times the control period, Nm/rad.
        integral_limit: bound of the integral torque, Nm.
        dead_band: of a rigid joint's integral, rad.
        complying_limit: bound of each integral while the arm complies, Nm.
        natural_frequency: wn, rad/s.
        stiffness, damping: wn^2, 1/s2, and 2 zeta wn, 1/s, of the weighted law.
        design_inertia: K_p / wn^2, kg m2: the inertia the PID's gains were made for.
        weighted_integral: wn^2 / K_p, which makes the PID's integral one of the weighted law.
        torque_limit: Nm.
        damping_limit: torque limit of damping (R3), Nm.
        transfer_step: largest step of a bumpless transfer in one cycle, Nm.
        torque_per_code, torque_per_force_code: Nm per code of the two DACs; negative where the
            motor turns against the joint.
        bias_limit: the largest torque of the force set-point DAC, Nm.
    """

    index: int
    proportional: float
    derivative: float
    integral_period: float
    integral_limit: float
    dead_band: float
    complying_limit: float
    natural_frequency: float
    stiffness: float
    damping: float
    design_inertia: float
    weighted_integral: float
    torque_limit: float
    damping_limit: float
    transfer_step: float
    torque_per_code: float
    torque_per_force_code: float
    bias_limit: float

    @classmethod
    def of(cls, parameters: Mapping[Parameter, float], joint: int) -> "ServoConfig":
        """The configuration of joint 1 to 6 by its node's parameters."""
        p = parameters
        proportional, natural = p[Parameter.KP], p[Parameter.NATURAL_FREQUENCY]
        stiffness = natural * natural
        limit = p[Parameter.TORQUE_LIMIT]
        return cls(
            index=joint - 1,
            proportional=proportional,
            derivative=p[Parameter.KD],
            integral_period=p[Parameter.KI] * p[Parameter.PERIOD],
            integral_limit=p[Parameter.INTEGRAL_LIMIT],
            dead_band=p[Parameter.INTEGRAL_DEADBAND],
            complying_limit=COMPLYING_SUM * p[Parameter.KI],
            natural_frequency=natural,
            stiffness=stiffness,
            damping=2.0 * p[Parameter.DAMPING_RATIO] * natural,
            design_inertia=proportional / stiffness if natural else 0.0,
            weighted_integral=stiffness / proportional if proportional else 0.0,
            torque_limit=limit,
            damping_limit=DAMPING_FRACTION * limit,
            transfer_step=TRANSFER_FRACTION * limit,
            torque_per_code=p[Parameter.TORQUE_PER_CODE],
            torque_per_force_code=p[Parameter.TORQUE_PER_FORCE_CODE],
            bias_limit=DAC_MAX * abs(p[Parameter.TORQUE_PER_FORCE_CODE]),
        )


class ServoState:
    """What a servo remembers from cycle to cycle.

    Attributes:
        sums: integrals of the six errors, each as the torque of an own error, Nm.
        integral: integral term of the torque, Nm.
        complies: whether the sums are those of a complying arm.
        intended_speed: speed, rad/s, at which the servo would take the joint to where its error is.
            While the arm complies COMPLY takes up what is ignored of an error, so the own one is
            the real one; its torque is not, which accelerates the other joints as well.
        at_limit: whether the last torque was clamped to the limit.
        specification: of the rows used last; None before the first.
        transfer: what remains of a bumpless transfer, Nm.
        last_torque: without friction and bias, Nm: where the next transfer begins.
    """

    __slots__ = (
        "at_limit",
        "complies",
        "integral",
        "intended_speed",
        "last_torque",
        "specification",
        "sums",
        "transfer",
    )

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """As before the first torque."""
        self.sums = [0.0] * 6
        self.integral = self.intended_speed = self.transfer = self.last_torque = 0.0
        self.complies = self.at_limit = False
        self.specification: int | None = None


class ServoTerms(NamedTuple):
    """What one torque is made of, Nm; the terms add up to it.

    Attributes:
        proportional, derivative, integral: of the real error, or weighted by the inertia.
        gravity, inertia: feedforward of the rows.
        friction, dither: friction compensation, and the dither within it.
        bias: commanded by BIAS; goes out on the force DAC.
        compliant_damping: of the directions that comply.
        transfer: what a bumpless transfer still holds back.
        saturation: what the torque limit takes away.
    """

    proportional: float = 0.0
    derivative: float = 0.0
    integral: float = 0.0
    gravity: float = 0.0
    inertia: float = 0.0
    friction: float = 0.0
    dither: float = 0.0
    bias: float = 0.0
    compliant_damping: float = 0.0
    transfer: float = 0.0
    saturation: float = 0.0

    @property
    def torque(self) -> float:
        """Their sum, Nm: current DAC and force DAC together."""
        return sum(self)


# --- the laws -----------------------------------------------------------------------------------

LawTerms = tuple[float, float, float, float]
"""Proportional, derivative and compliant damping torque, Nm; factor of the integral torque."""
LawTorque = Callable[[ServoConfig, RowSets, float, float, Sequence[float]], LawTerms]
"""A law: configuration, rows, the row's error and rate, the six rates (rad/s)."""


def _pid(
    config: ServoConfig, rows: RowSets, error: float, rate: float, rates: Sequence[float]
) -> LawTerms:
    """K_p e + K_d e_dot of the real error; compliant damping mu d (1 - C) e_dot, d = K_p / wn^2."""
    damping = 0.0
    if rows.damping:
        damping = rows.damping * config.design_inertia * (rates[config.index] - rate)
    return config.proportional * error, config.derivative * rate, damping, 1.0


def _inertia_weighted(
    config: ServoConfig, rows: RowSets, error: float, rate: float, rates: Sequence[float]
) -> LawTerms:
    """M C (wn^2 e + 2 zeta wn e_dot); compliant damping mu (M - M C) e_dot."""
    damping = 0.0
    if rows.damping:
        damping = rows.damping * (_dot(rows.inertia_row, rates) - rate)
    return config.stiffness * error, config.damping * rate, damping, config.weighted_integral


LAW_TORQUES: Final[Mapping[int, LawTorque]] = complete(
    {
        Law.PID: _pid,
        Law.WEIGHTED: _inertia_weighted,
    },
    Law,
)
"""What each law on the wire makes of an error and its rate."""


def _dot(row: Sequence[float], values: Sequence[float]) -> float:
    r1, r2, r3, r4, r5, r6 = row
    v1, v2, v3, v4, v5, v6 = values
    return r1 * v1 + r2 * v2 + r3 * v3 + r4 * v4 + r5 * v5 + r6 * v6


class Servo:
    """PID, or the inertia-weighted law, with gravity, inertia, friction and bias; one joint.

    Args:
        parameters: the node's configuration.
        joint: number of the joint, 1 to 6.

    Attributes:
        config: what it is set to.
        state: what it remembers.
        friction: friction compensation.
        recording: whether ``terms`` is made with each torque.
        terms: of the last torque while recording.
    """

    __slots__ = ("config", "friction", "recording", "state", "terms")

    def __init__(self, parameters: Mapping[Parameter, float], joint: int) -> None:
        self.config = ServoConfig.of(parameters, joint)
        self.state = ServoState()
        self.friction = FrictionCompensation(parameters)
        self.recording = False
        self.terms = ServoTerms()

    def reset(self) -> None:
        """Forget the integral and the direction of the last motion."""
        self.state.reset()
        self.friction.reset()

    def torque(
        self,
        errors: Sequence[float],
        rates: Sequence[float],
        accelerations: Sequence[float],
        rows: RowSets,
        gravity: float,
        friction: float = 0.0,
        bias: float = 0.0,
    ) -> float:
        """Joint torque without the bias, Nm; clamped so that both together keep the limit.

        Args:
            errors: the six joint errors, rad.
            rates: their rates, rad/s.
            accelerations: the six desired accelerations, rad/s2.
            rows: own rows of the law.
            gravity: holding torque, Nm.
            friction: torque of the friction compensation, Nm; its transfers are its own.
            bias: bias torque, Nm, which goes out on the force DAC.
        """
        config, state = self.config, self.state
        # feedforward: gravity, and the row of M times the six accelerations
        m1, m2, m3, m4, m5, m6 = rows.inertia_row
        a1, a2, a3, a4, a5, a6 = accelerations
        total = gravity + m1 * a1 + m2 * a2 + m3 * a3 + m4 * a4 + m5 * a5 + m6 * a6
        # feedback: the law of the row's error and rate
        r1, r2, r3, r4, r5, r6 = rows.law_row
        e1, e2, e3, e4, e5, e6 = errors
        v1, v2, v3, v4, v5, v6 = rates
        error = r1 * e1 + r2 * e2 + r3 * e3 + r4 * e4 + r5 * e5 + r6 * e6
        rate = r1 * v1 + r2 * v2 + r3 * v3 + r4 * v4 + r5 * v5 + r6 * v6
        proportional, derivative, damping, factor = LAW_TORQUES[rows.law](
            config, rows, error, rate, rates
        )
        total += damping
        total += proportional + derivative
        # what remains: integral, bumpless transfer, friction, bias, and the limit
        own_error = errors[config.index]
        state.intended_speed = config.natural_frequency * own_error
        if rows.selection:
            integral = self._integrate(errors, rows.law_row, total + friction, factor)
        else:
            integral = self._integrate_own(own_error, total + friction)
        total += integral
        transferred = self._ramp_transfer(total, rows.specification)
        unclamped = transferred + friction + bias
        clamped = self._clamp(unclamped)
        if self.recording:
            dither = self.friction.dither
            inertia = _dot(rows.inertia_row, accelerations)
            self.terms = ServoTerms(
                *(proportional, derivative, integral, gravity, inertia, friction - dither, dither),
                *(bias, damping, transferred - total, clamped - unclamped),
            )
        return clamped - bias

    def alone(
        self, error: float, rate: float, gravity: float, friction: float = 0.0, inertia: float = 0.0
    ) -> float:
        """Torque of the PID on this joint's own error, Nm: homing and stopping need no others.

        Args:
            error, rate: of the own joint, rad and rad/s.
            gravity, friction, inertia: feedforward, Nm.
        """
        config = self.config
        proportional, derivative = config.proportional * error, config.derivative * rate
        total = gravity + friction + inertia + proportional + derivative
        integral = self._integrate_own(error, total)
        total += integral
        torque = self._clamp(total)
        if self.recording:
            self.terms = ServoTerms(
                *(proportional, derivative, integral, gravity, inertia, friction),
                saturation=torque - total,
            )
        return torque

    def damped(self, speed: float, gravity: float) -> float:
        """Torque that brakes the motion, capped, with gravity compensated (R3), Nm."""
        limit = self.config.damping_limit
        derivative = max(-limit, min(limit, -self.config.derivative * speed))
        if self.recording:
            self.terms = ServoTerms(derivative=derivative, gravity=gravity)
        return gravity + derivative

    def _integrate_own(self, error: float, others: float) -> float:
        """Integral torque of a rigid joint: of its own error, under either law."""
        config, state = self.config, self.state
        index, sums = config.index, state.sums
        state.complies = False
        total = others + sums[index]
        self._sum_up(index, error, total, 1.0, config.dead_band, config.integral_limit)
        own = state.integral = sums[index]
        sums[:] = _ZERO6
        sums[index] = own
        return own

    def _integrate(
        self, errors: Sequence[float], row: Sequence[float], others: float, factor: float
    ) -> float:
        """Integral torque while the arm complies: the law's row times integrals of all six errors.

        So the integral is split by the same row as the errors are: nothing remains in a direction
        that complies. Each is kept as the torque it would make of an own error.
        """
        config, state = self.config, self.state
        sums = state.sums
        if not state.complies:  # the other joints do not know the sum it had as a rigid joint
            state.complies = True
            sums[:], state.integral = _ZERO6, 0.0
        total = others + state.integral
        for j, error in enumerate(errors):
            self._sum_up(j, error, total, row[j], COMPLYING_BAND, config.complying_limit)
        integral = _dot(row, sums) * factor
        bound = COMPLYING_INTEGRAL_FRACTION * config.integral_limit
        if not -bound <= integral <= bound:
            kept = bound / abs(integral)  # of each, so that it comes back at once
            sums[:] = [kept * one for one in sums]
            integral *= kept
        state.integral = integral
        return integral

    def _sum_up(
        self, j: int, error: float, total: float, share: float, band: float, bound: float
    ) -> None:
        """One step of one integral, frozen in the dead band and against a clamped torque.

        A joint that rests beyond its goal is held there by friction and by its own compensation
        of it: the compensation turns first, and the integral does not wind up meanwhile.
        """
        if -band <= error <= band:
            return
        config = self.config
        if j == config.index and self.friction.resting and self.friction.turn(error):
            return
        if abs(total) >= config.torque_limit and total * share * error > 0.0:
            return
        sums = self.state.sums
        new = sums[j] + config.integral_period * error
        sums[j] = bound if new > bound else -bound if new < -bound else new

    def _ramp_transfer(self, torque: float, specification: int) -> float:
        """Bumpless transfer: where what complies has changed, reach the new torque in small steps.

        From the torque the joint gave to one it can give: both are clamped, since a step within a
        clamped torque would act unseen.
        """
        state = self.state
        if specification != state.specification:
            if state.specification is not None:
                state.transfer = state.last_torque - self._clamp(torque)
            state.specification = specification
        if state.transfer:
            step = self.config.transfer_step
            state.transfer -= max(-step, min(step, state.transfer))
            torque = self._clamp(torque) + state.transfer
        state.last_torque = self._clamp(torque)
        return torque

    def _clamp(self, torque: float) -> float:
        limit = self.config.torque_limit
        if -limit <= torque <= limit:
            self.state.at_limit = False
            return torque
        self.state.at_limit = True
        return limit if torque > 0.0 else -limit

    def deliverable_bias(self, bias: float) -> float:
        """A bias torque as far as the force DAC can give it, Nm.

        What it cannot give must not be taken off the servo's own torque either.
        """
        limit = self.config.bias_limit
        return -limit if bias < -limit else limit if bias > limit else bias

    def code(self, torque: float) -> int:
        """Motor-current DAC code of a joint torque (Nm)."""
        code = round(torque / self.config.torque_per_code)
        return DAC_MIN if code < DAC_MIN else DAC_MAX if code > DAC_MAX else code

    def force_code(self, torque: float) -> int:
        """Force-set-point DAC code of a bias torque (Nm)."""
        code = round(torque / self.config.torque_per_force_code) if torque else 0
        return DAC_MIN if code < DAC_MIN else DAC_MAX if code > DAC_MAX else code
