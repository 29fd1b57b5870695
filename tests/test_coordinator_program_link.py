"""Threads, polls, signals and the end of a program, between the API and a link that is a dummy."""

import asyncio
import os
import signal
import threading
import time
from collections.abc import Callable

import pytest
from support.link import AsyncCoreSocket, CoreSocket, status
from support.server import ServerBench

from rfms_can.coordinator import Arm, ProgramError, Transform, connect, connect_async
from rfms_can.coordinator.program_link import POLLS, STANDSTILL_S, ProgramLink, StandstillWatch
from rfms_can.coordinator.turns import Turns
from rfms_can.errors import FaultError
from rfms_can.messages import AtRest, Status, StopRequest
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire


def test_turns_are_taken_in_the_order_of_coming() -> None:
    turns, order = Turns(), []

    def take(number: int) -> None:
        with turns:
            order.append(number)

    threads = [threading.Thread(target=take, args=(number,)) for number in range(5)]
    with turns:
        for thread in threads:
            thread.start()
            time.sleep(0.02)  # until it waits
    for thread in threads:
        thread.join(5.0)
    assert order == [0, 1, 2, 3, 4]


class Clock:
    """Wall time that a test moves."""

    def __init__(self) -> None:
        self.s = 100.0

    def __call__(self) -> float:
        return self.s


def polled(each_s: float, of: Callable[[int], Status], times: int) -> int:
    """Polls until the watch raises; ``times`` if it does not."""
    clock = Clock()
    watch = StandstillWatch("arm.sleep", clock)
    for poll in range(times):
        try:
            watch.poll(of(poll))
        except ProgramError as error:
            assert "arm.sleep" in str(error) and "\n" not in str(error)
            assert clock.s - 100.0 >= STANDSTILL_S
            return poll
        clock.s += each_s
    return times


@pytest.mark.parametrize("each_s", [0.001, 0.02, 0.5, 1.0])
def test_polls_while_time_stands_still_are_refused_after_a_while(each_s: float) -> None:
    least = max(POLLS - 1, round(STANDSTILL_S / each_s))
    assert least <= polled(each_s, lambda _: status(cycle=7), 10_000) <= least + 2


def test_polls_of_an_arm_that_moves_on_are_no_standstill() -> None:
    assert polled(0.02, lambda poll: status(cycle=poll // 100), 1000) == 1000


def test_polls_in_real_time_are_no_standstill() -> None:
    assert polled(0.02, lambda _: status(cycle=7, clock="realtime"), 1000) == 1000


def test_a_person_at_a_prompt_is_no_loop() -> None:
    assert polled(2.5, lambda _: status(cycle=7), 100) == 100


# --- in the master's process -------------------------------------------------------------------

SETTINGS = RunSettings(friction="none")


def lift(arm: Arm, seconds: float = 0.6) -> int:
    """A move straight up; its number."""
    there = arm.transform("there", Transform.translation(0.0, 0.0, 0.02) @ arm.pose)
    arm.position("up", arm.t6 == there)
    arm.mode("slow", segment_time=seconds, acceleration_time=0.1)
    return arm.move("up", "slow")


def test_a_program_that_polls_with_time_sleep_is_told_what_to_call() -> None:
    def program(arm: Arm) -> None:
        number = lift(arm)
        while arm.status.completed < number:
            time.sleep(0.02)

    began = time.monotonic()
    with pytest.raises(ProgramError, match=r"virtual.*call arm\.sleep"):
        execute(program, SETTINGS)
    assert time.monotonic() - began < STANDSTILL_S + 5.0


def test_a_positive_sleep_lets_time_pass() -> None:
    def program(arm: Arm) -> None:
        number = lift(arm)
        while arm.status.completed < number:
            arm.sleep(1e-4)

    execute(program, SETTINGS)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("polls", [True, False])
def test_the_first_signal_ends_a_program_that_lets_no_time_pass(
    number: signal.Signals, polls: bool
) -> None:
    def program(arm: Arm) -> None:
        threading.Timer(0.2, lambda: os.kill(os.getpid(), number)).start()
        for _ in range(400):
            if polls:
                assert arm.status.at_rest
            time.sleep(0.01)

    began = time.monotonic()
    with signals_noted() as interrupt, pytest.raises(KeyboardInterrupt):
        execute(program, SETTINGS, interrupted=interrupt, program_runs=interrupt.program_runs)
    assert interrupt.signal is number
    assert time.monotonic() - began < 4.0


def test_two_threads_take_turns_with_the_arm() -> None:
    """Both turn the same simulation; the motion is that of one thread, and nothing is missing."""
    rested: list[str] = []

    def program(arm: Arm) -> None:
        def watch() -> None:
            for _ in range(40):
                arm.sleep(0.008)
                assert arm.status.fault is None
            rested.append("watch")

        thread = threading.Thread(target=watch)
        number = lift(arm)
        thread.start()
        while arm.status.completed < number:
            arm.sleep(0.02)
        thread.join()
        rested.append("main")

    outcome = execute(program, SETTINGS)
    assert outcome.fault is None
    assert not outcome.result.incomplete
    assert rested == ["watch", "main"]


@pytest.mark.parametrize("fails", [True, False])
def test_a_thread_that_still_waits_is_cut_short_at_the_end(fails: bool) -> None:
    seen: list[BaseException] = []

    def program(arm: Arm) -> None:
        def wait() -> None:
            begun.set()
            try:
                arm.sleep(1e5)
            except ProgramError as error:
                seen.append(error)

        begun = threading.Event()
        threading.Thread(target=wait).start()
        begun.wait()
        time.sleep(0.1)
        if fails:
            raise ValueError("enough")

    if fails:
        with pytest.raises(ValueError, match="enough"):
            execute(program, SETTINGS)
    else:
        assert execute(program, SETTINGS).fault is None
    assert "had ended" in str(seen[0])


def test_the_arm_is_not_used_after_its_program() -> None:
    kept: list[Arm] = []
    execute(kept.append, SETTINGS)
    arm = kept[0]
    for use in (
        lambda: arm.status,
        lambda: arm.time,
        arm.wait,
        arm.stop,
        lambda: arm.sleep(0.1),
        arm.gripper.open,
    ):
        with pytest.raises(ProgramError, match="had ended"):
            use()


def test_every_request_after_a_fault_raises_it() -> None:
    session = Session(SimulatedRig(SETTINGS))
    session.bring_up()
    link = ProgramLink(session.link)
    arm = Arm(link)
    session.master.emergency_stop("the test")
    for _ in range(2):
        for use in (
            lambda: link.request(StopRequest()),
            lambda: link.wait(AtRest()),
            lambda: arm.transform("a", Transform.identity()),
            arm.gripper.close,
            arm.tare,
            lambda: arm.comply("fx", 1.0),
        ):
            with pytest.raises(FaultError, match="the test"):
                use()
    assert arm.status.fault is not None


# --- over the link -----------------------------------------------------------------------------


@pytest.fixture
def socket(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> CoreSocket:
    """The socket ``connect`` gets; it has ended after the block as a real one has."""
    one = CoreSocket(ServerBench(wire), b"program")
    place = "rfms_can.coordinator.connection"
    monkeypatch.setattr(f"{place}.ClientSocket", lambda *_: one)
    monkeypatch.setattr(f"{place}.AsyncClientSocket", lambda *_: AsyncCoreSocket(one))
    return one


@pytest.mark.usefixtures("socket")
def test_the_arm_is_not_used_after_its_block() -> None:
    with connect(lease_s=10.0) as arm:
        arm.sleep(0.1)
    for use in (lambda: arm.status, lambda: arm.pose, arm.wait, arm.stop, arm.gripper.close):
        with pytest.raises(ProgramError, match=r"block of connect\(\), had ended.*connect again"):
            use()


@pytest.mark.usefixtures("socket")
def test_the_arm_of_coroutines_is_not_used_after_its_block() -> None:
    async def program() -> None:
        async with connect_async(lease_s=10.0) as arm:
            await arm.sleep(0.1)
        for use in (arm.wait, arm.stop, arm.gripper.close, lambda: arm.run(arm.wait())):
            with pytest.raises(ProgramError, match="had ended"):
                await use()
        with pytest.raises(ProgramError, match="had ended"):
            assert arm.joints

    asyncio.run(program())


@pytest.mark.usefixtures("socket")
def test_polls_over_the_link_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rfms_can.coordinator.program_link.STANDSTILL_S", 0.3)

    def called() -> None:
        with connect(lease_s=10.0) as arm:
            number = lift(arm)
            while arm.status.completed < number:
                time.sleep(0.02)

    async def awaited() -> None:
        async with connect_async(lease_s=10.0) as arm:
            until = arm.time + 1.0
            while arm.time < until:
                await asyncio.sleep(0.02)

    with pytest.raises(ProgramError, match=r"call arm\.sleep\(seconds\)"):
        called()
    with pytest.raises(ProgramError, match=r"call await arm\.sleep\(seconds\)"):
        asyncio.run(awaited())


@pytest.mark.usefixtures("socket")
def test_observations_alone_let_no_time_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rfms_can.coordinator.program_link.STANDSTILL_S", 0.3)
    with connect(lease_s=10.0) as arm, pytest.raises(ProgramError, match=r"arm\.sleep"):
        part = arm.reference("part", Transform.identity())
        for _ in range(100):
            arm.observe(part, Transform.identity())
            time.sleep(0.01)


@pytest.mark.usefixtures("socket")
def test_the_first_signal_ends_a_program_over_the_link() -> None:
    began = time.monotonic()
    with signals_noted() as interrupt, pytest.raises(KeyboardInterrupt):  # noqa: SIM117
        with connect(
            lease_s=10.0, interrupted=interrupt, program_runs=interrupt.program_runs
        ) as arm:
            lift(arm, 5.0)
            threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGTERM)).start()
            time.sleep(4.0)
    assert time.monotonic() - began < 3.5
    assert interrupt.exit_code == 143
