"""Virtual time and lockstep send the same; repeated and lost frames disturb neither."""

import math
from typing import NamedTuple

import pytest
from support.fleet import Fleet

from rfms_can.arm import PUMA_260
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.settings import CLOCKS, MasterSettings
from rfms_can.master.trajectory.queue import MAX_QUEUE
from rfms_can.messages import GripperRequest
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import MESSAGES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import Dac, Heartbeat, JointError, Measure, Nmt, Rows, Setpoint

# --- clocks -----------------------------------------------------------------------------------


def stream(fleet: Fleet, cycles: int) -> dict[int, list[bytes]]:
    """Payloads by identifier, of so many cycles from START on, with a motion in them."""
    fleet.reach(Phase.READY)
    fleet.run(1)
    fleet.master.start()
    fleet.reach(Phase.RUN)
    start = fleet.id(Nmt)
    first = max(i for i, frame in enumerate(fleet.pump.sent) if frame.id == start) + 1
    fleet.run(5)
    fleet.move((0.3, -0.2, 0.2, 0.3, 0.2, -0.3), 0.6)
    fleet.master.handle(GripperRequest(True, 1.0))
    fleet.run(cycles)
    frames: dict[int, list[bytes]] = {}
    for frame in fleet.pump.sent[first:]:
        frames.setdefault(frame.id, []).append(frame.data)
    return frames


def test_the_barrier_bounds_a_cycle_only_where_it_waits_for_nodes() -> None:
    limits = {clock: MasterSettings(clock=clock, barrier_s=3.0).cycle_limit_ns for clock in Clock}
    assert limits == {
        clock: 3_000_000_000 if CLOCKS[clock].waits_for_nodes else 4_000_000 for clock in Clock
    }
    assert CLOCKS[Clock.LOCKSTEP].waits_for_nodes


def test_real_time_bounds_what_a_redefinition_plans_again(wire: Wire) -> None:
    """By the time of a plan, in the periods that nodes go on without SYNC."""
    for clock, rate_hz, most in (
        (Clock.VIRTUAL, 250.0, MAX_QUEUE),
        (Clock.LOCKSTEP, 250.0, MAX_QUEUE),
        (Clock.REALTIME, 250.0, 4),
        (Clock.REALTIME, 1000.0, 1),
    ):
        settings = MasterSettings(rate_hz=rate_hz, clock=clock)
        master = MasterNode(PUMA_260, wire, 1, settings)
        assert master.motion._waiting._most == settings.replans == most


def test_virtual_time_and_lockstep_send_the_same_frames(wire: Wire) -> None:
    virtual = stream(Fleet(wire), 200)
    lockstep = stream(Fleet(wire, Clock.LOCKSTEP), 200)
    assert set(virtual) == set(lockstep)
    for identifier, payloads in virtual.items():
        others = lockstep[identifier]
        common = min(len(payloads), len(others))
        assert common > 0
        assert abs(len(payloads) - len(others)) <= 2  # a cycle may be under way
        assert payloads[:common] == others[:common], hex(identifier)


def test_a_lockstep_cycle_ends_with_the_last_answer_and_no_time(wire: Wire) -> None:
    fleet = Fleet(wire, Clock.LOCKSTEP).enable()
    began = fleet.pump.now_ns
    fleet.run(50)
    assert fleet.pump.now_ns == began


def test_an_expired_barrier_counts_as_a_cycle_and_names_who_is_missing(wire: Wire) -> None:
    fleet = Fleet(wire, Clock.LOCKSTEP, barrier=0.05).enable()
    lost = fleet.id(Dac, 6)
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is fleet.master)
    closed, began = fleet.master.closed, fleet.pump.now_ns
    fleet.run(1)
    assert fleet.master.closed == closed + 1
    assert fleet.pump.now_ns == began + 50_000_000
    assert fleet.master.statistics.missing == {"DAC_6": 1}


# --- lossy bus --------------------------------------------------------------------------------


def test_frames_that_come_twice_change_nothing(wire: Wire) -> None:
    once, twice = Fleet(wire), Fleet(wire)
    twice.reach(Phase.READY)
    twice.pump.repeat(lambda _frame, _to: True)
    expected, got = stream(once, 100), stream(twice, 100)
    for identifier in set(expected) | set(got):
        if identifier < once.id(Heartbeat, 1):  # these tell how many were discarded
            assert got[identifier] == expected[identifier], hex(identifier)
    assert twice.master.fault is None
    assert set(twice.joints[0].refused) == {Refusal.DUPLICATE}


@pytest.mark.parametrize("record", [Setpoint, Measure, JointError, Dac, Rows])
def test_a_frame_lost_now_and_then_disturbs_nothing_for_long(
    wire: Wire, record: type[NamedTuple]
) -> None:
    """Every 25th frame of a kind is lost to everybody while the arm moves: R1, and no more."""
    fleet = Fleet(wire).enable()
    codecs = [c for c in wire.codecs.values() if c.name.split("_")[0] == _kind(record)]
    identifiers, seen = {codec.id for codec in codecs}, [0]
    doomed: set[bytes] = set()

    def lose(frame: Frame, _: object) -> bool:
        if frame.id not in identifiers:
            return False
        if frame.data in doomed:
            return True
        seen[0] += 1
        if seen[0] % 251 == 0:
            doomed.add(frame.data)
            return True
        return False

    fleet.pump.lose(lose)
    fleet.move((0.5, -0.2, 0.3, 0.5, 0.3, -0.5), 0.6)
    fleet.run(250)
    assert fleet.master.fault is None
    assert doomed
    assert max(map(abs, fleet.master.inputs.errors)) < math.radians(0.3)


def _kind(record: type[NamedTuple]) -> str:
    return MESSAGES[record].split("_")[0]
