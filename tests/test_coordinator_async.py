"""The async twin over a server's own core: the same arm, and parts that wait side by side."""

import asyncio
import inspect
from collections.abc import Awaitable, Callable

import pytest
from support.link import AsyncCoreSocket, CoreSocket
from support.server import SECOND, Coordinator, ServerBench

from rfms_can.coordinator import Arm, AsyncArm, Transform, connect_async
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import FaultError, LeaseError, LinkError, MoveError, ProgramError
from rfms_can.messages import CycleReached, JawAtRest, MoveOver, MoveRequest
from rfms_can.wire.contract import Wire

LONG_LEASE_S = 10.0


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def socket(bench: ServerBench, monkeypatch: pytest.MonkeyPatch) -> CoreSocket:
    """The socket ``connect_async`` gets leads here."""
    one = CoreSocket(bench, b"program")
    monkeypatch.setattr(
        "rfms_can.coordinator.connection.AsyncClientSocket", lambda *_: AsyncCoreSocket(one)
    )
    return one


Program = Callable[[AsyncArm], Awaitable[None]]


def run(program: Program, lease_s: float = LONG_LEASE_S) -> None:
    """Run a program to its end."""

    async def main() -> None:
        async with connect_async("bench", name="cell", lease_s=lease_s) as arm:
            await program(arm)

    asyncio.run(main())


async def lift(arm: AsyncArm, seconds: float = 0.6, name: str = "up") -> int:
    """A move straight up; its number."""
    there = await arm.transform("there", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
    await arm.position(name, arm.t6 == there)
    await arm.mode(name, segment_time=seconds, acceleration_time=0.1)
    return await arm.move(name, name)


# --- the twin ----------------------------------------------------------------------------------


def test_the_twins_have_the_same_words_with_the_same_arguments() -> None:
    words = [name for name in vars(Arm) if not name.startswith("_")]
    assert len(words) > 15
    for name in words:
        one, other = getattr(Arm, name), getattr(AsyncArm, name)
        assert inspect.signature(one).parameters == inspect.signature(other).parameters, name
        assert inspect.iscoroutinefunction(other), name
    assert {*vars(AsyncArm)} - {*vars(Arm)} == {"run"}


@pytest.mark.system
def test_a_program_moves_the_arm_as_its_twin_does(bench: ServerBench, wire: Wire) -> None:
    """Every frame of every cycle has the same payload."""
    frames = []
    for twin in (False, True):
        here = ServerBench(wire)
        socket = CoreSocket(here, b"program")
        if twin:
            asyncio.run(awaited(AsyncCoreSocket(socket)))
        else:
            called(socket)
        frames.append(here.frames)
    assert len(frames[0]) > 3000
    assert frames[0] == frames[1]


async def awaited(socket: AsyncCoreSocket) -> None:
    """A short program, awaited."""
    link = AsyncRemoteLink(socket, "cell", LONG_LEASE_S)
    await link.acquire()
    arm = AsyncArm(link)
    part = await arm.reference("part", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
    await arm.position("at part", arm.t6 == part)
    await arm.mode("slow", segment_time=0.5, acceleration_time=0.1, interpolation="cartesian")
    there = await arm.move("at part", "slow")
    await arm.sleep(0.2)
    await arm.observe(part, Transform.translation(0.004, 0.0, 0.03) @ arm.pose, at=arm.time)
    await arm.wait(there)
    await arm.gripper.close(0.5)
    await link.release()


def called(socket: CoreSocket) -> None:
    """The same program."""
    link = RemoteLink(socket, "cell", LONG_LEASE_S)
    link.acquire()
    arm = Arm(link)
    part = arm.reference("part", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
    arm.position("at part", arm.t6 == part)
    arm.mode("slow", segment_time=0.5, acceleration_time=0.1, interpolation="cartesian")
    there = arm.move("at part", "slow")
    arm.sleep(0.2)
    arm.observe(part, Transform.translation(0.004, 0.0, 0.03) @ arm.pose, at=arm.time)
    arm.wait(there)
    arm.gripper.close(0.5)
    link.release()


def test_all_words_reach_the_server(socket: CoreSocket) -> None:
    async def program(arm: AsyncArm) -> None:
        await lift(arm)
        await arm.pause()
        await arm.feed(0.5)
        await arm.resume()
        await arm.comply("fx", 0.0)
        assert arm.status.comply == "fx"
        await arm.lock("fx")
        slow = {"segment_time": 0.8, "acceleration_time": 0.1}
        await arm.mode("up", **slow)  # type: ignore[arg-type]
        await arm.mode("spare", **slow)  # type: ignore[arg-type]
        await arm.remove("spare")
        await arm.stop()
        await arm.release()
        assert arm.plan(1).segment_time == pytest.approx(0.8)

    run(program)
    kinds = [type(one).__name__.removesuffix("Request") for one in socket.requests]
    words = ["Pause", "Feed", "Resume", "Comply", "Lock", "ModeMessage", "ModeMessage", "Remove"]
    assert kinds[5:13] == words
    assert kinds[13:18] == ["Stop", "Wait", "OutcomeQuery", "Gripper", "Wait"]


# --- parts side by side ------------------------------------------------------------------------


def test_each_part_is_woken_in_its_own_cycle(bench: ServerBench, socket: CoreSocket) -> None:
    woken: list[tuple[str, int]] = []

    async def beat(arm: AsyncArm, name: str, seconds: float, times: int) -> str:
        for _ in range(times):
            await arm.sleep(seconds)
            woken.append((name, arm.status.cycle))
        return name

    async def program(arm: AsyncArm) -> None:
        begin = arm.status.cycle
        results = await arm.run(beat(arm, "a", 0.1, 3), beat(arm, "b", 0.06, 4))
        assert results == ["a", "b"]
        here = [(name, cycle - begin) for name, cycle in woken]
        assert here == [
            ("b", 15),
            ("a", 25),
            ("b", 30),
            ("b", 45),
            ("a", 50),
            ("b", 60),
            ("a", 75),
        ]

    run(program)
    begin = woken[0][1] - 15
    assert socket.waits[0].any_of == [CycleReached(begin + 25), CycleReached(begin + 15)]
    assert socket.waits[1].any_of == [CycleReached(begin + 25), CycleReached(begin + 30)]


def test_parts_that_hold_in_one_cycle_are_woken_by_one_reply(socket: CoreSocket) -> None:
    async def program(arm: AsyncArm) -> None:
        await arm.run(*(arm.sleep(0.1) for _ in range(5)))

    run(program)
    assert [len(wait.any_of) for wait in socket.waits] == [5, 2]  # and in the end at rest, or never


def test_time_stands_while_a_part_does_something_else(socket: CoreSocket) -> None:
    cycles: list[int] = []

    async def watch(arm: AsyncArm) -> None:
        await arm.sleep(0.04)
        cycles.append(arm.status.cycle)
        await asyncio.sleep(0.05)  # of the wall clock: a camera, a file, another service
        cycles.append(socket.bench.server.status().cycle)

    async def program(arm: AsyncArm) -> None:
        await arm.run(watch(arm), arm.sleep(0.2))
        cycles.append(arm.status.cycle)

    run(program)
    assert cycles[1] == cycles[0]
    assert cycles[2] == cycles[0] + 40


@pytest.mark.system
def test_one_part_moves_while_another_watches(socket: CoreSocket) -> None:
    heights: list[float] = []

    async def move(arm: AsyncArm) -> int:
        await arm.wait(there := await lift(arm))
        await arm.gripper.close()
        return there

    async def watch(arm: AsyncArm) -> None:
        while arm.status.completed < 1:
            heights.append(arm.pose.pz)
            await arm.sleep(0.1)

    async def program(arm: AsyncArm) -> None:
        assert await arm.run(move(arm), watch(arm)) == [1, None]

    run(program)
    assert len(heights) > 5
    assert heights[-1] - heights[0] == pytest.approx(0.03, abs=2e-3)
    together = [wait.any_of for wait in socket.waits]
    assert any(MoveOver(1) in any_of and len(any_of) == 2 for any_of in together)
    assert any(JawAtRest() in any_of for any_of in together)


def test_parts_may_have_parts(socket: CoreSocket) -> None:
    log: list[tuple[str, int]] = []

    async def note(arm: AsyncArm, name: str, seconds: float) -> None:
        await arm.sleep(seconds)
        log.append((name, arm.status.cycle))

    async def inner(arm: AsyncArm) -> None:
        await arm.run(note(arm, "i", 0.04), note(arm, "j", 0.02))
        await note(arm, "after", 0.04)

    async def program(arm: AsyncArm) -> None:
        begin = arm.status.cycle
        await arm.run(inner(arm), note(arm, "o", 0.06))
        await note(arm, "end", 0.004)
        seen = [(name, cycle - begin) for name, cycle in log]
        assert seen == [("j", 5), ("i", 10), ("o", 15), ("after", 20), ("end", 21)]

    run(program)


def test_no_parts_are_done_at_once(socket: CoreSocket) -> None:
    async def program(arm: AsyncArm) -> None:
        assert await arm.run() == []
        await arm.sleep(0.004)

    run(program)


def test_an_error_of_one_part_ends_the_others_and_is_raised_as_it_is(socket: CoreSocket) -> None:
    ended: list[str] = []

    async def waits(arm: AsyncArm) -> None:
        try:
            await arm.sleep(10.0)
        finally:
            ended.append("waits")

    async def fails(arm: AsyncArm) -> None:
        await arm.sleep(0.04)
        await arm.move("nowhere", "somehow")

    async def program(arm: AsyncArm) -> None:
        begin = arm.status.cycle
        with pytest.raises(ProgramError, match="'nowhere'"):
            await arm.run(waits(arm), fails(arm))
        assert ended == ["waits"]
        assert arm.status.cycle == begin + 10
        await arm.run(arm.sleep(0.04), arm.sleep(0.02))  # and the program goes on
        assert arm.status.cycle == begin + 20

    run(program)


def test_a_part_that_fails_before_another_has_begun(socket: CoreSocket) -> None:
    async def fails() -> None:
        raise MoveError("at once")

    async def program(arm: AsyncArm) -> None:
        with pytest.raises(MoveError, match="at once"):
            await arm.run(fails(), arm.sleep(1.0), arm.sleep(1.0))
        await arm.sleep(0.004)

    run(program)


# --- errors, lease, replies that do not come ---------------------------------------------------


@pytest.mark.system
def test_after_an_exception_the_arm_rests_on_its_way(
    bench: ServerBench, socket: CoreSocket
) -> None:
    start = bench.t6.pz

    async def program(arm: AsyncArm) -> None:
        await lift(arm, 1.0)
        await arm.sleep(0.5)
        raise ValueError("half way")

    with pytest.raises(ValueError, match="half way"):
        run(program)
    told = bench.server.status()
    assert (told.lease, told.at_rest, told.waiting, told.fault) == (None, True, 0, None)
    assert 0.002 < bench.t6.pz - start < 0.028
    assert bench.server.numbers().lapses == 0
    assert socket.closed


def test_a_fault_ends_every_part(bench: ServerBench, socket: CoreSocket) -> None:
    ended: list[type[BaseException]] = []

    async def waits(arm: AsyncArm) -> None:
        try:
            await arm.sleep(10.0)
        except BaseException as error:
            ended.append(type(error))
            raise

    async def alarm(arm: AsyncArm) -> None:
        await arm.sleep(0.02)
        bench.emergency("guard")
        await waits(arm)

    async def program(arm: AsyncArm) -> None:
        await arm.run(waits(arm), waits(arm), alarm(arm))

    with pytest.raises(FaultError, match="guard"):
        run(program)
    assert len(ended) == 3
    assert set(ended) <= {FaultError, asyncio.CancelledError}


def test_another_program_is_refused_by_name(bench: ServerBench, socket: CoreSocket) -> None:
    Coordinator(bench, "left cell").acquire(5.0)

    async def program(_: AsyncArm) -> None:
        raise AssertionError("the arm is not ours")

    with pytest.raises(LeaseError, match="controlled by 'left cell'"):
        run(program)
    assert socket.closed


def test_a_lapse_ends_the_program(bench: ServerBench, socket: CoreSocket) -> None:
    async def program(arm: AsyncArm) -> None:
        await arm.sleep(0.02)
        socket.late_ns = 11 * SECOND
        await arm.sleep(10.0)

    with pytest.raises(LeaseError, match="did not renew its lease in time"):
        run(program)
    assert bench.server.holder is None


@pytest.mark.parametrize("lost", ["lose", "lose_replies"])
def test_a_request_without_a_reply_is_processed_once(socket: CoreSocket, lost: str) -> None:
    async def program(arm: AsyncArm) -> None:
        await lift(arm)
        socket.lose, socket.lose_replies = (1, 0) if lost == "lose" else (0, 1)
        assert await arm.move("up", "up") == 2
        await arm.stop()

    run(program)
    assert sum(isinstance(one, MoveRequest) for one in socket.requests) == 2


def test_nonsense_is_a_link_error(socket: CoreSocket) -> None:
    async def program(arm: AsyncArm) -> None:
        socket.garble = b"\xc1nonsense"
        await arm.sleep(1.0)

    with pytest.raises(LinkError, match="sent an invalid reply"):
        run(program)


@pytest.mark.parametrize("lost", ["lose", "lose_replies"])
def test_a_wait_that_is_lost_or_whose_reply_is_lost_ends(socket: CoreSocket, lost: str) -> None:
    async def program(arm: AsyncArm) -> None:
        await arm.sleep(0.02)
        before = arm.status.cycle
        setattr(socket, lost, 1)
        await arm.sleep(0.1)
        assert arm.status.cycle >= before + 25

    run(program)
