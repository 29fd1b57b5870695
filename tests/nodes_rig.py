"""Nodes pumped with plain function calls: no bus model, no sleeping.

``Pump`` carries frames between any nodes, at once and in order, unless told to lose, repeat or
delay some. ``JointBench`` and ``GripperBench`` are everything around one node: they speak for the
master, the plant and the other nodes, and tell what it answers.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rfms_can.arm import PUMA_260, Arm
from rfms_can.cartesian_setpoint import CartesianSetpoint
from rfms_can.frame import Frame
from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.joint_nodes.gripper import GripperNode
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.kinematics import configuration_of, direct
from rfms_can.master.node_parameters import all_parameters
from rfms_can.master.phases import Phase
from rfms_can.master.settings import Clock
from rfms_can.master.supervisor import Supervisor
from rfms_can.node import Node
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.protection import Sender
from rfms_can.rig.settings import RunSettings
from rfms_can.setpoint_frames import values_of
from rfms_can.wire import GRIPPER, JOINTS, Wire
from rfms_can.wire.configuration import configuration_hash
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Dac,
    Emcy,
    JointError,
    Measure,
    Nmt,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import (
    Blend,
    Command,
    ConfigStatus,
    Law,
    Mode,
    NodeState,
    Parameter,
    TrajectoryState,
)

PERIOD_NS = 4_000_000
Fate = Callable[[Frame, Node], bool]


class Pump:
    """Carries frames between nodes and keeps their time.

    Attributes:
        now_ns: time; moves on from deadline to deadline.
        sent: every frame handed over, in order.
    """

    def __init__(self, *nodes: Node) -> None:
        self.nodes = list(nodes)
        self.now_ns = 0
        self.sent: list[Frame] = []
        self._fates: list[tuple[Fate, int, int]] = []  # whom, copies, delay
        self._accepts: dict[str, frozenset[int]] = {}
        self._queue: deque[tuple[Node, Frame]] = deque()
        self._later: list[tuple[int, Node, Frame]] = []

    def lose(self, fate: Fate) -> None:
        """Frames, receiver by receiver, that do not arrive."""
        self._fates.append((fate, 0, 0))

    def repeat(self, fate: Fate) -> None:
        """Frames that arrive twice."""
        self._fates.append((fate, 2, 0))

    def delay(self, fate: Fate, delay_ns: int) -> None:
        """Frames that arrive late."""
        self._fates.append((fate, 1, delay_ns))

    def heal(self) -> None:
        """From now on every frame arrives once and at once."""
        self._fates.clear()

    def post(self, frames: Iterable[Frame]) -> None:
        """Hand frames over, as if somebody had sent them."""
        for frame in frames:
            self.sent.append(frame)
            for node in self.nodes:
                if frame.id not in self._accepted_by(node):
                    continue
                copies, delay_ns = next(
                    ((c, d) for fate, c, d in self._fates if fate(frame, node)), (1, 0)
                )
                if delay_ns:
                    self._later.append((self.now_ns + delay_ns, node, frame))
                else:
                    self._queue.extend([(node, frame)] * copies)

    def _accepted_by(self, node: Node) -> frozenset[int]:
        accepts = self._accepts.get(node.name)
        if accepts is None:
            accepts = self._accepts[node.name] = node.accepts
        return accepts

    def run_until(self, goal: Callable[[], bool], most: int = 1_000_000) -> None:
        """Go on until ``goal`` holds; it must within ``most`` events."""
        for _ in range(most):
            if goal():
                return
            self.step()
        raise AssertionError(f"not reached in {most} events")

    def step(self) -> None:
        """Deliver one frame, or, when all are silent, do what is due next."""
        if self._queue:
            node, frame = self._queue.popleft()
            self.post(node.on_frame(frame, self.now_ns))
            return
        times = [due_ns for due_ns, _, _ in self._later]
        times += [d for node in self.nodes if (d := node.next_deadline_ns()) is not None]
        assert times, "nothing is left to happen"
        self.now_ns = max(self.now_ns, min(times))
        arrived = [entry for entry in self._later if entry[0] <= self.now_ns]
        if arrived:
            self._later = [entry for entry in self._later if entry[0] > self.now_ns]
            self._queue.extend((node, frame) for _, node, frame in arrived)
            return
        for node in self.nodes:
            deadline_ns = node.next_deadline_ns()
            if deadline_ns is not None and deadline_ns <= self.now_ns:
                self.post(node.on_time(self.now_ns))
                return


class Heard(NamedTuple):
    """A frame a node sent: the message's name, and its values."""

    name: str
    values: Any


class Reader:
    """Decodes what nodes send."""

    def __init__(self, wire: Wire) -> None:
        self._codecs = {codec.id: codec for codec in wire.codecs.values()}

    def read(self, frame: Frame) -> Heard:
        """A frame's name and values; one of ours that cannot be read is a failure."""
        codec = self._codecs[frame.id]
        values = codec.unpack(frame.data)
        assert values is not None
        return Heard(codec.name, values)

    def read_all(self, frames: Sequence[Frame]) -> list[Heard]:
        """All of them."""
        return [self.read(frame) for frame in frames]


class Bench:
    """Speaks to one node for everybody else.

    Attributes:
        node: the node under test.
        cycle: cycle under way, as SYNC counts.
        now_ns: time.
        row_set: set of rows sent last.
        heard: everything the node has sent.
    """

    def __init__(self, node: FieldNode, wire: Wire, parameters: dict[Parameter, float]) -> None:
        self.field_node = node
        self.wire = wire
        self.number = node.number
        self.parameters = dict(parameters)
        self.cycle = -1
        self.now_ns = 0
        self._sync_ns = 0  # when the last SYNC was due
        self.row_set = 0
        self.heard: list[Heard] = []
        self._reader = Reader(wire)
        self._senders: dict[tuple[type[NamedTuple], int | None], Sender[Any]] = {}
        self._take(node.on_time(0))

    # --- one frame --------------------------------------------------------------------------

    def sender(self, record: type[NamedTuple], node: int | None = None) -> Sender[Any]:
        """The sender of a message on behalf of whoever sends it."""
        key = (record, node)
        if key not in self._senders:
            self._senders[key] = self.wire.sender(record, node)
        return self._senders[key]

    def say(self, record: type[NamedTuple], node: int | None, *values: float) -> list[Heard]:
        """Send the node a message; what it answers."""
        return self.give(self.sender(record, node).frame(*values))

    def give(self, frame: Frame) -> list[Heard]:
        """Send the node a frame as it is; what it answers."""
        return self._take(self.field_node.on_frame(frame, self.now_ns))

    def _take(self, frames: Sequence[Frame]) -> list[Heard]:
        answers = self._reader.read_all(frames)
        self.heard += answers
        return answers

    def command(self, command: Command, argument: int = 0) -> list[Heard]:
        """NMT to everybody. START lets all counters begin anew, as the master does."""
        answers = self.say(Nmt, None, command, 0, argument)
        if command is Command.START:
            for sender in self._senders.values():
                sender.reset()
        return answers

    # --- time -------------------------------------------------------------------------------

    def sync(
        self,
        state: NodeState = NodeState.OPERATIONAL,
        row_set: int | None = None,
        *,
        dbc_hash: int | None = None,
        lost: bool = False,
    ) -> list[Heard]:
        """Begin the next cycle a period later; ``lost``: without the node hearing of it.

        SYNC names the set of rows sent last if no other is given.
        """
        self.cycle += 1
        self._sync_ns += PERIOD_NS
        self.now_ns = self._sync_ns
        digest = self.wire.dbc_hash if dbc_hash is None else dbc_hash
        named = self.row_set if row_set is None else row_set
        frame = self.sender(Sync, None).frame(self.cycle, state, named, digest)
        due = self.let_time_pass()
        return due if lost else due + self.give(frame)

    def let_time_pass(self) -> list[Heard]:
        """Call the node's timer as often as it is due by now."""
        answers: list[Heard] = []
        while (due := self.field_node.next_deadline_ns()) is not None and due <= self.now_ns:
            answers += self._take(self.field_node.on_time(self.now_ns))
        return answers

    def miss_syncs(self, count: int) -> list[Heard]:
        """Let time pass until ``count`` SYNCs have been missed in a row."""
        answers: list[Heard] = []
        for _ in range(count):
            due = self.field_node.next_deadline_ns()
            assert due is not None
            self.now_ns = due
            self.cycle += 1
            self._sync_ns += PERIOD_NS
            answers += self._take(self.field_node.on_time(due))
        return answers

    # --- bring-up ---------------------------------------------------------------------------

    def configure(self) -> None:
        """The whole dialogue."""
        for parameter, value in self.parameters.items():
            (answer,) = self.say(Config, self.number, parameter, 0, value, 0)
            assert answer.values[:2] == (parameter, ConfigStatus.TAKEN)
        (answer,) = self.commit()
        assert answer.values.status == ConfigStatus.TAKEN, answer

    def commit(self, *, total: int | None = None, digest: int | None = None) -> list[Heard]:
        """Close the dialogue."""
        rounded = {p: self.wire_value(v) for p, v in self.parameters.items()}
        return self.say(
            *(Config, self.number, Parameter.COMMIT),
            len(rounded) if total is None else total,
            0.0,
            configuration_hash(rounded) if digest is None else digest,
        )

    def wire_value(self, value: float) -> float:
        """A parameter as it arrives: float32."""
        frame = self.wire.sender(ConfigAck, 1).frame(0, 0, value, 0)
        return float(self._reader.read(frame).values.value)

    @property
    def state(self) -> NodeState:
        """The node's state."""
        return self.field_node.state

    def dacs(self, answers: Iterable[Heard] | None = None) -> list[Dac]:
        """DAC frames among answers, or of all time."""
        return self._of(f"DAC_{self.number}", answers)

    def emergencies(self, answers: Iterable[Heard] | None = None) -> list[Emcy]:
        """EMCY frames among answers, or of all time."""
        return self._of(f"EMCY_{self.number}", answers)

    def errors(self, answers: Iterable[Heard] | None = None) -> list[JointError]:
        """ERROR frames among answers, or of all time."""
        return self._of(f"ERROR_{self.number}", answers)

    def _of(self, name: str, answers: Iterable[Heard] | None) -> list[Any]:
        return [h.values for h in (self.heard if answers is None else answers) if h.name == name]


class JointBench(Bench):
    """A joint node, its arm at ``q``, its encoder powered up somewhere else than zero.

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
        self.node = JointNode(joint, wire, 0x100 + joint, PERIOD_NS)
        parameters = all_parameters(arm, "corke", PERIOD_NS * 1e-9)[joint]
        super().__init__(self.node, wire, {**parameters, **(changes or {})})
        self.arm = arm
        self.index = joint - 1
        self.q = list(arm.park)
        self.speed = 0.0
        self.bias: tuple[float, ...] | None = None

    # --- what the board says ------------------------------------------------------------------

    def counts(self, theta: float | None = None) -> int:
        """Encoder counts at an angle of the node's joint."""
        theta = self.q[self.index] if theta is None else theta
        return round(theta * self.parameters[Parameter.COUNTS_PER_UNIT]) - self.POWER_UP_COUNTS

    def angle(self, theta: float | None = None) -> float:
        """The angle the encoder resolves, rad."""
        per_rad = self.wire_value(self.parameters[Parameter.COUNTS_PER_UNIT])
        return (self.counts(theta) + self.POWER_UP_COUNTS) / per_rad

    def speed_code(self) -> int:
        """Velocity ADC code."""
        return round(self.speed / self.parameters[Parameter.RATE_PER_CODE])

    @property
    def read_speed(self) -> float:
        """The speed the ADC resolves, rad/s."""
        return self.speed_code() * self.wire_value(self.parameters[Parameter.RATE_PER_CODE])

    def measure(self, theta: float | None = None, cycle: int | None = None) -> list[Heard]:
        """MEASURE of the own joint."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        values = (self.counts(theta), 0, self.speed_code(), low, 0, 0)
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

    def setpoint(self, q: Sequence[float] | None = None, cycle: int | None = None) -> list[Heard]:
        """SETPOINT_1 of an arm held at joint angles ``q``; IDLE, so that the pose is all."""
        q = self.q if q is None else q
        pose, configuration = direct(self.arm, q), configuration_of(self.arm, q)
        setpoint = CartesianSetpoint(
            *(TrajectoryState.IDLE, Mode.JOINT, Blend.CONTINUOUS, 0.0, 0.0, 0.2),
            *(pose, configuration, None, configuration),
        )
        number = self.cycle if cycle is None else cycle
        return self.say(Setpoint, 1, *values_of(setpoint, pose, configuration, number))

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
    ) -> list[Heard]:
        """The node's own row of a set."""
        self.row_set = number
        own = [float(i == self.index) for i in range(6)] if compliance is None else compliance
        return self.say(Rows, self.number, *own, *weighted, gravity, number, law)

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


class Fleet:
    """All nine nodes on a pump.

    Attributes:
        pump: carries their frames.
        master, joints, gripper, plant: the nodes.
    """

    def __init__(self, wire: Wire, clock: Clock = Clock.VIRTUAL, **settings: Any) -> None:
        run = RunSettings(patience=settings.pop("patience", 3.0), **settings)
        how = replace(run.master(), clock=clock)
        watch_ns = how.cycle_limit_ns
        arm = run.the_arm
        self.wire = wire
        self.joints = [JointNode(joint, wire, joint, watch_ns) for joint in JOINTS]
        self.gripper = GripperNode(wire, GRIPPER, watch_ns)
        self.plant = PlantNode(PlantPhysics(arm, "corke", run.rate), wire, 9, watch_ns)
        self.master = Supervisor(arm, wire, 8, how)
        self.pump = Pump(*self.joints, self.gripper, self.plant, self.master)
        self.reader = Reader(wire)

    def reach(self, phase: Phase) -> "Fleet":
        """Run until the master has reached a phase."""
        self.pump.run_until(lambda: self.master.phase is phase)
        return self

    def enable(self) -> "Fleet":
        """From power-up to RUN, and through the first cycle."""
        self.reach(Phase.READY)
        self.master.start()
        self.reach(Phase.RUN)
        self.run(1)
        return self

    def run(self, cycles: int) -> None:
        """Close so many cycles more."""
        until = self.master.closed + cycles
        self.pump.run_until(lambda: self.master.closed >= until)

    def id(self, record: type[NamedTuple], node: int | None = None) -> int:
        """Identifier of a message."""
        return self.wire.id(record, node)

    def said(self, name: str, since: int = 0) -> list[Any]:
        """Values of every frame of a message, from ``since`` in ``pump.sent`` on."""
        identifier = self.wire.codecs[name].id
        frames = self.pump.sent[since:]
        return [self.reader.read(frame).values for frame in frames if frame.id == identifier]


class GripperBench(Bench):
    """The gripper node and its jaw's board."""

    def __init__(self, wire: Wire, arm: Arm = PUMA_260) -> None:
        self.node = GripperNode(wire, 0x107, PERIOD_NS)
        super().__init__(self.node, wire, all_parameters(arm, "corke", PERIOD_NS * 1e-9)[GRIPPER])
        self.arm = arm

    def measure(self, counts: int, cycle: int | None = None) -> list[Heard]:
        """MEASURE of the jaw."""
        low = (self.cycle if cycle is None else cycle) & 0xFF
        return self.say(Measure, GRIPPER, counts, 0, 0, low, 0, 0)
