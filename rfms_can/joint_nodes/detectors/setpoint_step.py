"""Set-points that no joint can follow: their angle steps, or their rate does."""

from collections.abc import Mapping
from typing import Final

from rfms_can.joint_nodes.detectors.following import Excess
from rfms_can.wire.vocabulary import Parameter

STEP_MARGIN: Final = 1.5
"""How much faster than the speed limit a set-point or an encoder may step before it is refused."""
RATE_STEP_FRACTION: Final = 0.2
"""Change of a set-point's rate in a cycle over the speed limit: five times what the acceleration
limits of our arms allow at 250 Hz, at 50 Hz as much."""
RATE_SETPOINTS: Final = 4
"""Set-points in a row after which the rate is that of the motion: two make one, its change three,
and the first after a gap goes on from what was extrapolated."""


class StepWatch:
    """The steps of one joint's set-points.

    Args:
        parameters: the node's configuration.
    """

    __slots__ = ("_held", "_max_rate_step", "_max_step", "_taken")

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        fastest = parameters[Parameter.SPEED_LIMIT]
        self._max_step: Final = STEP_MARGIN * fastest * parameters[Parameter.PERIOD]
        self._max_rate_step: Final = RATE_STEP_FRACTION * fastest
        self.reset()

    def reset(self) -> None:
        """The joint holds where it is, without a past."""
        self._held = self._taken = 0

    def hold(self) -> None:
        """A cycle without a set-point."""
        self._held += 1
        self._taken = 0

    def take(self) -> None:
        """A set-point has been taken."""
        self._held = 0
        self._taken += 1

    @property
    def bound(self) -> float:
        """Largest step of an angle now, rad."""
        return self._max_step * (1 + self._held)

    def excess(self, step: float, change: float) -> Excess | None:
        """What is too large of a step, rad, and of a change of rate, rad/s; None if neither is.

        The rate counts once the set-points that it is made of have come one by one.
        """
        bound = self._max_step * (1 + self._held)
        if not -bound <= step <= bound:
            return Excess(step, bound)
        largest = self._max_rate_step
        if self._taken >= RATE_SETPOINTS and not -largest <= change <= largest:
            return Excess(change, largest)
        return None
