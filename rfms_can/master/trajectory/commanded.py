"""The commanded trajectory: all six joints run in the master, before anything is sent."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

from rfms_can.errors import KinematicsError
from rfms_can.kinematics import Geometry, InverseKinematics, Joints, singularity_margins
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint

ESTIMATED: Final = 1.05
"""How much faster than its limit a set-point may be. Plans keep the limits; but the joints estimate
from their last set-points how they leave a segment, and where its straight part is short they are a
few per cent off."""


NEAR_WRIST: Final = 0.05
"""|S5| below which the joints are told their angles: what float32 leaves of a pose would be noise
of theta4 and theta6 with accelerations of 0.06 rad/s2 rms there, and ever more nearer by."""
NEAR_ELBOW: Final = 0.1
"""The same for the sine of the bend between upper arm and forearm."""
NEAR_SHOULDER: Final = 0.1
"""The same for the wrist centre's distance from the joint-1 axis, as a part of a2."""


class LimitedArm(Geometry, Protocol):
    """The geometry of an arm and how fast its joints may run."""

    @property
    def speed_limits(self) -> Sequence[float]:
        """rad/s, one per joint."""


class Told(NamedTuple):
    """Angles of the two poses of a set-point, rad; ``second`` is ``first`` where there is one."""

    first: Joints
    second: Joints


class CommandedTrajectory:
    """Six :class:`JointSetpoint` in double precision: the nodes' shadow.

    What the nodes compute from the same set-points differs by float32's rounding of T6, about
    1e-7 rad. ``theta``, ``rate`` and ``acceleration`` are the commanded trajectory as recorded.

    Attributes:
        told: the angles of T6_1 and T6_2, rad, where the joints are told them: near a singularity,
            where float32 and a pose alone do not say enough. None elsewhere.
    """

    def __init__(self, arm: LimitedArm, period_s: float) -> None:
        """An arm at rest at zero; ``reset`` says where it is. ``period_s`` is tau, s."""
        self.arm: Final = arm
        self._period: Final = period_s
        self._solve: Final = InverseKinematics(arm).solve
        self._joints: Final = tuple(JointSetpoint(period_s) for _ in arm.joint_limits)
        self._near_shoulder: Final = NEAR_SHOULDER * abs(arm.a2)
        self.told: Told | None = None
        self._bounds: Final = tuple(
            (lower, upper, ESTIMATED * speed * period_s)
            for (lower, upper), speed in zip(arm.joint_limits, arm.speed_limits, strict=True)
        )

    def reset(self, q: Sequence[float]) -> None:
        """Start over from rest at the joint angles ``q``, rad."""
        for joint, theta in zip(self._joints, q, strict=True):
            joint.reset(theta)

    @property
    def theta(self) -> Joints:
        """Set-points of this cycle, rad."""
        j1, j2, j3, j4, j5, j6 = self._joints
        return (j1.theta, j2.theta, j3.theta, j4.theta, j5.theta, j6.theta)

    @property
    def rate(self) -> Joints:
        """Their velocities, rad/s."""
        j1, j2, j3, j4, j5, j6 = self._joints
        return (j1.rate, j2.rate, j3.rate, j4.rate, j5.rate, j6.rate)

    @property
    def acceleration(self) -> Joints:
        """Their accelerations, rad/s2."""
        j1, j2, j3, j4, j5, j6 = self._joints
        return (
            *(j1.acceleration, j2.acceleration, j3.acceleration),
            *(j4.acceleration, j5.acceleration, j6.acceleration),
        )

    def check(self, setpoint: CartesianSetpoint) -> str | None:
        """Run the joints through ``setpoint``; why it must not be sent, or None if it may.

        A pose that cannot be solved leaves the joints where they were. A set-point past a joint
        or speed limit has been taken: after any refusal the trajectory goes on from ``reset``.
        """
        joints = self._joints
        try:
            first = self._solve(
                setpoint.T6_1,
                setpoint.configuration_1,
                [joint.turn_1(setpoint) for joint in joints],
                setpoint.theta4_1,
            )
            second = first
            if setpoint.T6_2 is not None:
                turns = [joint.turn_2 for joint in joints]
                second = self._solve(
                    setpoint.T6_2, setpoint.configuration_2, turns, setpoint.theta4_2
                )
        except KinematicsError as error:
            return str(error)
        near = self._is_near_singular(first) or self._is_near_singular(second)
        self.told = Told(first, second) if near else None
        for index, (lower, upper, step) in enumerate(self._bounds):
            joint = joints[index]
            before = joint.theta
            theta = joint.advance(setpoint, first[index], second[index])
            if not (lower <= theta <= upper and -step <= theta - before <= step):
                return self._refusal(index + 1, theta, before, setpoint)
        return None

    def _is_near_singular(self, q: Joints) -> bool:
        """Whether the joints are to be told the angles ``q``, rad."""
        elbow, shoulder, wrist = singularity_margins(self.arm, q)
        return (
            -NEAR_WRIST < wrist < NEAR_WRIST
            or -NEAR_ELBOW < elbow < NEAR_ELBOW
            or -self._near_shoulder < shoulder < self._near_shoulder
        )

    def _refusal(
        self, number: int, theta: float, before: float, setpoint: CartesianSetpoint
    ) -> str:
        """Why joint ``number`` cannot take ``theta`` after ``before``."""
        name = f"{self.arm.name}: joint {number}: "
        lower, upper = self.arm.joint_limits[number - 1]
        if math.isnan(theta):
            return f"{name}a {setpoint.state.name} set-point cannot follow the last one"
        if not lower <= theta <= upper:
            return (
                f"{name}set-point {theta:.6g} rad is outside [{lower:.6g}, {upper:.6g}] rad: "
                f"place the position further inside the range or take another configuration"
            )
        return (
            f"{name}set-point speed {(theta - before) / self._period:.4g} rad/s exceeds "
            f"{self.arm.speed_limits[number - 1]:g} rad/s: give the segment more time, or keep "
            f"the path away from singularities"
        )
