"""A client's three sockets: requests and replies, the newest status, emergency stops. Bytes only.

A request stays in its queue until the server is reached: an absent server shows as a missing reply.
An emergency stop is delivered immediately or refused; it is never queued for a server that starts
later.
"""

from types import TracebackType
from typing import Final, Self

import zmq

from rfms_can.errors import LinkError
from rfms_can.link.address import Endpoints, endpoints_of, operator_endpoint
from rfms_can.link.keys import ClientKeys
from rfms_can.messages import MAX_BYTES

REQUESTS_QUEUED: Final = 64
"""Requests that may wait to be sent."""
MAX_REPLY_BYTES: Final = 1024 * 1024
"""Longest message taken from a server: the names of a large world model."""
HAND_OVER_MS: Final = 1000
"""Timeout for the delivery of an emergency stop, ms, and its linger time on closing."""


class ClientSocket:
    """Connects to a server; one object for one thread.

    Args:
        address: a server's NAME, or ``tcp://ADDRESS:PORT``.
        keys: CURVE keys, for a server that requires them.

    Raises:
        LinkError: no server of that name runs, or the address is invalid; over TCP an absent
            server is not detected here.
    """

    def __init__(self, address: str, keys: ClientKeys | None = None) -> None:
        self.address = address
        endpoints = endpoints_of(address, with_keys=keys is not None)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._context.linger = 0
        try:
            self._connect(endpoints, keys)
        except zmq.ZMQError as error:
            self._context.destroy(linger=0)
            raise LinkError(f"server {address!r} cannot be reached: {error}") from error

    def _connect(self, endpoints: Endpoints, keys: ClientKeys | None) -> None:
        requests = self._socket(zmq.DEALER, keys, endpoints)
        requests.sndhwm = REQUESTS_QUEUED
        status = self._socket(zmq.SUB, keys, endpoints)
        status.setsockopt(zmq.CONFLATE, 1)
        status.subscribe(b"")
        emergency = self._socket(zmq.PUSH, keys, endpoints)
        emergency.setsockopt(zmq.IMMEDIATE, 1)  # only to a connected peer
        emergency.sndtimeo = HAND_OVER_MS
        emergency.linger = HAND_OVER_MS
        requests.connect(endpoints.requests)
        status.connect(endpoints.status)
        emergency.connect(endpoints.emergency)
        self.requests, self.status, self._emergency = requests, status, emergency

    def _socket(
        self, kind: int, keys: ClientKeys | None, endpoints: Endpoints
    ) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        socket.setsockopt(zmq.MAXMSGSIZE, MAX_REPLY_BYTES)
        if endpoints.requests.startswith("tcp://["):
            socket.setsockopt(zmq.IPV6, 1)
        if keys is not None:
            socket.curve_publickey, socket.curve_secretkey = keys.public, keys.secret
            socket.curve_serverkey = keys.server
        return socket

    def send(self, data: bytes) -> None:
        """Send a request.

        Raises:
            LinkError: it is longer than the server accepts, or too many requests are queued.
        """
        try:
            self.requests.send(checked_length(data), zmq.NOBLOCK)
        except zmq.Again as error:
            raise full(self.address) from error

    def receive(self, timeout_s: float) -> bytes | None:
        """The next reply; None if none came in time."""
        return take(self.requests) if self.requests.poll(milliseconds(timeout_s)) else None

    def newest_status(self, timeout_s: float) -> bytes | None:
        """The newest status that has not been read yet; None if none came in time."""
        return take(self.status) if self.status.poll(milliseconds(timeout_s)) else None

    def emergency(self, data: bytes) -> None:
        """Hand an emergency stop to the server.

        Raises:
            LinkError: no server accepted it within ``HAND_OVER_MS``.
        """
        try:
            self._emergency.send(checked_length(data))
        except zmq.Again as error:
            raise LinkError(
                f"server {self.address!r} did not take the emergency stop within "
                f"{HAND_OVER_MS} ms: use the arm's own emergency stop"
            ) from error

    def close(self) -> None:
        """Disconnect; replies that are under way are lost."""
        for socket in (self.requests, self.status, self._emergency):
            socket.close()
        self._context.term()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def send_as_operator(name: str, data: bytes) -> None:
    """Hand a message to the server of this name, on this machine, as the person who runs it.

    Raises:
        LinkError: no server of that name runs here, or it did not take the message in time.
    """
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    socket = context.socket(zmq.PUSH)
    try:
        socket.linger = HAND_OVER_MS
        socket.setsockopt(zmq.IMMEDIATE, 1)
        socket.sndtimeo = HAND_OVER_MS
        socket.connect(operator_endpoint(name))
        socket.send(checked_length(data))
    except zmq.ZMQError as error:
        raise LinkError(f"server {name!r} did not take it: {error}; see whether it runs") from error
    finally:
        socket.close()
        context.term()


def checked_length(data: bytes) -> bytes:
    """The message, if a server accepts its length.

    Raises:
        LinkError: it is too long.
    """
    if len(data) > MAX_BYTES:
        raise LinkError(f"a message of {len(data)} bytes: a server takes {MAX_BYTES} at most")
    return data


def full(address: str) -> LinkError:
    """The error for a full request queue."""
    return LinkError(
        f"server {address!r} takes no requests: {REQUESTS_QUEUED} wait already; see whether it runs"
    )


def take(socket: "zmq.Socket[bytes]") -> bytes | None:
    """A received message, or None."""
    try:
        return socket.recv(zmq.NOBLOCK)
    except zmq.Again:
        return None


def milliseconds(timeout_s: float) -> int:
    """A timeout for ZeroMQ, in whole milliseconds, rounded up."""
    return max(0, -int(-timeout_s * 1e3 // 1))
