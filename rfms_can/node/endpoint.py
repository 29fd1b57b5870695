"""Base of all nodes: typed senders and receivers, dispatched by identifier.

Invalid frames are refused and counted before a handler is called; frames to send are collected and
returned to the driver. No I/O, no clock.
"""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

from rfms_can.node.protocol import NOTHING
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import DBC_NAMES, NODE_NAMES, PLANT
from rfms_can.wire.protection import HeartbeatReceiver, Receiver, Refusal, Sender
from rfms_can.wire.records import Heartbeat

_MAX_U16: Final = 0xFFFF


class Endpoint(ABC):
    """Base of all nodes: the frame half of the node protocol; timing is left to each node.

    Args:
        number: node number (``wire.NODE_NAMES``).
        wire: compiled codecs.
        boot_id: different at every start; an argument, because nodes draw no random numbers.

    Attributes:
        name: the node's name.
        refused: frames refused, by reason.
        ignored: valid frames without an effect (stale, wrong state), by reason.
        foreign: received frames that are not in the contract.
    """

    def __init__(self, number: int, wire: Wire, boot_id: int) -> None:
        self.number = number
        self.name = NODE_NAMES[number]
        self.wire = wire
        self.boot_id = boot_id
        self.refused: Counter[Refusal] = Counter()
        self.ignored: Counter[str] = Counter()
        self.foreign = 0
        self._out: list[Frame] = []
        self._now_ns = 0
        self._handlers: dict[int, tuple[Callable[[Frame], Any], Callable[[Any], None]]] = {}
        self._receivers: list[Receiver[Any]] = []
        self._boots: dict[int, int] = {}
        self._senders: list[Sender[Any]] = []
        self._heartbeat = self._sends(Heartbeat, number)

    @abstractmethod
    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Handle the deadlines that have passed."""

    @abstractmethod
    def next_deadline_ns(self) -> int | None:
        """When ``on_time`` is to be called next."""

    @property
    def accepts(self) -> frozenset[int]:
        """Identifiers this node receives."""
        return frozenset(self._handlers)

    @property
    def discarded(self) -> int:
        """Frames refused since start."""
        return sum(self.refused.values())

    def bad_frames(self, node: int) -> Counter[Refusal]:
        """Frames refused since start that came under the identifiers of a node, by reason.

        Samples may be sent by several nodes: they count as those of the plant.
        """
        name = DBC_NAMES[node]
        bad: Counter[Refusal] = Counter()
        for receiver in self._receivers:
            senders = receiver.decoder.codec.senders
            if receiver.bad and name in senders and (len(senders) == 1 or node == PLANT):
                bad.update(receiver.bad)
        return bad

    @property
    def lost(self) -> int:
        """Frames missed since start, by gaps of their counters."""
        return sum(receiver.lost for receiver in self._receivers)

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        """Receive a frame: refuse and count it, or pass its values to its handler."""
        handler = self._handlers.get(frame.id)
        if handler is None:
            self.foreign += 1
            return NOTHING
        self._now_ns = now_ns
        take, act = handler
        values = take(frame)
        if values is not None:
            act(values)
        else:
            self._on_refused(frame)
        if not self._out:
            return NOTHING
        frames, self._out = self._out, []
        return frames

    def _on_refused(self, frame: Frame) -> None:
        """A frame has been refused, and counted; nothing more comes of it."""
        return

    def _hears(
        self,
        record: type[NamedTuple],
        node: int | None,
        act: Callable[[Any], None],
    ) -> None:
        """Register ``act`` as the handler of every valid frame of a message."""
        receiver = self.wire.receiver(record, node, self.refused)
        self._receivers.append(receiver)
        self._handlers[self.wire.id(record, node)] = (receiver.take, act)

    def _sends(self, record: type[NamedTuple], node: int | None = None) -> Sender[Any]:
        """Register a sender of a message of this node."""
        sender: Sender[Any] = self.wire.sender(record, node)
        self._senders.append(sender)
        return sender

    def _flush(self) -> Sequence[Frame]:
        """The frames collected to send."""
        if not self._out:
            return NOTHING
        frames, self._out = self._out, []
        return frames

    def _forget_counters(self) -> None:
        """Take the next frame of every message whatever its counter, after START or RESET."""
        for receiver in self._receivers:
            receiver.reset()

    def _note_boot(self, node: int, boot_id: int) -> None:
        """Take the next frame of each message of a node that has started again.

        Args:
            node: number of the sender of a HEARTBEAT.
            boot_id: what the HEARTBEAT says.
        """
        before = self._boots.get(node)
        self._boots[node] = boot_id
        if before == boot_id:
            return
        name = DBC_NAMES[node]
        for receiver in self._receivers:
            if name in receiver.decoder.codec.senders and not isinstance(
                receiver, HeartbeatReceiver
            ):
                receiver.reset()

    def _restart_counters(self) -> None:
        """All counters of sent and heard frames begin at 0, as when the arm is enabled."""
        self._forget_counters()
        for sender in self._senders:
            sender.reset()

    def _beat(self, state: int, register: int = 0, config_hash: int = 0) -> None:
        """Send a heartbeat."""
        self._out.append(
            self._heartbeat.frame(
                state,
                0,
                register,
                self.boot_id,
                self.wire.dbc_hash,
                config_hash,
                min(self.discarded, _MAX_U16),
                0,
            )
        )
