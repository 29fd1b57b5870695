"""Sockets that lead straight to a server's core on a bench, and lose messages when told to.

Time passes as the server allows it while a client waits for a reply; where nothing can come any
more, local time goes on by as much as was waited.
"""

import asyncio

import msgspec

from rfms_can.messages import AnyRequest, Envelope, WaitRequest
from support.server_bench import SECOND, Bench

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

    def __init__(self, bench: Bench, peer: bytes) -> None:
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
