"""The server's core, pumped with plain functions: lease, serials, waits, clock, emergency stop."""

import math

import pytest
from support.server import SECOND, Coordinator, ServerBench, encode

from rfms_can.errors import LinkError
from rfms_can.master.phases import Phase
from rfms_can.master.server.sessions import MAX_SESSIONS
from rfms_can.messages import (
    MAX_BYTES,
    AtRest,
    CycleReached,
    JawAtRest,
    LeaseRequest,
    ModeMessage,
    MoveOver,
    MoveRequest,
    Outcome,
    OutcomeQuery,
    PositionMessage,
    Query,
    Refusal,
    StopRequest,
    TransformMessage,
    WaitRequest,
)
from rfms_can.transform import Transform
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Estop, Setpoint

HOME = Transform.identity()


def apart(one: Transform, other: Transform) -> float:
    """Distance of two origins, m."""
    return math.dist((one.px, one.py, one.pz), (other.px, other.py, other.pz))


@pytest.fixture
def bench(wire: Wire) -> ServerBench:
    return ServerBench(wire)


@pytest.fixture
def left(bench: ServerBench) -> Coordinator:
    return Coordinator(bench, "left cell")


@pytest.fixture
def right(bench: ServerBench) -> Coordinator:
    return Coordinator(bench, "right cell")


# --- the lease --------------------------------------------------------------------------------


def test_without_a_lease_nothing_is_asked_of_the_arm(left: Coordinator) -> None:
    refusal = left.refused(TransformMessage("a", HOME))
    assert refusal.error == "LeaseError"
    assert "this session does not control the arm" in refusal.reason
    assert left.query().lease is None


def test_the_second_is_refused_by_name(left: Coordinator, right: Coordinator) -> None:
    left.acquire(2.0)
    for message in (TransformMessage("a", HOME), StopRequest(), LeaseRequest("acquire", "me")):
        refusal = right.refused(message)
        assert refusal.error == "LeaseError"
        assert refusal.reason.startswith("the arm is controlled by 'left cell', for 2.00 s yet")
    assert right.refused(LeaseRequest("renew")).error == "LeaseError"
    assert right.refused(LeaseRequest("release")).error == "LeaseError"
    assert right.query().lease == "left cell"  # reading is free to all
    left.done(LeaseRequest("release"))
    right.acquire()
    assert "'right cell'" in left.refused(StopRequest()).reason


def test_whatever_the_holder_says_renews_it(
    bench: ServerBench, left: Coordinator, right: Coordinator
) -> None:
    left.acquire(1.0)
    for message in (Query(), LeaseRequest("renew"), TransformMessage("a", HOME)):
        bench.now_ns += SECOND - 1
        left.done(message)
    bench.now_ns += SECOND - 1
    right.refused(LeaseRequest("acquire", "right cell"))
    bench.now_ns += 1
    right.acquire()
    assert bench.server.events[1] == "'left cell' did not renew its lease"


def test_a_renewal_may_change_the_duration(bench: ServerBench, left: Coordinator) -> None:
    left.acquire(1.0)
    left.done(LeaseRequest("renew", duration_s=5.0))
    bench.now_ns += 4 * SECOND
    bench.hear(bench.server.look(bench.now_ns))
    assert bench.server.holder == "left cell"
    bench.now_ns += 1 * SECOND
    bench.hear(bench.server.look(bench.now_ns))
    assert bench.server.holder is None


@pytest.mark.system
def test_a_lapse_in_mid_motion_is_a_controlled_stop(bench: ServerBench, left: Coordinator) -> None:
    left.acquire(1.0)
    sequence = left.move(seconds=2.0, z=0.08)
    second = left.move("then", seconds=2.0, x=0.02)
    assert left.ask(WaitRequest([MoveOver(second)])) is None
    bench.cycles(200)
    bench.now_ns += SECOND
    bench.cycles()
    assert bench.server.holder is None
    refusal = bench.inbox[left.peer][-1].refusal
    assert refusal is not None
    assert (refusal.error, left.serial) == ("LeaseError", bench.inbox[left.peer][-1].serial)
    assert bench.server.time_may_pass, "until the arm rests"
    bench.run(lambda: False)
    status = bench.server.status()
    assert (status.at_rest, status.waiting, status.fault) == (True, 0, None)
    assert status.phase == "RUN", "a controlled stop keeps the arm enabled"
    assert status.completed == second, "both are over: a program that polls goes on"
    outcomes = left.done(OutcomeQuery(sequence, second)).outcomes
    assert [outcome.how for outcome in outcomes] == [Outcome.LAPSED, Outcome.LAPSED]
    assert outcomes[0].reason == "'left cell' did not renew its lease"
    assert bench.server.numbers().lapses == 1
    assert bench.server.events[-1].endswith("the arm is brought to rest")
    assert not bench.server.time_may_pass


@pytest.mark.system
def test_giving_the_arm_back_in_mid_motion_stops_it_too(
    bench: ServerBench, left: Coordinator
) -> None:
    left.acquire()
    left.move(seconds=2.0)
    bench.cycles(200)
    left.done(LeaseRequest("release"))
    bench.run(lambda: False)
    assert bench.server.status().at_rest
    assert bench.server.numbers().lapses == 1


@pytest.mark.system
@pytest.mark.parametrize("cycles", [60, 300])  # on its way to the belt; at rest relative to it
def test_a_lapse_stops_an_arm_that_follows_a_moving_goal(
    bench: ServerBench, left: Coordinator, cycles: int
) -> None:
    """Without further observations of the belt its prediction must not carry the arm away."""
    left.acquire()
    belt = TransformMessage(
        "belt", HOME, "reference", predict="velocity", twist=(0.0, 0.05, 0.0, 0.0, 0.0, 0.0)
    )
    left.done(belt)
    left.done(TransformMessage("object", Transform.translation(0.0, 0.0, 0.03) @ bench.t6))
    left.done(PositionMessage("on it", ["t6"], ["belt", "object"]))
    left.done(ModeMessage("swift", "cartesian", 0.2, 0.6))
    left.done(MoveRequest("on it", "swift"))
    bench.cycles(cycles)
    bench.now_ns += SECOND
    bench.cycles()
    lapsed_at = bench.t6
    bench.run(lambda: False, limit=400)
    status = bench.server.status()
    assert (status.at_rest, status.phase, status.fault) == (True, "RUN", None)
    assert apart(bench.t6, lapsed_at) < 0.05
    bench.cycles(100)
    assert not any(bench.master.motion.commanded.rate)
    assert apart(Transform(*status.t6), bench.t6) < 1e-3


def test_another_program_begins_with_empty_tables(
    bench: ServerBench, left: Coordinator, right: Coordinator
) -> None:
    left.acquire()
    left.done(TransformMessage("a", HOME))
    bench.now_ns += 2 * SECOND
    left.acquire()  # the same session after a lapse keeps its names
    world = left.done(Query("world"))
    assert world is not None
    assert world.world is not None
    assert list(world.world.transforms) == ["a"]
    left.done(LeaseRequest("release"))
    right.acquire()
    world = right.done(Query("world"))
    assert world is not None
    assert world.world is not None
    assert not world.world.transforms


# --- serial numbers ---------------------------------------------------------------------------


def test_each_request_is_processed_once(bench: ServerBench, left: Coordinator) -> None:
    left.acquire()
    sequence = left.move()
    request = left.envelope(MoveRequest("there", "there"))
    first = bench.server.receive(left.peer, request, bench.now_ns)
    waiting = bench.server.status().waiting
    for peer in (left.peer, b"after a reconnection"):
        again = bench.server.receive(peer, request, bench.now_ns)
        assert [data for _, data in again] == [data for _, data in first]
        assert [to for to, _ in again] == [peer]
    assert bench.server.status().waiting == waiting
    answer = left.done(MoveRequest("there", "there"))
    assert answer is not None
    assert answer.sequence == sequence + 2
    assert bench.server.numbers().repeated == 2


@pytest.mark.parametrize(("serial", "due"), [(2, 4), (1, 4), (5, 4), (2**63, 4)])
def test_out_of_turn_is_refused_with_what_is_expected(
    bench: ServerBench, left: Coordinator, serial: int, due: int
) -> None:
    left.acquire()
    left.done(Query())
    left.done(Query())
    (reply,) = bench.give(left.envelope(StopRequest(), serial), left.peer)
    assert reply.serial == serial
    assert reply.refusal is not None
    assert reply.refusal.error == LinkError.__name__
    assert reply.refusal.reason == f"serial {serial}: out of turn, {due} is expected"
    left.done(Query())  # and the conversation goes on


def test_an_unknown_session_begins_at_one(bench: ServerBench, left: Coordinator) -> None:
    (reply,) = bench.give(left.envelope(Query(), 7), left.peer)
    assert reply.refusal is not None
    assert "the session is not known here, 1 is expected" in reply.refusal.reason
    assert bench.server.numbers().sessions == 0


def test_a_request_that_cannot_be_read_uses_up_its_serial(
    bench: ServerBench, left: Coordinator
) -> None:
    left.acquire()
    left.serial += 1
    envelope = {"session": left.session, "serial": left.serial, "message": {"type": "DANCE"}}
    (reply,) = bench.give(encode(envelope), left.peer)
    assert reply.serial == left.serial
    assert reply.refusal is not None
    assert "DANCE" in reply.refusal.reason
    left.done(Query())


def test_sessions_are_bounded_and_the_holders_is_kept(
    bench: ServerBench, left: Coordinator
) -> None:
    left.acquire()
    others = [Coordinator(bench, f"reader {number}") for number in range(3 * MAX_SESSIONS)]
    for other in others:
        other.ask(WaitRequest([CycleReached(10**9)]))
    assert bench.server.numbers().sessions == MAX_SESSIONS
    left.done(Query())
    refusal = bench.inbox[others[0].peer][-1].refusal
    assert refusal is not None
    assert "too many sessions" in refusal.reason
    assert (
        others[0].refused(Query()).reason.endswith("the session is not known here, 1 is expected")
    )


# --- waits and the clock ----------------------------------------------------------------------


def test_what_holds_is_answered_at_once(left: Coordinator) -> None:
    left.acquire()
    held = left.done(WaitRequest([CycleReached(10**9), AtRest(), JawAtRest()])).held
    assert held  # jaw and arm have rested since homing, or the jaw alone
    assert 0 not in held


def test_a_wait_is_answered_in_its_cycle(bench: ServerBench, left: Coordinator) -> None:
    left.acquire()
    cycle = bench.server.status().cycle + 5
    assert left.ask(WaitRequest([CycleReached(cycle)])) is None
    assert bench.run(lambda: False) == 5
    reply = bench.inbox[left.peer][-1]
    assert reply.status.cycle == cycle
    assert reply.answer is not None
    assert reply.answer.held == [0]


def test_a_later_wait_takes_the_place_of_an_earlier(bench: ServerBench, left: Coordinator) -> None:
    left.acquire()
    never = WaitRequest([CycleReached(10**9)])
    assert left.ask(never) is None
    assert left.ask(never) is None
    replies = [reply for reply in bench.inbox[left.peer] if reply.serial == left.serial - 1]
    assert [reply.answer.held for reply in replies if reply.answer is not None] == [[]]
    left.done(LeaseRequest("renew"))  # beside an outstanding wait
    assert bench.server.time_may_pass


def test_the_answer_to_a_wait_can_be_asked_for_again(bench: ServerBench, left: Coordinator) -> None:
    """Also after later requests: it may have been lost while they were answered."""
    left.acquire()
    cycle = bench.server.status().cycle + 2
    wait = left.envelope(WaitRequest([CycleReached(cycle)]))
    assert bench.give(wait, left.peer) == []
    assert bench.give(wait, left.peer) == [], "it still waits, once"
    left.done(LeaseRequest("renew"))
    bench.run(lambda: False)
    answered = bench.inbox[left.peer][-1]
    assert answered.answer is not None
    assert bench.give(wait, left.peer) == [answered]
    left.done(Query())
    assert bench.give(wait, left.peer) == [answered]


def test_time_passes_only_while_the_holder_waits(
    bench: ServerBench, left: Coordinator, right: Coordinator
) -> None:
    assert not bench.server.time_may_pass, "no lease"
    right.ask(WaitRequest([CycleReached(10**9)]))
    assert not bench.server.time_may_pass, "a reader's wait lets no time pass"
    left.acquire()
    assert not bench.server.time_may_pass
    cycle = bench.server.status().cycle + 3
    left.ask(WaitRequest([CycleReached(cycle)]))
    assert bench.server.time_may_pass
    bench.run(lambda: False)
    assert bench.server.status().cycle == cycle
    assert not bench.server.time_may_pass, "from the reply to the next wait time stands still"


def test_waits_of_readers_are_answered_too(
    bench: ServerBench, left: Coordinator, right: Coordinator
) -> None:
    left.acquire()
    cycle = bench.server.status().cycle + 2
    assert right.ask(WaitRequest([CycleReached(cycle)])) is None
    left.ask(WaitRequest([CycleReached(cycle + 2)]))
    bench.run(lambda: False)
    assert bench.inbox[right.peer][-1].status.cycle == cycle


def test_the_server_tells_who_waits_that_it_ends(bench: ServerBench, left: Coordinator) -> None:
    left.acquire()
    left.ask(WaitRequest([CycleReached(10**9)]))
    (reply,) = bench.hear(bench.server.end("the server ends: SIGTERM"))
    assert reply.refusal is not None
    assert (reply.refusal.error, reply.refusal.reason) == ("LinkError", "the server ends: SIGTERM")
    assert left.refused(StopRequest()) == Refusal("LinkError", "the server ends: SIGTERM")
    left.done(Query())


def test_the_answers_say_how_long_requests_took(bench: ServerBench, left: Coordinator) -> None:
    """A request acts in the set-point made when the cycle in progress is closed: one cycle on."""
    left.acquire(10.0)
    for number in range(60):
        bench.cycles()
        bench.steps(number)  # any moment of a cycle, which has some 35 of them
        left.done(TransformMessage("a", HOME))
    bench.cycles(2)
    answer = left.done(Query("server"))
    assert answer is not None
    assert answer.server is not None
    assert answer.server.latency_cycles == [0, 60, 0, 0]
    assert answer.server.latency_ns == []


# --- emergency stop ---------------------------------------------------------------------------


@pytest.mark.system
def test_an_emergency_stop_acts_within_one_cycle(
    bench: ServerBench, left: Coordinator, wire: Wire
) -> None:
    left.acquire()
    left.move(seconds=2.0)
    left.ask(WaitRequest([AtRest()]))
    bench.cycles(200)
    assert not bench.server.status().at_rest
    bench.frames.clear()
    (reply,) = bench.emergency("door", "opened")
    fault = "emergency stop by 'door': 'opened'"
    assert reply.refusal is not None
    assert (reply.refusal.error, reply.refusal.reason) == ("FaultError", fault)
    assert bench.master.fault == fault
    assert bench.master.phase is Phase.HALT
    bench.cycles(1)
    sent = [frame.id for frame in bench.frames]
    assert wire.id(Estop) in sent, "out before the next cycle closes"
    estop = next(frame for frame in bench.frames if frame.id == wire.id(Estop))
    assert wire.codec(Estop).unpack(estop.data) == ESTOP_VALUES
    bench.frames.clear()
    bench.cycles(125)
    assert wire.id(Setpoint, 1) not in {frame.id for frame in bench.frames}
    assert not bench.server.time_may_pass, "it rests: time stands until a reset"
    assert all(bench.master.arm_state.braked)
    assert bench.server.status().fault == fault
    assert left.refused(StopRequest()) == Refusal("FaultError", fault)
    assert left.refused(WaitRequest([AtRest()])) == Refusal("FaultError", fault)
    left.done(Query())


def test_the_first_fault_stays(bench: ServerBench) -> None:
    bench.emergency("door")
    bench.emergency("window", "later")
    assert bench.master.fault == "emergency stop by 'door'"
    assert bench.server.numbers().emergencies == 2


@pytest.mark.parametrize(
    "data", [b"", b"stop", encode({"type": "EMERGENCY"}), bytes(MAX_BYTES + 1), b"\x91" * 60_000]
)
def test_what_is_no_emergency_stop_stops_nothing(bench: ServerBench, data: bytes) -> None:
    bench.server.emergency(data)
    assert bench.master.fault is None
    assert bench.server.status().refused == 1


def test_an_emergency_stop_after_the_end_changes_nothing(wire: Wire) -> None:
    bench = ServerBench(wire)
    bench.master.stop()
    bench.rig.pump(lambda: bench.master.ended)
    bench.emergency("door")
    assert bench.master.fault is None, "it has ended: disabled and braked for good"
    assert bench.server.time_may_pass
