"""The bias force as joint torques, open or closed loop (thesis V.5, Ch. VII).

Open loop, tau = J^T S F: what reaches the environment is uncertain by the friction. Closed over the
wrist sensor, tau = J^T S (F + k_p e + k_i int e) with e = F - what is felt. In contact a torque
becomes a force at once, whatever the stiffness: so the integral does the work, and its gain is
bounded by the delay of the bus alone (three periods from a torque to its reading). In the air a
loop is open all the same: there the integral grows until the arm gets going on its way to contact,
and fades where no force is asked for, or what a tare has left over would send the arm off. In
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
MOMENT_PART: Final = 0.25
"""Part of it that moments have: with all of it a block on a wall rocks from one edge to another."""
INTEGRAL_LIMIT: Final[Vector6] = (60.0, 60.0, 60.0, 8.0, 8.0, 8.0)
"""Largest correction, N and N m: what friction may need."""
DEAD_BAND: Final[Vector6] = (0.3, 0.3, 0.3, 0.05, 0.05, 0.05)
"""Error that is none, N and N m: three deviations of a good sensor's noise, and what it does to the
moments about a tool 0.16 m from it."""
TOUCH: Final[Vector6] = (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
"""What is felt in contact, N and N m, along one axis or another."""
FORGET_S: Final = 0.2
"""Time constant, s, with which in the air an integral fades that pushes nowhere, or the wrong way:
what friction needed in contact would push a free arm on."""
MOVING: Final[Vector6] = (5e-3, 5e-3, 5e-3, 0.05, 0.05, 0.05)
"""Speed, m/s and rad/s, at which an arm has overcome what friction hid."""
SLOWING_S: Final = 0.012
"""Time constant, s, with which in the air the integral of an arm that moves fades: one that looks
for contact gets going, and meets it slowly."""
PASSAGE_S: Final = 0.1
"""Time, s, from a change of what complies until the loop closes: what the joints pressed with while
they were rigid goes out first, and the integral would answer it."""
BIAS_PART: Final = 0.8
"""Part of a joint's torque limit that a bias force may take: gravity and friction need the rest."""
SLEW_PART: Final = 0.007
"""Part of a joint's torque limit by which its bias may change, a cycle."""

NO_WAY: Final[Vector6] = (0.0,) * 6


class BiasForce:
    """Joint torques of a force to be exerted.

    In the air the integral of a closed loop gets an arm going, and no more; where no force is asked
    for an error within the dead band is none.

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
        "_integral",
        "_kept",
        "_kept_moving",
        "_limit",
        "_most",
        "_moving",
        "_passage",
        "_rate",
        "_slew",
        "_touch",
        "_wait",
        "torque",
    )

    def __init__(self, torque_limits: Sequence[float], period_s: float, closed: bool) -> None:
        self._slew = SLEW_PART * np.array(torque_limits)
        self._most = BIAS_PART * np.array(torque_limits)
        self._rate = INTEGRAL_RATE * period_s * np.repeat((1.0, MOMENT_PART), 3)
        self._limit = np.array(INTEGRAL_LIMIT)
        self._band, self._touch = np.array(DEAD_BAND), np.array(TOUCH)
        self._kept = math.exp(-period_s / FORGET_S)
        self._kept_moving = math.exp(-period_s / SLOWING_S)
        self._moving = period_s * np.array(MOVING)
        self._passage = round(PASSAGE_S / period_s)
        self._closed = closed
        self.reset()

    def reset(self) -> None:
        """No torque at once."""
        self.torque: Matrix = np.zeros(6)
        self._integral = np.zeros(6)
        self._wait = 0

    def begin(self) -> None:
        """Something else complies from now on: what the integral held was for another frame."""
        self._integral[:] = 0.0
        self._wait = self._passage

    @property
    def active(self) -> bool:
        """Whether any torque is asked for."""
        return bool(self.torque.any())

    def push(
        self,
        J: Matrix,
        selection: Selection,
        force: Sequence[float],
        felt: Sequence[float],
        gone: npt.ArrayLike = NO_WAY,
    ) -> None:
        """One cycle with a force to exert.

        Args:
            J: (6, 6), Jacobian of the compliance frame.
            selection: what complies.
            force: to be exerted on what the tool touches, N and N m, in the compliance frame.
            felt: what is, likewise; used if the loop is closed.
            gone: way of the cycle in the directions that comply, m and rad, smooth; likewise.
        """
        asked = np.asarray(force)
        if not self._closed or self._wait:
            self._wait = max(0, self._wait - 1)
            self._towards(self._within(J.T @ np.where(selection.mask, asked, 0.0)))
            return
        have = np.asarray(felt)
        missing = np.where(selection.mask, asked - have, 0.0)
        missing -= np.where(asked == 0.0, np.clip(missing, -self._band, self._band), 0.0)
        before = self._integral
        touches = bool((np.abs(have) > self._touch).any())
        grown = self._in_contact(missing) if touches else self._in_the_air(asked, missing, gone)
        asked = asked + PROPORTIONAL * missing + grown
        wanted = J.T @ np.where(selection.mask, asked, 0.0)
        possible = self._within(wanted)
        more = np.abs(grown) > np.abs(before)  # may not, while the joints give what they can
        self._integral = grown if possible is wanted else np.where(more, before, grown)
        self._towards(possible)

    def _in_contact(self, missing: Matrix) -> Matrix:
        """The integral, one cycle on."""
        return np.clip(self._integral + self._rate * missing, -self._limit, self._limit)

    def _in_the_air(self, asked: Matrix, missing: Matrix, gone: npt.ArrayLike) -> Matrix:
        """The integral, one cycle on: it gets an arm going that looks for contact."""
        before, faded = self._integral, self._kept * self._integral
        pushes = np.where(before * missing >= 0.0, before, faded) + self._rate * missing
        moves = np.abs(gone) > self._moving
        pushes = np.where(moves, self._kept_moving * before, pushes)
        return np.where(asked == 0.0, faded, np.clip(pushes, -self._limit, self._limit))

    def _within(self, torque: Matrix) -> Matrix:
        """The torque, all of it less by the same part where a joint cannot give it."""
        beyond = float((np.abs(torque) / self._most).max())
        return torque if beyond <= 1.0 else torque / beyond

    def relax(self) -> None:
        """One cycle without: the torque goes back to none."""
        self._integral[:] = 0.0
        if self.active:
            self._towards(np.zeros(6))

    def _towards(self, wanted: Matrix) -> None:
        self.torque = self.torque + np.clip(wanted - self.torque, -self._slew, self._slew)
