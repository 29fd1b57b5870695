"""The arm in MuJoCo: the plant's rigid bodies. The only importer of mujoco.

MuJoCo integrates the rigid bodies, the drives' armature and viscous friction (implicitly). Dry
friction, brakes and hard stops are :class:`~rfms_can.plant.friction.DryFriction`'s.
"""

import contextlib
import ctypes
from collections.abc import Sequence
from math import cos, sin
from pathlib import Path
from typing import Final

import mujoco
import numpy as np

from rfms_can.arm import JOINTS, Arm, JointFriction
from rfms_can.errors import PlantError
from rfms_can.plant.friction import DryFriction

GRAVITY: Final = 9.81  # m/s2, along -z of the base
BRAKE_TORQUE_RATIO: Final = 4.0
"""P: holding torque of a joint's brake over the torque limit of its drive."""

NO_BRAKES: Final = (False,) * JOINTS


class ArmModel:
    """Six joints driven by torques, advanced by whole physics steps.

    Attributes:
        q: joint angles, rad (a plain list of 6; read only).
        qd: joint speeds, rad/s (a plain list of 6; read only). A sticking joint's is exactly 0.
    """

    def __init__(
        self, arm: Arm, friction: Sequence[JointFriction], physics_step_s: float = 1e-3
    ) -> None:
        """Build the model of ``arm`` from its data, parked; friction per joint.

        Raises:
            PlantError: MuJoCo refuses the model, with its text.
        """
        _keep_warnings_to_ourselves()
        _stop_timers()
        self._model = _compile(arm, friction, physics_step_s)
        self._data = mujoco.MjData(self._model)
        self._step_s = physics_step_s
        self._limits = arm.joint_limits
        brake_torque = [BRAKE_TORQUE_RATIO * drive.torque_limit for drive in arm.drives]
        self._dry = DryFriction(friction, brake_torque, arm.joint_limits, physics_step_s)
        self._inertia = np.zeros((JOINTS, JOINTS))
        self._damping = np.diag([joint.viscous for joint in friction])
        # Views into MuJoCo's memory, taken once: each attribute look-up costs more than the copy.
        self._qpos, self._qvel = self._data.qpos, self._data.qvel
        self._applied = self._data.qfrc_applied
        self._warnings = self._data.warning.number
        self.q = [0.0] * JOINTS
        self.qd = [0.0] * JOINTS
        self.reset(arm.park)

    def reset(self, q: Sequence[float], qd: Sequence[float] = (0.0,) * JOINTS) -> None:
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
        mujoco.mj_forward(self._model, self._data)
        self._raise_warning()

    def step(
        self, motor_torque: Sequence[float], brakes: Sequence[bool] = NO_BRAKES, steps: int = 1
    ) -> None:
        """Advance ``steps`` physics steps under constant joint torques (6, Nm) and brakes.

        Raises:
            PlantError: MuJoCo warned; the message is its text.
        """
        model, data, dry, q = self._model, self._data, self._dry, self.q
        qpos, qvel, applied = self._qpos, self._qvel, self._applied
        dry.prepare(self._response(), brakes)
        try:
            for _ in range(steps):
                applied[:] = [m + p for m, p in zip(motor_torque, dry.torque, strict=True)]
                mujoco.mj_step(model, data)
                self.qd = qvel.tolist()
                dry.advance(self.qd, q)
                qvel[:], qpos[:] = self.qd, q
        finally:  # MuJoCo's warning comes before what we may say of its consequences
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
        site = self._data.site("t6")
        pose = np.column_stack((site.xmat.reshape(3, 3), site.xpos))
        rows: list[list[float]] = pose.tolist()
        return rows

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


def _compile(arm: Arm, friction: Sequence[JointFriction], physics_step_s: float) -> mujoco.MjModel:
    """The arm as a MuJoCo model: joint i turns about z of frame i - 1, base on the joint-2 axis."""
    spec = mujoco.MjSpec()
    spec.modelname = arm.name
    spec.option.timestep = physics_step_s
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # damping implicit, all else not
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET  # the culprit state stays
    body, position, quaternion = spec.worldbody, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    for index, (alpha, a, d) in enumerate(arm.dh):
        link = arm.links[index]
        body = body.add_body(name=f"link{index + 1}", pos=position, quat=quaternion)
        lower, upper = arm.joint_limits[index]
        body.add_joint(
            name=f"joint{index + 1}",
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0.0, 0.0, 1.0],
            range=[lower, upper],
            limited=mujoco.mjtLimited.mjLIMITED_FALSE,  # DryFriction has the stops
            armature=arm.drives[index].armature,
            damping=friction[index].viscous,
        )
        # A_i = Rz(q) times this fixed part: the link's own frame, seen from its joint.
        c, s = cos(alpha), sin(alpha)
        x, y, z = link.com
        position, quaternion = [a, 0.0, d], [cos(alpha / 2.0), sin(alpha / 2.0), 0.0, 0.0]
        body.explicitinertial = True
        body.mass = link.physical_mass
        body.ipos = [a + x, c * y - s * z, d + s * y + c * z]
        body.iquat = quaternion
        body.inertia = link.physical_inertia
    body.add_site(name="t6", pos=position, quat=quaternion)
    try:
        return spec.compile()
    except ValueError as error:
        raise PlantError(f"MuJoCo refuses the model of {arm.name}: {error}") from error


def _stop_timers() -> None:
    """Set ``mjcb_time`` to null: MuJoCo then does not time the stages of each step.

    It reads the clock some 28 times a step. That is a third of a step of this arm, and where the
    clock is a system call (user-mode kernel) nearly all of it: 406 us of 412. The Python binding
    puts its own timer there and cannot take it away, so the library's variable is set.
    """
    for library in Path(mujoco.__file__).parent.glob("libmujoco.*"):
        with contextlib.suppress(OSError, ValueError):
            ctypes.c_void_p.in_dll(ctypes.CDLL(str(library)), "mjcb_time").value = None


def _keep_warnings_to_ourselves() -> None:
    """We read every warning from its counter; MuJoCo would also write a log to the directory."""
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(lambda _text: None)
