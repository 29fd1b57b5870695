"""A session with a server, without sockets: numbering of requests, decoding of replies."""

import secrets
from typing import Final, NamedTuple, TypeVar

import msgspec

from rfms_can.coordinator.refusals import error_of
from rfms_can.errors import LinkError
from rfms_can.messages import (
    Answer,
    AnyRequest,
    Envelope,
    LeaseRequest,
    Reply,
    SensorRequest,
    Status,
)

Heard = TypeVar("Heard", Reply, Status)

ANSWER_S: Final = 5.0
"""Timeout for a server's answer, s: longer than a lockstep barrier."""
RETRY_S: Final = 0.5
"""Time after which an unanswered request is sent again, s; it is processed once."""
RENEWALS: Final = 3
"""Renewals of a lease within its duration."""
UNREAD: Final = 0
"""Serial number of the reply to an undecodable request; requests count from 1."""
REALTIME: Final = "realtime"
ENABLED: Final = "RUN"
"""The phase in which the server's time passes."""
CLOCK_DRIFT: Final = 1e-3
"""Largest assumed drift of the server's clock against ours, s/s."""

_encode = msgspec.msgpack.Encoder().encode
_replies: Final = msgspec.msgpack.Decoder(Reply)
_statuses: Final = msgspec.msgpack.Decoder(Status)


class Request(NamedTuple):
    """A numbered request, encoded."""

    serial: int
    data: bytes


class Lease(NamedTuple):
    """The lease on the arm: requests to acquire, renew and release it.

    Attributes:
        name: of this coordinator, shown to others that are refused.
        duration_s: time without a renewal after which the server stops the arm, s.
    """

    name: str
    duration_s: float

    @property
    def acquire(self) -> LeaseRequest | SensorRequest:
        """Acquire the lease."""
        return LeaseRequest("acquire", self.name, self.duration_s)

    @property
    def renew(self) -> LeaseRequest | SensorRequest:
        """Renew it for its duration from now."""
        return LeaseRequest("renew", self.name, self.duration_s)

    @property
    def release(self) -> LeaseRequest | SensorRequest:
        """Release it."""
        return LeaseRequest("release", self.name)

    @property
    def renewal_s(self) -> float:
        """Time between two renewals, s."""
        return self.duration_s / RENEWALS


class Conversation:
    """Numbers requests, decodes replies, and keeps the newest state of the arm.

    Args:
        address: of the server, for errors.

    Attributes:
        lost: why the server was given up, or None.
    """

    def __init__(self, address: str) -> None:
        self.lost: LinkError | None = None
        self._address = address
        self._session = secrets.token_hex(16)
        self._serial = 0
        self._status: Status | None = None
        self._offset = 0.0
        self._heard = 0.0

    def ask(self, message: AnyRequest) -> Request:
        """``number`` for a message that is answered at once, unless the server has been given up.

        Raises:
            LinkError: it has: nothing is waited for any more.
        """
        if self.lost is not None:
            raise self.lost
        return self.number(message)

    def number(self, message: AnyRequest) -> Request:
        """Give a message the next serial number."""
        self._serial += 1
        return Request(self._serial, _encode(Envelope(self._session, self._serial, message)))

    def read(self, data: bytes, now: float) -> Reply:
        """Decode a reply.

        Args:
            data: as received.
            now: local time, s, monotonic.

        Raises:
            LinkError: it is not a valid reply.
            RfmsError: the server could not decode a request.
        """
        reply = self._decoded(_replies, data)
        self._note(reply.status, now)
        if reply.serial == UNREAD:
            answer_of(reply)
        return reply

    def hear(self, data: bytes, now: float) -> None:
        """Decode a broadcast status; arguments as with :meth:`read`.

        Raises:
            LinkError: it is not a valid status.
        """
        self._note(self._decoded(_statuses, data), now)

    @property
    def status(self) -> Status:
        """The newest known state of the arm.

        Raises:
            LinkError: no state has been received yet, or the server has been given up: what it told
                last is not the state any more.
        """
        if self.lost is not None:
            raise self.lost
        if self._status is None:
            raise self.silent()
        return self._status

    def time(self, now: float) -> float:
        """The server's time, s.

        In virtual time and lockstep it is that of the last status, because it stands still while
        the program runs. In real time it has advanced since: the offset is taken from the status
        with the least delay, so that a late one does not set it back.

        Args:
            now: local time, s, monotonic.
        """
        status = self.status
        return now - self._offset if status.clock == REALTIME else status.time

    def silent(self) -> LinkError:
        """The error for a server that does not answer; gives it up."""
        self.lost = LinkError(
            f"server {self._address!r} has not answered for {ANSWER_S:g} s: see whether it runs "
            f"(rfms serve), and the address and keys"
        )
        return self.lost

    def _note(self, status: Status, now: float) -> None:
        """Store a state unless it is older than the known one, and update the clock offset."""
        known = self._status
        if known is not None and status.issued < known.issued:
            return
        offset = now - status.time
        if known is not None and known.phase == status.phase == ENABLED:  # else its time stands
            offset = min(offset, self._offset + CLOCK_DRIFT * (now - self._heard))
        self._status, self._offset, self._heard = status, offset, now

    def _decoded(self, decoder: msgspec.msgpack.Decoder[Heard], data: bytes) -> Heard:
        try:
            return decoder.decode(data)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise LinkError(f"server {self._address!r} sent an invalid reply: {error}") from error


def answer_of(reply: Reply) -> Answer:
    """The answer of a reply.

    Raises:
        RfmsError: the request was refused, with the class of the server's error.
    """
    if reply.refusal is not None:
        raise error_of(reply.refusal)
    return reply.answer or Answer()
