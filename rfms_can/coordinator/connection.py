"""Connecting to a server: ``with connect("rfms") as arm:``, ``connect_async``, emergency stop."""

from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Final

import msgspec

from rfms_can.coordinator.aio import AsyncArm
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.arm import Arm
from rfms_can.coordinator.moves import Moves
from rfms_can.coordinator.program_link import AsyncProgramLink, ProgramLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.coordinator.stopping import finish, judge, wait_for_rest
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
    program_runs: Callable[[bool], None] = lambda _: None,
    watch: Callable[[Status], None] = lambda _: None,
) -> Iterator[Arm]:
    """Take control of a server's arm; release it at rest at the end of the block.

    At the end of the block the queued moves are completed, and one that was not made is raised, as
    by ``Arm.wait()``; after an exception the arm is first
    brought to rest on its path, and the exception is raised again. Threads take turns with the arm:
    while one waits, a request of another is blocked; use ``connect_async`` for concurrency. After
    the block every use of the arm is a ``ProgramError``.

    Args:
        server: its NAME, or ``tcp://ADDRESS:PORT``.
        name: of this coordinator, shown to others that are refused.
        keys: CURVE keys, for a server that requires them.
        lease_s: time without a renewal after which the server stops the arm, 0.1 to 10 s.
        interrupted: whether the program is to end; called while it waits or reads the arm's state.
        program_runs: told True where the block's own code runs, and a signal may raise at once.
        watch: called periodically with the arm's state while the program waits.

    Raises:
        LinkError: no server is running, or it does not answer.
        LeaseError: another coordinator controls the arm.
        KeyboardInterrupt: ``interrupted`` returned True; the arm is at rest.
    """

    def ends() -> bool:
        return interrupted() or program.ending  # the wait of a thread at the end of the block

    with ClientSocket(server, keys) as socket:
        link = RemoteLink(socket, name, lease_s, interrupted=ends, watch=watch)
        program = ProgramLink(link, interrupted=interrupted, program_runs=program_runs)
        link.acquire()
        moves = Moves()
        try:
            with program:
                yield Arm(program, moves)
            finish(link, moves)
        except BaseException:
            with suppress(RfmsError):  # the original error matters more; the lease lapses
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
    """``connect`` for coroutines; the event loop must run often enough to renew the lease.

    A part of a program that computes for longer than the lease without awaiting loses it: compute
    in another thread (``asyncio.to_thread``).
    """
    async with AsyncClientSocket(server, keys) as socket:
        link, moves = AsyncRemoteLink(socket, name, lease_s), Moves()
        try:
            await link.acquire()
            try:
                with AsyncProgramLink(link) as program:
                    yield AsyncArm(program, moves)
                await wait_for_rest(link)
                await judge(link, moves)
            except BaseException:
                with suppress(RfmsError):  # the original error matters more; the lease lapses
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
    """Stop the arm immediately, with or without the lease. Not a safety function.

    Raises:
        LinkError: no server accepted it.
    """
    with ClientSocket(server, keys) as socket:
        socket.emergency(msgspec.msgpack.encode(EmergencyStop(name, reason)))
