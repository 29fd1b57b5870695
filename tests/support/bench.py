"""Everything around one node: a bench speaks for master, plant and the other nodes.

``Bench`` is for any node, ``FieldNodeBench`` for one that is configured and has a ladder; what a
joint needs besides is ``joint_bench``. A node is called, never waited for.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

from rfms_can.joint_nodes.field_node import FieldNode
from rfms_can.node.protocol import Node
from rfms_can.wire.configuration import configuration_hash
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Dac,
    Emcy,
    JointError,
    Nmt,
    Sync,
)
from rfms_can.wire.vocabulary import (
    Command,
    ConfigStatus,
    NodeState,
    Parameter,
)

PERIOD_NS = 4_000_000

AnyNode = TypeVar("AnyNode", bound=Node)
AnyFieldNode = TypeVar("AnyFieldNode", bound=FieldNode)


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


class Bench(Generic[AnyNode]):
    """Speaks to one node for all others.

    Attributes:
        node: the node under test.
        cycle: cycle under way, as SYNC counts.
        now_ns: time.
        row_set: set of rows sent last.
        heard: everything the node has sent.
    """

    def __init__(self, node: AnyNode, wire: Wire) -> None:
        self.node = node
        self.wire = wire
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
        """The sender of a message, in place of the node that sends it."""
        key = (record, node)
        if key not in self._senders:
            self._senders[key] = self.wire.sender(record, node)
        return self._senders[key]

    def say(self, record: type[NamedTuple], node: int | None, *values: float) -> list[Heard]:
        """Send the node a message; what it answers."""
        return self.give(self.sender(record, node).frame(*values))

    def give(self, frame: Frame) -> list[Heard]:
        """Send the node a frame as it is; what it answers."""
        return self._take(self.node.on_frame(frame, self.now_ns))

    def _take(self, frames: Sequence[Frame]) -> list[Heard]:
        answers = self._reader.read_all(frames)
        self.heard += answers
        return answers

    def command(self, command: Command, argument: int = 0) -> list[Heard]:
        """NMT to all nodes. START resets all counters, as the master does."""
        answers = self.say(Nmt, None, command, 0, argument)
        if command is Command.START:
            self.reset_counters()
        return answers

    def reset_counters(self) -> None:
        """All senders begin at counter 0 again."""
        for sender in self._senders.values():
            sender.reset()

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
        while (due := self.node.next_deadline_ns()) is not None and due <= self.now_ns:
            answers += self._take(self.node.on_time(self.now_ns))
        return answers

    def miss_syncs(self, count: int) -> list[Heard]:
        """Let time pass until ``count`` SYNCs have been missed in a row."""
        answers: list[Heard] = []
        for _ in range(count):
            due = self.node.next_deadline_ns()
            assert due is not None
            self.now_ns = due
            self.cycle += 1
            self._sync_ns += PERIOD_NS
            answers += self._take(self.node.on_time(due))
        return answers


class FieldNodeBench(Bench[AnyFieldNode]):
    """Speaks to a joint or gripper node.

    Attributes:
        number: of the node.
        parameters: what CONFIG tells it.
    """

    def __init__(self, node: AnyFieldNode, wire: Wire, parameters: dict[Parameter, float]) -> None:
        self.number = node.number
        self.parameters = dict(parameters)
        super().__init__(node, wire)

    def command(self, command: Command, argument: int = 0) -> list[Heard]:
        """NMT to all nodes. A START that is taken resets all counters, as the master does."""
        before = self.node.state
        answers = self.say(Nmt, None, command, 0, argument)
        if self.node.state is NodeState.OPERATIONAL is not before:
            self.reset_counters()
        return answers

    # --- bring-up ---------------------------------------------------------------------------

    def configure(self) -> None:
        """The whole dialogue; everything is taken."""
        for answer in self.dialogue():
            assert answer.values.status == ConfigStatus.TAKEN, answer

    def dialogue(self) -> list[Heard]:
        """The answers of the whole dialogue, the one to COMMIT last."""
        answers: list[Heard] = []
        for parameter, value in self.parameters.items():
            answers += self.say(Config, self.number, parameter, 0, value, 0)
        return answers + self.commit()

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

    # --- what it has sent -------------------------------------------------------------------

    @property
    def state(self) -> NodeState:
        """The node's state."""
        return self.node.state

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
