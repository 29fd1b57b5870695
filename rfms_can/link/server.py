"""A server's sockets: requests in and replies out, the status to everybody, emergency stops in.

Nothing here waits for a peer: a reply to a peer that has gone is dropped, and a slow reader of
the status misses some of it. Messages longer than ``MAX_BYTES`` end the connection they came on
before they are read.
"""

import os
import select
from collections.abc import Iterator
from types import TracebackType
from typing import IO, Final, Self

import zmq

from rfms_can.errors import LinkError
from rfms_can.link.address import DEFAULT_NAME, TcpAddress, place_of, socket_paths
from rfms_can.link.keys import DOMAIN, ServerKeys, authenticate
from rfms_can.messages import MAX_BYTES

STATUS_QUEUED: Final = 4
"""Status messages kept for a reader that is slow."""
REQUESTS_QUEUED: Final = 256
"""Messages kept of and for one peer."""
SOCKET_MODE: Final = 0o600
AT_ONCE: Final = 64
"""Requests taken at a time, so that a peer that never stops keeps no cycle waiting."""


def check_binding(tcp: TcpAddress | None, keys: ServerKeys | None) -> None:
    """See that nobody reaches the arm over a network without a key.

    Raises:
        LinkError: the address is not this machine's, and there are no keys.
    """
    if tcp is not None and not tcp.loopback and keys is None:
        raise LinkError(
            f"{tcp.endpoints.requests} is not loopback: others would move the arm. Give --keys "
            f"(rfms keys makes them), or bind 127.0.0.1"
        )


class ServerSocket:
    """Listens on the Unix sockets of a name and, when asked, on TCP.

    Args:
        name: the server's.
        tcp: address to listen on besides, or None.
        keys: CURVE keys of the TCP connections; the Unix sockets are their owner's anyway.

    Raises:
        LinkError: the name or a port is taken, the directory is not ours alone, or the address
            is not this machine's and there are no keys.
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
        self._lock: IO[bytes] = place_of(name).claim()
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._authenticator = None if keys is None else authenticate(self._context, keys)
        self._requests = self._make(zmq.ROUTER, REQUESTS_QUEUED)
        self._epoll = select.epoll()
        self._look_again = True
        self._status = self._make(zmq.PUB, STATUS_QUEUED)
        self._emergency = self._make(zmq.PULL, REQUESTS_QUEUED)
        try:
            self._bind_paths()
            if tcp is not None:
                self._bind_tcp(tcp, keys)
        except BaseException:
            self.close()
            raise
        self._poller = zmq.Poller()
        self._poller.register(self._emergency, zmq.POLLIN)
        self._poller.register(self._requests, zmq.POLLIN)
        for socket in (self._emergency, self._requests):
            self._epoll.register(socket.fileno(), select.EPOLLIN)

    @property
    def _sockets(self) -> "tuple[zmq.Socket[bytes], ...]":
        return self._requests, self._status, self._emergency

    def _make(self, kind: int, queued: int) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        socket.linger = 0
        socket.set_hwm(queued)
        socket.setsockopt(zmq.MAXMSGSIZE, MAX_BYTES)
        return socket

    def _bind_paths(self) -> None:
        """Bind the Unix sockets; they are nobody else's from their first moment on."""
        before = os.umask(0o177)
        try:
            for socket, path in zip(self._sockets, self._paths, strict=True):
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
        """Bind the ports; options set now concern them and not the Unix sockets."""
        for socket, endpoint in zip(self._sockets, tcp.endpoints, strict=True):
            socket.setsockopt(zmq.IPV6, int(tcp.six))
            if keys is not None:
                socket.setsockopt(zmq.CURVE_SERVER, 1)
                socket.curve_publickey, socket.curve_secretkey = keys.public, keys.secret
                socket.setsockopt(zmq.ZAP_DOMAIN, DOMAIN)
            try:
                socket.bind(endpoint)
            except zmq.ZMQError as error:
                raise LinkError(f"{endpoint} cannot be bound: {error}; choose another") from error

    def pending(self) -> bool:
        """Whether somebody has sent something: quick enough to ask after every frame.

        ZeroMQ's descriptors tell that something is new, once: what may have been told while we
        sent, or is left from before, is looked at anyway.
        """
        if not self._look_again and not self._epoll.poll(0):
            return False
        self._look_again = False
        return bool(self._poller.poll(0))

    def wait(self, timeout_s: float) -> bool:
        """Wait until somebody has sent something; whether somebody has."""
        self._look_again = True
        return bool(self._poller.poll(max(0, round(timeout_s * 1e3))))

    def emergencies(self) -> Iterator[bytes]:
        """Emergency stops that have come, each in one piece."""
        for _ in range(AT_ONCE):
            try:
                parts = self._emergency.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            yield parts[0] if len(parts) == 1 else b""
        self._look_again = True

    def requests(self) -> Iterator[tuple[bytes, bytes]]:
        """Requests that have come: the peer, and the message; of several parts none is one."""
        for _ in range(AT_ONCE):
            try:
                peer, *parts = self._requests.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            yield peer, parts[0] if len(parts) == 1 else b""
        self._look_again = True

    def reply(self, peer: bytes, data: bytes) -> None:
        """Answer a peer; one that has gone or does not read gets nothing."""
        self._look_again = True
        try:
            self._requests.send_multipart((peer, data), zmq.NOBLOCK)
        except zmq.Again:
            return

    def broadcast(self, status: bytes) -> None:
        """Tell everybody who listens."""
        self._status.send(status, zmq.NOBLOCK)

    def close(self) -> None:
        """Disconnect everybody and free the name."""
        self._epoll.close()
        for socket in self._sockets:
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
