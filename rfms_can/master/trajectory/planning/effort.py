"""What planning may cost: in real time the next cycle does not wait for it.

Counted in poses that are solved, not in seconds: nodes read no clock, and the same request is
answered the same every time.
"""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.errors import MoveError
from rfms_can.kinematics import Configuration, Geometry, InverseKinematics, Joints
from rfms_can.transform import Transform

PREVIEW: Final = 100
"""Poses that a look at all phases of a move counts as: about a millisecond."""


class TooLongError(MoveError):
    """Planning a move takes longer than the next cycle can wait."""


class Effort:
    """The poses that may be solved for one request.

    Args:
        most: of a request; infinite where time waits.

    Attributes:
        spent: whether the last request took them all.
    """

    __slots__ = ("_left", "_most", "spent")

    def __init__(self, most: float = math.inf) -> None:
        self._most: Final = most
        self.begin()

    def begin(self) -> None:
        """A request begins."""
        self._left, self.spent = self._most, False

    def spend(self, poses: int) -> None:
        """Take some.

        Raises:
            TooLongError: there are none left.
        """
        self._left -= poses
        if self._left < 0:
            self.spent = True
            raise TooLongError(
                f"to plan it takes more than {self._most:.0f} poses, and in real time the next "
                f"cycle does not wait: ask for a way that is not next to a singularity, or with "
                f"the times that it needs, or plan it on another clock"
            )


class MeteredKinematics(InverseKinematics):
    """The inverse solution of an arm, counted.

    Args:
        arm: its geometry.
        effort: that each pose is taken from.
    """

    def __init__(self, arm: Geometry, effort: Effort) -> None:
        super().__init__(arm)
        self._spend: Final = effort.spend

    def solve(
        self,
        t6: Transform,
        configuration: Configuration,
        previous: Sequence[float] | None = None,
        theta4: float | None = None,
    ) -> Joints:
        """The same; raises TooLongError besides."""
        self._spend(1)
        return super().solve(t6, configuration, previous, theta4)
