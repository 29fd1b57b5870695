"""The gripper of a program, for both variants of the program API."""

from rfms_can.coordinator import definitions
from rfms_can.coordinator.link import AsyncLink, Link
from rfms_can.messages import JawAtRest


class Gripper:
    """The gripper: both calls return when the jaw rests, at its stop or on a workpiece."""

    __slots__ = ("_link",)

    def __init__(self, link: Link) -> None:
        self._link = link

    def open(self, force: float = 1.0) -> None:
        """Open with a fraction (0 to 1) of the full force, and wait."""
        self._command(True, force)

    def close(self, force: float = 1.0) -> None:
        """Close with a fraction (0 to 1) of the full force, and wait."""
        self._command(False, force)

    def _command(self, opens: bool, force: float) -> None:
        self._link.request(definitions.gripper(opens, force))
        self._link.wait(JawAtRest())


class AsyncGripper:
    """``Gripper`` for coroutines."""

    __slots__ = ("_link",)

    def __init__(self, link: AsyncLink) -> None:
        self._link = link

    async def open(self, force: float = 1.0) -> None:
        """Open with a fraction (0 to 1) of the full force, and wait."""
        await self._command(True, force)

    async def close(self, force: float = 1.0) -> None:
        """Close with a fraction (0 to 1) of the full force, and wait."""
        await self._command(False, force)

    async def _command(self, opens: bool, force: float) -> None:
        await self._link.request(definitions.gripper(opens, force))
        await self._link.wait(JawAtRest())
