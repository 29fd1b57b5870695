"""How a program ends: it waits for its moves however long they take, not for an arm that shakes."""

import asyncio
from collections.abc import Callable

import pytest
from support.link import status

from rfms_can.coordinator.stopping import STOPPING_S, stopped, wait_for, wait_for_rest
from rfms_can.errors import ProgramError
from rfms_can.messages import AnyCondition, CycleReached, MoveOver, Status

PERIOD_S = 0.004


class Shown:
    """A link to an arm whose moves end at one time, s, and which rests from another on."""

    def __init__(self, moves_until: float, rests_from: float, feed: float = 1.0) -> None:
        self.moves_until, self.rests_from, self.feed = moves_until, rests_from, feed
        self.cycle = 0

    @property
    def now(self) -> float:
        return self.cycle * PERIOD_S

    def status(self) -> Status:
        return status(
            cycle=self.cycle,
            period=PERIOD_S,
            sequence=1,
            completed=int(self.now >= self.moves_until),
            waiting=0,
            feed=self.feed,
            at_rest=self.now >= self.rests_from,
        )

    def holds(self, _: AnyCondition) -> bool:
        return self.status().at_rest

    def wait(self, *any_of: AnyCondition) -> None:
        def held(condition: AnyCondition) -> bool:
            if isinstance(condition, CycleReached):
                return self.cycle >= condition.cycle
            return self.holds(condition)

        while not any(map(held, any_of)):
            self.cycle += 1


class AsyncShown(Shown):
    async def wait(self, *any_of: AnyCondition) -> None:  # type: ignore[override]
        super().wait(*any_of)


def blocking(moves_until: float, rests_from: float) -> Shown:
    link = Shown(moves_until, rests_from)
    wait_for(link)  # type: ignore[arg-type]  # no requests are made
    return link


def awaiting(moves_until: float, rests_from: float) -> Shown:
    link = AsyncShown(moves_until, rests_from)
    asyncio.run(wait_for_rest(link))  # type: ignore[arg-type]
    return link


@pytest.mark.parametrize("way", [blocking, awaiting])
@pytest.mark.parametrize(
    ("moves_until", "rests_from"), [(0.0, 0.0), (3.0, 3.2), (95.0, 95.5), (5.0, 24.0)]
)
def test_it_goes_on_when_the_arm_rests(
    way: Callable[[float, float], Shown], moves_until: float, rests_from: float
) -> None:
    assert way(moves_until, rests_from).now == pytest.approx(rests_from, abs=PERIOD_S)


@pytest.mark.parametrize("way", [blocking, awaiting])
def test_an_arm_that_shakes_is_not_waited_for(way: Callable[[float, float], Shown]) -> None:
    with pytest.raises(ProgramError, match="not come to rest within 20 s after its last move"):
        way(5.0, 1e9)


def test_a_paused_arm_is_not_waited_for() -> None:
    with pytest.raises(ProgramError, match=r"the arm is paused, .*: resume\(\) before you wait"):
        wait_for(Shown(95.0, 95.5, feed=0.0))  # type: ignore[arg-type]


def test_a_move_is_waited_for_however_long_it_takes() -> None:
    link = Shown(95.0, 1e9)
    link.holds = lambda _: link.now >= 95.0  # type: ignore[method-assign]
    wait_for(link, MoveOver(1))  # type: ignore[arg-type]
    assert link.now == pytest.approx(95.0, abs=PERIOD_S)


def test_a_stop_is_over_after_20_s_at_most() -> None:
    _, end = stopped(status(cycle=100, period=PERIOD_S))
    assert end == CycleReached(100 + round(STOPPING_S / PERIOD_S))
