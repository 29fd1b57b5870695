"""How moves end: `completed` counts those that are over, `outcome` says how, `wait` raises it."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest
from support.link import AsyncCoreSocket, CoreSocket, FakeLink
from support.server import SECOND, Coordinator, ServerBench

from rfms_can.coordinator import Arm, AsyncArm, Outcome, Transform
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import FaultError, LeaseError, ProgramError, RfmsError, StoppedError
from rfms_can.master.trajectory.outcomes import HISTORY, MoveOutcomes
from rfms_can.messages import (
    CycleReached,
    LeaseRequest,
    MoveOutcome,
    OutcomeQuery,
    WaitRequest,
)
from rfms_can.messages.outcomes import OUTCOMES
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire

LONG_LEASE_S = 10.0
BROKEN = (Outcome.STOPPED, Outcome.SHORT, Outcome.LAPSED, Outcome.FAULTED)


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def socket(bench: ServerBench) -> CoreSocket:
    return CoreSocket(bench, b"program")


def lift(arm: Arm, seconds: float = 1.0, height: float = 0.03) -> int:
    """A move straight up; its number."""
    there = arm.transform("there", Transform.translation(0.0, 0.0, height) @ arm.pose)
    arm.position("up", arm.t6 == there)
    arm.mode("slow", segment_time=seconds, acceleration_time=0.1)
    return arm.move("up", "slow")


# --- the record --------------------------------------------------------------------------------


def three() -> MoveOutcomes:
    outcomes = MoveOutcomes()
    for number in (1, 2, 3):
        outcomes.accept(number)
    return outcomes


def how(outcomes: MoveOutcomes, first: int = 1, last: int = 3) -> list[Outcome]:
    return [outcome.how for outcome in outcomes.of(first, last)]


def test_dropped_moves_are_over_when_the_arm_rests() -> None:
    outcomes = three()
    outcomes.arrived(1)
    outcomes.ends((2, 3), Outcome.LAPSED, "asleep")
    assert (outcomes.completed, how(outcomes)) == (1, [Outcome.MADE, *[Outcome.UNDER_WAY] * 2])
    outcomes.rests()
    assert outcomes.completed == 3
    assert outcomes.of(2, 3) == [MoveOutcome(n, Outcome.LAPSED, "asleep") for n in (2, 3)]


def test_what_ended_a_move_first_stays() -> None:
    outcomes = three()
    outcomes.ends((1,), Outcome.STOPPED, "stop()")
    outcomes.ends((1, 2), Outcome.LAPSED, "asleep")
    outcomes.abandon(Outcome.FAULTED, "joint 3")
    assert how(outcomes) == [Outcome.STOPPED, Outcome.LAPSED, Outcome.FAULTED]
    assert outcomes.completed == 3
    outcomes.ends((1, 2, 3), Outcome.STOPPED, "too late")
    outcomes.rests()
    assert how(outcomes) == [Outcome.STOPPED, Outcome.LAPSED, Outcome.FAULTED]


def test_a_stop_that_came_too_late_stopped_nothing_but_a_guard_tripped() -> None:
    outcomes = three()
    outcomes.ends((1,), Outcome.STOPPED, "stop()")
    outcomes.ends((2,), Outcome.GUARDED, "fz")
    for number in (1, 2, 3):
        outcomes.arrived(number)
    assert how(outcomes) == [Outcome.MADE, Outcome.GUARDED, Outcome.MADE]


@pytest.mark.parametrize(
    ("first", "last", "complaint"),
    [
        (0, 1, "outcomes of 0 to 1: moves count from 1"),
        (3, 2, "outcomes of 3 to 2: moves count from 1, and the first comes first"),
        (4, 4, "outcome of move 4: the last move has number 3; give a number that move"),
        (1, 257, "outcomes of 1 to 257: 257 moves, 256 at a time: ask for fewer"),
    ],
)
def test_what_is_no_move_is_refused_in_one_line(first: int, last: int, complaint: str) -> None:
    with pytest.raises(ProgramError, match=complaint) as refused:
        three().of(first, last)
    assert "\n" not in str(refused.value)


def test_the_record_is_bounded_and_says_so() -> None:
    outcomes = MoveOutcomes()
    for number in range(1, 3 * HISTORY):
        outcomes.accept(number)
        outcomes.arrived(number)
    kept = 2 * HISTORY
    assert outcomes.of(kept, kept)[0].how is Outcome.MADE
    with pytest.raises(ProgramError, match=f"too long ago, those of the last 1024 .* from {kept}"):
        outcomes.of(kept - 1, kept - 1)


def test_every_outcome_that_is_not_as_meant_has_an_error() -> None:
    broken = [how for how, rule in OUTCOMES.items() if rule.error is not None]
    assert set(broken) == set(BROKEN)
    assert all(rule.over for how, rule in OUTCOMES.items() if how is not Outcome.UNDER_WAY)


# --- what a program hears ------------------------------------------------------------------------


@pytest.fixture
def fake() -> FakeLink:
    return FakeLink()


@pytest.mark.parametrize("ended", BROKEN)
def test_a_wait_for_a_move_raises_what_happened(fake: FakeLink, ended: Outcome) -> None:
    arm = Arm(fake)
    number = lift(arm)
    fake.ended[number] = (ended, "the reason")
    error = OUTCOMES[ended].error
    assert error is not None
    with pytest.raises(error, match=rf"move 1 did not reach its goal \({ended.value}\): the rea"):
        arm.wait(number)
    assert arm.outcome(number) == MoveOutcome(1, ended, "the reason")
    arm.wait()  # it has been told
    with pytest.raises(error):
        arm.wait(number)  # it is still so


@pytest.mark.parametrize("ended", [Outcome.MADE, Outcome.GUARDED])
def test_a_move_that_ended_as_it_was_meant_to_is_no_error(fake: FakeLink, ended: Outcome) -> None:
    arm = Arm(fake)
    number = lift(arm)
    fake.ended[number] = (ended, "fz 15 N reached 15 N")
    arm.wait(number)
    arm.wait()


def test_waiting_for_rest_raises_once_what_the_program_did_not_ask_for(fake: FakeLink) -> None:
    arm = Arm(fake)
    first = lift(arm)
    second = arm.move("up", "slow")
    fake.ended[first] = (Outcome.STOPPED, "stop()")
    arm.wait()
    fake.ended[second] = (Outcome.LAPSED, "asleep")
    arm.wait()  # both were over and told
    third = arm.move("up", "slow")
    fake.ended[third] = (Outcome.LAPSED, "asleep")
    with pytest.raises(LeaseError, match="move 3"):
        arm.wait()
    arm.wait()


@pytest.mark.parametrize(
    "number", [0, 2, -1, "1", None, 1.5], ids=["zero", "later", "negative", "text", "none", "half"]
)
def test_the_outcome_of_what_is_no_move_is_refused(fake: FakeLink, number: Any) -> None:
    arm = Arm(fake)
    lift(arm)
    heard = len(fake.heard)
    with pytest.raises(ProgramError, match=r"outcome of move .*: .*give a number that move\(\)"):
        arm.outcome(number)
    assert len(fake.heard) == heard


# --- M7: a program that polls ends ----------------------------------------------------------------


def polled(ends: Callable[[Arm, int], None], **settings: Any) -> MoveOutcome:
    """The guide's loop; how the move ended."""
    told: list[MoveOutcome] = []

    def program(arm: Arm) -> None:
        number = lift(arm)
        arm.mode("feel", segment_time=1.0, acceleration_time=0.1, **settings)
        if settings:
            arm.stop()
            number = arm.move("up", "feel")
        arm.sleep(0.3)
        ends(arm, number)
        while arm.status.completed < number:
            arm.sleep(0.02)
        assert arm.status.at_rest
        told.append(arm.outcome(number))

    assert execute(program, RunSettings(friction="none")).fault is None
    return told[0]


@pytest.mark.system
def test_a_guard_ends_the_loop_of_the_guide() -> None:
    told = polled(lambda arm, number: None, stop_on_distance={"dz": 0.005})
    assert told.how is Outcome.GUARDED
    assert "reached 0.005 m" in told.reason


@pytest.mark.system
def test_a_stop_ends_the_loop_of_the_guide() -> None:
    def stops(arm: Arm, number: int) -> None:
        queued = arm.move("up", "slow")
        assert arm.outcome(number).how is arm.outcome(queued).how is Outcome.UNDER_WAY
        arm.stop()
        assert arm.outcome(queued).how is Outcome.STOPPED
        with pytest.raises(StoppedError, match=r"move 2 .*: stopped by stop"):
            arm.wait(queued)

    assert polled(stops).how is Outcome.STOPPED


def test_a_fault_ends_the_moves(bench: ServerBench, socket: CoreSocket) -> None:
    link = RemoteLink(socket, "cell", LONG_LEASE_S, now=socket.now)
    link.acquire()
    arm = Arm(link)
    number = lift(arm)
    arm.sleep(0.1)
    bench.master.lose("the process of joint 3 has ended")
    with pytest.raises(FaultError, match="joint 3"):
        arm.wait(number)
    assert arm.outcome(number) == MoveOutcome(
        1, Outcome.FAULTED, "the process of joint 3 has ended"
    )


# --- M8: a client that was frozen -----------------------------------------------------------------


@pytest.mark.parametrize("taken", [False, True], ids=["free", "taken by another"])
def test_a_frozen_client_hears_at_its_next_word_that_it_lost_the_arm(
    bench: ServerBench, socket: CoreSocket, taken: bool
) -> None:
    link = RemoteLink(socket, "cell", 1.0, now=socket.now)
    link.acquire()
    arm = Arm(link)
    number = lift(arm, seconds=2.0)
    arm.sleep(0.3)
    bench.now_ns += 4 * SECOND  # a debugger, a closed lid
    bench.cycles(200)
    assert bench.server.status().completed == number, "over: dropped on its way, and at rest"
    if taken:
        other = Coordinator(bench, "other").acquire(LONG_LEASE_S)
        other.move("elsewhere", z=0.01)
    words: list[Callable[[], object]] = [
        lambda: arm.wait(number),
        arm.wait,
        lambda: arm.sleep(0.1),
        lambda: arm.move("up", "slow"),
        arm.gripper.close,
        arm.stop,
    ]
    for word in words:
        with pytest.raises(LeaseError, match="'cell' did not renew its lease in time"):
            word()
    assert arm.outcome(number) == MoveOutcome(1, Outcome.LAPSED, "'cell' did not renew its lease")
    assert bench.server.holder == ("other" if taken else None)


def test_the_lease_of_an_arm_that_is_being_stopped_can_be_had_when_it_rests(
    bench: ServerBench,
) -> None:
    """The client that comes next must be served: a move would be refused until the arm rests."""
    left, right = Coordinator(bench, "left"), Coordinator(bench, "right")
    left.acquire(1.0)
    left.move(seconds=2.0)
    left.ask(WaitRequest([CycleReached(100)]))
    bench.cycles(100)
    bench.now_ns += 2 * SECOND
    refusal = right.refused(LeaseRequest("acquire", "right", 1.0))
    assert (refusal.error, refusal.reason) == (
        "LeaseError",
        "'left' did not renew its lease: the arm is brought to rest: it can be had when it rests, "
        "try again in a moment",
    )
    bench.run(lambda: bench.server.status().at_rest)
    right.acquire(1.0)
    assert right.move("on", z=0.01) == 2


def test_a_session_that_takes_the_lease_again_goes_on(
    bench: ServerBench, socket: CoreSocket
) -> None:
    link = RemoteLink(socket, "cell", 1.0, now=socket.now)
    link.acquire()
    arm = Arm(link)
    bench.now_ns += 4 * SECOND
    bench.cycles()
    with pytest.raises(LeaseError):
        arm.wait()
    link.acquire()
    arm.wait(lift(arm, seconds=0.5))


def test_who_never_had_the_lease_may_wait_for_the_moves_of_others(bench: ServerBench) -> None:
    left, right = Coordinator(bench, "left"), Coordinator(bench, "right")
    number = left.acquire(LONG_LEASE_S).move()
    assert right.done(OutcomeQuery(number, number)).outcomes[0].how is Outcome.UNDER_WAY
    refusal = right.refused(OutcomeQuery(number, number + 1))
    assert (refusal.error, "\n" in refusal.reason) == ("ProgramError", False)


def test_coroutines_hear_the_same(bench: ServerBench, socket: CoreSocket) -> None:
    heard: list[str] = []

    async def main() -> None:
        link = AsyncRemoteLink(AsyncCoreSocket(socket), "cell", LONG_LEASE_S, now=socket.now)
        await link.acquire()
        arm = AsyncArm(link)
        there = await arm.transform("there", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
        await arm.position("up", arm.t6 == there)
        await arm.mode("slow", segment_time=1.0, acceleration_time=0.1)
        number = await arm.move("up", "slow")

        async def waits() -> None:
            try:
                await arm.wait(number)
            except StoppedError as error:
                heard.append(str(error))

        async def stops() -> None:
            await arm.sleep(0.3)
            await arm.stop()

        await arm.run(waits(), stops())
        assert (await arm.outcome(number)).how is Outcome.STOPPED
        with pytest.raises(RfmsError, match="outcome of move 7"):
            await arm.outcome(7)
        await link.release()

    asyncio.run(main())
    assert heard == ["move 1 did not reach its goal (stopped): stopped by stop()"]
