"""What the joints are commanded to do, over what they may."""

from collections.abc import Sequence

import numpy as np

from rfms_can.arm import Arm


class Judge:
    """Watches the commanded joint angles of a run.

    Args:
        arm: its limits.
        start: where it stands at first, rad.
        period_s: tau, s.

    Attributes:
        speed, acceleration: largest first and second difference of an angle, over its limit.
        joint: that accelerated most.
        cycles: judged.
    """

    def __init__(self, arm: Arm, start: Sequence[float], period_s: float) -> None:
        self.speed = self.acceleration = 0.0
        self.joint = self.cycles = 0
        self._bend_limits = np.array(arm.acceleration_limits) * period_s**2
        self._step_limits = np.array(arm.speed_limits) * period_s
        self._before = np.array(start)
        self._step = np.zeros(6)

    def take(self, angles: Sequence[float]) -> None:
        """The angles of the next cycle, rad."""
        theta = np.array(angles)
        step = theta - self._before
        bends = np.abs(step - self._step) / self._bend_limits
        if not self.cycles:  # its pose is where the arm stands, but for rounding
            bends[:] = 0.0
        self.speed = max(self.speed, float((np.abs(step) / self._step_limits).max()))
        if bends.max() > self.acceleration:
            self.acceleration = float(bends.max())
            self.joint = int(bends.argmax()) + 1
        self._before, self._step = theta, step
        self.cycles += 1
