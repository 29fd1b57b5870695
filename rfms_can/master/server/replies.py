"""Replies: an answer or a refusal with its reason, and the arm's state; counted and sent later."""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

import msgspec

from rfms_can.errors import RfmsError
from rfms_can.master.node import MasterNode
from rfms_can.master.report import status_of
from rfms_can.master.server.lease import Lease
from rfms_can.messages import Answer, Refusal, Reply, Status

Result = Answer | RfmsError
"""What became of a request."""
LONGEST_REASON: Final = 500
"""Characters of a reason: what a peer sent may be quoted in it."""
_encode: Final = msgspec.msgpack.Encoder().encode


class Outgoing(NamedTuple):
    """A reply to send, and its receiver."""

    peer: bytes
    data: bytes


class Replies:
    """Makes replies and keeps them until the owner of the sockets takes them.

    Attributes:
        refused: messages refused so far.
        sensors: says the state of each sensor.
    """

    def __init__(self, master: MasterNode, lease: Lease) -> None:
        self.refused = 0
        self._issued = 0
        self.sensors: Callable[[], Mapping[str, str]] = dict
        self._master = master
        self._lease = lease
        self._out: list[Outgoing] = []

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""
        self._issued += 1
        sensors = self.sensors()
        return status_of(self._master, self._lease.name, self.refused, self._issued, sensors)

    def make(self, peer: bytes, serial: int, result: Result) -> bytes:
        """Reply to a request; a refusal is counted. The bytes, for who asks again."""
        refusal = answer = None
        if isinstance(result, RfmsError):
            self.refused += 1
            remedy = dict(getattr(result, "remedy", {}))
            refusal = Refusal(type(result).__name__, one_line(str(result)), remedy)
        else:
            answer = result
        data = _encode(Reply(serial, self.status(), answer, refusal))
        self.repeat(peer, data)
        return data

    def repeat(self, peer: bytes, data: bytes) -> None:
        """Send a reply that was made before."""
        self._out.append(Outgoing(peer, data))

    def take(self) -> list[Outgoing]:
        """The replies to send now."""
        out, self._out = self._out, []
        return out


def one_line(text: str) -> str:
    """A text that others may have a hand in, fit for one line of a log or a terminal."""
    shown = (c if c.isprintable() else f"\\u{ord(c):04x}" for c in text[:LONGEST_REASON])
    return "".join(shown)
