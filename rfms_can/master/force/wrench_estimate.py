"""The wrench of the hand on the world: measured by the wrist sensor, or estimated from torques.

The sensor sits between hand and tool and reads what the hand does to the tool: the tool's weight is
in it, and a bias. Without one, what the motors do beyond gravity, inertia and friction is what
reaches the world: as uncertain as the friction is.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from rfms_can.arm import JointFriction, Load
from rfms_can.arm.wrist import SENSOR_RANGE
from rfms_can.master.force.specification import NO_FORCE
from rfms_can.master.force.wrench import weight
from rfms_can.messages import Vector6
from rfms_can.transform import Transform, differential_transform

Matrix = npt.NDArray[np.float64]

TARE_CYCLES: Final = 25
"""Readings that a tare averages."""
ESTIMATE_TIME_S: Final = 0.04
"""Time constant of a wrench estimated from torques."""


class WrenchEstimate:
    """The wrench of the hand on the world, at T6 along its axes.

    Args:
        friction: what the servos compensate, per joint.
        period_s: control period, s.

    Attributes:
        sensed: whether readings of a sensor have come.
        tared: whether the sensor's bias is known.
        wrench: N and N m (6), weight and bias taken out.
    """

    def __init__(self, friction: Sequence[JointFriction], period_s: float) -> None:
        self._friction = friction
        self._gain = period_s / (ESTIMATE_TIME_S + period_s)
        self.reset()

    def reset(self) -> None:
        """Before the first reading."""
        self.sensed = self.tared = False
        self.wrench: Vector6 = NO_FORCE
        self._bias: Vector6 = NO_FORCE
        self._sum = np.zeros(6)
        self._tare_readings = 0  # still to come
        self._estimate = np.zeros(6)

    def tare(self) -> None:
        """Take the next readings for the sensor's bias: the tool touches nothing."""
        self._sum[:] = 0.0
        self._tare_readings = TARE_CYCLES

    def discard(self) -> None:
        """Discard an estimate: it was for the move it was made in. Readings go on."""
        if not self.sensed:
            self._estimate[:] = 0.0
            self.wrench = NO_FORCE

    @property
    def taring(self) -> bool:
        """Whether a tare is in progress."""
        return self._tare_readings > 0

    def read(self, reading: Sequence[float], load: Load, T6: Transform) -> None:
        """Take a reading of the sensor, (6,), N and N m."""
        self.sensed = True
        pulled = weight(load, T6)
        biased = [r + w for r, w in zip(reading, pulled, strict=True)]
        if self._tare_readings:
            self._sum += biased
            self._tare_readings -= 1
            if not self._tare_readings:
                b1, b2, b3, b4, b5, b6 = (self._sum / TARE_CYCLES).tolist()
                self._bias = (b1, b2, b3, b4, b5, b6)
                self.tared = True
        w1, w2, w3, w4, w5, w6 = (w - b for w, b in zip(biased, self._bias, strict=True))
        self.wrench = (w1, w2, w3, w4, w5, w6)

    def estimate(
        self,
        torques: Sequence[float],
        rates: Sequence[float],
        accelerations: Sequence[float],
        J: Matrix,
        M: Matrix,
        gravity: Matrix,
    ) -> None:
        """Estimate it from what the motors do: tau = J^T f + g + M q'' + friction.

        Args:
            torques: of the motors, Nm (6).
            rates, accelerations: commanded, rad/s and rad/s2 (6).
            J: (6, 6), Jacobian in the T6 frame.
            M: (6, 6), inertia, kg m2.
            gravity: (6,), Nm.
        """
        friction_torques = [
            friction.viscous * rate
            + (
                friction.coulomb_positive
                if rate > 0.0
                else -friction.coulomb_negative
                if rate < 0.0
                else 0.0
            )
            for friction, rate in zip(self._friction, rates, strict=True)
        ]
        external = np.subtract(torques, friction_torques) - gravity - M @ np.asarray(accelerations)
        wrench = np.linalg.lstsq(J.T, external, rcond=1e-3)[0]
        self._estimate += self._gain * (wrench - self._estimate)
        w1, w2, w3, w4, w5, w6 = self._estimate.tolist()
        self.wrench = (w1, w2, w3, w4, w5, w6)

    def friction_uncertainty(self, J: Matrix, frame: Transform) -> Matrix:
        """How much of a wrench friction may hide, (6,), N and N m in a frame of T6."""
        coulomb = [max(f.coulomb_positive, f.coulomb_negative) for f in self._friction]
        return _in_frame(_largest_wrench(J, coulomb), frame)

    def measurable_limit(
        self, J: Matrix, frame: Transform, torque_limits: Sequence[float]
    ) -> Matrix:
        """The largest wrench that can be read or estimated, (6,), N and N m in a frame of T6."""
        if not self.sensed:
            return _in_frame(_largest_wrench(J, torque_limits), frame)
        return _in_frame(np.array(SENSOR_RANGE) - np.abs(self._bias), frame)


def _largest_wrench(J: Matrix, torques: Sequence[float]) -> Matrix:
    """Largest wrench at T6, (6,), that torques up to these may be, of whichever signs."""
    size: Matrix = np.abs(np.linalg.pinv(J.T, rcond=1e-3)) @ np.array(torques)
    return size


def _in_frame(size: Matrix, frame: Transform) -> Matrix:
    """The largest in a frame of what may be as large as this at T6, of whichever signs."""
    largest: Matrix = np.abs(np.array(differential_transform(frame.inverse())).T) @ size
    return largest
