"""A server's sockets: requests in and replies out, status broadcasts, emergency stops in.

What a person does at the server's machine comes on a socket of its own, never over TCP.

Nothing here blocks on a peer: a reply to a disconnected peer is dropped, and a slow subscriber of
the status misses some of it. A message longer than ``MAX_BYTES`` closes its connection unread, and
a :class:`~rfms_can.link.connections.ConnectionGuard` cuts connections that are too many.
"""

import os
import select
from collections import deque
from collections.abc import Iterator
from types import TracebackType
from typing import IO, Final, Self

import zmq

from rfms_can.errors import LinkError
from rfms_can.link.address import (
    DEFAULT_NAME,
    OPERATOR,
    SOCKETS,
    TcpAddress,
    rendezvous_of,
    socket_paths,
)
from rfms_can.link.connections import ConnectionGuard
from rfms_can.link.keys import DOMAIN, ServerKeys, authenticate
from rfms_can.messages import MAX_BYTES

STATUS_QUEUED: Final = 4
"""Status messages queued for a slow subscriber."""
REQUESTS_QUEUED: Final = 256
"""Messages queued from and for one peer."""
HANDSHAKE_MS: Final = 5_000
"""Time a peer has to introduce itself, ms; one that connects and says nothing is cut."""
NOTICES_KEPT: Final = 64
SOCKET_MODE: Final = 0o600
AT_ONCE: Final = 64
"""Requests taken at a time, so that a flood from one peer does not delay a cycle."""


def check_binding(tcp: TcpAddress | None, keys: ServerKeys | None) -> None:
    """Refuse a network address without keys.

    Raises:
        LinkError: the address is reachable from other machines, and no keys are given.
    """
    if tcp is not None and not tcp.loopback and keys is None:
        raise LinkError(
            f"{tcp.endpoints.requests} is not loopback: others would move the arm. Give --keys "
            f"(rfms keys makes them), or bind 127.0.0.1"
        )


class ServerSocket:
    """Listens on the Unix sockets of a name and, on request, on TCP.

    Args:
        name: of the server.
        tcp: additional address to listen on, or None.
        keys: CURVE keys of the TCP connections; file permissions protect the Unix sockets.

    Attributes:
        name: as given.
        notices: lines about connections that were cut, for a person; the reader empties it.

    Raises:
        LinkError: the name or a port is taken, the directory is open to other users, or the
            address is reachable from other machines and no keys are given.
    """

    def __init__(
        self,
        name: str = DEFAULT_NAME,
        tcp: TcpAddress | None = None,
        keys: ServerKeys | None = None,
    ) -> None:
        check_binding(tcp, keys)
        self.name = name
        self._paths = socket_paths(name)
        self._lock: IO[bytes] = rendezvous_of(name).claim()
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._authenticator = None if keys is None else authenticate(self._context, keys)
        self._requests = self._make(zmq.ROUTER, REQUESTS_QUEUED)
        self._epoll = select.epoll()
        self._poll_again = True
        self._status = self._make(zmq.PUB, STATUS_QUEUED)
        self._emergency = self._make(zmq.PULL, REQUESTS_QUEUED)
        self._operator = self._make(zmq.PULL, REQUESTS_QUEUED)
        self.notices: deque[str] = deque(maxlen=NOTICES_KEPT)
        self._guard: ConnectionGuard | None = None
        try:
            self._guard = self._guarded(tcp)
            self._bind_paths()
            if tcp is not None:
                self._bind_tcp(tcp, keys)
        except BaseException:
            self.close()
            raise
        self._poller = zmq.Poller()
        for socket in (self._emergency, self._operator, self._requests):
            self._poller.register(socket, zmq.POLLIN)
            self._epoll.register(socket.fileno(), select.EPOLLIN)

    @property
    def _sockets(self) -> "tuple[zmq.Socket[bytes], ...]":
        return self._requests, self._status, self._emergency

    def _make(self, kind: int, queued: int) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        socket.linger = 0
        socket.set_hwm(queued)
        socket.setsockopt(zmq.MAXMSGSIZE, MAX_BYTES)
        socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE_MS)
        return socket

    def _guarded(self, tcp: TcpAddress | None) -> ConnectionGuard:
        """The guard of all sockets, which are not bound yet."""
        addresses: list[str | int] = [str(path) for path in self._paths]
        if tcp is not None:
            addresses += [tcp.port + place for place in range(len(SOCKETS))]
        names = (*SOCKETS, OPERATOR)
        sockets = dict(zip(names, (*self._sockets, self._operator), strict=True))
        return ConnectionGuard(sockets, addresses, self.notices)

    def _bind_paths(self) -> None:
        """Bind the Unix sockets, with the owner's permissions from the start."""
        before = os.umask(0o177)
        try:
            for socket, path in zip((*self._sockets, self._operator), self._paths, strict=True):
                path.unlink(missing_ok=True)
                socket.bind(f"ipc://{path}")
        except (OSError, zmq.ZMQError) as error:
            raise LinkError(f"server {self.name!r}: cannot bind {path}: {error}") from error
        finally:
            os.umask(before)
        for path in self._paths:
            mode = path.stat().st_mode & 0o777
            if mode != SOCKET_MODE:
                raise LinkError(f"{path} has mode {mode:o} instead of {SOCKET_MODE:o}: not served")

    def _bind_tcp(self, tcp: TcpAddress, keys: ServerKeys | None) -> None:
        """Bind the ports; options set here do not apply to the Unix sockets, which are bound."""
        for socket, endpoint in zip(self._sockets, tcp.endpoints, strict=True):
            socket.setsockopt(zmq.IPV6, int(tcp.ipv6))
            if keys is not None:
                socket.setsockopt(zmq.CURVE_SERVER, 1)
                socket.curve_publickey, socket.curve_secretkey = keys.public, keys.secret
                socket.setsockopt(zmq.ZAP_DOMAIN, DOMAIN)
            try:
                socket.bind(endpoint)
            except zmq.ZMQError as error:
                raise LinkError(f"{endpoint} cannot be bound: {error}; choose another") from error

    def pending(self) -> bool:
        """Whether a message has arrived; fast enough to be called after every frame.

        ZeroMQ's descriptors are edge-triggered: an event may be consumed while this end sends, or
        messages may be left from before, so ``_poll_again`` forces a poll.
        """
        if not self._poll_again and not self._epoll.poll(0):
            return False
        self._poll_again = False
        return bool(self._poller.poll(0))

    def wait(self, timeout_s: float) -> bool:
        """Wait until a message has arrived; False on a timeout."""
        self._poll_again = True
        return bool(self._poller.poll(max(0, round(timeout_s * 1e3))))

    def emergencies(self) -> Iterator[bytes]:
        """Received emergency stops; a message of several parts gives an empty one."""
        return self._pulled(self._emergency)

    def operators(self) -> Iterator[bytes]:
        """Received messages of a person at this machine, as :meth:`emergencies`."""
        return self._pulled(self._operator)

    def _pulled(self, socket: "zmq.Socket[bytes]") -> Iterator[bytes]:
        for _ in range(AT_ONCE):
            try:
                parts = socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            yield parts[0] if len(parts) == 1 else b""
        self._poll_again = True

    def requests(self) -> Iterator[tuple[bytes, bytes]]:
        """Received requests as (peer, message); a message of several parts gives an empty one."""
        for _ in range(AT_ONCE):
            try:
                peer, *parts = self._requests.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            yield peer, parts[0] if len(parts) == 1 else b""
        self._poll_again = True

    def reply(self, peer: bytes, data: bytes) -> None:
        """Reply to a peer; dropped if the peer has gone or does not read."""
        self._poll_again = True
        try:
            self._requests.send_multipart((peer, data), zmq.NOBLOCK)
        except zmq.Again:
            return

    def broadcast(self, status: bytes) -> None:
        """Publish the status to all subscribers."""
        self._status.send(status, zmq.NOBLOCK)

    def close(self) -> None:
        """Disconnect all peers and release the name."""
        self._epoll.close()
        if self._guard is not None:
            self._guard.close()
            self._guard = None
        for socket in (*self._sockets, self._operator):
            socket.close()
        if self._authenticator is not None:
            self._authenticator.stop()
        self._context.term()
        for path in self._paths:
            path.unlink(missing_ok=True)
        self._lock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
