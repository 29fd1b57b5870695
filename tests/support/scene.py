"""A PUMA 560 in a scene, without a bus: held, led along, and pressed against what is there."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from rfms_can.arm import PUMA_560
from rfms_can.dynamics.rigid_body import GRAVITY, ArmDynamics
from rfms_can.kinematics import InverseKinematics, Joints, configuration_of, direct
from rfms_can.plant.arm_model import ArmModel
from rfms_can.plant.scene import Scene
from rfms_can.plant.scene.catalogue import scene_from
from rfms_can.transform import Transform

Floats = npt.NDArray[np.float64]

NATURAL = 60.0
"""Of the position control, rad/s; critically damped."""
CONFIGURATION = configuration_of(PUMA_560, PUMA_560.park)


class SceneBench:
    """An arm in a scene, controlled at 1 kHz: rigid, or complying in axes of the tool's tip.

    Args:
        scene: as a run asks for it.
        friction: friction set of the arm.
    """

    def __init__(self, scene: str, friction: str = "none") -> None:
        self.scene: Scene = scene_from(scene, "puma560")
        assert self.scene.tool is not None
        self.tool = self.scene.tool
        self.friction = PUMA_560.friction_sets[friction]
        step_s = self.scene.longest_step_s
        self.model = ArmModel(PUMA_560, self.friction, step_s, self.scene)
        self.steps = round(1e-3 / step_s)
        self._dynamics = ArmDynamics(PUMA_560)

    def solve(self, tip: Transform) -> Joints:
        """Joint angles with the tip at a pose in the base frame."""
        pose = tip @ self.tool.tip.inverse()
        return InverseKinematics(PUMA_560).solve(pose, CONFIGURATION, PUMA_560.park)

    def put(self, tip: Transform) -> None:
        """Stand still with the tip at a pose."""
        self.model.reset(self.solve(tip))

    @property
    def tip(self) -> Transform:
        """The tip, in the base frame."""
        return Transform.from_rows(self.model.wrist_pose()) @ self.tool.tip

    def weight(self) -> Floats:
        """What the hand does to a tool at rest, (6,), N and Nm at T6, along its axes."""
        pose = direct(PUMA_560, self.model.q)
        up = GRAVITY * self.tool.mass * np.array([pose.nz, pose.oz, pose.az])
        return np.concatenate((up, np.cross(self.tool.com, up)))

    def holding(self) -> list[float]:
        """Torque that holds arm and tool against gravity, (6,), Nm."""
        dynamics = self._dynamics
        dynamics.update(self.model.q)
        torque: list[float] = (dynamics.g + dynamics.J.T @ self.weight()).tolist()
        return torque

    def energy(self) -> float:
        """Kinetic and potential energy of arm and tool, J."""
        model, data = self.model.engine
        model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
        mujoco.mj_forward(model, data)
        return float(sum(data.energy))

    def tip_jacobian(self) -> Floats:
        """Velocity and rate of the tip along its axes, (6, 6)."""
        rates = self._dynamics.J.copy()
        x, y, z = self.tool.tip.px, self.tool.tip.py, self.tool.tip.pz
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        rates[:3] -= cross @ rates[3:]
        return rates

    def control(
        self,
        tip: Transform,
        seconds: float,
        *,
        comply: Sequence[int] = (),
        force: Sequence[float] = (0.0,) * 6,
        each: Callable[[], None] = lambda: None,
    ) -> None:
        """Control to a pose of the tip: rigid, but in the axes in ``comply`` (0 to 5) only damped.

        Args:
            tip: pose in the base frame.
            seconds: how long.
            comply: axes of the tip's frame.
            force: exerted on what is met, along the axes of the tip, N and Nm.
            each: called every millisecond.
        """
        wanted, dynamics, model = np.array(self.solve(tip)), self._dynamics, self.model
        free = np.zeros(6)
        free[list(comply)] = 1.0
        for _ in range(round(seconds / 1e-3)):
            dynamics.update(model.q)
            rates = self.tip_jacobian()
            held = np.linalg.solve(rates, (1.0 - free)[:, None] * rates)
            wish = NATURAL**2 * (held @ (wanted - model.q)) - 2.0 * NATURAL * np.array(model.qd)
            torque = dynamics.M @ wish + dynamics.g + dynamics.J.T @ self.weight()
            torque += rates.T @ np.array(force)
            model.step(self.with_friction(torque.tolist()), steps=self.steps)
            each()

    def with_friction(self, torque: list[float]) -> list[float]:
        """Add the dry friction of joints that turn."""
        return [
            t + (f.coulomb_positive if v > 0.0 else -f.coulomb_negative if v < 0.0 else 0.0)
            for t, v, f in zip(torque, self.model.qd, self.friction, strict=True)
        ]
