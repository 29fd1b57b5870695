"""The arm and its fixtures in MuJoCo: the plant's rigid bodies.

MuJoCo integrates the rigid bodies, the drives' armature and viscous friction (implicitly). Dry
friction, brakes and hard stops are :class:`~rfms_can.plant.friction.DryFriction`'s.
"""

import contextlib
import ctypes
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any, Final

import mujoco
import numpy as np

from rfms_can.arm import JOINT_COUNT, Arm, JointFriction
from rfms_can.errors import PlantError
from rfms_can.plant.broad_phase import BroadPhase
from rfms_can.plant.contact_wrench import NO_CONTACT, ContactReader, Contacts
from rfms_can.plant.friction import DryFriction
from rfms_can.plant.model_builder import TIP, compile_model
from rfms_can.plant.scene import FREE, Scene

BRAKE_TORQUE_RATIO: Final = 4.0
"""P: holding torque of a joint's brake over the torque limit of its drive."""

NO_BRAKES: Final = (False,) * JOINT_COUNT


class ArmModel:
    """Six joints driven by torques, advanced by whole physics steps.

    Attributes:
        q: joint angles, rad (a plain list of 6; read only).
        qd: joint speeds, rad/s (a plain list of 6; read only). A sticking joint's is exactly 0.
    """

    def __init__(
        self,
        arm: Arm,
        friction: Sequence[JointFriction],
        physics_step_s: float = 1e-3,
        scene: Scene = FREE,
    ) -> None:
        """Build the model of ``arm`` from its data, parked, in a scene; friction per joint.

        Raises:
            PlantError: MuJoCo refuses the model, with its text.
        """
        _silence_warning_log()
        _stop_timers()
        self._model = compile_model(arm, friction, physics_step_s, scene)
        self._data = mujoco.MjData(self._model)
        self._step_s = physics_step_s
        self._limits = arm.joint_limits
        brake_torque = [BRAKE_TORQUE_RATIO * drive.torque_limit for drive in arm.drives]
        self._dry = DryFriction(friction, brake_torque, arm.hard_stops, physics_step_s)
        self._inertia = np.zeros((JOINT_COUNT, JOINT_COUNT))
        self._damping = np.diag([joint.viscous for joint in friction])
        # Views into MuJoCo's memory, taken once: each attribute look-up costs more than the copy.
        self._qpos, self._qvel = self._data.qpos, self._data.qvel
        self._applied = self._data.qfrc_applied
        self._warnings = self._data.warning.number
        self._tip = self._data.site("t6" if scene.tool is None else TIP)
        # Wrist sensors (force, torque) between hand and tool, summed over one call of step.
        self._sensors, self._wrist_sum, self._summed_steps = self._data.sensordata, np.zeros(6), 1
        self._contacts = None
        if scene.tool is not None:
            self._contacts = ContactReader(self._model, self._data)
        self._broad_phase: BroadPhase | None = None
        self.q = [0.0] * JOINT_COUNT
        self.qd = [0.0] * JOINT_COUNT
        self.reset(arm.park)
        if self._model.npair:
            self._broad_phase = BroadPhase(self._model, self._data)

    def reset(self, q: Sequence[float], qd: Sequence[float] = (0.0,) * JOINT_COUNT) -> None:
        """Put the arm at ``q`` (6, rad) with speeds ``qd`` (6, rad/s), without friction history.

        Raises:
            PlantError: a joint is outside its range.
        """
        for joint, (angle, (lower, upper)) in enumerate(zip(q, self._limits, strict=True), start=1):
            if not lower <= angle <= upper:
                raise PlantError(
                    f"joint {joint} cannot start at {angle:.4f} rad: its range is "
                    f"{lower:.4f} to {upper:.4f} rad"
                )
        mujoco.mj_resetData(self._model, self._data)
        self.q, self.qd = list(q), list(qd)
        self._qpos[:], self._qvel[:] = self.q, self.qd
        self._dry.reset()
        if self._broad_phase is not None:  # the arm may have jumped: select the pairs again
            mujoco.mj_kinematics(self._model, self._data)
            self._broad_phase.update()
        mujoco.mj_forward(self._model, self._data)
        self._reset_force_sums(1)
        self._sum_forces()
        self._raise_warning()

    def disable_broad_phase(self) -> None:
        """Let MuJoCo test every pair, to check that the broad phase changes no result."""
        if self._broad_phase is not None:
            self._broad_phase.enable_all_pairs()
            self._broad_phase = None

    def clearance(self) -> float:
        """Distance of the tool's bounding sphere from the nearest fixture, m; 0 on overlap."""
        return inf if self._broad_phase is None else self._broad_phase.distance()

    def set_step(self, physics_step_s: float) -> None:
        """Take steps of another length, s, from the state as it is."""
        if physics_step_s != self._step_s:
            self._step_s = self._model.opt.timestep = physics_step_s
            self._dry.set_step(physics_step_s)
            if self._broad_phase is not None:
                self._broad_phase.enable_all_pairs()

    def step(
        self, motor_torque: Sequence[float], brakes: Sequence[bool] = NO_BRAKES, steps: int = 1
    ) -> None:
        """Advance ``steps`` physics steps under constant joint torques (6, Nm) and brakes.

        Raises:
            PlantError: MuJoCo warned; the message is its text.
        """
        model, data, dry, q = self._model, self._data, self._dry, self.q
        qpos, qvel, applied = self._qpos, self._qvel, self._applied
        broad_phase, step_s = self._broad_phase, self._step_s
        dry.prepare(self._response(), brakes, motor_torque)
        self._reset_force_sums(steps)
        try:
            for _ in range(steps):
                applied[:] = [m + p for m, p in zip(motor_torque, dry.torque, strict=True)]
                mujoco.mj_step(model, data)
                self._sum_forces()
                self.qd = qd = qvel.tolist()
                dry.advance(qd, q)
                qvel[:], qpos[:] = qd, q
                if broad_phase is not None:
                    broad_phase.advance(qd, step_s)
        finally:  # report MuJoCo's warning rather than an error that follows from it
            if any(self._warnings.tolist()):
                self._raise_warning()

    @property
    def engine(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """MuJoCo's own model and data, for tools that look closer."""
        return self._model, self._data

    def inertia_matrix(self) -> list[list[float]]:
        """Joint-space inertia at the last step, armature included, (6, 6), kg m2."""
        mujoco.mj_fullM(self._model, self._data, self._inertia)
        rows: list[list[float]] = self._inertia.tolist()
        return rows

    def holding_torque(self) -> list[float]:
        """Gravity, Coriolis and centrifugal torque at the state of the last step, (6,), Nm."""
        torque: list[float] = self._data.qfrc_bias.tolist()
        return torque

    def wrist_pose(self) -> list[list[float]]:
        """T6 at the last step: rows of [n o a p], (3, 4)."""
        return self._site(self._data.site("t6"))

    def tip_pose(self) -> list[list[float]]:
        """The tool's tip at the last step, T6 without a tool: rows of [n o a p], (3, 4)."""
        return self._site(self._tip)

    @staticmethod
    def _site(site: Any) -> list[list[float]]:
        pose = np.column_stack((site.xmat.reshape(3, 3), site.xpos))
        rows: list[list[float]] = pose.tolist()
        return rows

    @property
    def contacts(self) -> int:
        """Points at which the tool touches a fixture, in the last step."""
        return int(self._data.ncon)

    def wrist_force(self) -> list[float]:
        """Wrench of the hand on the tool, (6,): force, N, and torque about T6, Nm, in T6's axes.

        The mean of the last call of ``step``. Weight and inertia of the tool are in it, as in a
        sensor between the two. Zero without one.
        """
        values: list[float] = (self._wrist_sum / self._summed_steps).tolist()
        return values

    def contact_force(self) -> Contacts:
        """Wrench of the fixtures on the tool, the mean of the last call of ``step``."""
        return NO_CONTACT if self._contacts is None else self._contacts.read()

    def _reset_force_sums(self, steps: int) -> None:
        """Start the mean over the next ``steps`` steps."""
        self._wrist_sum[:] = 0.0
        self._summed_steps = steps
        if self._contacts is not None:
            self._contacts.begin()

    def _sum_forces(self) -> None:
        """Add the forces of a step, which MuJoCo evaluates at its beginning."""
        if self._contacts is not None:
            self._wrist_sum += self._sensors
            self._contacts.add()

    def _response(self) -> list[list[float]]:
        """Speed per torque over one step, W = h (M + h B)^-1, (6, 6), rad/s per Nm.

        Computed once a control period: the arm hardly moves within one.
        """
        mujoco.mj_fullM(self._model, self._data, self._inertia)
        response: list[list[float]] = np.linalg.inv(
            self._inertia / self._step_s + self._damping
        ).tolist()
        return response

    def _raise_warning(self) -> None:
        """Raise MuJoCo's warnings, if there are any, the one that came first at the front."""
        warnings = [
            (int(warning.number), mujoco.mju_warningText(kind, int(warning.lastinfo)))
            for kind, warning in enumerate(self._data.warning)
            if warning.number
        ]
        if warnings:
            warnings.sort(key=lambda warning: -warning[0])  # the longer on, the more often
            text = " ".join(text for _, text in warnings)
            raise PlantError(f"MuJoCo warned before {self._data.time:.4f} s: {text}")


def _stop_timers() -> None:
    """Set ``mjcb_time`` to null: MuJoCo then does not time the stages of each step.

    It reads the clock some 28 times a step. That is a third of a step of this arm, and where the
    clock is a system call (user-mode kernel) nearly all of it: 406 us of 412. The Python binding
    puts its own timer there and cannot take it away, so the library's variable is set.
    """
    for library in Path(mujoco.__file__).parent.glob("libmujoco.*"):
        with contextlib.suppress(OSError, ValueError):
            ctypes.c_void_p.in_dll(ctypes.CDLL(str(library)), "mjcb_time").value = None


def _silence_warning_log() -> None:
    """We read every warning from its counter; MuJoCo would also write a log to the directory."""
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(lambda _text: None)
