"""Friction compensation: which way the joint moves, or will move (f_i of Eq. 5.11).

A rigid joint follows its set-point, so the desired velocity gives the sign. A complying joint moves
where external forces take it: while it moves, the measured velocity gives the sign; at rest, the
torque of the servo. At rest in contact neither does, and the force on the environment is uncertain
by the stiction (thesis V.5: "the maximum force control errors occur when manipulator is at rest").
A declared dither helps: it compensates friction in one direction and the other in turn, by less
than all of it, so that nothing moves but what an external force moves by the little that remains.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.vocabulary import Parameter

REVERSAL_S: Final = 0.25
"""Time, s, in which the friction of a resting rigid joint turns to where its error is."""
COMPLYING_FRACTION: Final = 0.98
"""Fraction of the friction that is compensated while the joint complies: overcompensation would
drive it on by itself. What remains holds a joint back that a commanded motion has to take along:
the damping of the compliant directions, which does that, must be stronger."""
TRANSFER_FRACTION: Final = 0.006
"""Fraction of the torque limit by which torque may step in one cycle during a bumpless transfer,
where what complies changes."""
TRANSFER_S: Final = 0.1
"""Shortest time, s, of the bumpless transfer of the friction compensation."""
MOVING_CODES: Final = 1.5
"""Velocity ADC codes from which a complying joint counts as moving."""
FULL_COMPENSATION_COUNTS: Final = 4.0
"""Encoder counts of error for which a complying joint at rest has its friction compensated in
full: one count more or less must not turn it."""


class FrictionCompensation:
    """Torque that overcomes the friction of one joint.

    Args:
        parameters: the node's configuration.

    Attributes:
        resting: whether a rigid joint's desired speed counted as rest.
        dither: dither within the torque returned last, Nm.
    """

    __slots__ = (
        "_complies",
        "_coulomb_negative",
        "_coulomb_positive",
        "_coulomb_torque",
        "_dither_fraction",
        "_dither_half_wave",
        "_dither_wave",
        "_full_speed",
        "_moving_speed",
        "_resting_speed",
        "_reversal_step",
        "_transfer_cycles",
        "_transfer_left",
        "_transfer_step",
        "_viscous",
        "_viscous_torque",
        "dither",
        "resting",
    )

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        p = parameters
        self._coulomb_positive = p[Parameter.COULOMB_POSITIVE]
        self._coulomb_negative = p[Parameter.COULOMB_NEGATIVE]
        self._viscous = p[Parameter.VISCOUS]
        self._resting_speed = p[Parameter.FRICTION_SPEED]
        self._reversal_step = (
            (self._coulomb_positive + self._coulomb_negative) * p[Parameter.PERIOD] / REVERSAL_S
        )
        self._transfer_cycles = round(TRANSFER_S / p[Parameter.PERIOD])
        self._transfer_step = TRANSFER_FRACTION * p[Parameter.TORQUE_LIMIT]
        self._moving_speed = MOVING_CODES * abs(p[Parameter.RATE_PER_CODE])
        natural, counts = p[Parameter.NATURAL_FREQUENCY], abs(p[Parameter.COUNTS_PER_UNIT])
        self._full_speed = FULL_COMPENSATION_COUNTS * natural / counts if counts else 0.0
        self._dither_fraction = p[Parameter.DITHER_FRACTION]
        halves = 2.0 * p[Parameter.PERIOD]
        self._dither_half_wave = max(1, round(p[Parameter.DITHER_PERIOD] / halves))
        self._dither_wave = 2 * self._dither_half_wave  # up as long as down: its mean must be zero
        self.reset()

    def reset(self) -> None:
        """Forget the direction of the last motion."""
        self._coulomb_torque = self._viscous_torque = self.dither = 0.0
        self._complies = False
        self._transfer_left = 0
        self.resting = True

    def rigid(self, speed: float) -> float:
        """Torque at a desired speed (rad/s), Nm.

        Signed by the desired velocity; at rest it stays as the last motion left it. A joint that
        stops a little short then still has its friction overcome in the direction it came from
        and creeps home, instead of sticking until the integral has grown to the stiction.
        """
        if self._complies:
            self._transfer_left = self._transfer_cycles
        self._complies = self.resting = False
        self.dither = 0.0
        coulomb = max(-self._coulomb_negative, min(self._coulomb_positive, self._coulomb_torque))
        if speed > self._resting_speed:
            coulomb = self._coulomb_positive
        elif speed < -self._resting_speed:
            coulomb = -self._coulomb_negative
        else:
            self.resting = True
        return self._ramp_transfer(coulomb, self._viscous * speed)

    def complying(
        self, desired: float, measured: float, intended_speed: float, cycle: int
    ) -> float:
        """Torque of a complying joint, Nm.

        Args:
            desired: commanded speed, rad/s.
            measured: speed, rad/s.
            intended_speed: speed, rad/s, at which the servo would take the joint to its error.
            cycle: number of the control cycle; the dither's clock.
        """
        moving = self._moving_speed
        rests = -moving < measured < moving
        speed = desired + intended_speed if rests else measured
        if not self._complies:
            self._transfer_left = self._transfer_cycles
        self._complies = True
        self.resting = False  # the integral must not be held back
        full = max(moving, self._full_speed) if rests else moving
        fraction = max(-1.0, min(1.0, speed / full)) if moving else (speed > 0.0) - (speed < 0.0)
        size = self._coulomb_positive if fraction > 0.0 else self._coulomb_negative
        torque = self._ramp_transfer(COMPLYING_FRACTION * size * fraction, self._viscous * speed)
        self.dither = 0.0
        if self._dither_fraction and rests and not self._transfer_left:
            up = cycle % self._dither_wave < self._dither_half_wave
            wave = self._coulomb_positive if up else -self._coulomb_negative
            self.dither = self._dither_fraction * (wave - self._coulomb_torque)
            torque += self.dither
        return torque

    def _ramp_transfer(self, coulomb: float, viscous: float) -> float:
        """The next torque: at once, or in small steps where compliance has begun or ended.

        What has not been reached yet, of the Coulomb and of the viscous torque, counts as Coulomb.
        """
        if self._transfer_left:
            change = coulomb + viscous - self._coulomb_torque - self._viscous_torque
            reached = -self._transfer_step < change < self._transfer_step
            self._transfer_left = max(self._transfer_left - 1, 0 if reached else 1)
            if not reached:
                step = self._transfer_step if change > 0.0 else -self._transfer_step
                coulomb = self._coulomb_torque + self._viscous_torque + step - viscous
        self._coulomb_torque, self._viscous_torque = coulomb, viscous
        return coulomb + viscous

    def turn(self, error: float) -> bool:
        """Turn a resting joint's friction one step towards its error; False if it is there."""
        before = self._coulomb_torque
        if error > 0.0:
            self._coulomb_torque = min(before + self._reversal_step, self._coulomb_positive)
        else:
            self._coulomb_torque = max(before - self._reversal_step, -self._coulomb_negative)
        return self._coulomb_torque != before
