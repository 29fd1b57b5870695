"""A program's link without sockets: to a server's core on a bench, or to no server at all.

``CoreSocket`` loses messages when told to. Time passes as the server allows it while a client waits
for a reply; where nothing can come any more, local time goes on by as much as was waited.
``FakeLink`` remembers what a program says, and answers by itself.
"""

import asyncio

import msgspec

from rfms_can.errors import FaultError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyRequest,
    CycleReached,
    Envelope,
    Message,
    MoveOutcome,
    MoveOver,
    MoveRequest,
    Outcome,
    Status,
    WaitRequest,
)
from rfms_can.transform import Transform
from support.server import SECOND, ServerBench

CYCLES = 25
"""Cycles that may pass during one wait for a reply."""

_encode = msgspec.msgpack.Encoder().encode
_envelope = msgspec.msgpack.Decoder(Envelope).decode


class CoreSocket:
    """A client's sockets without sockets.

    Attributes:
        sent: envelopes, in order, lost ones among them.
        lose: how many of the next requests are lost on their way.
        lose_replies: how many of the next replies are.
        deaf: whether the server is not there at all.
        garble: what comes instead of the next reply.
        late_ns: by how much local time goes on with the next cycle.
    """

    def __init__(self, bench: ServerBench, peer: bytes) -> None:
        self.address = "bench"
        self.bench = bench
        self.peer = peer
        self.sent: list[Envelope] = []
        self.lose = self.lose_replies = self.late_ns = 0
        self.deaf = False
        self.garble: bytes | None = None
        self.closed = False

    @property
    def requests(self) -> list[AnyRequest]:
        """What has been asked, every request once."""
        return list({one.serial: one.message for one in self.sent}.values())

    @property
    def waits(self) -> list[WaitRequest]:
        """What has been waited for."""
        return [one for one in self.requests if isinstance(one, WaitRequest)]

    def now(self) -> float:
        """Local time, s."""
        return self.bench.now_ns / SECOND

    def send(self, data: bytes) -> None:
        self.sent.append(_envelope(data))
        if self.lose:
            self.lose -= 1
        elif not self.deaf:
            self.bench.give(data, self.peer)

    def receive(self, timeout_s: float) -> bytes | None:
        bench, inbox = self.bench, self.bench.inbox.setdefault(self.peer, [])
        for _ in range(CYCLES):
            if inbox or self.deaf or not bench.server.time_may_pass:
                break
            bench.cycles()
            bench.now_ns += self.late_ns
            self.late_ns = 0
        if self.garble is not None:
            data, self.garble = self.garble, None
            return data
        if self.lose_replies and inbox:
            self.lose_replies -= 1
            inbox.pop(0)
        if inbox:
            return _encode(inbox.pop(0))
        bench.now_ns += round(timeout_s * SECOND)
        return None

    def newest_status(self, timeout_s: float) -> bytes | None:
        return None if self.deaf else _encode(self.bench.server.status())

    def close(self) -> None:
        self.closed = True

    def __enter__(self) -> "CoreSocket":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class AsyncCoreSocket:
    """``CoreSocket`` for coroutines.

    Attributes:
        core: what it leads to.
    """

    def __init__(self, core: CoreSocket) -> None:
        self.address = core.address
        self.core = core

    def send(self, data: bytes) -> None:
        self.core.send(data)

    async def receive(self, timeout_s: float) -> bytes | None:
        await asyncio.sleep(0)
        data = self.core.receive(0.0)
        if data is None:
            await asyncio.sleep(0.001)
        return data

    async def newest_status(self, timeout_s: float) -> bytes | None:
        await asyncio.sleep(0)
        return self.core.newest_status(timeout_s)

    def close(self) -> None:
        self.core.close()

    async def __aenter__(self) -> "AsyncCoreSocket":
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()


class FakeLink:
    """Takes every message, and lets a cycle pass whenever a condition does not hold.

    Attributes:
        heard: messages, in order.
        now: cycles that have passed.
        over: last move that is complete.
        rests_at: cycle at which arm and jaw come to rest.
        refusal: raised by the next request, if any.
        ended: how moves ended that were not made, and why.
    """

    def __init__(self) -> None:
        self.heard: list[Message] = []
        self.now = 0
        self.over = 0
        self.rests_at = 0
        self.refusal: Exception | None = None
        self.fault_at: int | None = None
        self.ended: dict[int, tuple[Outcome, str]] = {}
        self._moves = 0

    def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        made = (Outcome.MADE, "")
        return [MoveOutcome(n, *self.ended.get(n, made)) for n in range(first, last + 1)]

    def request(self, message: Message) -> Answer:
        if self.refusal is not None:
            raise self.refusal
        self.heard.append(message)
        if isinstance(message, MoveRequest):
            self._moves += 1
            return Answer(self._moves)
        return Answer()

    def wait(self, *any_of: AnyCondition) -> None:
        while not any(self._holds(condition) for condition in any_of):
            self.now += 1
            if self.now == self.fault_at:
                raise FaultError("joint 3: OVER_TORQUE (9)")
            if self.now % 100 == 0:
                self.over += 1

    def _holds(self, condition: AnyCondition) -> bool:
        match condition:
            case MoveOver(sequence):
                return self.over >= sequence
            case CycleReached(cycle):
                return self.now >= cycle
            case _:
                return self.now >= self.rests_at

    def status(self) -> Status:
        return status(
            cycle=self.now,
            joints=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
            t6=Transform.translation(0.3, 0.2, 0.1),
            completed=min(self.over, self._moves),
        )

    def time(self) -> float:
        return 0.004 * self.now


NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

AT_REST = Status(
    cycle=0,
    time=0.0,
    period=0.004,
    clock="virtual",
    phase="RUN",
    stage="IDLE",
    joints=NOTHING,
    t6=Transform.identity(),
    errors=NOTHING,
    sequence=0,
    completed=0,
    waiting=0,
    at_rest=True,
    jaw_at_rest=True,
    jaw=0.08,
    feed=1.0,
    comply="",
    complying="",
    complied=NOTHING,
    force=NOTHING,
    force_loop="none",
    guard=None,
    lease=None,
    refused=0,
    fault=None,
)


def status(**fields: object) -> Status:
    """The status of an arm at rest, but for some fields."""
    return msgspec.structs.replace(AT_REST, **fields)
