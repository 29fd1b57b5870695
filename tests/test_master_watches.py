"""What the master sees of the bus itself: own frames, babbling, a full bus, bad frames, delay."""

from collections.abc import Callable

import pytest
from support.fleet import Fleet

from rfms_can.bus.timing import BusTiming
from rfms_can.master.corruption import MOST, WINDOW, Corruption, Watched
from rfms_can.master.lateness import LATE_AGAIN, Lateness
from rfms_can.master.own_frames import KEPT, OwnFrames
from rfms_can.master.phases import Phase
from rfms_can.master.traffic import MOST_IN_A_CYCLE, Message, Traffic
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY, MASTER
from rfms_can.wire.records import Heartbeat, JointError, Measure, Nmt, Sync
from rfms_can.wire.vocabulary import Command, NodeState

PERIOD_NS = 4_000_000


def frame(*payload: int, identifier: int = 0x80) -> Frame:
    return Frame(identifier, bytes(payload))


# --- own frames ---------------------------------------------------------------------------------


def own_frames(*sent: Frame) -> OwnFrames:
    own = OwnFrames(frozenset({0x80, 0x81}))
    for one in sent:
        own.sent(one)
    return own


def test_what_was_sent_is_confirmed_in_its_order() -> None:
    own = own_frames(frame(1), frame(2), frame(7, identifier=0x123))
    assert own.confirm(Frame(0x80, bytes((1,))))  # bit for bit, not the same object
    assert own.confirm(frame(2))
    assert (own.confirmed, own.altered) == (2, {0x80: 0, 0x81: 0})


def test_what_was_not_sent_is_foreign() -> None:
    own = own_frames(frame(1))
    assert not own.confirm(frame(1, identifier=0x81))
    assert own.confirm(frame(1))
    assert not own.confirm(frame(2))
    assert own.confirmed == 1


def test_a_repetition_by_the_bus_is_not_foreign() -> None:
    own = own_frames(frame(1))
    assert own.confirm(frame(1)) and own.confirm(frame(1))


def test_a_frame_that_never_went_out_is_passed_over() -> None:
    own = own_frames(frame(1), frame(2), frame(3))
    assert own.confirm(frame(3))
    assert own.altered[0x80] == 0
    assert not own.confirm(frame(2))


def test_an_altered_frame_is_counted_and_stands_for_the_one_that_waits() -> None:
    own = own_frames(frame(1))
    assert own.confirm(frame(9))
    assert own.altered == {0x80: 1, 0x81: 0}
    own.sent(frame(2))
    assert own.confirm(frame(2))
    assert own.altered[0x80] == 1


def test_a_foreign_frame_that_comes_before_the_own_one_shows_with_it() -> None:
    own = own_frames(frame(1))
    assert own.confirm(frame(9))
    assert not own.confirm(frame(1))


def test_frames_without_confirmation_are_forgotten() -> None:
    own = own_frames(*(frame(n) for n in range(KEPT + 1)))
    for n in range(1, KEPT + 1):
        assert own.confirm(frame(n))
    assert own.altered[0x80] == 0


# --- traffic ------------------------------------------------------------------------------------

ERROR, BEAT, STRANGE = 0x201, 0x701, 0x010
MESSAGES = {ERROR: Message("ERROR_1", "joint 1", 16), BEAT: Message("HEARTBEAT_1", "joint 1", 20)}


@pytest.fixture
def traffic() -> Traffic:
    return Traffic(MESSAGES, BusTiming().exact_ns)


def test_twice_what_is_due_is_borne_for_ever(traffic: Traffic) -> None:
    for cycle in range(50):
        traffic.counts[ERROR] += MOST_IN_A_CYCLE
        assert traffic.end_cycle(cycle, PERIOD_NS) is None


def test_one_cycle_with_more_may_be_a_repetition(traffic: Traffic) -> None:
    for cycle in range(50):
        traffic.counts[ERROR] += 3 * (cycle % 2)
        assert traffic.end_cycle(cycle, PERIOD_NS) is None


def test_who_sends_more_in_two_cycles_babbles(traffic: Traffic) -> None:
    traffic.counts[BEAT] += 3
    assert traffic.end_cycle(4, PERIOD_NS) is None
    traffic.counts[BEAT] += 5
    fault = traffic.end_cycle(5, PERIOD_NS)
    assert fault is not None
    assert fault.words.startswith("joint 1 babbles: 5 HEARTBEAT_1 in a cycle (bound 2, 2 cycles)")
    culprit = fault.culprit
    assert (culprit.sender, culprit.frame, culprit.cycle) == ("joint 1", "HEARTBEAT_1", 5)
    assert (culprit.value, culprit.bound) == (5.0, 2.0)


def test_two_messages_in_turn_are_not_one_that_babbles(traffic: Traffic) -> None:
    for cycle in range(20):
        traffic.counts[(ERROR, BEAT)[cycle % 2]] += 4
        assert traffic.end_cycle(cycle, PERIOD_NS) is None


def fill(traffic: Traffic, part: float) -> None:
    """Strangers take so much of a cycle."""
    one = frame(*bytes(64), identifier=STRANGE)
    for _ in range(round(part * PERIOD_NS / BusTiming().exact_ns(one))):
        traffic.hear_foreign(one)


def ours(traffic: Traffic, part: float) -> None:
    """Our nodes take so much of a cycle; what is too much of a message does not matter here."""
    one = BusTiming().exact_ns(Frame(ERROR, bytes(16)))
    traffic.counts[ERROR] += round(part * PERIOD_NS / one)


@pytest.mark.parametrize("part", [0.1, 0.6, 0.9])
def test_strangers_on_a_bus_with_room_are_borne(traffic: Traffic, part: float) -> None:
    for cycle in range(20):
        fill(traffic, part)
        assert traffic.end_cycle(cycle, PERIOD_NS) is None


def test_a_stranger_that_takes_most_of_a_full_bus_is_named_after_a_cycle(traffic: Traffic) -> None:
    fill(traffic, 0.85)
    ours(traffic, 0.001 + 0.13)
    fault = traffic.end_cycle(9, PERIOD_NS)
    assert fault is not None and fault.words.startswith("foreign frames fill the bus: identifier")
    assert (fault.culprit.sender, fault.culprit.frame) == ("foreign", "0x010")
    assert fault.culprit.value is not None and 0.95 < fault.culprit.value <= 1.0


def test_one_that_takes_less_of_it_after_two_in_a_row() -> None:
    traffic = Traffic({n: Message("", "", 8) for n in range(45)}, BusTiming().exact_ns)

    def cycle(stranger: float) -> bool:
        for identifier in traffic.counts:  # one of each: no one babbles
            traffic.counts[identifier] = 1
        fill(traffic, stranger)
        return traffic.end_cycle(1, PERIOD_NS) is not None

    assert not cycle(0.4)
    assert not cycle(0.0)  # no stranger: what is full is ours
    assert not cycle(0.4)
    assert cycle(0.4)


def test_without_a_bus_time_the_load_is_not_judged() -> None:
    traffic = Traffic(MESSAGES)
    fill(traffic, 2.0)
    assert traffic.end_cycle(0, PERIOD_NS) is None


def test_what_came_before_the_arm_was_enabled_is_forgotten(traffic: Traffic) -> None:
    for _ in range(2):
        traffic.counts[ERROR] += 9
        fill(traffic, 0.99)
        traffic.forget()
        assert traffic.end_cycle(0, PERIOD_NS) is None


# --- bad frames ---------------------------------------------------------------------------------


def corruption() -> Corruption:
    return Corruption(
        {
            1: Watched("ERROR_1", "joint 1", 0b1, 1),
            2: Watched("HEARTBEAT_1", "joint 1", 0b10, HEARTBEAT_EVERY),
        }
    )


def bad(watch: Corruption, closed: int, identifier: int = 1, missing: int = 0b11) -> bool:
    watch.begin()
    watch.refused(identifier, "wrong CRC")
    return watch.end_incomplete(closed, missing, closed) is not None


def test_three_bad_ones_of_the_last_ten_are_too_many() -> None:
    watch = corruption()
    assert [bad(watch, cycle) for cycle in (0, 3, WINDOW - 1)] == [False, False, True]


def test_three_of_eleven_are_borne() -> None:
    watch = corruption()
    assert not any(bad(watch, cycle) for cycle in range(0, 200, WINDOW // 2))
    assert WINDOW == 10 and MOST == 3


def test_heartbeats_are_counted_by_those_that_were_due() -> None:
    watch, every = corruption(), HEARTBEAT_EVERY
    due = [0, 5 * every, 9 * every]
    assert [bad(watch, cycle, 2) for cycle in due] == [False, False, True]


def test_bad_copies_in_a_cycle_count_once_and_not_where_a_good_one_came() -> None:
    watch = corruption()
    watch.begin()
    for _ in range(5):
        watch.refused(1, "wrong CRC")
    assert watch.end_incomplete(0, 0b1, 0) is None
    assert not any(bad(watch, cycle, missing=0b10) for cycle in range(1, 9))
    assert not bad(watch, 8)
    assert bad(watch, 9)


def test_what_is_only_missing_is_not_bad() -> None:
    watch = corruption()
    for cycle in range(50):
        watch.begin()
        assert watch.end_incomplete(cycle, 0b11, cycle) is None


def test_a_joint_that_is_silent_since_its_samples_are_bad_is_not_to_blame() -> None:
    watch = Corruption({1: Watched("MEASURE_4", "plant", 0b1, 1)})
    assert not bad(watch, 10) and not bad(watch, 13)
    fault = watch.behind("ERROR_4", 3, 15, 700)
    assert fault is not None
    assert (fault.culprit.sender, fault.culprit.frame) == ("plant", "MEASURE_4")
    assert watch.behind("ERROR_5", 3, 15, 700) is None  # another joint's
    assert watch.behind("DAC_4", 3, 15, 700) is None
    assert watch.behind("ERROR_4", 3, 17, 700) is None  # it has answered in between
    assert watch.behind("ERROR_4", 30, 40, 700) is None  # long ago


def test_one_bad_sample_does_not_explain_a_joint_s_silence() -> None:
    watch = Corruption({1: Watched("MEASURE_4", "plant", 0b1, 1)})
    assert not bad(watch, 13)
    assert watch.behind("ERROR_4", 3, 15, 700) is None


# --- its own lateness ---------------------------------------------------------------------------


def late(lateness: Lateness, cycle: int, periods: float) -> None:
    """SYNC of a cycle goes out so many periods after it was due."""
    lateness.begin(cycle * PERIOD_NS)
    lateness.confirm(round((cycle + periods) * PERIOD_NS))


def test_the_third_late_cycle_is_told_as_soon_as_it_is_late() -> None:
    lateness = Lateness(PERIOD_NS, scheduled=True)
    late(lateness, 0, 0.7)
    assert lateness.deadline_ns is None
    late(lateness, 1, 0.7)
    lateness.begin(2 * PERIOD_NS)
    deadline_ns = round((2 + LATE_AGAIN) * PERIOD_NS)
    assert lateness.deadline_ns == deadline_ns
    assert lateness.judge(deadline_ns - 1, 2) is None
    fault = lateness.judge(deadline_ns, 2)
    assert fault is not None
    assert (fault.culprit.sender, fault.culprit.frame) == ("master", "SYNC")


def test_two_late_cycles_and_one_in_time_are_forgiven() -> None:
    lateness = Lateness(PERIOD_NS, scheduled=True)
    for cycle in range(60):
        late(lateness, cycle, 0.1 if cycle % 3 == 2 else 0.9)
        assert lateness.judge((cycle + 1) * PERIOD_NS, cycle) is None


def test_what_has_not_gone_out_at_all_is_late() -> None:
    lateness = Lateness(PERIOD_NS, scheduled=True)
    for cycle in range(3):
        lateness.begin(cycle * PERIOD_NS)
    assert lateness.judge(round(2.4 * PERIOD_NS), 2) is not None


@pytest.mark.parametrize(("periods", "told"), [(2.9, False), (3.0, True), (20.0, True)])
def test_a_master_that_oversleeps_names_itself(periods: float, told: bool) -> None:
    lateness = Lateness(PERIOD_NS, scheduled=True)
    fault = lateness.overslept(0, round(periods * PERIOD_NS), 1)
    assert (fault is not None) is told


def test_without_a_schedule_nothing_is_late() -> None:
    lateness = Lateness(PERIOD_NS, scheduled=False)
    for cycle in range(9):
        late(lateness, cycle, 5.0)
    assert lateness.deadline_ns is None
    assert lateness.judge(PERIOD_NS * 100, 9) is None
    assert lateness.overslept(0, PERIOD_NS * 100, 9) is None


# --- the whole ----------------------------------------------------------------------------------


@pytest.fixture
def fleet(wire: Wire) -> Fleet:
    return Fleet(wire).enable()


FOREIGN: dict[str, Callable[[Wire], Frame]] = {
    "SYNC": lambda w: w.sender(Sync).frame(900, NodeState.OPERATIONAL, 0, w.dbc_hash, 0),
    "NMT": lambda w: w.sender(Nmt).frame(Command.STOP, 0, 0),
    "HEARTBEAT_8": lambda w: w.sender(Heartbeat, MASTER).frame(0, 0, 0, 77, w.dbc_hash, 0, 0, 0),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_a_second_master_stops_the_arm_and_is_named(fleet: Fleet, name: str) -> None:
    fleet.run(3)
    fleet.master.on_frame(FOREIGN[name](fleet.wire), fleet.pump.now_ns)
    assert fleet.master.phase is Phase.HALT
    assert fleet.master.fault == (
        f"master: a second master is on the bus, it sends {name}: stop one of them"
    )
    culprit = fleet.master.culprit
    assert culprit is not None and (culprit.sender, culprit.frame) == ("master", name)


def test_a_master_that_starts_beside_another_sends_nothing(wire: Wire) -> None:
    fleet = Fleet(wire)
    master = fleet.master
    object.__setattr__(master.settings, "listening_s", 0.1)
    master = type(master)(master.arm, wire, 5, master.settings)
    assert list(master.on_time(0)) == []
    assert master.next_deadline_ns() == 100_000_000
    assert list(master.on_frame(FOREIGN["SYNC"](wire), 50_000_000)) == []
    assert master.fault == (
        "master: another master drives this bus, it sends SYNC: stop it first, or take another bus"
    )
    assert list(master.on_time(100_000_000)) == []
    assert master.next_deadline_ns() is None


def test_one_that_hears_no_other_begins_after_it_has_listened(wire: Wire) -> None:
    fleet = Fleet(wire)
    object.__setattr__(fleet.master.settings, "listening_s", 0.1)
    master = type(fleet.master)(fleet.master.arm, wire, 5, fleet.master.settings)
    assert list(master.on_time(0)) == []
    (beat,) = master.on_time(100_000_000)
    assert beat.id == wire.id(Heartbeat, MASTER)


@pytest.mark.parametrize(
    ("record", "sender", "name"),
    [(JointError, "joint 4", "ERROR_4"), (Measure, "plant", "MEASURE_4")],
)
def test_every_third_bad_frame_halts_the_arm(
    fleet: Fleet, record: type[JointError] | type[Measure], sender: str, name: str
) -> None:
    fleet.run(3)
    wanted, seen = fleet.id(record, 4), 0
    take = fleet.master.on_frame

    def corrupted(heard: Frame, now_ns: int) -> object:
        nonlocal seen
        if heard.id == wanted:
            seen += 1
            if seen % 3 == 1:
                heard = Frame(heard.id, bytes((*heard.data[:-1], heard.data[-1] ^ 1)))
        return take(heard, now_ns)

    setattr(fleet.master, "on_frame", corrupted)  # noqa: B010
    assert fleet.halted() == (
        f"{sender}: 3 of the last 10 {name} were refused (wrong CRC): is its bus, or a gateway "
        f"before it, disturbed?"
    )
    assert seen <= 10


def test_a_joint_that_sends_its_error_ten_times_babbles(fleet: Fleet) -> None:
    fleet.run(3)
    fleet.pump.repeat(lambda heard, to: heard.id == fleet.id(JointError, 2) and to is fleet.master)
    fleet.run(5)
    assert fleet.master.fault is None  # twice is borne
    fleet.pump.heal()
    for _ in range(2):
        fleet.master.traffic.counts[fleet.id(JointError, 2)] += 9
        fleet.run(1)
    assert (fleet.master.fault or "").startswith("joint 2 babbles: 10 ERROR_2 in a cycle")
