"""``RemoteLink`` for coroutines, several of which may wait concurrently."""

import asyncio
import time
from collections.abc import Callable, Coroutine, Sequence
from contextlib import suppress
from typing import Any

from rfms_can.coordinator.concurrency import Parts, Waiting
from rfms_can.coordinator.conversation import (
    ANSWER_S,
    REALTIME,
    RETRY_S,
    Conversation,
    Lease,
    Request,
    answer_of,
)
from rfms_can.coordinator.sockets import AsyncSocket
from rfms_can.coordinator.stopping import stopped
from rfms_can.errors import LinkError, RfmsError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyRequest,
    ArmRequest,
    LeaseRequest,
    MoveOutcome,
    OutcomeQuery,
    Reply,
    SensorRequest,
    Status,
    StopRequest,
    WaitRequest,
)


class AsyncRemoteLink:
    """``AsyncLink`` on a server's sockets; one object for one event loop.

    Args:
        socket: connected; the caller closes it.
        name: of this coordinator, shown to others that are refused.
        lease_s: time without a renewal after which the server stops the arm, s.
        now: local time, s, monotonic.
    """

    def __init__(
        self,
        socket: AsyncSocket,
        name: str,
        lease_s: float,
        *,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket = socket
        self._lease = Lease(name, lease_s)
        self._now = now
        self._conversation = Conversation(socket.address)
        self._parts = Parts(self._ask)
        self._lock = asyncio.Lock()
        self._replies: dict[int, asyncio.Future[Reply]] = {}
        self._asked: dict[int, Sequence[Waiting]] = {}
        self._to_ask: Sequence[Waiting] = ()
        self._wait: Request | None = None  # sent last
        self._tasks: list[asyncio.Task[None]] = []

    # --- the lease ----------------------------------------------------------------------------

    async def acquire(self) -> None:
        """Take the lease and keep it; errors as with ``RemoteLink.acquire``."""
        self._tasks.append(asyncio.create_task(self._guarded(self._receive())))
        await self.request(self._lease.acquire)
        self._tasks.append(asyncio.create_task(self._guarded(self._renew())))
        if self.status().clock == REALTIME:
            self._parts.at_once = True
            self._tasks.append(asyncio.create_task(self._guarded(self._hear())))

    async def stop_moving(self) -> None:
        """Bring the arm to rest on its path and wait for it."""
        await self.request(StopRequest())
        await self.wait(*stopped(self.status()))

    async def release(self) -> None:
        """Release the lease, if the server still answers; a moving arm is stopped."""
        with suppress(RfmsError):  # it has lapsed, or will
            await self.request(self._lease.release)
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    # --- requests -----------------------------------------------------------------------------

    async def request(self, message: ArmRequest | LeaseRequest | SensorRequest) -> Answer:
        """Send a request; see ``RemoteLink.request``."""
        return await self._in_turn(message)

    async def wait(self, *any_of: AnyCondition) -> None:
        """Let time advance until one of the conditions holds, for this part of the program."""
        await self._parts.wait(any_of)

    async def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """How moves ended; see ``Link.outcomes``."""
        return (await self._in_turn(OutcomeQuery(first, last))).outcomes

    async def run(self, *parts: Coroutine[Any, Any, Any]) -> list[Any]:
        """Run coroutines as parts of one program; see ``Parts.run``."""
        return await self._parts.run(parts)

    def status(self) -> Status:
        """The newest state of the arm, of the last reply or, in real time, of a later broadcast."""
        return self._conversation.status

    def time(self) -> float:
        """The server's time, s."""
        return self._conversation.time(self._now())

    # --- replies ------------------------------------------------------------------------------

    async def _in_turn(self, message: AnyRequest) -> Answer:
        """One request at a time: the server repeats only its last reply."""
        async with self._lock:
            try:
                return await self._exchange(message)
            finally:
                self._send_wait()

    async def _exchange(self, message: AnyRequest) -> Answer:
        request = self._conversation.ask(message)
        reply = self._replies[request.serial] = asyncio.get_running_loop().create_future()
        until = self._now() + ANSWER_S
        try:
            while self._now() < until:
                self._socket.send(request.data)
                done, _ = await asyncio.wait([reply], timeout=RETRY_S)
                if done:
                    return answer_of(reply.result())
        finally:
            del self._replies[request.serial]
        raise self._conversation.silent()

    def _ask(self, waiting: Sequence[Waiting]) -> None:
        """Send one wait for all waiting parts; it replaces an earlier one."""
        self._to_ask = waiting
        if not self._lock.locked():
            self._send_wait()

    def _send_wait(self) -> None:
        waiting, self._to_ask = self._to_ask, ()
        if waiting:
            conditions = [condition for part in waiting for condition in part.any_of]
            wait = self._conversation.number(WaitRequest(conditions))
            self._asked[wait.serial] = waiting
            self._wait = wait
            self._socket.send(wait.data)

    async def _receive(self) -> None:
        """Assign every reply to its request."""
        while True:
            data = await self._socket.receive(self._lease.duration_s)
            if data is None:
                continue
            reply = self._conversation.read(data, self._now())
            future = self._replies.get(reply.serial)
            asked = self._asked.pop(reply.serial, None)
            if future is not None and not future.done():
                future.set_result(reply)
            elif asked is not None:
                self._woken(asked, reply)

    def _woken(self, asked: Sequence[Waiting], reply: Reply) -> None:
        try:
            self._parts.woken(asked, answer_of(reply).held)
        except RfmsError as error:
            self._parts.refused(asked, error)

    async def _renew(self) -> None:
        while True:
            await asyncio.sleep(self._lease.renewal_s)
            wait = self._wait
            if wait is not None and wait.serial in self._asked and not self._lock.locked():
                self._socket.send(wait.data)  # its reply may be lost: it is then repeated
            await self._in_turn(self._lease.renew)

    async def _hear(self) -> None:
        while True:
            data = await self._socket.newest_status(self._lease.duration_s)
            if data is not None:
                self._conversation.hear(data, self._now())

    async def _guarded(self, task: Coroutine[Any, Any, None]) -> None:
        """Run a task in the background; if it fails, waiting parts get its error."""
        try:
            await task
        except Exception as error:
            if isinstance(error, LinkError):
                self._conversation.lost = error
            self._parts.fail(error)
            if not isinstance(error, RfmsError):
                raise
