"""Friction compensation: which way the joint moves, or will (f_i of Eq. 5.11).

A rigid joint follows its set-point, so the desired velocity tells. A complying joint goes where it
is pushed: while it moves the measured velocity tells; at rest, the torque that the servo pushes
with. At rest in contact neither tells, and the force that reaches the environment is uncertain by
the stiction (thesis V.5: "the maximum force control errors occur when manipulator is at rest").
A declared dither helps: it compensates friction in one direction and the other in turn, by less
than all of it, so that nothing moves but what is pushed from outside by the little that is left.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

REVERSAL_S: Final = 0.25
"""Time, s, in which the friction of a resting rigid joint turns to where its error is."""
COMPLYING_PART: Final = 0.98
"""Part of the friction that is compensated while the joint complies: more than there is would drive
it on by itself. What is left holds a joint back that a commanded motion shall take along: the
damping of the compliant directions, which does that, must be stronger."""
PASSAGE_PART: Final = 0.006
"""Part of the torque limit by which torque may step, a cycle, where what complies changes."""
PASSAGE_S: Final = 0.1
"""Time, s, for which its friction compensation does so at least."""
MOVING_CODES: Final = 1.5
"""Velocity ADC codes from which a complying joint counts as moving."""
PUSHING_COUNTS: Final = 4.0
"""Encoder counts of error for which a complying joint that rests has its friction compensated in
full: one count more or less must not turn it."""


class FrictionCompensation:
    """Torque that overcomes the friction of one joint.

    Args:
        parameters: the node's configuration.

    Attributes:
        resting: whether a rigid joint's desired speed counted as rest.
    """

    __slots__ = (
        "_complies",
        "_coulomb",
        "_dither",
        "_half_wave",
        "_moving",
        "_negative",
        "_passage",
        "_passing",
        "_positive",
        "_pushing",
        "_reversal",
        "_rubs",
        "_step",
        "_still",
        "_viscous",
        "_wave",
        "resting",
    )

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._positive = p[Parameter.COULOMB_POSITIVE]
        self._negative = p[Parameter.COULOMB_NEGATIVE]
        self._viscous = p[Parameter.VISCOUS]
        self._still = p[Parameter.FRICTION_SPEED]
        self._reversal = (self._positive + self._negative) * p[Parameter.PERIOD] / REVERSAL_S
        self._passage = round(PASSAGE_S / p[Parameter.PERIOD])
        self._step = PASSAGE_PART * p[Parameter.TORQUE_LIMIT]
        self._moving = MOVING_CODES * abs(p[Parameter.RATE_PER_CODE])
        natural, counts = p[Parameter.NATURAL_FREQUENCY], abs(p[Parameter.COUNTS_PER_UNIT])
        self._pushing = PUSHING_COUNTS * natural / counts if counts else 0.0
        self._dither = p[Parameter.DITHER_PART]
        halves = 2.0 * p[Parameter.PERIOD]
        self._half_wave = max(1, round(p[Parameter.DITHER_PERIOD] / halves))
        self._wave = 2 * self._half_wave  # up as long as down: it must not push by itself
        self.reset()

    def reset(self) -> None:
        """Forget the direction of the last motion."""
        self._coulomb = self._rubs = 0.0
        self._complies = False
        self._passing = 0  # cycles of small steps that are left
        self.resting = True

    def rigid(self, speed: float) -> float:
        """Torque at a desired speed (rad/s), Nm.

        Signed by the desired velocity; at rest it stays as the last motion left it. A joint that
        stops a little short then still has its friction overcome in the direction it came from
        and creeps home, instead of sticking until the integral has grown to the stiction.
        """
        if self._complies:
            self._passing = self._passage
        self._complies = self.resting = False
        coulomb = max(-self._negative, min(self._positive, self._coulomb))
        if speed > self._still:
            coulomb = self._positive
        elif speed < -self._still:
            coulomb = -self._negative
        else:
            self.resting = True
        return self._go_to(coulomb, self._viscous * speed)

    def complying(self, desired: float, measured: float, push: float, cycle: int) -> float:
        """Torque of a complying joint, Nm.

        Args:
            desired: commanded speed, rad/s.
            measured: speed, rad/s.
            push: speed, rad/s, at which the servo's torque would let the joint move.
            cycle: number of the control cycle; the dither's clock.
        """
        moving = self._moving
        rests = -moving < measured < moving
        speed = desired + push if rests else measured
        if not self._complies:
            self._passing = self._passage
        self._complies = True
        self.resting = False  # no integral to be kept back
        full = max(moving, self._pushing) if rests else moving
        part = max(-1.0, min(1.0, speed / full)) if moving else (speed > 0.0) - (speed < 0.0)
        size = self._positive if part > 0.0 else self._negative
        torque = self._go_to(COMPLYING_PART * size * part, self._viscous * speed)
        if self._dither and rests and not self._passing:
            up = cycle % self._wave < self._half_wave
            wave = self._positive if up else -self._negative
            torque += self._dither * (wave - self._coulomb)
        return torque

    def _go_to(self, coulomb: float, rubs: float) -> float:
        """The next torque: at once, but where compliance begins or ends in small steps.

        What is not there yet of the Coulomb and of the viscous part counts as the Coulomb one's.
        """
        if self._passing:
            change = coulomb + rubs - self._coulomb - self._rubs
            there = -self._step < change < self._step
            self._passing = max(self._passing - 1, 0 if there else 1)
            if not there:
                step = self._step if change > 0.0 else -self._step
                coulomb = self._coulomb + self._rubs + step - rubs
        self._coulomb, self._rubs = coulomb, rubs
        return coulomb + rubs

    def turn(self, error: float) -> bool:
        """Turn a resting joint's friction a step to where its error is; False if it is there."""
        before = self._coulomb
        if error > 0.0:
            self._coulomb = min(before + self._reversal, self._positive)
        else:
            self._coulomb = max(before - self._reversal, -self._negative)
        return self._coulomb != before
