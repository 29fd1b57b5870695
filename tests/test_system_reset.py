"""The way back from a fault, as programs, clients and persons use it; never by itself."""

import asyncio
import json
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from support.command_line import Rfms
from support.link import AsyncCoreSocket, CoreSocket, status
from support.server import SECOND, Coordinator, Running, ServerBench, encode

from rfms_can.coordinator import Arm, AsyncArm, FaultError, Outcome, ProgramError, Transform
from rfms_can.coordinator.aio_remote import AsyncRemoteLink
from rfms_can.coordinator.conversation import Conversation
from rfms_can.coordinator.remote import RemoteLink
from rfms_can.errors import LeaseError, LinkError
from rfms_can.link.address import operator_endpoint
from rfms_can.link.client import send_as_operator
from rfms_can.messages import EmergencyLift, Enabled, Refusal, ResetRequest, Status, WaitRequest
from rfms_can.rig.runner import execute
from rfms_can.rig.serve import Listening
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire

pytestmark = pytest.mark.system

IDEAL = RunSettings(friction="none")
LONG_LEASE_S = 10.0


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def socket(bench: ServerBench) -> CoreSocket:
    return CoreSocket(bench, b"program")


@pytest.fixture
def arm(socket: CoreSocket) -> Arm:
    link = RemoteLink(socket, "cell", LONG_LEASE_S, now=socket.now)
    link.acquire()
    return Arm(link)


def lift(arm: Arm, name: str = "up", height: float = 0.03) -> int:
    """A move straight up; its number."""
    there = arm.transform(name, Transform.translation(0.0, 0.0, height) @ arm.pose)
    arm.position(name, arm.t6 == there)
    arm.mode(name, segment_time=1.0, acceleration_time=0.2)
    return arm.move(name, name)


# --- a program in the master's process --------------------------------------------------------


def in_process(program: Callable[[Arm, Rig], None]) -> Any:
    """How a program ended that also holds the rig."""
    rigs: list[Rig] = []
    return execute(lambda arm: program(arm, rigs[0]), IDEAL, watch=rigs.append)


def test_a_program_catches_the_fault_resets_and_goes_on() -> None:
    def program(arm: Arm, rig: Rig) -> None:
        number = lift(arm)
        arm.sleep(0.4)
        rig.master.lose("a fault")
        for use in (lambda: arm.wait(number), arm.wait, lambda: arm.move("up", "up")):
            with pytest.raises(FaultError, match="a fault"):
                use()
        assert arm.status.phase == "HALT"
        arm.reset()
        assert arm.outcome(number).how is Outcome.FAULTED
        arm.wait()
        arm.wait(arm.move("up", "up"))  # the names are still there

    outcome = in_process(program)
    assert (outcome.fault, outcome.result.fault) == (None, None)
    assert outcome.result.reset_faults == ["a fault"]


def test_a_program_that_swallows_the_fault_ends_with_it() -> None:
    def program(arm: Arm, rig: Rig) -> None:
        lift(arm)
        rig.master.lose("a fault")
        with pytest.raises(FaultError):
            arm.wait()

    assert str(in_process(program).fault) == "a fault"


def test_a_program_cannot_lift_an_emergency_stop() -> None:
    def program(arm: Arm, rig: Rig) -> None:
        rig.master.emergency_stop("emergency stop by 'door'")
        with pytest.raises(FaultError, match="an emergency stop is in force") as refused:
            arm.reset()
        assert "\n" not in str(refused.value)
        assert arm.status.emergency

    assert str(in_process(program).fault) == "emergency stop by 'door'"


def test_without_a_fault_reset_is_refused_and_nothing_moves() -> None:
    def program(arm: Arm, rig: Rig) -> None:
        before = arm.status
        with pytest.raises(ProgramError, match=r"reset in phase RUN: .*: go on"):
            arm.reset()
        assert arm.status == before

    assert in_process(program).fault is None


# --- over the link -----------------------------------------------------------------------------


def test_the_holder_of_the_lease_resets(bench: ServerBench, arm: Arm) -> None:
    number = lift(arm)
    arm.sleep(0.4)
    bench.master.lose("a fault")
    with pytest.raises(FaultError, match="a fault"):
        arm.wait(number)
    other = Coordinator(bench, "other")
    assert other.refused(ResetRequest()).error == "LeaseError"
    assert bench.server.holder == "cell", "who controls a halted arm goes on controlling it"
    arm.reset()
    assert (arm.status.phase, arm.status.fault) == ("RUN", None)
    arm.wait(arm.move("up", "up"))
    assert list(bench.server.events)[-2:] == [
        "halted: a fault; reset() of its program, or rfms reset, leads back",
        "reset: the arm is called back",
    ]


def test_a_cause_that_persists_is_told_at_the_wait(bench: ServerBench, arm: Arm) -> None:
    bench.rig.bus.detach(bench.rig.bus._controllers[2])  # joint 3 has lost its plug
    with pytest.raises(FaultError, match="joint 3"):
        arm.wait(lift(arm))
    for _ in range(2):
        with pytest.raises(FaultError, match="not on the bus: joint 3; start them"):
            arm.reset()
    with pytest.raises(FaultError, match="not on the bus: joint 3"):
        arm.move("up", "up")


def test_a_halted_arm_rests_and_then_time_stands_still(bench: ServerBench, arm: Arm) -> None:
    lift(arm)
    arm.sleep(0.4)
    bench.master.lose("a fault")
    bench.run(lambda: False)
    assert not bench.server.time_may_pass
    assert max(abs(speed) for speed in bench.rig.plant.physics.model.qd) < 0.02
    assert bench.server.status().phase == "HALT"


def test_the_lease_of_a_halted_arm_lapses_and_another_may_reset(
    bench: ServerBench, arm: Arm
) -> None:
    number = lift(arm)
    arm.sleep(0.4)
    bench.master.lose("a fault")
    bench.now_ns += 11 * SECOND
    bench.hear(bench.server.look(bench.now_ns))
    other = Coordinator(bench, "other").acquire(LONG_LEASE_S)
    other.done(ResetRequest())
    assert other.ask(WaitRequest([Enabled()])) is None
    bench.run(lambda: bench.master.phase.name == "RUN")
    with pytest.raises(LeaseError, match="'cell' did not renew"):
        arm.wait(number)
    assert arm.outcome(number).how is Outcome.FAULTED


def test_the_operators_queue_takes_a_lift_and_nothing_else(bench: ServerBench) -> None:
    bench.emergency("door")
    for data in (b"", b"lift", encode({"type": "EMERGENCY", "name": "x"}), b"\x91" * 60_000):
        bench.server.operator(data)
    assert bench.server.status().refused == 4
    assert bench.server.status().emergency
    cell = Coordinator(bench, "cell")
    assert bench.give(cell.envelope(EmergencyLift("cell")))[0].refusal is not None  # type: ignore[arg-type]
    bench.server.emergency(encode(EmergencyLift("cell")))
    assert bench.server.status().emergency, "neither queue of programs lifts it"
    bench.server.operator(encode(EmergencyLift("ann")))
    assert not bench.server.status().emergency
    assert bench.server.status().phase == "HALT"
    assert "'ann' lifted the emergency stop" in bench.server.events[-1]


def test_coroutines_reset_too(bench: ServerBench, socket: CoreSocket) -> None:
    async def main() -> None:
        link = AsyncRemoteLink(AsyncCoreSocket(socket), "cell", LONG_LEASE_S, now=socket.now)
        await link.acquire()
        arm = AsyncArm(link)
        there = await arm.transform("up", Transform.translation(0.0, 0.0, 0.03) @ arm.pose)
        await arm.position("up", arm.t6 == there)
        await arm.mode("up", segment_time=1.0, acceleration_time=0.2)
        number = await arm.move("up", "up")
        await arm.sleep(0.4)
        bench.master.lose("a fault")
        with pytest.raises(FaultError, match="a fault"):
            await arm.wait(number)
        await arm.reset()
        await arm.wait(await arm.move("up", "up"))
        await link.release()

    asyncio.run(main())
    assert bench.master.fault is None


def test_a_halt_is_heard_although_no_cycle_counts(bench: ServerBench) -> None:
    conversation = Conversation("bench")

    def hear() -> Status:
        conversation.hear(msgspec.msgpack.encode(bench.server.status()), 0.0)
        return conversation.status

    before = hear()
    late = msgspec.msgpack.encode(bench.server.status())
    bench.master.lose("a fault")
    after = hear()
    assert (after.cycle, after.phase, after.fault) == (before.cycle, "HALT", "a fault")
    conversation.hear(late, 0.0)
    assert conversation.status == after, "what was told before is older, and ignored"


def test_the_time_of_a_realtime_server_stands_while_it_is_halted() -> None:
    conversation = Conversation("bench")
    issued = 0

    def hear(cycle: int, phase: str, now: float) -> None:
        nonlocal issued
        issued += 1
        told = status(cycle=cycle, time=0.004 * cycle, clock="realtime", phase=phase, issued=issued)
        conversation.hear(msgspec.msgpack.encode(told), now)

    hear(1000, "RUN", 50.0)
    hear(1000, "HALT", 50.004)
    hear(1000, "HALT", 80.0)
    assert conversation.time(80.0) == pytest.approx(4.0)
    hear(1001, "RUN", 80.1)
    assert conversation.time(80.1) == pytest.approx(4.004)


# --- rfms reset --------------------------------------------------------------------------------


@pytest.fixture
def running(runtime: Any) -> Any:
    with Running(IDEAL, Listening("rfms")) as server:
        yield server


def halt(running: Running, reason: str = "a fault") -> None:
    """A fault, as soon as the server looks."""
    assert running.serving is not None
    running.serving.session.master.lose(reason)
    running.client("looks").watch(lambda told: told.fault == reason)


def test_the_command_resets_and_gives_the_arm_back(running: Running, rfms: Rfms) -> None:
    halt(running)
    ended = rfms("reset")
    assert (ended.code, ended.out) == (0, "")
    assert ended.err == "rfms: the fault is reset (a fault); the arm is enabled and holds\n"
    halt(running, "another")
    ended = rfms("reset", "--json")
    assert json.loads(ended.out) == {"server": "rfms", "reset": "another", "phase": "RUN"}
    served = running.end()
    assert served.fault is None
    assert served.result.reset_faults == ["a fault", "another"]


def test_the_command_without_a_fault_is_one_line(running: Running, rfms: Rfms) -> None:
    assert rfms("reset").complaint.startswith("rfms: reset in phase RUN: the arm is enabled")
    running.client("cell").acquire()
    assert "the arm is controlled by 'cell'" in rfms("reset").complaint


def test_the_command_without_a_server_is_one_line(rfms: Rfms) -> None:
    for arguments in ((), ("--lift-emergency-stop",)):
        assert rfms("reset", *arguments).complaint.startswith("rfms: no server 'rfms' is running")


def test_a_lift_needs_a_terminal_and_the_servers_machine(running: Running, rfms: Rfms) -> None:
    running.client("door").emergency()
    running.client("looks").watch(lambda told: told.emergency)
    assert "standard input is no terminal" in rfms("reset", "--lift-emergency-stop").complaint
    remote = rfms("reset", "--lift-emergency-stop", "--server", "tcp://127.0.0.1:5555")
    assert "give its NAME there" in remote.complaint
    with pytest.raises(LinkError, match="on the server's machine alone"):
        operator_endpoint("tcp://127.0.0.1:5555")
    send_as_operator("rfms", encode(EmergencyLift("ann")))
    told = running.client("looks").watch(lambda told: not told.emergency)
    assert told.phase == "HALT"
    assert rfms("reset").code == 0
    assert running.end().fault is None


def test_a_refusal_keeps_its_class(bench: ServerBench, arm: Arm) -> None:
    bench.emergency("door")
    cell = Coordinator(bench, "observer")
    refusal = cell.refused(ResetRequest())
    assert isinstance(refusal, Refusal)
    assert refusal.error == "LeaseError"
    with pytest.raises(FaultError, match="an emergency stop is in force"):
        arm.reset()
