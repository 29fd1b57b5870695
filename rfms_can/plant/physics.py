"""The plant between two SYNCs: six boards, the arm, and the gripper's jaw.

No frames and no clock: its owner sets the control period and passes the codes from the bus.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from rfms_can.arm import Arm
from rfms_can.errors import PlantError
from rfms_can.plant.arm_model import NO_BRAKES, ArmModel
from rfms_can.plant.board import JointBoard, Sample
from rfms_can.plant.contact_wrench import Contacts
from rfms_can.plant.jaw import Jaw
from rfms_can.plant.scene import FREE, Scene, Tool
from rfms_can.plant.variant import Variant, as_built
from rfms_can.plant.wrist_sensor import WristSensor
from rfms_can.transform import Transform

PHYSICS_STEPS_NS: Final = (1_000_000, 500_000, 250_000, 200_000, 100_000)
"""Lengths of a physics step, largest first; 1 ms at most."""

MAX_TIP_SPEED: Final = 5.0
"""Bound of the speed of any point of a tool, m/s. Where the tool cannot reach a fixture within a
period, physics takes the longest steps, as without a scene, instead of those for contact."""

RATES_HZ: Final = (50, 100, 125, 200, 250, 400, 500, 800, 1000, 2000)
"""Valid rates that the error message suggests."""


def physics_steps(rate_hz: float, longest_s: float = 1e-3) -> tuple[int, float]:
    """Physics steps per control period, and their length (s), at ``rate_hz``.

    The largest of :data:`PHYSICS_STEPS_NS` up to ``longest_s`` that divides the period, in whole
    nanoseconds.

    Raises:
        PlantError: none does; the message names the period and rates that fit.
    """
    period_ns = round(1e9 / rate_hz) if rate_hz > 0.0 else 0
    if period_ns > 0 and abs(period_ns * rate_hz - 1e9) < 1e-3 * rate_hz:
        for step_ns in PHYSICS_STEPS_NS:
            steps, rest = divmod(period_ns, step_ns)
            if steps and not rest and step_ns * 1e-9 <= longest_s:
                return steps, step_ns * 1e-9
    period = f"a period of {1e3 / rate_hz:.6g} ms" if rate_hz > 0.0 else "no period"
    raise PlantError(
        f"rate {rate_hz:g} Hz: {period} is not a whole number of physics steps of 1, 0.5, 0.25, "
        f"0.2 or 0.1 ms; rates that fit: {', '.join(map(str, RATES_HZ))} Hz"
    )


class PlantPhysics:
    """Six boards on one arm, and a gripper, advanced one control period at a time.

    Attributes:
        arm: the arm it carries.
        steps_per_period: physics steps in one control period, where the tool may touch something.
        step_s: length of a physics step there, s.
        jaw: the gripper.
        model: its rigid bodies and the fixtures.
    """

    def __init__(
        self,
        arm: Arm,
        friction_name: str,
        rate_hz: float,
        initial_q: Sequence[float] | None = None,
        part_width: float = 0.0,
        scene: Scene = FREE,
        sensor: WristSensor | None = None,
        variant: Variant | None = None,
    ) -> None:
        """Power up ``arm`` at ``initial_q`` (6, rad; parked if None), gripper half open.

        Args:
            arm: the arm.
            friction_name: its friction set.
            rate_hz: control rate, Hz.
            initial_q: joint angles, rad (6).
            part_width: of the workpiece in the gripper, m.
            scene: tool and fixtures.
            sensor: between hand and tool, or None.
            variant: true parameters of arm and boards; those of the data sheet if None.

        Raises:
            ArmError: no such friction set.
            PlantError: the rate does not fit the physics step, or the pose not the arm, or the
                variant's load not the scene.
        """
        self.arm = arm
        self._contact_steps = physics_steps(rate_hz, scene.longest_step_s)
        self._free_steps = physics_steps(rate_hz)
        self._free_clearance = MAX_TIP_SPEED / rate_hz
        self.steps_per_period, self.step_s = self._contact_steps
        variant = variant or as_built(arm, friction_name)
        scene = _with_load(scene, variant)
        self.model = ArmModel(variant.arm, variant.friction, self.step_s, scene)
        self._sensor = sensor
        self._place = scene.place.inverse()
        if initial_q is not None:
            self.model.reset(initial_q)
        self._boards: list[JointBoard] = list(variant.boards(self.model.q))
        self._seized = [False] * len(self._boards)
        self._pushed = [0.0] * len(self._boards)
        self.jaw = Jaw(arm.gripper, arm.gripper.stroke / 2.0, part_width)

    @property
    def true_q(self) -> list[float]:
        """The exact joint angles, (6,), rad (a copy)."""
        return list(self.model.q)

    @property
    def true_qd(self) -> list[float]:
        """The exact joint speeds, (6,), rad/s (a copy)."""
        return list(self.model.qd)

    def step_period(
        self,
        motor_current_codes: Sequence[int],
        force_set_point_codes: Sequence[int],
        brakes: Sequence[bool] = NO_BRAKES,
    ) -> None:
        """Advance one control period with the DACs held at the given codes (6 each).

        A brake that is on (True) holds its joint; the motor goes on pushing against it.

        Raises:
            PlantError: MuJoCo warned; the message is its text.
        """
        boards, model, jaw = self._boards, self.model, self.jaw
        if any(self._seized):
            brakes = [closed or stuck for closed, stuck in zip(brakes, self._seized, strict=True)]
        torque = [
            board.set_dacs(current, force) + pushed
            for board, current, force, pushed in zip(
                boards, motor_current_codes, force_set_point_codes, self._pushed, strict=True
            )
        ]
        steps, step_s = (
            self._free_steps if model.clearance() > self._free_clearance else self._contact_steps
        )
        model.set_step(step_s)
        model.step(torque, brakes, steps)
        for board, q, qd in zip(boards, model.q, model.qd, strict=True):
            board.observe(q, qd)
        steps, step_s = self._free_steps  # the jaw has no contact with the scene
        for _ in range(steps):
            jaw.step(step_s)

    def exchange_board(self, joint: int, exchange: Callable[[JointBoard], JointBoard]) -> None:
        """Put another board in the place of that of joint index ``joint``, for trials of faults.

        Args:
            joint: 0 to 5.
            exchange: makes it of the board that is there.
        """
        self._boards[joint] = exchange(self._boards[joint])

    def seize_brake(self, joint: int) -> None:
        """Let the brake of joint index ``joint`` hold for good, whatever it is told."""
        self._seized[joint] = True

    def push(self, joint: int, torque: float) -> None:
        """Push at joint index ``joint`` from outside with a torque, Nm, from now on; 0 lets go."""
        self._pushed[joint] = torque

    def sample(self) -> list[Sample]:
        """Counts, current ADC, velocity ADC and index flag of each joint, for MEASURE."""
        return [board.sample() for board in self._boards]

    @property
    def contacts(self) -> int:
        """Points at which the tool touches a fixture now."""
        return self.model.contacts

    @property
    def true_force(self) -> list[float]:
        """Wrench of the hand on the tool at T6, mean of the last period, (6,), N and Nm."""
        return self.model.wrist_force()

    def contact_force(self) -> Contacts:
        """Contact wrench on the tool in the last period, along the axes of its tip."""
        return self.model.contact_force()

    def tip_in_place(self) -> Transform:
        """Pose of the tool's tip (T6 without a tool) in the true frame of the task."""
        pose = Transform.from_rows(self.model.tip_pose())
        return self._place @ pose

    def sample_force(self) -> list[float] | None:
        """The wrist sensor's reading of the last period, (6,), N and Nm; None without one."""
        return None if self._sensor is None else self._sensor.sample(self.model.wrist_force())

    def coarse(self, joint: int) -> int:
        """Coarse position code (0 to 4095) of joint index ``joint``."""
        return self._boards[joint].coarse(self.model.q[joint])

    def latched_index_counts(self, joint: int) -> int | None:
        """Counts at the last index pulse of joint index ``joint``; None before the first."""
        return self._boards[joint].latched_index_counts


def _with_load(scene: Scene, variant: Variant) -> Scene:
    """The scene with the variant's load in the hand."""
    load = variant.load
    if not load.mass:
        return scene
    if scene.tool is not None:
        raise PlantError(f"plant {variant.name!r}: scene {scene.name!r} has a tool in the hand")
    tool = Tool(load.mass, load.com, load.inertia, (), Transform.identity())
    return replace(scene, tool=tool)
