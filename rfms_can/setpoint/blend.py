"""The polynomials of the trajectory: segment parameter h and matching polynomials (section 3.4).

Master and nodes share them: the master needs h for r = 1 - h, each node the matching polynomial of
its own joint. Inside a transition both are functions of p (3.14), which runs from 0 at
t = -t_acc to 1 at t = +t_acc.
"""

from typing import Final, NamedTuple, Self

Derivatives = tuple[float, float, float, float]
"""A value and its first three derivatives: position, velocity, acceleration, jerk."""


def blend_parameter(p: float) -> float:
    """h t_seg / t_acc during a transition (3.15): from rest at p = 0 to cruise at p = 1.

    Three derivatives vanish at p = 0; at p = 1 the rate is 2 per unit of p, and the second and
    third derivative vanish again.
    """
    square = p * p
    return ((2.0 * p - 6.0) * p + 5.0) * square * square


def stop_parameter(p: float) -> float:
    """(h - h_stop) t_seg / t_acc of a controlled stop: (3.15) reversed, 0 to 1.

    From cruise at p = 0 to rest at p = 1, acceleration and jerk zero at both ends: a stop along
    the path takes 2 t_acc and covers the distance of t_acc at cruise.
    """
    return 2.0 * p - blend_parameter(p)


def segment_derivatives(time: float, acceleration_time: float, segment_time: float) -> Derivatives:
    """h and its time derivatives at local ``time``, seconds from -t_acc (3.15, 3.16)."""
    if time >= acceleration_time:
        return (time / segment_time, 1.0 / segment_time, 0.0, 0.0)
    span = 2.0 * acceleration_time
    p = (time + acceleration_time) / span
    scale = acceleration_time / segment_time
    return (
        scale * blend_parameter(p),
        scale * ((12.0 * p - 30.0) * p + 20.0) * p**3 / span,
        scale * ((60.0 * p - 120.0) * p + 60.0) * p**2 / span**2,
        scale * ((240.0 * p - 360.0) * p + 120.0) * p / span**3,
    )


def earlier(motion: Derivatives, time: float) -> Derivatives:
    """``motion`` as it was ``time`` seconds ago, by its Taylor series."""
    position, velocity, acceleration, jerk = motion
    return (
        position - time * (velocity - time * (acceleration / 2.0 - time * jerk / 6.0)),
        velocity - time * (acceleration - time * jerk / 2.0),
        acceleration - time * jerk,
        jerk,
    )


class MatchingPolynomial(NamedTuple):
    """Polynomial added to a new segment so that it continues the motion of the old one (3.18).

    Degree 7 with four conditions at either end, all zero at p = 1, so (1 - p)^4 divides it: the
    rest, q0 + q1 p + q2 p^2 + q3 p^3, is the Taylor series at p = 0 of the polynomial over
    (1 - p)^4 = 1 / (1 + 4 p + 10 p^2 + 20 p^3 + ...). Radians; the derivatives are per unit of p.
    """

    q0: float
    q1: float
    q2: float
    q3: float

    @classmethod
    def matching(cls, difference: Derivatives, acceleration_time: float) -> Self:
        """The polynomial that removes all four differences within 2 t_acc: the default blend.

        Args:
            difference: position, velocity, acceleration and jerk of the old motion less those of
                the new one at the hand-over, rad and seconds.
            acceleration_time: t_acc, s.
        """
        position, velocity, acceleration, jerk = difference
        span = 2.0 * acceleration_time
        a0 = position
        a1 = span * velocity
        a2 = span * span * acceleration / 2.0
        a3 = span * span * span * jerk / 6.0
        return cls(
            a0,
            a1 + 4.0 * a0,
            a2 + 4.0 * a1 + 10.0 * a0,
            a3 + 4.0 * a2 + 10.0 * a1 + 20.0 * a0,
        )

    @classmethod
    def thesis(cls, position: float, velocity: float, acceleration_time: float) -> Self:
        """The polynomial of (3.19): acceleration and jerk at the hand-over are assumed zero.

        They are not if the old segment is Cartesian or its goal moves: the joint's acceleration
        then has a step of that size.
        """
        return cls.matching((position, velocity, 0.0, 0.0), acceleration_time)

    def at(self, p: float) -> float:
        """The value at p, 0 to 1, radians; exactly 0 at p = 1."""
        q0, q1, q2, q3 = self
        s = 1.0 - p
        s *= s
        return s * s * (((q3 * p + q2) * p + q1) * p + q0)

    @property
    def coefficients(self) -> tuple[float, ...]:
        """a0 to a7 of the power series in p; a2 = a3 = 0 in the thesis' form (3.19)."""
        product = [0.0] * 8
        for i, binomial in enumerate((1.0, -4.0, 6.0, -4.0, 1.0)):
            for j, q in enumerate(self):
                product[i + j] += binomial * q
        return tuple(product)

    def derivatives(self, p: float, acceleration_time: float) -> Derivatives:
        """Value and time derivatives at p: rad, rad/s, rad/s2, rad/s3."""
        series = list(self.coefficients)
        span = 2.0 * acceleration_time
        values = []
        for order in range(4):
            value = 0.0
            for coefficient in reversed(series):
                value = value * p + coefficient
            values.append(value / span**order)
            series = [k * coefficient for k, coefficient in enumerate(series)][1:]
        return (values[0], values[1], values[2], values[3])


NO_MATCH: Final = MatchingPolynomial(0.0, 0.0, 0.0, 0.0)
"""The matching polynomial between two motions that already agree."""
