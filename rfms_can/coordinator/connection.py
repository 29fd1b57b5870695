"""Connecting to a server: ``with connect("rfms") as arm:``, its twin, and the emergency stop."""

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Final

import msgspec

from rfms_can.coordinator.aio import AsyncArm
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.arm import Arm
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.coordinator.stopping import wait_for, wait_for_rest
from rfms_can.errors import RfmsError
from rfms_can.link.address import DEFAULT_NAME
from rfms_can.link.aio import AsyncClientSocket
from rfms_can.link.client import ClientSocket
from rfms_can.link.keys import ClientKeys
from rfms_can.messages import EmergencyStop, Status

LEASE_S: Final = 1.0


@contextmanager
def connect(
    server: str = DEFAULT_NAME,
    *,
    name: str = "coordinator",
    keys: ClientKeys | None = None,
    lease_s: float = LEASE_S,
    interrupted: Callable[[], bool] = lambda: False,
    watch: Callable[[Status], None] = lambda _: None,
) -> Iterator[Arm]:
    """Take control of a server's arm; at the end give it back at rest.

    At the end of the block the moves that are queued are waited for; after an exception the arm
    is brought to rest on its path first, and the exception goes on. The arm is one thread's: while
    it waits, another thread that asks something waits too; ``connect_async`` is for that.

    Args:
        server: its NAME, or ``tcp://ADDRESS:PORT``.
        name: who asks for the arm, for those who are refused.
        keys: CURVE keys, for a server that asks for them.
        lease_s: how long the server waits for a sign of life before it stops the arm, 0.1 to 10 s.
        interrupted: whether somebody wants the program to end; asked while it waits.
        watch: is shown the arm's state now and then while the program waits.

    Raises:
        LinkError: no server is there, or it does not answer.
        LeaseError: another coordinator controls the arm.
        KeyboardInterrupt: ``interrupted`` said so; the arm rests.
    """
    with ClientSocket(server, keys) as socket:
        link = RemoteLink(socket, name, lease_s, interrupted=interrupted, watch=watch)
        link.acquire()
        try:
            yield Arm(link)
            wait_for(link)
        except BaseException:
            with suppress(RfmsError):  # what ended the program matters more; the lease lapses
                link.stop_moving()
            raise
        finally:
            link.release()


@asynccontextmanager
async def connect_async(
    server: str = DEFAULT_NAME,
    *,
    name: str = "coordinator",
    keys: ClientKeys | None = None,
    lease_s: float = LEASE_S,
) -> AsyncIterator[AsyncArm]:
    """``connect`` for coroutines; the event loop must come by often enough to renew the lease.

    A part of a program that computes for longer than the lease without awaiting loses it: compute
    in another thread (``asyncio.to_thread``).
    """
    async with AsyncClientSocket(server, keys) as socket:
        link = AsyncRemoteLink(socket, name, lease_s)
        try:
            await link.acquire()
            try:
                yield AsyncArm(link)
                await wait_for_rest(link)
            except BaseException:
                with suppress(RfmsError):  # what ended the program matters more; the lease lapses
                    await link.stop_moving()
                raise
        finally:
            await link.release()


def emergency_stop(
    server: str = DEFAULT_NAME,
    *,
    name: str = "coordinator",
    reason: str = "",
    keys: ClientKeys | None = None,
) -> None:
    """Stop the arm now, whoever controls it. Not a safety function.

    Raises:
        LinkError: nobody took it.
    """
    with ClientSocket(server, keys) as socket:
        socket.emergency(msgspec.msgpack.encode(EmergencyStop(name, reason)))
