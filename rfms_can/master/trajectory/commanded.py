"""The commanded trajectory: all six joints run in the master, before anything is sent."""

import math
from collections.abc import Sequence
from typing import Final, Protocol

from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import Geometry, InverseKinematics, Joints
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move, Segment
from rfms_can.setpoint import CartesianSetpoint, JointSetpoint
from rfms_can.wire.vocabulary import Mode

PATH_SAMPLES: Final = 24
"""Poses at which a Cartesian path is tried before its move is accepted."""


ESTIMATED: Final = 1.05
"""How much faster than its limit a set-point may be. Plans keep the limits; but the joints estimate
from their last set-points how they leave a segment, and where its straight part is short they are a
few per cent off."""


class LimitedArm(Geometry, Protocol):
    """The geometry of an arm and how fast its joints may run."""

    @property
    def speed_limits(self) -> Sequence[float]:
        """rad/s, one per joint."""


class CommandedTrajectory:
    """Six :class:`JointSetpoint` in double precision: the nodes' shadow.

    What the nodes compute from the same set-points differs by float32's rounding of T6, about
    1e-7 rad. ``theta``, ``rate`` and ``acceleration`` are the commanded trajectory as recorded.
    """

    def __init__(self, arm: LimitedArm, period_s: float) -> None:
        """An arm at rest at zero; ``reset`` says where it is. ``period_s`` is tau, s."""
        self.arm: Final = arm
        self._period: Final = period_s
        self._solve: Final = InverseKinematics(arm).solve
        self._joints: Final = tuple(JointSetpoint(period_s) for _ in arm.joint_limits)
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
            )
            second = first
            if setpoint.T6_2 is not None:
                turns = [joint.turn_2 for joint in joints]
                second = self._solve(setpoint.T6_2, setpoint.configuration_2, turns)
        except KinematicsError as error:
            return str(error)
        for index, (lower, upper, step) in enumerate(self._bounds):
            joint = joints[index]
            before = joint.theta
            theta = joint.advance(setpoint, first[index], second[index])
            if not (lower <= theta <= upper and -step <= theta - before <= step):
                return self._refusal(index + 1, theta, before, setpoint)
        return None

    def admit(self, before: Move, move: Move, tick: int) -> None:
        """Try the segment of ``move`` from the goal of ``before``, as they are at ``tick``.

        Transitions cut corners and are not tried; ``check`` sees every set-point.

        Raises:
            KinematicsError: the goal, or a pose on a Cartesian path, has no solution.
            MoveError: a joint would run faster than it may; the message gives the time it needs.
        """
        origin = before.target.pose(Moment(tick))
        q = self._solve(origin, before.configuration, self.theta)
        segment = Segment.towards(move, origin, Moment(tick, 0.0))
        samples = 1 if move.mode is Mode.JOINT else PATH_SAMPLES
        for sample in range(1, samples + 1):
            h = sample / samples
            pose = segment.pose(Moment(tick, h), 1.0 - h)
            ahead = self._solve(pose, move.configuration, q)
            self._check_speed(q, ahead, samples, move)
            q = ahead

    def _check_speed(self, q: Joints, ahead: Joints, samples: int, move: Move) -> None:
        """Whether the joints can make one of ``samples`` parts of the segment in its time."""
        duration = move.segment_ticks * self._period
        for number, (start, end, limit) in enumerate(
            zip(q, ahead, self.arm.speed_limits, strict=True), 1
        ):
            speed = abs(end - start) * samples / duration
            if speed > limit:
                raise MoveError(
                    f"move {move.sequence}: joint {number} of {self.arm.name} would run at "
                    f"{speed:.4g} rad/s, its limit is {limit:g} rad/s: give the segment at least "
                    f"{duration * speed / limit:.4g} s instead of {duration:.4g} s"
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
