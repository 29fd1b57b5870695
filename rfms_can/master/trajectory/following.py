"""How the six joints follow what is asked of them: on it, behind it, or to rest beside it."""

from collections.abc import Sequence
from typing import Final

from rfms_can.master.trajectory.braking import Brake
from rfms_can.master.trajectory.commanded import CommandedTrajectory, LimitedArm
from rfms_can.master.trajectory.lag import KEPT, LARGEST, Lag
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire.vocabulary import Blend


class Following:
    """What the joints make of a path: where one cannot keep up it lags, and from too far it brakes.

    Args:
        arm: its geometry and limits.
        period_s: control period, s.
        blend: matching polynomial of transitions.

    Attributes:
        commanded: the commanded trajectory.
    """

    def __init__(self, arm: LimitedArm, period_s: float, blend: Blend) -> None:
        self._arm: Final = arm
        self._blend: Final = blend
        self.commanded: Final = CommandedTrajectory(arm, period_s)
        self._lag: Final = Lag(arm, period_s)
        self._brake: Brake | None = None
        self._complies = False  # whether compliance displaced the set-point made last

    def enable(self, q: Sequence[float]) -> None:
        """At rest at the encoders' angles, rad, with nothing to catch up with."""
        self.hold(q)
        self._lag.reset(q)

    def hold(self, q: Sequence[float]) -> None:
        """At rest at joint angles, rad; what lags behind goes on catching up."""
        self.commanded.reset(q)
        self._brake = None

    @property
    def brakes(self) -> bool:
        """Whether it comes to rest beside a path, or has."""
        return self._brake is not None

    @property
    def has_braked(self) -> bool:
        """Whether it rests there."""
        return self._brake is not None and self._brake.over

    def refusal(self, setpoint: CartesianSetpoint) -> str | None:
        """Take a set-point of the path; why the joints cannot follow it, or None if they do."""
        return self._too_far() or self.commanded.check(setpoint)

    def brake(self, sequence: int) -> CartesianSetpoint:
        """Come to rest from here on, whatever is asked; the first set-point of that.

        Args:
            sequence: number of the move under way.
        """
        commanded = self.commanded
        limits = [KEPT * limit for limit in commanded.bend_limits]
        self._brake = Brake(self._arm, commanded.theta, commanded.steps, limits)
        return self.slow_down(sequence)

    def slow_down(self, sequence: int) -> CartesianSetpoint:
        """The next set-point of coming to rest; of the move ``sequence``."""
        if self._brake is None:
            raise AssertionError("nothing brakes")
        theta = self._brake.step()
        setpoint = self._brake.setpoint(theta, sequence, self._blend)
        self.commanded.follow(setpoint, theta)
        return setpoint

    def displaced(self, displacement: Sequence[float] | None) -> Sequence[float] | None:
        """What the joints add to the set-point made last: a displacement, and their lag, rad (6).

        Args:
            displacement: by compliance, rad (6), or None.

        Returns:
            None if there is nothing to add.
        """
        lag, theta = self._lag, self.commanded.theta
        self._complies = displacement is not None
        if displacement is None:
            lag.follow(theta)
            return lag.angles if lag.active else None
        lag.follow([t + d for t, d in zip(theta, displacement, strict=True)])
        if not lag.active:
            return displacement
        return [d + behind for d, behind in zip(displacement, lag.angles, strict=True)]

    def errors_of_asked(self, errors: Sequence[float]) -> Sequence[float]:
        """Joint errors as they would be if no joint lagged behind, rad: asked for less encoder."""
        if not self._lag.active:
            return errors
        return [error - behind for error, behind in zip(errors, self._lag.angles, strict=True)]

    @property
    def moves(self) -> bool:
        """Whether the arm is commanded to move in the set-point made last."""
        return any(self.commanded.rate)

    def _too_far(self) -> str | None:
        """Which joint lags too far behind its path, in words; None if none does."""
        on_a_path = any(self.commanded.steps) and not self._complies
        joint = self._lag.joint_too_far if on_a_path else None
        if joint is None:
            return None
        return (
            f"{self._arm.name}: joint {joint}: set-point lags over {LARGEST:g} rad behind what is "
            f"asked of it, at its limits of speed and acceleration"
        )
