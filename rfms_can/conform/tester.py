"""The tester: master, board and the five other joints around one node.

It brings the node to a state, plays cycles, and knows where its own encoder stands. Angles are
radians, torques Nm; what goes out is what a master and a board would send. The current that its
board tells is that of the DAC of two cycles before, as a sound amplifier's.
"""

import contextlib
import math
from collections.abc import Mapping, Sequence
from typing import Final

from rfms_can.conform.lines import Line
from rfms_can.conform.outcome import CheckFailed, NodeSilent
from rfms_can.conform.talk import Answers, Talk
from rfms_can.conform.vectors import Vectors, float32, set_hash
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS, MASTER
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Heartbeat,
    JointAngles,
    JointError,
    Measure,
    Nmt,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import Command, ConfigStatus, NodeState, Parameter

POWER_UP_COUNTS: Final = -1234
"""Encoder count at joint angle 0: a board powers up anywhere."""
REAL_BARRIER_S: Final = 20.0
"""BARRIER where time is real: the tester may take as long as it likes."""
QUIET_S: Final = 0.1
"""How long nothing must come where a node has nothing to say."""
NO_ERROR: Final = ((0.0, 0.0, 0.0),) * 5
OF_SPEED_LIMIT: Final = (Parameter.OVERSPEED_LIMIT, Parameter.TACHOMETER_LIMIT)
"""Bounds of a speed."""
QUICK_TRIES: Final = 4
"""ANNOUNCE needs so many tries with a node that counts where another master left off."""

Parameters = dict[Parameter, float]


class Tester(Talk):
    """Speaks for all others, and knows the bench that the node is on.

    Args:
        line, joint, wire: see ``Talk``.
        vectors: what nodes must compute, and the parameters of the bench.
        boot_id: of the tester as master; another one at each run.

    Attributes:
        parameters: that the node was told last.
        cycle: number of the cycle under way.
        row_set: number of the set that SYNC names.
        theta: where the joint stands, rad.
        speed: of the joint, rad/s.
        zero: encoder count at joint angle 0.
        current: code of the current that the board tells: what DAC asked for two cycles before.
        last_cycle, sync_ns: number and time of the last SYNC.
        sampled, sampled_before: low byte of the cycle of the last MEASURE, and of that before.
        boot: what the node said when it was switched on; None if it was on before.
    """

    def __init__(
        self, line: Line, joint: int, wire: Wire, vectors: Vectors, boot_id: int = 1
    ) -> None:
        super().__init__(line, joint, wire)
        self.vectors = vectors
        self.boot_id = boot_id
        self.index = joint - 1
        self.parameters: Parameters = {}
        self.cycle = 0
        self.row_set = 0
        self.zero = POWER_UP_COUNTS
        self.theta = 0.0
        self.speed = 0.0
        self.boot: Answers | None = None
        self.sampled = self.sampled_before = 0
        self.current = self._acting = 0
        self.last_cycle = -1
        self.sync_ns = 0
        self._due_ns = line.now_ns

    # --- from anywhere to a state -------------------------------------------------------------

    def greet(self) -> None:
        """Become the node's master, in the place of any other."""
        self.forget()
        self.last_beat = None
        for tries_left in reversed(range(QUICK_TRIES)):
            self.send(self.master_beat())
            try:
                self.beat()
                return
            except NodeSilent:
                if not tries_left:
                    raise

    def master_beat(self, boot_id: int | None = None) -> Frame:
        """A HEARTBEAT of the master."""
        own = self.boot_id if boot_id is None else boot_id
        return self.frame(
            Heartbeat, MASTER, NodeState.PREOP, 0, 0, own, self.wire.dbc_hash, 0, 0, 0
        )

    def wait_for_power(self, seconds: float) -> None:
        """Listen until the node is switched on; what it says then is ``boot``.

        Raises:
            NodeSilent: it is not switched on.
        """
        if self.line.virtual:
            return  # the tester switches it on itself
        until_ns = self.line.now_ns + round(seconds * 1e9)
        frame = self.line.receive(until_ns)
        if frame is None:
            raise NodeSilent("nothing", "nothing", f"a HEARTBEAT at power-on within {seconds:g} s")
        self._read(frame)
        self.boot = self.listen()

    def to_preop(self) -> None:
        """From any state to PREOP, no fault remembered."""
        if self.beat().state == NodeState.OPERATIONAL:
            self.command(Command.QUICKSTOP)
        self.command(Command.RESET)
        beat = self.beat()
        self.equal(NodeState(beat.state).name, "PREOP", "state after RESET")
        self.equal(beat.error_register, 0, "error register after RESET")
        self.cycle, self.row_set = 0, 0
        self.speed = 0.0

    def leave(self) -> None:
        """Leave the node in PREOP, if it listens, and SYNC with it: it shall not drive when its
        master has gone, and for BARRIER no other one can start again beside one that drives."""
        with contextlib.suppress(CheckFailed):
            self.to_preop()
            self.sync(NodeState.PREOP)

    def bench(self, changes: Mapping[Parameter, float] | None = None) -> Parameters:
        """The parameters of the suite's bench, for this line.

        Bounds of a speed go with SPEED_LIMIT, if that changes and they do not.
        """
        clock = Clock.VIRTUAL if self.line.virtual else Clock.LOCKSTEP
        usual = self.vectors.bench
        fastest = (changes or {}).get(Parameter.SPEED_LIMIT, usual[Parameter.SPEED_LIMIT])
        times = fastest / usual[Parameter.SPEED_LIMIT]
        values = {
            **usual,
            **{p: times * usual[p] for p in OF_SPEED_LIMIT},
            Parameter.CLOCK: float(clock),
            Parameter.BARRIER: REAL_BARRIER_S,
            **(changes or {}),
        }
        return {p: float32(v) for p, v in values.items()}

    def configure(self, changes: Mapping[Parameter, float] | None = None) -> None:
        """From any state to PREOP with a new configuration: the node has no reference."""
        self.to_preop()
        self.tell_parameters(changes)

    def tell_parameters(self, changes: Mapping[Parameter, float] | None = None) -> None:
        """In PREOP: a whole configuration."""
        self.parameters = self.bench(changes)
        for parameter, value in self.parameters.items():
            self.send(self.frame(Config, self.joint, parameter, 0, value, 0))
        answers = self.settle()
        taken = [a for a in answers.of("CONFIG_ACK") if a.status == ConfigStatus.TAKEN]
        self.equal(len(taken), len(self.parameters), "parameters TAKEN")
        ack = self.commit()
        self.equal(ConfigStatus(ack.status).name, "TAKEN", "answer to COMMIT")

    def commit(self, total: int | None = None, digest: int | None = None) -> ConfigAck:
        """Close the set; the answer."""
        total = len(self.parameters) if total is None else total
        digest = set_hash(self.parameters) if digest is None else digest
        values = (Parameter.COMMIT, total, 0.0, digest)
        ack: ConfigAck = self.one(self.say(Config, self.joint, *values), "CONFIG_ACK")
        return ack

    def home(self, theta: float = 0.0) -> None:
        """From PREOP to READY, the index seen already, the joint at rest at ``theta``."""
        self.theta, self.speed = theta, 0.0
        self.only(self.command(Command.HOME), ())
        self.sync(NodeState.HOMING)
        self.measure()
        self.reference()
        self.state_is(NodeState.READY)

    def unreferenced(
        self, changes: Mapping[Parameter, float] | None = None, theta: float = 0.0
    ) -> None:
        """From any state to PREOP, newly configured, the joint at ``theta``."""
        self.configure(changes)
        self.theta = theta

    def ready(self, changes: Mapping[Parameter, float] | None = None, theta: float = 0.0) -> None:
        """From any state to READY, newly configured."""
        self.configure(changes)
        self.home(theta)

    def operational(
        self, changes: Mapping[Parameter, float] | None = None, theta: float = 0.0
    ) -> None:
        """From any state to OPERATIONAL, newly configured; cycle 0 comes next."""
        self.ready(changes, theta)
        self.start()

    def start(self, node: int = 0) -> Answers:
        """START that the node takes: both sides count from 0."""
        self.send(self.frame(Nmt, None, Command.START, node, 0))
        self.restart_counters()
        self.cycle, self.row_set = -1, 0
        answers = self.settle()
        self.state_is(NodeState.OPERATIONAL)
        return answers

    def state_is(self, state: NodeState) -> Heartbeat:
        """The node must be in a state; its HEARTBEAT."""
        beat = self.beat()
        self.equal(NodeState(beat.state).name, state.name, "state")
        return beat

    # --- frames of a cycle --------------------------------------------------------------------

    @property
    def period_ns(self) -> int:
        """Control period, ns."""
        return round(self.parameters.get(Parameter.PERIOD, 0.004) * 1e9)

    def sync(
        self,
        state: NodeState = NodeState.OPERATIONAL,
        *,
        skip: int = 0,
        row_set: int | None = None,
    ) -> Answers:
        """The next SYNC, a period after the last; ``skip`` cycles are left out."""
        self.cycle += 1 + skip
        if self.line.virtual:
            self._due_ns = max(self._due_ns + self.period_ns * (1 + skip), self.line.now_ns)
            self.line.pass_until(self._due_ns)
        named = self.row_set if row_set is None else row_set
        self.last_cycle = self.cycle
        self.current, self._acting = self._acting, self._asked()
        answers = self.say(Sync, None, self.cycle, state, named, self.wire.dbc_hash)
        self.sync_ns = self.line.now_ns
        return answers

    def _asked(self) -> int:
        """Current of both DACs of the last frame, in codes of current_dac; 0 before any."""
        p, dac = self.parameters, self.last_dac
        if dac is None or Parameter.TORQUE_PER_CODE not in p:
            return 0
        force_scale = p[Parameter.TORQUE_PER_FORCE_CODE] / p[Parameter.TORQUE_PER_CODE]
        return max(-2048, min(2047, round(dac.current_dac + dac.force_dac * force_scale)))

    def counts(self, theta: float | None = None) -> int:
        """Encoder counts where the joint stands."""
        theta = self.theta if theta is None else theta
        return round(theta * self.parameters[Parameter.COUNTS_PER_UNIT]) + self.zero

    def move_to(self, theta: float, most: float = math.inf) -> None:
        """Go to an angle within a cycle; the tachometer tells the speed, up to ``most`` rad/s."""
        speed = (theta - self.theta) / self.parameters[Parameter.PERIOD]
        self.theta, self.speed = theta, max(-most, min(most, speed))

    @property
    def measured(self) -> float:
        """The angle that the encoder tells, rad."""
        return (self.counts() - self.zero) / self.parameters[Parameter.COUNTS_PER_UNIT]

    @property
    def speed_code(self) -> int:
        """Velocity ADC code."""
        return round(self.speed / self.parameters[Parameter.RATE_PER_CODE])

    @property
    def measured_speed(self) -> float:
        """The speed that the ADC tells, rad/s."""
        return self.speed_code * self.parameters[Parameter.RATE_PER_CODE]

    def measure(
        self,
        *,
        counts: int | None = None,
        cycle: int | None = None,
        current: int | None = None,
        speed_code: int | None = None,
        index_seen: int = 0,
        braked: int = 0,
    ) -> Answers:
        """MEASURE of the own board."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        told = self.counts() if counts is None else counts
        driven = self.current if current is None else current
        speed = self.speed_code if speed_code is None else speed_code
        self.sampled_before, self.sampled = self.sampled, low
        return self.say(Measure, self.joint, told, driven, speed, low, index_seen, braked, 0)

    def coarse_code(self, theta: float | None = None) -> int:
        """Coarse ADC code where the joint stands."""
        p = self.parameters
        theta = self.theta if theta is None else theta
        code = round((theta - p[Parameter.COARSE_ZERO]) / p[Parameter.COARSE_PER_CODE])
        return max(0, min(4095, code))

    @property
    def interval(self) -> int:
        """Encoder counts between two indexes."""
        return round(self.parameters[Parameter.INDEX_INTERVAL_COUNTS])

    def reference(
        self,
        *,
        valid: int = 1,
        coarse: int | None = None,
        index_counts: int | None = None,
        cycle: int | None = None,
    ) -> Answers:
        """REFERENCE of the own board; index pulses lie at whole intervals from joint angle 0."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        if index_counts is None:
            passed = (self.counts() - self.zero) // self.interval
            index_counts = passed * self.interval + self.zero
        code = self.coarse_code() if coarse is None else coarse
        return self.say(Reference, self.joint, code, index_counts, valid, low)

    def setpoint_frame(
        self, extras: int = JOINT_SETPOINT_BELONGS, cycle: int | None = None, **changes: float
    ) -> Frame:
        """SETPOINT_1 at rest, the angle told in JOINT_SETPOINT; ``changes`` by field."""
        cycle = self.cycle if cycle is None else cycle
        rest = self.vectors.rest_pose
        told: tuple[float, ...] = (
            *(*rest.o, *rest.a, *rest.p, 0.0, 0.0, 0.2),
            *(0, 0, rest.configuration, 1, cycle & 0xFFFFFFFF, 0, 1, extras, 0),
        )
        values = {**dict(zip(Setpoint._fields, told, strict=True)), **changes}
        return self.frame(Setpoint, 1, *values.values())

    def angles_frame(
        self, angle: float, which: int = 1, cycle: int | None = None, joints: int | None = None
    ) -> Frame:
        """JOINT_SETPOINT with the own joint's angle; the others are elsewhere."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        angles = [0.25 * (j - 3.0) for j in JOINTS]
        angles[self.index] = angle
        bits = 1 << self.index if joints is None else joints
        return self.frame(JointAngles, which, *angles, low, bits)

    def setpoint(self, angle: float | None = None, cycle: int | None = None) -> Answers:
        """The set-point of this cycle: rest at an angle, by default where the joint stands."""
        angle = self.measured if angle is None else angle
        return self.give(self.setpoint_frame(cycle=cycle), self.angles_frame(angle, cycle=cycle))

    def others(
        self, values: Sequence[Sequence[float]] = NO_ERROR
    ) -> list[tuple[int, Sequence[float]]]:
        """The five other joints and what each tells, in ascending order."""
        return list(zip((j for j in JOINTS if j != self.joint), values, strict=True))

    def errors(
        self,
        values: Sequence[Sequence[float]] = NO_ERROR,
        *,
        without: Sequence[int] = (),
        cycle: int | None = None,
    ) -> Answers:
        """ERROR of the five other joints."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        answers = Answers()
        for joint, told in self.others(values):
            if joint not in without:
                answers += self.say(JointError, joint, *told, low)
        return answers

    def own_first(self, row: Sequence[float]) -> list[float]:
        """A row in the order of the joints, of one with the own joint's element first."""
        own, *others = row
        return [*others[: self.index], own, *others[self.index :]]

    def rows(self, number: int, values: Sequence[float]) -> Answers:
        """ROWS of the own joint: law row, inertia row, gravity, then set and the rest."""
        self.row_set = number
        return self.say(Rows, self.joint, *values)

    def run(self, cycles: int = 1) -> Answers:
        """Good cycles at rest; what the node sent in the last."""
        answers = Answers()
        for _ in range(cycles):
            answers = self.sync()
            answers += self.setpoint()
            answers += self.measure()
            answers += self.errors()
        return answers
