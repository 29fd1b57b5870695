"""Everything around one joint node: master, plant, and the five other joints."""

import math
from collections.abc import Sequence

from rfms_can.arm import PUMA_260, Arm
from rfms_can.joint_nodes.controller import JointController
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import configuration_of, direct
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.frames import values_of
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import (
    JointError,
    Measure,
    Reference,
    Rows,
    Setpoint,
)
from rfms_can.wire.vocabulary import (
    Blend,
    Command,
    Law,
    Mode,
    NodeState,
    Parameter,
    TrajectoryState,
)
from support.bench import PERIOD_NS, FieldNodeBench, Heard

ANY_SPEED: dict[Parameter, float] = {
    Parameter.SPEED_LIMIT: 100.0,
    Parameter.OVERSPEED_LIMIT: 150.0,
    Parameter.TACHOMETER_LIMIT: 100.0,
}
"""Of a joint whose samples need not be one motion: for tests that are about something else."""


def step_limit(bench: "JointBench") -> float:
    """Largest step of a set-point or a measurement, rad in one cycle."""
    return 1.5 * bench.parameters[Parameter.SPEED_LIMIT] * PERIOD_NS * 1e-9


class JointBench(FieldNodeBench[JointNode]):
    """A joint node, its arm at ``q``, its encoder powered up somewhere else than zero.

    The board tells the current that the DACs of two cycles before ask for; the joint moves as its
    speed says, from SYNC to SYNC.

    Attributes:
        q: where the arm is and its set-point lies, rad; change it freely.
        speed: of the node's own joint, rad/s.
    """

    POWER_UP_COUNTS = 1234

    def __init__(
        self,
        wire: Wire,
        joint: int = 2,
        arm: Arm = PUMA_260,
        changes: dict[Parameter, float] | None = None,
    ) -> None:
        node = JointNode(joint, wire, 0x100 + joint)
        parameters = all_parameters(arm, "corke", PERIOD_NS * 1e-9)[joint]
        super().__init__(node, wire, {**parameters, **(changes or {})})
        self.arm = arm
        self.index = joint - 1
        self.q = list(arm.park)
        self.speed = 0.0
        self.bias: tuple[float, ...] | None = None
        self._driven = self._acting = 0

    @property
    def controller(self) -> JointController:
        """The controller of a configured node."""
        assert self.node.controller is not None
        return self.node.controller

    # --- what the board says ------------------------------------------------------------------

    def sync(
        self,
        state: NodeState = NodeState.OPERATIONAL,
        row_set: int | None = None,
        *,
        dbc_hash: int | None = None,
        lost: bool = False,
    ) -> list[Heard]:
        """Begin the next cycle: the last DAC acts, and the joint has moved for a period."""
        self._go_on()
        return super().sync(state, row_set, dbc_hash=dbc_hash, lost=lost)

    def miss_syncs(self, count: int) -> list[Heard]:
        """Let time pass until ``count`` SYNCs have been missed in a row; the joint moves on."""
        for _ in range(count):
            self._go_on()
        return super().miss_syncs(count)

    def _go_on(self) -> None:
        self._driven, self._acting = self._acting, self._asked()
        self.q[self.index] += self.speed * PERIOD_NS * 1e-9

    def _asked(self) -> int:
        """Current of both DACs of the last frame, in codes of current_dac; 0 before any."""
        p, dacs = self.parameters, self.dacs()
        if not dacs:
            return 0
        force_scale = p[Parameter.TORQUE_PER_FORCE_CODE] / p[Parameter.TORQUE_PER_CODE]
        return max(-2048, min(2047, round(dacs[-1].current_dac + dacs[-1].force_dac * force_scale)))

    def counts(self, theta: float | None = None) -> int:
        """Encoder counts at an angle of the node's joint."""
        theta = self.q[self.index] if theta is None else theta
        return round(theta * self.parameters[Parameter.COUNTS_PER_UNIT]) - self.POWER_UP_COUNTS

    def angle(self, theta: float | None = None) -> float:
        """The angle the encoder resolves, rad."""
        per_rad = self.wire_value(self.parameters[Parameter.COUNTS_PER_UNIT])
        return (self.counts(theta) + self.POWER_UP_COUNTS) / per_rad

    def speed_code(self, speed: float | None = None) -> int:
        """Velocity ADC code, of the joint's speed or another, rad/s."""
        told = self.speed if speed is None else speed
        return round(told / self.parameters[Parameter.RATE_PER_CODE])

    @property
    def read_speed(self) -> float:
        """The speed the ADC resolves, rad/s."""
        return self.speed_code() * self.wire_value(self.parameters[Parameter.RATE_PER_CODE])

    @property
    def driven(self) -> int:
        """The current that MEASURE tells, in codes of current_dac."""
        return self._driven

    def measure(
        self,
        theta: float | None = None,
        cycle: int | None = None,
        *,
        speed: float | None = None,
        code: int | None = None,
        current: int | None = None,
        braked: bool = False,
    ) -> list[Heard]:
        """MEASURE of the own joint.

        Args:
            theta: angle that the encoder tells, rad; where the joint is.
            cycle: of the sample; the one under way.
            speed: that the tachometer tells, rad/s, or ``code`` its code; how fast the joint is.
            current: code of the current ADC; what the DACs asked for.
            braked: whether the brake holds.
        """
        low = (self.cycle if cycle is None else cycle) & 0xFF
        told = self.speed_code(speed) if code is None else code
        driven = self._driven if current is None else current
        values = (self.counts(theta), driven, told, low, 0, int(braked))
        return self.say(Measure, self.number, *values)

    def reference(self, coarse_error: float = 0.0) -> list[Heard]:
        """REFERENCE: the index pulse last crossed, and the potentiometer off by an error, rad."""
        p = self.parameters
        interval = round(p[Parameter.INDEX_INTERVAL_COUNTS])
        absolute = self.counts() + self.POWER_UP_COUNTS
        pulse = absolute // interval * interval
        coarse = (self.q[self.index] + coarse_error - p[Parameter.COARSE_ZERO]) / p[
            Parameter.COARSE_PER_CODE
        ]
        values = (round(coarse), pulse - self.POWER_UP_COUNTS, 1, self.cycle & 0xFF)
        return self.say(Reference, self.number, *values)

    # --- what the others say ------------------------------------------------------------------

    def setpoint(
        self, q: Sequence[float] | None = None, cycle: int | None = None, extras: int = 0
    ) -> list[Heard]:
        """SETPOINT_1 of an arm held at joint angles ``q``; IDLE, so that the pose is all."""
        q = self.q if q is None else q
        pose, configuration = direct(self.arm, q), configuration_of(self.arm, q)
        setpoint = CartesianSetpoint(
            *(TrajectoryState.IDLE, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.0, 0.2),
            *(pose, configuration, None, configuration),
        )
        number = self.cycle if cycle is None else cycle
        return self.say(Setpoint, 1, *values_of(setpoint, pose, configuration, number, extras))

    def other_errors(
        self,
        errors: Sequence[float] = (0.0,) * 6,
        rates: Sequence[float] = (0.0,) * 6,
        accelerations: Sequence[float] = (0.0,) * 6,
        *,
        without: Sequence[int] = (),
        cycle: int | None = None,
    ) -> list[Heard]:
        """ERROR of the five other joints."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        answers: list[Heard] = []
        for joint in JOINTS:
            if joint != self.number and joint not in without:
                i = joint - 1
                answers += self.say(JointError, joint, errors[i], rates[i], accelerations[i], low)
        return answers

    def rows(
        self,
        number: int,
        *,
        compliance: Sequence[float] | None = None,
        weighted: Sequence[float] = (0.0,) * 6,
        gravity: float = 0.0,
        law: Law = Law.PID,
        damping: float = 0.0,
        selection: int = 0,
        specification: int = 0,
    ) -> list[Heard]:
        """The node's own rows of a set: ``compliance`` of C, ``weighted`` of the inertia matrix.

        Under the weighted law ``weighted`` is the row of M C, and ``compliance`` that of M.
        """
        self.row_set = number
        own = [float(i == self.index) for i in range(6)] if compliance is None else compliance
        told = (gravity, number, law, damping, selection, specification)
        first, second = (weighted, own) if law is Law.WEIGHTED else (own, weighted)
        return self.say(Rows, self.number, *first, *second, *told)

    # --- whole cycles -------------------------------------------------------------------------

    def run(self, cycles: int = 1, row_set: int | None = None) -> list[Heard]:
        """Good control cycles; the arm stands where its set-point is."""
        answers: list[Heard] = []
        for _ in range(cycles):
            answers += self.sync(row_set=row_set)
            answers += self.setpoint()
            answers += self.measure()
            answers += self.other_errors()
        return answers

    def reach(self, speed: float) -> list[Heard]:
        """Good control cycles until the joint moves at a speed, rad/s; no faster than it may."""
        change = self.parameters[Parameter.ACCELERATION_LIMIT] * PERIOD_NS * 1e-9
        answers: list[Heard] = []
        while self.speed != speed:
            off = speed - self.speed
            self.speed = speed if abs(off) <= change else self.speed + math.copysign(change, off)
            answers += self.run()
        return answers

    def home(self) -> None:
        """From PREOP to READY; the index has been seen already."""
        self.command(Command.HOME)
        self.rows(self.row_set)
        self.sync(NodeState.HOMING)
        self.measure()
        self.reference()
        assert self.state is NodeState.READY

    def start(self) -> None:
        """From READY to OPERATIONAL, and through the first cycle."""
        self.command(Command.START)
        self.cycle = -1
        self.run()
        assert self.state is NodeState.OPERATIONAL

    def enable(self) -> "JointBench":
        """From power-up to OPERATIONAL."""
        self.configure()
        self.home()
        self.start()
        return self
