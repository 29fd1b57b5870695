"""The simulated bus: order, time, queues, errors; everything repeats to the nanosecond."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.bus_nodes import Listener, Responder, Talker

from rfms_can.bus.disturbance import EVERYONE, Disturbance
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame

TIMING = BusTiming(1_000_000, 5_000_000)
INTERMISSION_NS = 3000
EVERYTHING = frozenset(range(0x800))


def end_ns(frame: Frame, start_ns: int = 0) -> int:
    return start_ns + TIMING.exact_ns(frame) - INTERMISSION_NS


def test_a_frame_arrives_at_the_end_of_its_own_bit_time_where_it_is_accepted() -> None:
    bus, frame = SimulatedBus(TIMING), Frame(0x123, bytes(64))
    talker = Talker("talker", [frame], accepts=EVERYTHING - {0x123})
    listener = Listener("listener", EVERYTHING)
    deaf = Listener("deaf", frozenset({0x124}))
    for node in (talker, listener, deaf):
        bus.attach(node)
    bus.run_until(1_000_000)
    assert listener.heard == [(end_ns(frame), frame)]
    assert talker.heard == deaf.heard == []
    assert bus.statistics.busy_ns == TIMING.exact_ns(frame)
    assert bus.statistics.load(bus.now_ns) == pytest.approx(TIMING.exact_ns(frame) / 1e6)


def test_a_sender_that_accepts_its_own_identifier_hears_when_the_frame_has_gone_out() -> None:
    bus, frame = SimulatedBus(TIMING), Frame(0x123, bytes(64))
    talker = Talker("talker", [frame], accepts=EVERYTHING)
    bus.attach(talker)
    bus.run_until(1_000_000)
    assert talker.heard == [(end_ns(frame), frame)]


def test_worst_case_mode_stuffs_every_frame_fully() -> None:
    bus, listener = SimulatedBus(TIMING, worst_case=True), Listener("listener", EVERYTHING)
    bus.attach(Talker("talker", [Frame(0x123, bytes(8))]))
    bus.attach(listener)
    bus.run_until(1_000_000)
    assert listener.heard[0][0] == 56_600 - INTERMISSION_NS


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 0x7FF)), max_size=24))
def test_pending_frames_are_sent_by_identifier_whoever_sends_them(
    queued: list[tuple[int, int]],
) -> None:
    unique = {identifier: sender for sender, identifier in queued}
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    for sender in range(4):
        frames = [Frame(identifier, b"") for identifier, by in unique.items() if by == sender]
        bus.attach(Talker(f"talker {sender}", frames))
    bus.attach(listener)
    bus.run_until(10_000_000)
    assert [frame.id for _, frame in listener.heard] == sorted(unique)


def test_an_urgent_frame_waits_for_the_one_on_the_wire_and_for_nothing_else() -> None:
    slow, urgent, other = Frame(0x700, bytes(64)), Frame(0x001, b""), Frame(0x600, b"")
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    bus.attach(Talker("first", [slow]))
    bus.attach(Talker("second", [other, urgent], first_ns=1))
    bus.attach(listener)
    bus.run_until(1_000_000)
    assert [frame for _, frame in listener.heard] == [slow, urgent, other]
    start = TIMING.exact_ns(slow)
    assert listener.heard[1][0] == end_ns(urgent, start)
    assert bus.statistics.frames[0x001].max_response_ns == end_ns(urgent, start) - 1


def test_an_answer_is_handed_over_at_the_end_of_the_question_or_after_the_latency() -> None:
    question, answer = Frame(0x100, b"?"), Frame(0x200, b"!")
    times = []
    for latency_ns in (0, 50_000):
        bus, listener = SimulatedBus(TIMING), Listener("listener", frozenset({0x200}))
        bus.attach(Talker("talker", [question]))
        bus.attach(Responder("responder", {0x100: [answer]}), latency_ns=latency_ns)
        bus.attach(listener)
        bus.run_until(1_000_000)
        times.append(listener.heard[0][0])
    assert times[0] == end_ns(answer, TIMING.exact_ns(question))
    assert times[1] == end_ns(answer, end_ns(question) + 50_000)


def test_a_full_transmit_queue_refuses_and_counts() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    port = bus.attach(Talker("talker", [Frame(i, b"") for i in range(10)]), tx_capacity=4)
    bus.attach(listener)
    bus.run_until(1_000_000)
    assert (len(listener.heard), port.tx_overflow, port.pending) == (4, 6, 0)


def test_a_predicate_stops_the_run_and_an_unreachable_one_is_an_error() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    bus.attach(Talker("talker", [Frame(1, b"")], rounds=3))
    bus.attach(listener)
    bus.run_until(lambda: len(listener.heard) == 2)
    assert bus.now_ns == end_ns(Frame(1, b""), 1_000_000)
    with pytest.raises(BusError, match="no event is left at"):
        bus.run_until(lambda: len(listener.heard) == 4)


def test_a_deadline_that_does_not_move_on_is_an_error_not_a_hang() -> None:
    class Stuck(Listener):
        def next_deadline_ns(self) -> int | None:
            return 5

    bus = SimulatedBus(TIMING)
    bus.attach(Stuck("joint 3", frozenset()))
    with pytest.raises(BusError, match="joint 3: its deadline 5 ns is still due"):
        bus.run_until(10)


def test_timers_due_at_frame_ends_are_no_reason_to_suspect_a_hang() -> None:
    class Echo(Listener):  # due the instant it hears something
        due: int | None = None

        def on_frame(self, frame: Frame, now_ns: int) -> tuple[Frame, ...]:
            self.due = now_ns
            return ()

        def on_time(self, now_ns: int) -> tuple[Frame, ...]:
            self.due = None
            return ()

        def next_deadline_ns(self) -> int | None:
            return self.due

    bus = SimulatedBus(TIMING)
    bus.attach(Echo("echo", EVERYTHING))
    bus.attach(Talker("talker", [Frame(1, b"")], 100_000, 1100))
    bus.run_until(200_000_000)
    assert bus.statistics.frames[1].count == 1100


def test_observers_see_each_frame_once_with_its_sender() -> None:
    bus = SimulatedBus(TIMING)
    seen: list[tuple[int, Frame, str]] = []
    bus.observers.append(lambda time_ns, frame, sender: seen.append((time_ns, frame, sender)))
    frame = Frame(0x42, b"abc")
    bus.attach(Talker("talker", [frame]))
    bus.run_until(1_000_000)
    assert seen == [(end_ns(frame), frame, "talker")]


def test_an_error_frame_is_followed_by_a_retransmission_and_moves_the_counters() -> None:
    frame = Frame(0x42, b"abc")
    verdicts = iter([Disturbance(error_at=1.0), None])
    bus = SimulatedBus(TIMING, disturber=lambda *_: next(verdicts))
    talker, listener = Talker("talker", [frame]), Listener("listener", EVERYTHING)
    sender, receiver = bus.attach(talker), bus.attach(listener)
    bus.step()  # on_time
    bus.step()  # start of frame, up to the end of the error frame
    assert (sender.tec, receiver.rec, listener.heard) == (8, 1, [])
    bus.run_until(1_000_000)
    # the frame, 12 bits of error flags, 8 of delimiter, 3 of intermission, the frame
    restart = end_ns(frame) + 23_000
    assert listener.heard == [(end_ns(frame, restart), frame)]
    assert (sender.tec, receiver.rec, bus.statistics.error_frames) == (7, 0, 1)


def test_thirty_two_errors_end_in_bus_off_and_nothing_restarts_it() -> None:
    def against_talker(time_ns: int, frame: Frame, sender: str) -> Disturbance | None:
        return Disturbance(error_at=0.5) if sender == "talker" else None

    bus = SimulatedBus(TIMING, disturber=against_talker)
    talker = Talker(
        "talker", [Frame(0x10, b""), Frame(0x11, b"")], 50_000_000, 3, accepts=EVERYTHING
    )
    other = Talker("other", [Frame(0x20, b"")], 1_000_000, 100, accepts=EVERYTHING)
    port, witness = bus.attach(talker), bus.attach(other)
    bus.run_until(40_000_000)
    assert port.bus_off
    assert (port.tec, bus.statistics.error_frames, port.pending) == (256, 32, 0)
    heard = len(talker.heard)
    bus.run_until(200_000_000)
    assert len(talker.heard) == heard, "a bus-off node hears nothing"
    assert port.tx_overflow == 4, "two more rounds of two frames were refused"
    assert bus.statistics.frames[0x20].count == 100
    assert not witness.error_passive


def test_an_error_passive_sender_lets_less_urgent_frames_pass_before_it_tries_again() -> None:
    bus = SimulatedBus(
        TIMING, disturber=lambda _, f, __: Disturbance(error_at=0.1) if f.id == 1 else None
    )
    port = bus.attach(Talker("failing", [Frame(1, b"")]))
    bus.attach(Talker("patient", [Frame(0x700, b"")]))
    seen: list[int] = []
    bus.observers.append(lambda time_ns, frame, sender: seen.append(port.tec))
    bus.run_until(50_000_000)
    assert seen == [128], "sent at the first suspension, long before bus-off"


def test_disturbances_lose_alter_delay_and_repeat_frames() -> None:
    verdicts = {
        1: Disturbance(lost_at=frozenset({"a"})),
        2: Disturbance(data=b"broken"),
        3: Disturbance(delay_ns=500_000),
        4: Disturbance(copies=2),
        5: Disturbance(lost_at=EVERYONE),
    }
    bus = SimulatedBus(TIMING, disturber=lambda _, frame, __: verdicts[frame.id])
    a, b = Listener("a", EVERYTHING), Listener("b", EVERYTHING)
    port, _ = bus.attach(a), bus.attach(b)
    bus.attach(Talker("talker", [Frame(i, bytes([i] * 6)) for i in verdicts]))
    bus.run_until(2_000_000)
    assert [frame.id for _, frame in a.heard] == [2, 4, 4, 4, 3]
    assert [frame.id for _, frame in b.heard] == [1, 2, 4, 4, 4, 3]
    assert a.heard[0][1].data == b"broken"
    assert a.heard[-1][0] - 500_000 < a.heard[1][0], "delayed behind a later frame"
    assert port.rx_lost == 2
    assert bus.statistics.error_frames == 0


@pytest.mark.parametrize(
    "disturbance",
    [
        Disturbance(lost_at=EVERYONE),
        Disturbance(data=b"longer than it was"[:12]),
        Disturbance(data=b"", fd=False),
        Disturbance(delay_ns=500_000),
        Disturbance(copies=3),
    ],
    ids=["lost", "longer", "classic", "late", "copied"],
)
def test_what_a_sender_hears_of_its_own_frame_is_not_disturbed(disturbance: Disturbance) -> None:
    bus, frame = SimulatedBus(TIMING), Frame(0x123, b"own")
    bus.disturber = lambda *_: disturbance
    talker, listener = Talker("talker", [frame], accepts=EVERYTHING), Listener("l", EVERYTHING)
    for node in (talker, listener):
        bus.attach(node)
    bus.run_until(1_000_000)
    assert talker.heard == [(end_ns(frame), frame)]
    data = frame.data if disturbance.data is None else disturbance.data
    delivered = Frame(frame.id, data, disturbance.fd is not False)
    times = 0 if disturbance.lost_at else 1 + disturbance.copies
    assert [heard for _, heard in listener.heard] == [delivered] * times


def test_a_disturber_can_be_taken_away() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    bus.attach(Talker("talker", [Frame(1, b"x")], rounds=2))
    bus.attach(listener)
    bus.disturber = lambda *_: Disturbance(lost_at=EVERYONE)
    bus.run_until(900_000)
    bus.disturber = None
    bus.run_until(2_000_000)
    assert len(listener.heard) == 1


def test_a_controller_that_is_switched_off_neither_sends_nor_hears() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    off = bus.attach(Talker("off", [Frame(1, b"x")], rounds=3, accepts=EVERYTHING))
    bus.attach(Talker("on", [Frame(2, b"y")], rounds=3, first_ns=100_000))
    bus.attach(listener)
    bus.run_until(500_000)
    bus.switch_off(off)
    bus.run_until(5_000_000)
    assert listener.payloads == [b"x", b"y", b"y", b"y"]
    assert off.tx_overflow == 2, "its node goes on"


def test_another_node_takes_the_place_behind_a_controller() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    controller = bus.attach(Listener("node", EVERYTHING))
    bus.attach(listener)
    bus.attach(Talker("talker", [Frame(2, b"y")], rounds=2))
    bus.run_until(500_000)
    fresh = Talker("node", [Frame(1, b"x")], first_ns=600_000, accepts=EVERYTHING - {1})
    bus.exchange(controller, fresh)
    bus.run_until(3_000_000)
    assert listener.payloads == [b"y", b"x", b"y"]
    assert fresh.payloads == [b"y"], "what comes from now on"


def test_identical_emergency_stops_at_once_are_one_frame_and_both_are_sent() -> None:
    stop = Frame(0x000, b"STOP")
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    others = EVERYTHING - {0x000}
    talkers = [Talker(f"talker {i}", [stop], accepts=others) for i in range(2)]
    ports = [bus.attach(talker) for talker in talkers]
    bus.attach(listener)
    bus.run_until(1_000_000)
    assert listener.payloads == [b"STOP"]
    assert [(port.pending, port.tec) for port in ports] == [(0, 0), (0, 0)]
    assert talkers[0].heard == talkers[1].heard == []


def test_different_frames_of_one_identifier_collide_until_the_loser_is_error_passive() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    recessive = bus.attach(Talker("recessive", [Frame(0x80, b"\xff")]))
    dominant = bus.attach(Talker("dominant", [Frame(0x80, b"\x00")]))
    bus.attach(listener)
    bus.run_until(10_000_000)
    assert listener.payloads == [b"\x00", b"\xff"], "the dominant payload gets through first"
    assert bus.statistics.collisions == 16, "16 x 8 = 128: error-passive"
    assert (recessive.pending, dominant.pending) == (0, 0)
    assert (recessive.tec, dominant.tec) == (128 + 8 - 1, 128 - 1)


def test_a_node_that_keeps_losing_its_identifier_to_another_ends_bus_off() -> None:
    bus = SimulatedBus(TIMING)
    loser = Talker("loser", [Frame(0x80, b"\xff")], 10_000_000, 50, accepts=EVERYTHING)
    port = bus.attach(loser)
    winner = bus.attach(Talker("winner", [Frame(0x80, b"\x00")], 10_000_000, 50))
    bus.run_until(400_000_000)
    assert port.bus_off
    assert not winner.error_passive
    heard = len(loser.heard)
    bus.run_until(500_000_000)
    assert (len(loser.heard), port.pending) == (heard, 0)
    assert bus.statistics.collisions == 16


def test_a_detached_node_is_silent_and_unhearing_and_its_frame_ends_in_an_error() -> None:
    bus, listener = SimulatedBus(TIMING), Listener("listener", EVERYTHING)
    dying = Talker("dying", [Frame(1, bytes(64))], 1_000_000, 5, accepts=EVERYTHING)
    bus.attach(Listener("before", EVERYTHING))
    port = bus.attach(dying)
    bus.attach(listener)
    bus.attach(Talker("other", [Frame(2, b"")], 1_000_000, 3))
    bus.run_until(20_000)
    bus.detach(port)
    bus.run_until(3_000_000)
    assert [frame.id for _, frame in listener.heard] == [2, 2, 2]
    assert bus.statistics.error_frames == 1
    assert dying.heard == []


def test_two_nodes_of_one_name_are_refused() -> None:
    bus = SimulatedBus(TIMING)
    bus.attach(Listener("joint 1", EVERYTHING))
    with pytest.raises(BusError, match="joint 1"):
        bus.attach(Listener("joint 1", EVERYTHING))


def test_an_fd_frame_on_a_classic_bus_is_our_own_bug() -> None:
    bus = SimulatedBus(BusTiming(1_000_000, None))
    bus.attach(Talker("talker", [Frame(1, b"")]))
    with pytest.raises(BusError, match="classic bus"):
        bus.run_until(1_000_000)
