"""Frames to the node and from it: each of its frames is held to the contract as it comes."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple, NoReturn

from rfms_can.conform.lines import Line
from rfms_can.conform.outcome import CheckFailed, NodeSilent
from rfms_can.conform.protection import fits, sealed
from rfms_can.wire.codec import MessageCodec
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import BOARDS
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Reference,
)
from rfms_can.wire.vocabulary import Command

PATIENCE_NS: Final = 1_000_000_000
"""How long the node may take to answer, real time, ns."""
LISTEN_NS: Final = 100_000_000
"""How long nothing comes before the node counts as quiet, ns."""
FENCE: Final = 63
"""A reserved parameter: the node answers that it does not know it, in any state."""
LARGEST_FENCE: Final = 1 << 20
SENT_KEPT: Final = 6
"""Frames that a failure tells of."""

_SPOKEN: Final[dict[type[NamedTuple], str]] = {
    Emcy: "EMCY",
    JointError: "ERROR",
    Dac: "DAC",
    ConfigAck: "CONFIG_ACK",
    Heartbeat: "HEARTBEAT",
}
"""What a joint sends, and how checks call it."""
Key = tuple[type[NamedTuple], int | None]


class Heard(NamedTuple):
    """A frame of the node.

    Attributes:
        name: without the number of the node, e.g. ``DAC``.
        values: its record.
        counter: of its header.
    """

    name: str
    values: Any
    counter: int


class Answers(list[Heard]):
    """What the node sent since the last look, in order."""

    @property
    def names(self) -> list[str]:
        """Names of the frames, in order."""
        return [heard.name for heard in self]

    def of(self, name: str) -> list[Any]:
        """Records of the frames of one name."""
        return [heard.values for heard in self if heard.name == name]

    def __add__(self, more: list[Heard]) -> "Answers":  # type: ignore[override]
        return Answers([*self, *more])

    def __str__(self) -> str:
        return ", ".join(f"{h.name}{_words(h.values)}" for h in self) or "nothing"


def _words(values: NamedTuple) -> str:
    told = (f"{k}={v:.7g}" for k, v in values._asdict().items() if k not in ("boot_id", "reserved"))
    return f"({', '.join(told)})"


class Talk:
    """Speaks to one node for all others, and reads what it says.

    Args:
        line: the way to it.
        joint: its number.
        wire: the contract.

    Attributes:
        sent_frames, heard_frames: counts.
        last_beat: the HEARTBEAT heard last; None before the first.
        last_dac: the DAC heard last; None before the first.
        sent_ns: when the last frame was sent that was not a question of ``settle``.
        heard_ns: when a frame of each name was heard last.
    """

    def __init__(self, line: Line, joint: int, wire: Wire) -> None:
        self.line, self.joint, self.wire = line, joint, wire
        self.sent_frames = self.heard_frames = 0
        self.last_beat: Heartbeat | None = None
        self._sent: deque[Frame] = deque(maxlen=SENT_KEPT)
        self._counters: dict[Key, int] = {}
        self._codecs: dict[Key, MessageCodec[Any]] = {}
        self._inbound = {wire.id(r, joint): (n, wire.codec(r, joint)) for r, n in _SPOKEN.items()}
        self._expected: dict[int, int] = {}
        board = BOARDS[joint]
        others = [(Measure, joint), (Reference, joint), (Emcy, board), (Heartbeat, board)]
        self._of_the_board = {wire.id(record, node) for record, node in others}
        self._came = Answers()
        self._fences = 0
        self.last_dac: Dac | None = None
        self.sent_ns = 0
        self.heard_ns: dict[str, int] = {}

    # --- to the node --------------------------------------------------------------------------

    def codec(self, record: type[NamedTuple], node: int | None = None) -> MessageCodec[Any]:
        """The message of a record."""
        key = (record, node)
        if key not in self._codecs:
            self._codecs[key] = self.wire.codec(record, node)
        return self._codecs[key]

    def body(self, record: type[NamedTuple], node: int | None, *values: float) -> bytearray:
        """Payload of a message, its header left open."""
        codec = self.codec(record, node)
        body = bytearray(codec.length)
        codec.pack_into(body, *values)
        return body

    def counter(self, record: type[NamedTuple], node: int | None = None) -> int:
        """The counter that the next frame of a message has."""
        return self._counters.get((record, node), 0)

    def skip_counter(self, record: type[NamedTuple], node: int | None, steps: int) -> None:
        """Move the counter of a message on, or back."""
        self._counters[record, node] = self.counter(record, node) + steps & 0xFF

    def seal(self, record: type[NamedTuple], node: int | None, body: bytes | bytearray) -> Frame:
        """The next frame of a message, its counter taken, around a payload."""
        codec = self.codec(record, node)
        if codec.data_id is None:
            return Frame(codec.id, bytes(body))
        counter = self.counter(record, node)
        self._counters[record, node] = counter + 1 & 0xFF
        return sealed(codec.id, body, counter, codec.data_id)

    def frame(self, record: type[NamedTuple], node: int | None, *values: float) -> Frame:
        """The next frame of a message."""
        return self.seal(record, node, self.body(record, node, *values))

    def say(self, record: type[NamedTuple], node: int | None, *values: float) -> Answers:
        """Send a message; what the node answers."""
        return self.give(self.frame(record, node, *values))

    def give(self, *frames: Frame) -> Answers:
        """Send frames as they are; what the node answers."""
        self.send(*frames)
        return self.settle()

    def send(self, *frames: Frame) -> None:
        """Send frames without a look at the answers."""
        for frame in frames:
            self._sent.append(frame)
            self.line.send(frame)
        self.sent_ns = self.line.now_ns
        self.sent_frames += len(frames)

    def command(self, command: Command, node: int = 0, argument: int = 0) -> Answers:
        """NMT."""
        return self.say(Nmt, None, command, node, argument)

    def estop(self) -> Answers:
        """The emergency stop."""
        return self.say(Estop, None, 0x504F5453, 0xAFB0ABAC)

    def restart_counters(self) -> None:
        """Both sides count from 0, as after START."""
        self._counters.clear()
        self._expected = dict.fromkeys(self._inbound, 0)

    # --- from the node ------------------------------------------------------------------------

    def settle(self) -> Answers:
        """What the node has answered to all that was sent."""
        if self.line.virtual:
            self._read_all(0)
        else:
            self._fence()
        return self.came()

    def _fence(self) -> None:
        """Ask what no node knows, by a number: what came before answers what was sent before."""
        self._fences = self._fences % LARGEST_FENCE + 1
        number = float(self._fences)
        self.line.send(self.frame(Config, self.joint, FENCE, 0, number, 0))
        self.sent_frames += 1
        self._await(lambda h: h.name == "CONFIG_ACK" and h.values[0:3:2] == (FENCE, number))
        if self.line.settle_ns:
            self._read_all(self.line.now_ns + self.line.settle_ns)

    def beat(self) -> Heartbeat:
        """The node's HEARTBEAT now, as it answers ANNOUNCE; what else comes is kept."""
        self.line.send(self.frame(Nmt, None, Command.ANNOUNCE, self.joint, 0))
        self.sent_frames += 1
        beat: Heartbeat = self._await(lambda h: h.name == "HEARTBEAT")
        return beat

    def _await(self, wanted: Callable[[Heard], bool]) -> Any:
        """The record of the first frame that is wanted, taken out of what came."""
        until_ns = self.line.now_ns + PATIENCE_NS
        while (frame := self.line.receive(until_ns)) is not None:
            self._read(frame)
            if self._came and wanted(self._came[-1]):
                return self._came.pop().values
        asked = "NMT ANNOUNCE, or CONFIG of a reserved parameter"
        raise NodeSilent(f"{self.told()}; {asked}", str(self._came), "an answer")

    def came(self) -> Answers:
        """What has come so far, without a look whether there is more."""
        answers, self._came = self._came, Answers()
        return answers

    def elapse(self, seconds: float) -> Answers:
        """Let time pass; what the node sends meanwhile."""
        self.line.pass_until(self.line.now_ns + round(seconds * 1e9))
        return self.settle()

    def listen(self) -> Answers:
        """What the node sends unasked; on a port, until it has been quiet."""
        self._read_all(0 if self.line.virtual else self.line.now_ns + LISTEN_NS)
        return self.came()

    def power_on(self) -> Answers | None:
        """Switch the node off and on, where that can be done; what it says."""
        self._expected.clear()
        if not self.line.power_on():
            return None
        self._expected = dict.fromkeys(self._inbound, 0)
        self.last_beat = None
        self._read_all(0)
        return self.came()

    def forget(self) -> None:
        """Drop what came, whatever it was, and take the next frames whatever their counters."""
        self._expected.clear()
        while self.line.receive(0 if self.line.virtual else self.line.now_ns) is not None:
            pass
        self._came = Answers()

    def _read_all(self, until_ns: int) -> None:
        while (frame := self.line.receive(until_ns)) is not None:
            self._read(frame)

    def _read(self, frame: Frame) -> None:
        """Check a frame of the node, whatever it answers: who, length, CRC, counter, ranges."""
        if frame.id in self._of_the_board:
            return
        self.heard_frames += 1
        known = self._inbound.get(frame.id)
        if known is None:
            self.fail(f"frame {frame.id:#05x}", f"frames that joint {self.joint} sends, no others")
        name, codec = known
        data = frame.data
        assert codec.data_id is not None
        if not frame.fd or len(data) != codec.length:
            kind = "CAN FD" if frame.fd else "classic"
            self.fail(f"{codec.name}: {kind}, {len(data)} bytes", f"CAN FD, {codec.length} bytes")
        if not fits(data, codec.data_id):
            self.fail(f"{codec.name} {data.hex()}", "a CRC that fits data and data ID")
        expected = self._expected.get(frame.id)
        if expected is not None and data[2] != expected:
            self.fail(f"{codec.name} with counter {data[2]}", f"counter {expected}")
        self._expected[frame.id] = data[2] + 1 & 0xFF
        values: Any = codec.unpack(data)
        if values is None:
            self.fail(f"{codec.name} {data.hex()}", "values in the ranges of the DBC")
        self.heard_ns[name] = self.line.now_ns
        if name == "HEARTBEAT":
            self._note_beat(values)
        elif name == "DAC":
            self.last_dac = values
        self._came.append(Heard(name, values, data[2]))

    def _note_beat(self, beat: Heartbeat) -> None:
        """What each HEARTBEAT must say, whenever it comes."""
        before, self.last_beat = self.last_beat, beat
        if beat.dbc_hash != self.wire.dbc_hash:
            self.fail(f"HEARTBEAT with DBC hash {beat.dbc_hash:#06x}", f"{self.wire.dbc_hash:#06x}")
        if before is not None and beat.boot_id != before.boot_id:
            self.fail("another boot id: the node has started again", "a node that goes on")
        if bool(beat.error_register) != bool(beat.error_register & 1):
            self.fail(f"error register {beat.error_register:#x}", "bit 0 set where any other is")
        if before is not None and beat.discarded < before.discarded:
            self.fail(f"discarded {before.discarded}, then {beat.discarded}", "a count since start")

    # --- what is required ---------------------------------------------------------------------

    def told(self) -> str:
        """The last frames that were sent, in words."""
        return "; ".join(self._in_words(frame) for frame in self._sent) or "nothing"

    def _in_words(self, frame: Frame) -> str:
        codec = next((c for c in self.wire.codecs.values() if c.id == frame.id), None)
        values = None
        if codec is not None and len(frame.data) == codec.length:
            values = codec.unpack(frame.data)
        if codec is None or values is None:
            return f"{frame.id:#05x}#{frame.data.hex()}"
        return f"{codec.name}{_words(values)}"

    def fail(self, got: str, want: str) -> NoReturn:
        """End the check."""
        raise CheckFailed(self.told(), got, want)

    def equal(self, got: object, want: object, what: str) -> None:
        """A value must be the one required."""
        if got != want:
            self.fail(f"{what} {got}", f"{what} {want}")

    def near(self, got: float, want: float, tolerance: float, what: str) -> None:
        """A number must be within a tolerance of the one required."""
        if not abs(got - want) <= tolerance:
            self.fail(f"{what} {got:.9g}", f"{what} {want:.9g} within {tolerance:g}")

    def only(self, answers: Answers, names: Sequence[str], why: str = "") -> Answers:
        """Exactly these frames must have come, in this order."""
        if answers.names != list(names):
            wanted = f"{', '.join(names) or 'nothing'}{why and f' ({why})'}"
            self.fail(str(answers), wanted)
        return answers

    def one(self, answers: Answers, name: str, why: str = "") -> Any:
        """One frame of a name, and no other; its record."""
        return self.only(answers, (name,), why)[0].values
