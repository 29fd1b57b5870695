"""Dry friction, brakes and hard stops of six joints: one boxed problem a physics step.

A physics engine regularises dry friction: a loaded joint creeps. Here the torques of a step solve
the problem exactly (a mixed linear complementarity problem, as in Stewart and Trinkle 1996):

    v = v* + W (p - p0),    with, joint by joint, the torque p between its bounds and
    v = 0 if p lies strictly between them,  v > 0 only at the lower,  v < 0 only at the upper

where v* is the engine's velocity after the step with the friction torques p0 of the step before,
and W the step times the inverse of the (damped) inertia matrix. If p0 still satisfies the
conditions, it is kept. While the load changes, as on a contact, mostly the same joints stick as
before: one small linear system gives their torques, which are the solution if all stay within
bounds. When a joint sticks or breaks away, projected Gauss-Seidel from p0 finds p in a few sweeps.
A sticking joint's velocity is exactly 0.0. W is symmetric and positive definite, so the sweeps
converge.

A brake is a friction with wide bounds. A hard stop bounds the velocity so that the joint ends the
step on the stop at the latest, and is perfectly inelastic.
"""

from collections.abc import Sequence
from math import inf
from operator import mul
from typing import Final

import numpy as np

from rfms_can.arm import JOINT_COUNT, JointFriction
from rfms_can.errors import PlantError

SPEED_TOLERANCE: Final = 1e-12  # rad/s: changes below do not count

Problem = tuple[int, float, list[float], float, float, float, float]
"""One joint's row of the problem: index, 1 / W_ii, row of W, torque bounds (Nm), and the lowest and
highest speed its stops allow, times 1 / W_ii (Nm)."""
MAX_SWEEPS: Final = 400  # 5 are usual; the worst coupling of these arms needs under 100


class DryFriction:
    """Torques of dry friction, brakes and hard stops.

    Attributes:
        torque: of friction, brakes and stops on each joint over the last step, Nm: the next step's
            p0, to be applied by the engine in addition to the motors' torque.
    """

    def __init__(
        self,
        friction: Sequence[JointFriction],
        brake_torque: Sequence[float],
        joint_limits: Sequence[tuple[float, float]],
        step_s: float,
    ) -> None:
        """Take friction per joint, brake torques (Nm), limits (rad) and the physics step (s)."""
        self._friction = tuple(friction)
        self._brake_torque = tuple(brake_torque)
        self._limits = tuple(joint_limits)
        self._step_s = step_s
        self._joints: list[Problem] = []
        self._holding_gains: dict[tuple[int, ...], list[list[float]]] = {}
        self.reset()

    def set_step(self, step_s: float) -> None:
        """Change the length of a physics step, s; the torques of the last step are kept."""
        self._step_s = step_s

    def reset(self) -> None:
        """Forget the torques of the step before."""
        self.torque = [0.0] * JOINT_COUNT
        self._on_stop = False

    def prepare(
        self,
        response: list[list[float]],
        brakes: Sequence[bool],
        motor_torque: Sequence[float] = (0.0,) * JOINT_COUNT,
    ) -> None:
        """Set W, (6, 6), rad/s per Nm, which may be a few steps old, and the brakes that are on.

        ``motor_torque`` (6, Nm) is the load on which load-dependent friction depends.
        """
        self._joints.clear()
        self._holding_gains.clear()
        for i, joint in enumerate(self._friction):
            brake = self._brake_torque[i] if brakes[i] else 0.0
            grown = joint.load * motor_torque[i]
            low = -max(joint.coulomb_positive + grown, 0.0) - brake
            high = max(joint.coulomb_negative + grown, 0.0) + brake
            self._joints.append((i, 1.0 / response[i][i], response[i], low, high, -inf, inf))

    def advance(self, speed: list[float], q: list[float]) -> None:
        """Turn v* (6, rad/s) into v and move ``q`` (6, rad) one step on, both in place.

        Raises:
            PlantError: the sweeps do not settle, which only a wrong W or a NaN can cause.
        """
        if not self._on_stop and not self._unchanged(speed) and not self._keep_sticking_set(speed):
            self._settle(speed, self._joints)
        if not self._on_stop and self._stays_in_range(speed, q):
            for i, v in enumerate(speed):
                q[i] += self._step_s * v
            return
        self._settle_on_stops(speed, q)
        for i, (lower, upper) in enumerate(self._limits):
            # Rounding may put a joint an ulp beyond the stop that bounds its speed.
            q[i] = min(max(q[i] + self._step_s * speed[i], lower), upper)

    def _unchanged(self, speed: list[float]) -> bool:
        """Whether the last step's torques are still the solution; then set sticking joints to 0."""
        torque = self.torque
        for i, inertia, _, low, high, _, _ in self._joints:
            stopping = torque[i] - speed[i] * inertia
            wanted = low if stopping < low else high if stopping > high else stopping
            if not abs(wanted - torque[i]) <= SPEED_TOLERANCE * inertia:
                return False
        self._zero_sticking(speed, self._joints)
        return True

    def _keep_sticking_set(self, speed: list[float]) -> bool:
        """Try the sticking joints of the last step; whether the result satisfies all conditions."""
        joints, torque = self._joints, self.torque
        held = tuple(i for i, _, _, low, high, _, _ in joints if low < torque[i] < high)
        if not held:
            return False
        gain = self._holding_gains.get(held)
        if gain is None:
            gain = self._holding_gains[held] = self._holding_gain(held)
        if not gain:
            return False
        speeds = [speed[i] for i in held]
        new_speed, new_torque = speed[:], torque[:]
        for i, row in zip(held, gain, strict=True):
            change = -sum(map(mul, row, speeds))
            new_torque[i] += change
            _add_scaled(new_speed, joints[i][2], change)
        for i, inertia, _, low, high, _, _ in joints:
            if i in held:
                if not low < new_torque[i] < high:
                    return False
                new_speed[i] = 0.0
            else:
                stopping = new_torque[i] - new_speed[i] * inertia
                if not (stopping <= low if new_torque[i] == low else stopping >= high):
                    return False
        speed[:], torque[:] = new_speed, new_torque
        return True

    def _holding_gain(self, held: tuple[int, ...]) -> list[list[float]]:
        """Torque per speed that brings the given joints to rest together, (n, n), Nms/rad.

        The inverse of their block of W; empty where W is not positive definite, which the sweeps
        then report.
        """
        rows = [[self._joints[i][2][j] for j in held] for i in held]
        try:
            root = np.linalg.inv(np.linalg.cholesky(rows))
        except np.linalg.LinAlgError:
            return []
        gain: list[list[float]] = (root.T @ root).tolist()
        return gain

    def _stays_in_range(self, speed: list[float], q: list[float]) -> bool:
        """Whether no joint ends the step beyond a stop."""
        step_s = self._step_s
        for angle, v, (lower, upper) in zip(q, speed, self._limits, strict=True):
            if not lower <= angle + step_s * v <= upper:
                return False
        return True

    def _settle_on_stops(self, speed: list[float], q: list[float]) -> None:
        """Settle with speeds bounded so that no joint ends the step beyond its stop."""
        joints: list[Problem] = []
        for i, inertia, row, low, high, _, _ in self._joints:
            lower, upper = self._limits[i]
            torque_per_radian = inertia / self._step_s
            slowest, fastest = (
                (lower - q[i]) * torque_per_radian,
                (upper - q[i]) * torque_per_radian,
            )
            joints.append((i, inertia, row, low, high, slowest, fastest))
        self._settle(speed, joints)
        self._on_stop = any(
            not low <= self.torque[i] <= high for i, _, _, low, high, _, _ in joints
        )

    def _settle(self, speed: list[float], joints: Sequence[Problem]) -> None:
        """Projected Gauss-Seidel over the joints.

        ``stopping`` is the torque that brings a joint to rest while the others keep their speeds.
        If it exceeds the friction bound, the joint slides against the bound, at most up to its
        stop.
        """
        torque = self.torque
        for _ in range(MAX_SWEEPS):
            settled = True
            for i, inertia, row, low, high, slowest, fastest in joints:
                stopping = torque[i] - speed[i] * inertia
                if stopping < low:
                    wanted = min(low, stopping + fastest)
                elif stopping > high:
                    wanted = max(high, stopping + slowest)
                else:
                    wanted = stopping
                change = wanted - torque[i]
                if not abs(change) <= SPEED_TOLERANCE * inertia:  # a NaN never settles
                    settled = False
                    torque[i] = wanted
                    _add_scaled(speed, row, change)
            if settled:
                self._zero_sticking(speed, joints)
                return
        raise PlantError(
            f"friction torques do not settle in {MAX_SWEEPS} sweeps at joint speeds {speed} "
            "rad/s: the inertia matrix is not positive definite, or a motor torque is not a number"
        )

    def _zero_sticking(self, speed: list[float], joints: Sequence[Problem]) -> None:
        """Set the speed of sticking joints to exactly 0, without a rounding error."""
        for i, _, _, low, high, _, _ in joints:
            if low < self.torque[i] < high:
                speed[i] = 0.0


def _add_scaled(vector: list[float], direction: list[float], scale: float) -> None:
    """``vector += scale direction``, six elements, in place."""
    a, b, c, d, e, f = direction
    vector[0] += scale * a
    vector[1] += scale * b
    vector[2] += scale * c
    vector[3] += scale * d
    vector[4] += scale * e
    vector[5] += scale * f
