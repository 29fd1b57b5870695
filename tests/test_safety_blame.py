"""Whom the master blames and with which numbers: each fault of its watches, to the word.

These are what a fault is looked for by; a wrong one leads to the wrong node.
"""

from types import SimpleNamespace
from typing import cast

import pytest

from rfms_can.bus.timing import BusTiming
from rfms_can.master.blame import blame
from rfms_can.master.corruption import Corruption, Watched
from rfms_can.master.fault import Fault
from rfms_can.master.inputs import CycleInputs
from rfms_can.master.lateness import Lateness
from rfms_can.master.own_frames import OwnFrames
from rfms_can.master.traffic import Message, Traffic
from rfms_can.messages.culprit import Culprit
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, MASTER, PLANT
from rfms_can.wire.records import Emcy, JointError, Measure, Rows, Setpoint, Sync
from rfms_can.wire.vocabulary import FaultCode

F = FaultCode
PERIOD_NS = 4_000_000
BITS = ("sampled", "told", "spoken", "sampled_before", "told_before", "spoken_before")


# --- what an EMCY halts for -----------------------------------------------------------------------


def inputs(**bits: int) -> CycleInputs:
    """Bits of the joints that the master has heard, in this cycle or the one before."""
    return cast(CycleInputs, SimpleNamespace(**{**dict.fromkeys(BITS, 0), **bits}))


def emcy(fault: int, culprit: int, frame: int = 0, value: float = 3.0, bound: float = 3.0) -> Emcy:
    return Emcy(fault, culprit, frame, value, bound, 0, 0)


ABOUT = {
    F.SYNC_MISSING: (MASTER, (Sync, None), "spoken"),
    F.SETPOINT_MISSING: (MASTER, (Setpoint, 1), "told"),
    F.MEASURE_MISSING: (PLANT, (Measure, 3), "sampled"),
    F.ERROR_MISSING: (5, (JointError, 5), "told"),
}
"""Of each fault about a frame that many hear: its sender, the frame, what is heard of it."""
SPEAKS = {
    F.SYNC_MISSING: ("other nodes have answered it", 0b000001),
    F.SETPOINT_MISSING: ("other joints have answered it", 0b100000),
    F.MEASURE_MISSING: ("the master has heard it", 0b000100),
    F.ERROR_MISSING: ("the master has heard it", 0b010000),
}
"""What speaks against joint 3, and the least of what must have been heard for it."""
NAMES = {MASTER: "master", PLANT: "plant", 5: "joint 5"}


@pytest.mark.parametrize("when", ["", "_before"])
@pytest.mark.parametrize("fault", ABOUT, ids=lambda fault: fault.name)
def test_who_misses_what_has_been_on_the_bus_does_not_hear(
    wire: Wire, fault: FaultCode, when: str
) -> None:
    sender, (record, number), heard = ABOUT[fault]
    against, bits = SPEAKS[fault]
    message = emcy(fault, sender, wire.id(record, number))
    told = blame(wire, inputs(**{heard + when: bits}), 3, message, 812)
    name = f"{record.__name__}"
    assert told.words.endswith(f"; but {against}: joint 3 does not hear"), name
    assert told.words.startswith(f"joint 3: {fault.name} (3, bound 3): ")
    assert told.culprit.sender == "joint 3"
    for others in (0, bits ^ 0b111111 if "master" in against else 0b000100):
        told = blame(wire, inputs(**{heard + when: others}), 3, message, 812)
        assert "does not hear" not in told.words
        assert told.culprit.sender == NAMES[sender]
    assert (told.culprit.cycle, told.culprit.value, told.culprit.bound) == (812, 3.0, 3.0)


def test_all_joints_are_others_to_a_node_that_is_none(wire: Wire) -> None:
    message = emcy(F.SYNC_MISSING, MASTER, wire.id(Sync))
    told = blame(wire, inputs(spoken=0b000001), GRIPPER, message, 1)
    assert told.culprit.sender == "gripper"
    measure = emcy(F.MEASURE_MISSING, PLANT, wire.id(Measure, GRIPPER))
    told = blame(wire, inputs(sampled=0b111111), GRIPPER, measure, 1)
    assert told.culprit.sender == "plant", "the master does not ask who hears the jaw's samples"


def test_who_blames_itself_is_believed(wire: Wire) -> None:
    message = emcy(F.ERROR_MISSING, 5, wire.id(JointError, 5))
    told = blame(wire, inputs(told=0b111111), 5, message, 1)
    assert told == Fault(
        "joint 5: ERROR_MISSING (3, bound 3): ERROR_5", Culprit("joint 5", "ERROR_5", 1, 3.0, 3.0)
    )


def test_who_blames_a_node_that_is_no_joint_for_an_error_is_believed(wire: Wire) -> None:
    told = blame(wire, inputs(told=0b111111), 3, emcy(F.ERROR_MISSING, PLANT), 1)
    assert told.culprit.sender == "plant"


@pytest.mark.parametrize("fault", [F.ENCODER_GLITCH, F.HOMING_FAILED, F.ROWS_MISSING])
def test_a_sample_is_the_joint_s_and_rows_are_the_master_s(wire: Wire, fault: FaultCode) -> None:
    culprit = MASTER if fault is F.ROWS_MISSING else PLANT
    frame = wire.id(Rows, 3) if fault is F.ROWS_MISSING else wire.id(Measure, 3)
    told = blame(wire, inputs(**dict.fromkeys(BITS, 0b111111)), 3, emcy(fault, culprit, frame), 9)
    assert told.culprit.sender == ("master" if fault is F.ROWS_MISSING else "joint 3")
    assert told.culprit.frame == ("ROWS_3" if fault is F.ROWS_MISSING else "MEASURE_3")


def test_a_culprit_that_is_none_is_the_sender_and_no_bound_is_none(wire: Wire) -> None:
    told = blame(wire, inputs(), 3, emcy(F.EMERGENCY_STOP, 0, 0, 0.0, 0.0), 7)
    assert told == Fault("joint 3: EMERGENCY_STOP (0)", Culprit("joint 3", "", 7, 0.0, None))


def test_an_identifier_without_a_name_is_none(wire: Wire) -> None:
    assert blame(wire, inputs(), 3, emcy(F.BAD_FRAMES, MASTER, 0x7F0), 7).culprit.frame == ""


# --- bad frames -----------------------------------------------------------------------------------


def refused(watch: Corruption, closed: int, identifier: int, missing: int = 0b11) -> Fault | None:
    watch.begin()
    watch.refused(identifier, "wrong CRC")
    return watch.end_incomplete(closed, missing, 700 + closed)


def bad_frames(every: int = 1) -> Corruption:
    return Corruption(
        {1: Watched("MEASURE_4", "plant", 0b1, every), 2: Watched("ERROR_4", "joint 4", 0b10, 1)}
    )


def test_three_bad_frames_are_told_to_the_word() -> None:
    watch = bad_frames()
    assert [refused(watch, closed, 1) for closed in (4, 6)] == [None, None]
    assert refused(watch, 13, 1) == Fault(
        "plant: 3 of the last 10 MEASURE_4 were refused (wrong CRC): is its bus, or a gateway "
        "before it, disturbed?",
        Culprit("plant", "MEASURE_4", 713, 3.0, 3.0),
    )


def test_each_message_has_its_own_count_in_its_own_time() -> None:
    watch = bad_frames()
    for closed in (0, 1):
        assert refused(watch, closed, 1) is None and refused(watch, closed, 2) is None
    watch = bad_frames(every=5)
    assert [refused(watch, closed, 1) is None for closed in (0, 20, 49)] == [True, True, False]
    watch = bad_frames(every=5)
    assert [refused(watch, closed, 1) is None for closed in (0, 20, 50)] == [True] * 3


def test_one_that_is_not_watched_counts_for_nothing() -> None:
    watch = bad_frames()
    assert [refused(watch, closed, 3) for closed in range(5)] == [None] * 5


def test_what_was_refused_before_the_arm_was_enabled_does_not_count() -> None:
    watch = bad_frames()
    refused(watch, 0, 1)
    refused(watch, 1, 1)
    watch.refused(1, "wrong CRC")
    watch.forget()
    assert watch.end_incomplete(2, 0b1, 2) is None
    assert refused(watch, 3, 1) is None and refused(watch, 4, 1) is None
    assert refused(watch, 5, 1) is not None


def test_one_that_was_answered_after_all_does_not_hide_another_that_was_not() -> None:
    watch = bad_frames()
    for closed in (0, 1, 2):
        watch.begin()
        watch.refused(1, "wrong CRC")
        watch.refused(2, "wrong CRC")
        fault = watch.end_incomplete(closed, 0b10, closed)
    assert fault is not None and fault.culprit.frame == "ERROR_4"


def test_bad_samples_behind_a_silence_are_told_to_the_word() -> None:
    watch = bad_frames()
    for closed in (3, 7):
        assert refused(watch, closed, 1) is None
    assert watch.behind("ERROR_4", 2, 9, 700) == Fault(
        "plant: 2 of the last 10 MEASURE_4 were refused, and joint 4 has not answered since (no "
        "ERROR_4 for 2 cycles)",
        Culprit("plant", "MEASURE_4", 700, 2.0, 3.0),
    )
    assert watch.behind("ERROR_4", 1, 9, 700) is None, "it has answered since"
    assert watch.behind("ERROR_4", 30, 12, 700) is not None
    assert watch.behind("ERROR_4", 30, 13, 700) is None, "one of the last ten is no row"


def test_bad_samples_of_another_joint_hide_none_of_this_one() -> None:
    watched = {n: Watched(f"MEASURE_{n}", "plant", 1 << n, 1) for n in (3, 4)}
    watch = Corruption(watched)
    for closed in (1, 2):
        watch.begin()
        for n in watched:
            watch.refused(n, "wrong CRC")
        watch.end_incomplete(closed, 0b11000, closed)
    fault = watch.behind("ERROR_4", 3, 3, 3)
    assert fault is not None and fault.culprit.frame == "MEASURE_4"


# --- traffic --------------------------------------------------------------------------------------

OURS, MORE, STRANGE, RARE = 0x201, 0x301, 0x010, 0x011
MESSAGES = {OURS: Message("ERROR_1", "joint 1", 16), MORE: Message("DAC_2", "joint 2", 8)}
PART_NS = 100_000


def traffic() -> Traffic:
    """On a bus on which every frame takes a fortieth of a cycle."""
    return Traffic(MESSAGES, lambda _: PART_NS)


def cycle(watch: Traffic, strange: int, rare: int = 0, ours: int = 0) -> Fault | None:
    for identifier, count in ((STRANGE, strange), (RARE, rare)):
        for _ in range(count):
            watch.hear_foreign(Frame(identifier, b""))
    watch.counts[OURS] += ours
    return watch.end_cycle(33, PERIOD_NS)


def test_of_several_that_babble_the_worst_is_named() -> None:
    watch = traffic()
    for _ in range(2):
        watch.counts.update({OURS: 3, MORE: 4})
        fault = watch.end_cycle(8, PERIOD_NS)
        assert watch.counts == {OURS: 0, MORE: 0}
    assert fault == Fault(
        "joint 2 babbles: 4 DAC_2 in a cycle (bound 2, 2 cycles): stop it, or look for a second "
        "one of its number",
        Culprit("joint 2", "DAC_2", 8, 4.0, 2.0),
    )


def test_one_that_babbles_now_is_not_named_for_one_that_has() -> None:
    watch = traffic()
    watch.counts.update({OURS: 3})
    watch.end_cycle(8, PERIOD_NS)
    watch.counts.update({OURS: 3, MORE: 9})
    fault = watch.end_cycle(9, PERIOD_NS)
    assert fault is not None and fault.culprit.frame == "ERROR_1"


def test_a_cycle_with_no_more_than_is_due_ends_the_row() -> None:
    watch = traffic()
    for count in (3, 2, 3, 0, 3):
        watch.counts.update({OURS: count})
        assert watch.end_cycle(8, PERIOD_NS) is None


def test_a_full_bus_with_strangers_is_told_to_the_word() -> None:
    watch = traffic()
    assert cycle(watch, 12, rare=7, ours=2) is None, "21 of 40"
    assert cycle(watch, 36, ours=2) is None, "38 of 40: the bound itself"
    fault = cycle(watch, 36, rare=2, ours=1)
    assert fault == Fault(
        "foreign frames fill the bus: identifier 0x010 takes 90% of a cycle, the load is 98% "
        "(bound 95%): no node of this bus sends it",
        Culprit("foreign", "0x010", 33, 39 / 40, 0.95),
    )
    assert cycle(traffic(), 100) is not None
    full = cycle(traffic(), 100)
    assert full is not None and full.culprit.value == 1.0


def test_half_of_a_full_bus_is_borne_for_a_cycle_and_more_is_not() -> None:
    def busy(strange: int) -> Traffic:
        watch = Traffic({**MESSAGES, **dict.fromkeys(range(20), Message("", "", 8))}, busy_ns)
        watch.counts.update(dict.fromkeys(range(20), 1))
        return watch

    def busy_ns(_: Frame) -> int:
        return PART_NS

    assert cycle(busy(20), 20) is None
    assert cycle(busy(21), 21) is not None


def test_two_full_cycles_must_be_in_a_row() -> None:
    watch = Traffic(dict.fromkeys(range(20), Message("", "", 8)), lambda _: PART_NS)

    def full(strange: int) -> Fault | None:
        watch.counts.update(dict.fromkeys(range(20), 1))
        for _ in range(strange):
            watch.hear_foreign(Frame(STRANGE, b""))
        return watch.end_cycle(1, PERIOD_NS)

    assert [full(n) is None for n in (19, 0, 19, 10, 19, 19)] == [True] * 5 + [False]
    watch.forget()
    assert [full(n) is None for n in (19, 19)] == [True, False]


def test_a_cycle_without_a_length_has_no_load() -> None:
    watch = traffic()
    watch.hear_foreign(Frame(STRANGE, b""))
    watch.counts[OURS] += 2
    assert watch.end_cycle(0, 0) is None  # nothing is divided by it


def test_frames_of_ours_are_taken_for_zeros_of_their_length() -> None:
    asked: list[Frame] = []

    def bus_time(frame: Frame) -> int:
        asked.append(frame)
        return BusTiming().exact_ns(frame)

    watch = Traffic(MESSAGES, bus_time)
    cycle(watch, 1, ours=2)
    assert asked == [Frame(STRANGE, b""), Frame(OURS, bytes(16))]


# --- own frames -----------------------------------------------------------------------------------


def test_frames_that_are_none_of_the_master_s_are_not_kept() -> None:
    own = OwnFrames(frozenset({0x80}))
    own.sent(Frame(0x123, b"\1"))
    assert own.altered == {0x80: 0}
    assert not own.confirm(Frame(0x80, b"\1"))
    assert own.confirmed == 0


def test_a_repetition_is_of_the_last_frame_alone() -> None:
    own = OwnFrames(frozenset({0x80}))
    for byte in (b"\1", b"\2"):
        own.sent(Frame(0x80, byte))
        assert own.confirm(Frame(0x80, byte))
    assert own.confirm(Frame(0x80, b"\2"))
    assert own.confirmed == 3
    assert not own.confirm(Frame(0x80, b"\1"))


# --- its own lateness -----------------------------------------------------------------------------


def late(watch: Lateness, cycle: int, periods: float) -> None:
    """SYNC of a cycle goes out so many periods after it was due."""
    watch.begin(cycle * PERIOD_NS)
    watch.confirm(round((cycle + periods) * PERIOD_NS))


def test_half_a_period_is_in_time_and_more_is_late() -> None:
    for periods, told in ((0.5, False), (0.501, True)):
        watch = Lateness(PERIOD_NS, scheduled=True)
        for k in range(3):
            assert watch.judge(k * PERIOD_NS, k) is None
            late(watch, k, periods)
        assert (watch.judge(3 * PERIOD_NS, 3) is not None) is told


def test_lateness_is_told_to_the_word() -> None:
    watch = Lateness(PERIOD_NS, scheduled=True)
    for k in range(3):
        late(watch, k, 0.75)
    tail = "its computer is too slow, or too busy, for the rate"
    assert watch.judge(round(2.75 * PERIOD_NS), 2) == Fault(
        f"master: its SYNC is 0.8 periods late (bound 0.5, for 3 cycles): {tail}",
        Culprit("master", "SYNC", 2, 0.75, 0.5),
    )
    assert watch.overslept(PERIOD_NS, 4 * PERIOD_NS, 5) == Fault(
        f"master: its SYNC is 3.0 periods late (bound 3.0, at once): {tail}",
        Culprit("master", "SYNC", 5, 3.0, 3.0),
    )


def test_a_second_confirmation_counts_for_nothing() -> None:
    watch = Lateness(PERIOD_NS, scheduled=True)
    late(watch, 0, 0.75)
    for _ in range(5):
        watch.confirm(PERIOD_NS)
    late(watch, 1, 0.75)
    assert watch.judge(2 * PERIOD_NS, 2) is None


def test_what_was_late_before_the_arm_was_enabled_is_forgotten() -> None:
    watch = Lateness(PERIOD_NS, scheduled=True)
    for k in range(2):
        late(watch, k, 0.75)
    watch.begin(2 * PERIOD_NS)
    watch.forget()
    assert watch.deadline_ns is None
    late(watch, 3, 0.75)
    assert watch.judge(4 * PERIOD_NS, 4) is None
    assert watch.deadline_ns is None
