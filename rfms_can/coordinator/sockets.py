"""Interface of the client's sockets: bytes out, bytes in, with timeouts."""

from typing import Protocol


class Socket(Protocol):
    """A client's sockets; see :class:`rfms_can.link.client.ClientSocket`."""

    address: str

    def send(self, data: bytes) -> None:
        """Send a request."""

    def receive(self, timeout_s: float) -> bytes | None:
        """The next reply; None if none came in time."""

    def newest_status(self, timeout_s: float) -> bytes | None:
        """The newest status that has not been read yet; None if none came in time."""

    def close(self) -> None:
        """Disconnect."""


class AsyncSocket(Protocol):
    """``Socket`` for coroutines; see :class:`rfms_can.link.aio.AsyncClientSocket`."""

    address: str

    def send(self, data: bytes) -> None:
        """Send a request."""

    async def receive(self, timeout_s: float) -> bytes | None:
        """The next reply; None if none came in time."""

    async def newest_status(self, timeout_s: float) -> bytes | None:
        """The newest status that has not been read yet; None if none came in time."""

    def close(self) -> None:
        """Disconnect."""
