"""When a program's parts let time go on, by themselves: what the server is asked, and when."""

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress

from hypothesis import given
from hypothesis import strategies as st

from rfms_can.coordinator.concurrency import Parts, Waiting
from rfms_can.messages import AnyCondition, CycleReached


class FakeServer:
    """Answers the newest wait, in virtual time: the earliest cycles first.

    Attributes:
        asked: how many conditions each wait had.
        cycle: how far time has gone on.
    """

    def __init__(self, *, at_once: bool = False) -> None:
        self.parts = Parts(self._begin)
        self.parts.at_once = at_once
        self.asked: list[int] = []
        self.cycle = 0
        self._newest: Sequence[Waiting] = ()

    def _begin(self, waiting: Sequence[Waiting]) -> None:
        self.asked.append(len(waiting))
        if self._newest:
            self.parts.woken(self._newest, [])
        self._newest = waiting

    async def serve(self) -> None:
        """Let time advance while a part waits."""
        while True:
            await asyncio.sleep(0)
            asked, self._newest = self._newest, ()
            conditions: list[AnyCondition] = [one for part in asked for one in part.any_of]
            cycles = [one.cycle for one in conditions if isinstance(one, CycleReached)]
            if cycles:
                self.cycle = max(self.cycle, min(cycles))
                held = [index for index, cycle in enumerate(cycles) if cycle <= self.cycle]
                self.parts.woken(asked, held)

    async def until(self, cycle: int) -> None:
        """Wait for a cycle."""
        await self.parts.wait([CycleReached(cycle)])


def drive(server: FakeServer, program: Callable[[], object]) -> None:
    """Run a program while the server serves it."""

    async def main() -> None:
        serving = asyncio.create_task(server.serve())
        async with asyncio.timeout(20.0):
            await program()  # type: ignore[misc]
        serving.cancel()

    asyncio.run(main())


@given(st.lists(st.lists(st.integers(0, 30), max_size=6), min_size=1, max_size=6))
def test_each_part_waits_its_own_time_and_all_wait_before_any_goes_on(
    steps: list[list[int]],
) -> None:
    """Parts that sleep so many cycles each time: every one ends at the sum of its steps."""
    server = FakeServer()
    ends: dict[int, int] = {}

    async def part(number: int) -> None:
        now = 0
        for step in steps[number]:
            now += step
            await server.until(now)
            assert server.cycle == now, "time went on before this part had waited"
            for _ in range(number):
                await asyncio.sleep(0)  # the others must not run away meanwhile
            assert server.cycle == now
        ends[number] = server.cycle

    async def program() -> None:
        await server.parts.run([part(number) for number in range(len(steps))])

    drive(server, program)
    assert ends == {number: sum(one) for number, one in enumerate(steps)}
    assert all(number <= len(steps) for number in server.asked)


def test_in_real_time_nobody_waits_for_the_others() -> None:
    server = FakeServer(at_once=True)
    seen: list[int] = []

    async def busy() -> None:
        while len(seen) < 3:
            await asyncio.sleep(0)

    async def watches() -> None:
        for cycle in (5, 10, 15):
            await server.until(cycle)
            seen.append(server.cycle)

    async def program() -> None:
        await server.parts.run([busy(), watches()])

    drive(server, program)
    assert seen == [5, 10, 15]


def test_in_real_time_a_later_wait_names_all_that_is_waited_for() -> None:
    server = FakeServer(at_once=True)

    async def program() -> None:
        await server.parts.run([server.until(30), server.until(20), server.until(10)])

    drive(server, program)
    assert server.asked == [1, 2, 3, 2, 1]
    assert server.cycle == 30


def test_a_part_that_gives_up_a_wait_is_waited_for_again() -> None:
    server = FakeServer()

    async def gives_up() -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(0.0):
                await server.until(1000)
        await server.until(7)

    async def busy() -> None:
        await asyncio.sleep(0.01)
        await server.until(3)

    async def program() -> None:
        await server.parts.run([gives_up(), busy()])

    drive(server, program)
    assert server.cycle == 7
    assert server.asked == [2, 1]
