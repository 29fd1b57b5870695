"""The client's sockets for asyncio: replies and status are awaited, the rest is unchanged."""

import asyncio
from types import TracebackType
from typing import Self, cast

import zmq
import zmq.asyncio

from rfms_can.link.client import ClientSocket, checked_length, full, milliseconds, take
from rfms_can.link.keys import ClientKeys


class AsyncClientSocket:
    """``ClientSocket`` whose replies and status are awaited; one object for one event loop.

    Args:
        address: a server's NAME, or ``tcp://ADDRESS:PORT``.
        keys: CURVE keys, for a server that requires them.

    Raises:
        LinkError: see ``ClientSocket``.
    """

    def __init__(self, address: str, keys: ClientKeys | None = None) -> None:
        self.address = address
        self._socket = ClientSocket(address, keys)
        self._requests = zmq.asyncio.Socket.from_socket(self._socket.requests)
        self._status = zmq.asyncio.Socket.from_socket(self._socket.status)

    def send(self, data: bytes) -> None:
        """Send a request; see ``ClientSocket.send``."""
        # by the asyncio socket: it polls again for replies that its own send made readable
        sent = self._requests.send(checked_length(data), zmq.NOBLOCK)
        error = cast("asyncio.Future[object]", sent).exception()  # done: it does not wait
        if isinstance(error, zmq.Again):
            raise full(self.address) from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """The next reply; None if none came in time."""
        ready = await self._requests.poll(milliseconds(timeout_s))
        return take(self._socket.requests) if ready else None

    async def newest_status(self, timeout_s: float) -> bytes | None:
        """The newest status that has not been read yet; None if none came in time."""
        ready = await self._status.poll(milliseconds(timeout_s))
        return take(self._socket.status) if ready else None

    def emergency(self, data: bytes) -> None:
        """Hand an emergency stop to the server; see ``ClientSocket.emergency``."""
        self._socket.emergency(data)

    def close(self) -> None:
        """Disconnect; replies that are under way are lost."""
        self._requests.close()
        self._status.close()
        self._socket.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
