"""The commanded trajectory: all six joints run in the master, before anything is sent."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

from rfms_can.errors import KinematicsError
from rfms_can.kinematics import (
    WIRE,
    Configuration,
    Geometry,
    InverseKinematics,
    Joints,
    singularity_margins,
)
from rfms_can.master.trajectory.braking import STOPPING_FRACTION
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.setpoint.frames import angles_as_received, as_received
from rfms_can.setpoint.joint import Mark
from rfms_can.transform import Transform

FASTER: Final = 1.2
"""How much faster than its limit a set-point may be: within that the joint lags behind. Plans keep
the limits; but the joints estimate from their last set-points how they leave a segment, and where
its straight part is short they are a few per cent off."""
PAST_END: Final = 1e-3
"""Rad a set-point may be past the end of a joint's range, for the same reason: stops are 0.05 rad
behind the ends. What poses are solved to has to be inside."""
LEAP: Final = 5e-3
"""Rad a joint may be asked to leap from one step to the next: within that it lags behind. In a slow
feed joints fit longer pieces of a path that bends next to a singularity; and where a path begins
there, 1e-8 m decide where theta4 comes from."""


GUARD: Final = 0.045
"""Rad past the end of a range at which a stop of a joint's own must end: past 0.05 it stops."""

NEAR_WRIST: Final = 0.2
"""|S5| below which the joints are told their angles: what float32 leaves of a pose would be noise
of theta4 and theta6: 2e-6 rad at rest there, and more the nearer it is."""
NEAR_ELBOW: Final = 0.1
"""The same for the sine of the bend between upper arm and forearm."""
NEAR_SHOULDER: Final = 0.1
"""The same for the wrist centre's distance from the joint-1 axis, as a part of a2."""


NEAR_HALF_TURN: Final = math.pi - 1e-3
"""A solution that is so far from where it was, rad, might as well be on another turn."""
NEAR_END: Final = 1e-4
"""The same of a solution so near to an end of its range, or past it: its turn would be another."""


class LimitedArm(Geometry, Protocol):
    """The geometry of an arm, and how fast its joints may run and accelerate."""

    @property
    def speed_limits(self) -> Sequence[float]:
        """rad/s, one per joint."""

    @property
    def acceleration_limits(self) -> Sequence[float]:
        """rad/s2, one per joint."""


_NOWHERE: Final[Joints] = (math.nan,) * 6


class _Bounds(NamedTuple):
    """What a joint may do: angles in rad, steps in rad a cycle, and the way to rest per step^2."""

    lower: float
    upper: float
    step: float
    bend: float
    rest_per_step2: float
    guard_below: float
    guard_above: float
    stop_per_step2: float


class Told(NamedTuple):
    """Angles of the two poses of a set-point, rad; ``second`` is ``first`` where there is one."""

    first: Joints
    second: Joints


class CommandedTrajectory:
    """Six :class:`JointSetpoint` on the float32 numbers of the wire: what the nodes compute.

    They estimate from their own past how they leave a segment: a shadow in double precision was
    1e-5 rad beside them after a transition that a moving goal begins, and a stop began with that
    step. ``theta``, ``rate`` and ``acceleration`` are the commanded trajectory as recorded.

    Attributes:
        bend_limits: acceleration limit of each joint, rad a cycle squared.
        told: the angles of T6_1 and T6_2, rad, where the joints are told them: near a singularity,
            a half turn, or an end of a range, where a pose of float32 does not say enough. None
            elsewhere.
    """

    def __init__(self, arm: LimitedArm, period_s: float, *, exact: bool = False) -> None:
        """An arm at rest at zero; ``reset`` says where it is.

        Args:
            arm: its geometry and limits.
            period_s: tau, s.
            exact: whether set-points are taken in double precision, as no bus carries them.
        """
        self.arm: Final = arm
        self._exact: Final = exact
        self._period: Final = period_s
        self.bend_limits: Final = tuple(
            acceleration * period_s * period_s for acceleration in arm.acceleration_limits
        )
        self._marks: Final = [Mark(0.0, 0.0, 0.0)] * len(arm.joint_limits)
        self._solve: Final = InverseKinematics(arm, WIRE).solve
        self._joints: Final = tuple(JointSetpoint(period_s) for _ in arm.joint_limits)
        self._near_shoulder: Final = NEAR_SHOULDER * abs(arm.a2)
        self.told: Told | None = None
        self._well_inside: Final = tuple(
            (lower + NEAR_END, upper - NEAR_END) for lower, upper in arm.joint_limits
        )
        self._bounds: Final = tuple(
            _Bounds(
                lower - PAST_END,
                upper + PAST_END,
                FASTER * speed * period_s,
                max(bend, LEAP),
                0.5 / bend,
                lower - GUARD,
                upper + GUARD,
                0.5 / (STOPPING_FRACTION * bend),
            )
            for (lower, upper), speed, bend in zip(
                arm.joint_limits, arm.speed_limits, self.bend_limits, strict=True
            )
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

    @property
    def steps(self) -> Joints:
        """What they moved in the last cycle, rad."""
        j1, j2, j3, j4, j5, j6 = self._joints
        return (j1.step, j2.step, j3.step, j4.step, j5.step, j6.step)

    def follow(self, setpoint: CartesianSetpoint, theta: Joints) -> None:
        """Take a set-point whose angles are known, rad: the joints are told them."""
        theta = angles_as_received(theta)
        self.told = Told(theta, theta)
        for joint, angle in zip(self._joints, theta, strict=True):
            if math.isnan(joint.advance(setpoint, angle)):
                raise AssertionError(f"a {setpoint.state.name} set-point cannot follow the last")

    def check(self, setpoint: CartesianSetpoint) -> str | None:
        """Run the joints through ``setpoint``; why it must not be sent, or None if it may.

        After a refusal ``theta`` and ``steps`` are what they were: go on with ``follow``, which
        brings its own angles, or with ``reset``.

        Raises:
            AssertionError: the trajectory generator is at fault: no joint would take its state.
        """
        exact, setpoint = setpoint, setpoint if self._exact else as_received(setpoint)
        joints = self._joints
        turns_1 = [joint.turn_1(setpoint) for joint in joints]
        first = second = _NOWHERE
        try:
            first = second = self._angles(
                setpoint.T6_1, setpoint.configuration_1, turns_1, setpoint.near_1
            )
            in_doubt = self._is_in_doubt(first, turns_1)
            if setpoint.T6_2 is not None:
                turns_2 = [joint.turn_2 for joint in joints]
                second = self._angles(
                    setpoint.T6_2, setpoint.configuration_2, turns_2, setpoint.near_2
                )
                in_doubt = in_doubt or self._is_in_doubt(second, turns_2)
        except KinematicsError as error:
            if self._exact:
                return str(error)
            in_doubt = True  # float32 may have pushed it over an edge
        self.told = None
        if in_doubt and not self._exact:
            try:
                self.told = self._tell(exact, turns_1)
            except KinematicsError as error:
                return str(error)
            first, second = self.told
        marks = self._marks
        for index, bounds in enumerate(self._bounds):
            lower, upper, most, most_bend, per_speed2, below, above, stop_per_speed2 = bounds
            joint = joints[index]
            mark = marks[index] = joint.mark()
            theta = joint.advance(setpoint, first[index], second[index])
            step = theta - mark.theta
            way = step * abs(step)
            rest = theta + way * per_speed2 - 0.5 * step
            if not (
                lower <= theta <= upper
                and -most <= step <= most
                and -most_bend <= step - mark.step <= most_bend
                and lower <= rest <= upper
                and below <= theta + way * stop_per_speed2 <= above
            ):
                for taken in range(index + 1):
                    joints[taken].return_to(marks[taken])
                return self._refusal(index + 1, theta, mark, setpoint)
        return None

    def _tell(self, setpoint: CartesianSetpoint, turns_1: Sequence[float]) -> Told:
        """The angles of the exact poses, as the joints are told them."""
        first = second = self._angles(
            setpoint.T6_1, setpoint.configuration_1, turns_1, setpoint.near_1
        )
        if setpoint.T6_2 is not None:
            turns_2 = [joint.turn_2 for joint in self._joints]
            second = self._angles(setpoint.T6_2, setpoint.configuration_2, turns_2, setpoint.near_2)
        return Told(angles_as_received(first), angles_as_received(second))

    def _angles(
        self,
        pose: Transform,
        configuration: Configuration,
        turns: Sequence[float],
        near: Joints | None,
    ) -> Joints:
        """The solution near given angles, or where none are on from those before; rad."""
        if near is None:
            return self._solve(pose, configuration, turns)
        return self._solve(pose, configuration, near, near[3])

    def _is_in_doubt(self, q: Joints, turns: Sequence[float]) -> bool:
        """Whether the joints are to be told the angles ``q``, on the turns nearest to ``turns``,
        rad: what they know is a pose of float32."""
        for angle, turn, (lower, upper) in zip(q, turns, self._well_inside, strict=True):
            if not (-NEAR_HALF_TURN < angle - turn < NEAR_HALF_TURN and lower < angle < upper):
                return True
        elbow, shoulder, wrist = singularity_margins(self.arm, q)
        return (
            -NEAR_WRIST < wrist < NEAR_WRIST
            or -NEAR_ELBOW < elbow < NEAR_ELBOW
            or -self._near_shoulder < shoulder < self._near_shoulder
        )

    def _refusal(self, number: int, theta: float, before: Mark, setpoint: CartesianSetpoint) -> str:
        """Why joint ``number`` cannot take ``theta``, rad, after what it did ``before``."""
        name = f"{self.arm.name}: joint {number}: "
        (lower, upper), tau = self.arm.joint_limits[number - 1], self._period
        if math.isnan(theta):
            raise AssertionError(f"{name}a {setpoint.state.name} set-point cannot follow the last")
        range_text = f"[{lower:.6g}, {upper:.6g}] rad"
        if not lower <= theta <= upper:
            return f"{name}set-point {theta:.6g} rad is outside {range_text}"
        step = theta - before.theta
        limit = self.arm.speed_limits[number - 1]
        if abs(step) > FASTER * limit * tau:
            return f"{name}set-point speed {step / tau:.4g} rad/s exceeds {limit:g} rad/s"
        limit, bend = self.arm.acceleration_limits[number - 1], step - before.step
        if abs(bend) > max(limit * tau * tau, LEAP):
            return (
                f"{name}set-point acceleration {bend / tau**2:.4g} rad/s2 exceeds {limit:g} rad/s2"
            )
        return (
            f"{name}set-point {theta:.6g} rad at {step / tau:.4g} rad/s can no longer come to rest "
            f"inside {range_text}"
        )
