"""The bias force as joint torques, open or closed loop (thesis V.5, Ch. VII).

Open loop, tau = J^T S F: what reaches the environment is uncertain by the friction. Closed over the
wrist sensor, tau = J^T S (F + k_p e + k_i int e) with e = F - the measured force. In contact a
torque becomes a force at once, whatever the stiffness: so the integral does the work, and only
the delay of the bus bounds its gain (three periods from a torque to its reading). In the air a
loop is open all the same: there the integral grows until the arm gets going towards contact,
and fades where no force is commanded, or what a tare has left over would send the arm off. In
contact a dead band is for that.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.compliance.selection import Selection
from rfms_can.messages import Vector6

Matrix = npt.NDArray[np.float64]

PROPORTIONAL: Final = 0.1
INTEGRAL_RATE: Final = 16.0
"""k_i of forces, 1/s."""
MOMENT_FRACTION: Final = 0.25
"""Fraction of it for moments: with all of it a block on a wall rocks from one edge to another."""
INTEGRAL_LIMIT: Final[Vector6] = (60.0, 60.0, 60.0, 8.0, 8.0, 8.0)
"""Largest correction, N and N m: what friction may need."""
DEAD_BAND: Final[Vector6] = (0.3, 0.3, 0.3, 0.05, 0.05, 0.05)
"""Error treated as zero, N and N m: three deviations of a good sensor's noise, and its effect on
the moments about a tool 0.16 m from it."""
CONTACT: Final[Vector6] = (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
"""Measured wrench that means contact, N and N m, along one axis or another."""
INTEGRAL_FADE_S: Final = 0.2
"""Time constant, s, with which in the air an integral fades without a force to exert, or with the
wrong sign: what friction needed in contact would accelerate a free arm."""
MOVING: Final[Vector6] = (5e-3, 5e-3, 5e-3, 0.05, 0.05, 0.05)
"""Speed, m/s and rad/s, at which an arm has overcome what friction hid."""
MOVING_FADE_S: Final = 0.012
"""Time constant, s, with which in the air the integral of an arm that moves fades: one that looks
for contact gets going, and meets it slowly."""
LOOP_DELAY_S: Final = 0.1
"""Time, s, from a change of what complies until the loop closes: what the joints pressed with while
they were rigid goes out first, and the integral would answer it."""
BIAS_FRACTION: Final = 0.8
"""Fraction of a joint's torque limit for a bias force: gravity and friction need the rest."""
SLEW_FRACTION: Final = 0.007
"""Fraction of a joint's torque limit by which its bias may change, a cycle."""

ZERO6: Final[Vector6] = (0.0,) * 6


class BiasForce:
    """Joint torques of a force to be exerted.

    In the air the integral of a closed loop gets an arm going, and no more; where no force is
    commanded, an error within the dead band counts as zero.

    Args:
        torque_limits: of the joints, Nm.
        period_s: control period, s.
        closed: whether the loop is closed over the sensor.

    Attributes:
        torque: what goes out, Nm (6).
    """

    __slots__ = (
        "_band",
        "_closed",
        "_contact",
        "_decay",
        "_delay_cycles",
        "_integral",
        "_limit",
        "_max_torque",
        "_moving",
        "_moving_decay",
        "_rate",
        "_slew",
        "_wait",
        "torque",
    )

    def __init__(self, torque_limits: Sequence[float], period_s: float, closed: bool) -> None:
        self._slew = SLEW_FRACTION * np.array(torque_limits)
        self._max_torque = BIAS_FRACTION * np.array(torque_limits)
        self._rate = INTEGRAL_RATE * period_s * np.repeat((1.0, MOMENT_FRACTION), 3)
        self._limit = np.array(INTEGRAL_LIMIT)
        self._band, self._contact = np.array(DEAD_BAND), np.array(CONTACT)
        self._decay = math.exp(-period_s / INTEGRAL_FADE_S)
        self._moving_decay = math.exp(-period_s / MOVING_FADE_S)
        self._moving = period_s * np.array(MOVING)
        self._delay_cycles = round(LOOP_DELAY_S / period_s)
        self._closed = closed
        self.reset()

    def reset(self) -> None:
        """Drop the torque immediately."""
        self.torque: Matrix = np.zeros(6)
        self._integral = np.zeros(6)
        self._wait = 0

    def begin(self) -> None:
        """Something else complies from now on: what the integral held was for another frame."""
        self._integral[:] = 0.0
        self._wait = self._delay_cycles

    @property
    def active(self) -> bool:
        """Whether any torque goes out."""
        return bool(self.torque.any())

    def update(
        self,
        J: Matrix,
        selection: Selection,
        force: Sequence[float],
        measured: Sequence[float],
        displacement: npt.ArrayLike = ZERO6,
    ) -> None:
        """One cycle with a force to exert.

        Args:
            J: (6, 6), Jacobian of the compliance frame.
            selection: what complies.
            force: to be exerted on what the tool touches, N and N m, in the compliance frame.
            measured: the force that is exerted, likewise; used if the loop is closed.
            displacement: of the compliance frame per cycle, m and rad, low-pass filtered; likewise.
        """
        commanded = np.asarray(force)
        if not self._closed or self._wait:
            self._wait = max(0, self._wait - 1)
            self._slew_to(self._limited(J.T @ np.where(selection.mask, commanded, 0.0)))
            return
        have = np.asarray(measured)
        missing = np.where(selection.mask, commanded - have, 0.0)
        missing -= np.where(commanded == 0.0, np.clip(missing, -self._band, self._band), 0.0)
        before = self._integral
        touches = bool((np.abs(have) > self._contact).any())
        grown = (
            self._in_contact(missing)
            if touches
            else self._in_the_air(commanded, missing, displacement)
        )
        commanded = commanded + PROPORTIONAL * missing + grown
        wanted = J.T @ np.where(selection.mask, commanded, 0.0)
        possible = self._limited(wanted)
        more = np.abs(grown) > np.abs(before)  # may not, while the joints give what they can
        self._integral = grown if possible is wanted else np.where(more, before, grown)
        self._slew_to(possible)

    def _in_contact(self, missing: Matrix) -> Matrix:
        """The integral, one cycle on."""
        return np.clip(self._integral + self._rate * missing, -self._limit, self._limit)

    def _in_the_air(
        self, commanded: Matrix, missing: Matrix, displacement: npt.ArrayLike
    ) -> Matrix:
        """The integral, one cycle on: it gets an arm going that looks for contact."""
        before, faded = self._integral, self._decay * self._integral
        growing = np.where(before * missing >= 0.0, before, faded) + self._rate * missing
        moves = np.abs(displacement) > self._moving
        growing = np.where(moves, self._moving_decay * before, growing)
        return np.where(commanded == 0.0, faded, np.clip(growing, -self._limit, self._limit))

    def _limited(self, torque: Matrix) -> Matrix:
        """The torque, scaled down as a whole where a joint cannot give it."""
        beyond = float((np.abs(torque) / self._max_torque).max())
        return torque if beyond <= 1.0 else torque / beyond

    def relax(self) -> None:
        """One cycle without a force to exert: the torque returns to zero."""
        self._integral[:] = 0.0
        if self.active:
            self._slew_to(np.zeros(6))

    def _slew_to(self, wanted: Matrix) -> None:
        self.torque = self.torque + np.clip(wanted - self.torque, -self._slew, self._slew)
