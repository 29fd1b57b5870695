"""Response times: the analysis against its paper, and the simulated bus against the analysis."""

import json

import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bus_nodes import Talker
from typer.testing import CliRunner

from rfms_can.bus.budget import OCCASIONAL, OTHER_ARMS, Budget, Cycle, Rows, Traffic, budget
from rfms_can.bus.schedule import Stream, load, response_times
from rfms_can.bus.simulated import SimulatedBus
from rfms_can.bus.timing import BusTiming
from rfms_can.cli.budget import budget as budget_verb
from rfms_can.errors import BusError
from rfms_can.wire.codec import load_database
from rfms_can.wire.frame import Frame

MS = 1_000_000
FD_1_5 = BusTiming(1_000_000, 5_000_000)
FD_1_8 = BusTiming(1_000_000, 8_000_000)
CLASSIC = BusTiming(1_000_000, None)
INTERMISSION_NS = 3000

SCHEDULE = [
    Stream("SYNC", 0x080, 12, 4 * MS),
    *(Stream(f"MEASURE {i}", 0x100 + i, 12, 4 * MS) for i in range(1, 7)),
    Stream("SETPOINT", 0x140, 64, 4 * MS),
    *(Stream(f"ERROR {i}", 0x200 + i, 16, 4 * MS) for i in range(1, 7)),
    *(Stream(f"DAC {i}", 0x280 + i, 8, 4 * MS) for i in range(1, 7)),
    *(Stream(f"ROWS {i}", 0x300 + i, 64, 4 * MS) for i in range(1, 7)),
    *(Stream(f"HEARTBEAT {i}", 0x700 + i, 16, 48 * MS) for i in range(1, 3)),
]


def measured_ns(first_ns: list[int], worst_case: bool, payload_byte: int = 0x55) -> dict[int, int]:
    """Longest response per identifier when each stream starts at its own time."""
    bus = SimulatedBus(FD_1_5, worst_case=worst_case)
    for stream, start_ns in zip(SCHEDULE, first_ns, strict=True):
        assert stream.period_ns is not None
        frame = Frame(stream.id, bytes([payload_byte] * stream.length))
        bus.attach(Talker(stream.name, [frame], stream.period_ns, rounds=1000, first_ns=start_ns))
    bus.run_until(120 * MS)
    return {identifier: seen.max_response_ns for identifier, seen in bus.statistics.frames.items()}


def test_frames_that_not_every_cycle_holds_are_known_to_the_budget() -> None:
    at_need = {
        message.name
        for message in load_database().messages
        if message.send_type == "event" and message.dbc.attributes["RfmsEvery"].value
    }
    others = {name for name in at_need if name.startswith(OTHER_ARMS)}
    assert at_need - others == OCCASIONAL, "list it in OCCASIONAL"


def test_the_papers_example_needs_the_second_instance_of_c() -> None:
    # Davis et al. 2007, table 1: 125 bits at 125 kbit/s; the older analysis said 3 ms for C
    timing = BusTiming(125_000, None)
    streams = [
        Stream("A", 1, 7, 2_500_000, fd=False),
        Stream("B", 2, 7, 3_500_000, fd=False),
        Stream("C", 3, 7, 3_500_000, fd=False),
    ]
    bounds = [response.response_ns for response in response_times(streams, timing)]
    assert bounds == [2_000_000, 3_000_000, 3_500_000]


def test_jitter_delays_a_stream_and_lets_it_interfere_twice() -> None:
    calm = [Stream("A", 1, 8, MS), Stream("B", 2, 8, 10 * MS)]
    late = [Stream("A", 1, 8, MS, jitter_ns=950_000), calm[1]]
    frame_ns = FD_1_5.worst_case_ns(8)
    assert [r.response_ns for r in response_times(calm, FD_1_5)] == [2 * frame_ns, 2 * frame_ns]
    assert [r.response_ns for r in response_times(late, FD_1_5)] == [
        2 * frame_ns + 950_000,
        3 * frame_ns,
    ]


def test_an_overloaded_priority_has_no_bound_and_the_ones_above_keep_theirs() -> None:
    streams = [Stream(name, i, 64, 300_000) for i, name in enumerate("ABC")]
    responses = response_times(streams, FD_1_5)
    assert load(streams, FD_1_5) > 1.0
    assert responses[0].response_ns == 2 * FD_1_5.worst_case_ns(64)
    assert responses[1].response_ns is None
    assert [response.in_time for response in responses] == [False, False, False]


def test_event_frames_block_but_do_not_interfere() -> None:
    streams = [Stream("event", 0, 64, None), Stream("A", 1, 8, MS), Stream("last", 2, 64, None)]
    _, periodic, _ = response_times(streams, FD_1_5)
    assert periodic.response_ns == FD_1_5.worst_case_ns(64) + FD_1_5.worst_case_ns(8)


@settings(max_examples=30)
@given(
    st.lists(st.integers(0, 4 * MS), min_size=len(SCHEDULE), max_size=len(SCHEDULE)),
    st.booleans(),
    st.integers(0, 255),
)
def test_no_simulated_response_exceeds_its_bound(
    first_ns: list[int], worst_case: bool, payload_byte: int
) -> None:
    measured = measured_ns(first_ns, worst_case, payload_byte)
    for response in response_times(SCHEDULE, FD_1_5):
        assert response.response_ns is not None
        assert measured[response.stream.id] <= response.response_ns - INTERMISSION_NS


def test_at_the_critical_instant_every_simulated_response_reaches_its_bound() -> None:
    for place, response in enumerate(response_times(SCHEDULE, FD_1_5)):
        # the longest less urgent frame has just started when all others are handed over
        blockers = SCHEDULE[place + 1 :]
        longest = max((s.length for s in blockers), default=0)
        blocker = next((s for s in blockers if s.length == longest), None)
        first_ns = [0 if stream is blocker else 1 for stream in SCHEDULE]
        measured = measured_ns(first_ns, worst_case=True)[response.stream.id]
        assert response.response_ns is not None
        slack_ns = response.response_ns - INTERMISSION_NS - measured
        assert 0 <= slack_ns <= 1


def of_250_hz(timing: BusTiming, **choices: Rows | Traffic | Cycle) -> Budget:
    return budget(250.0, timing, **choices)  # type: ignore[arg-type]


def test_the_budget_of_the_wire_contract() -> None:
    everything = of_250_hz(FD_1_5, cycle=Cycle.USUAL)
    assert everything.load == pytest.approx(0.64, abs=0.02)
    assert everything.max_rate_hz == pytest.approx(317, rel=0.05)
    assert of_250_hz(FD_1_5, cycle=Cycle.USUAL, rows=Rows.STAGGERED).max_rate_hz == (
        pytest.approx(480, rel=0.05)
    )
    assert of_250_hz(FD_1_8, cycle=Cycle.USUAL).max_rate_hz == pytest.approx(400, rel=0.05)
    two_buses = [
        of_250_hz(FD_1_5, cycle=Cycle.USUAL, rows=Rows.STAGGERED, traffic=traffic)
        for traffic in (Traffic.CONTROL, Traffic.PLANT)
    ]
    assert min(bus.max_rate_hz for bus in two_buses) == pytest.approx(850, rel=0.05)


def test_nodes_that_the_plant_stands_for_take_no_time() -> None:
    names = {response.stream.name for response in of_250_hz(FD_1_5).responses}
    assert {"HEARTBEAT_9", "MEASURE_3", "DAC_7", "FORCE"} <= names
    assert not {"HEARTBEAT_10", "HEARTBEAT_13", "POSITION_1", "JOINT_SETPOINT_1"} & names


def test_the_fullest_cycle_fits_the_default_rate_and_its_rows_each_cycle() -> None:
    full = of_250_hz(FD_1_5)
    assert full.in_time
    assert full.cycle_ns < 4 * MS
    usual = of_250_hz(FD_1_5, cycle=Cycle.USUAL)
    extra_ns = FD_1_5.worst_case_ns(64) + 3 * FD_1_5.worst_case_ns(32)
    assert full.load - usual.load == pytest.approx(extra_ns / (4 * MS))


def test_classic_can_cannot_carry_the_default_rate() -> None:
    classic = of_250_hz(CLASSIC, cycle=Cycle.USUAL, rows=Rows.STAGGERED)
    assert classic.load > 1.0
    assert not classic.in_time
    assert all(response.stream.length <= 8 for response in classic.responses)


def test_each_bus_of_split_traffic_carries_sync_and_no_frame_is_lost() -> None:
    names = [
        {response.stream.name for response in of_250_hz(FD_1_5, traffic=traffic).responses}
        for traffic in (Traffic.BOTH, Traffic.CONTROL, Traffic.PLANT)
    ]
    assert names[0] == names[1] | names[2]
    assert names[1] & names[2] == {"SYNC"}


def test_a_rate_that_is_none_is_refused() -> None:
    with pytest.raises(BusError, match="rate 0"):
        budget(0.0, FD_1_5)


def run_verb(*arguments: str) -> tuple[int, str]:
    app = typer.Typer()
    app.command()(budget_verb)
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.output


def test_the_verb_answers_in_json_and_its_exit_code_says_whether_it_fits() -> None:
    code, output = run_verb("--json")
    report = json.loads(output)
    assert code == 0
    assert report["in_time"] is True
    setpoint = next(frame for frame in report["frames"] if frame["frame"] == "SETPOINT_1")
    assert setpoint["wire_us"] == pytest.approx(169.6)
    assert len(report["alternatives"]) == 12
    code, output = run_verb("--json", "--rate", "1000")
    assert code == 1
    assert json.loads(output)["in_time"] is False


def test_the_verb_prints_every_frame() -> None:
    code, output = run_verb("--rows", "staggered", "--cycle", "usual")
    assert code == 0
    assert "ROWS_6" in output
    assert "classic 1 Mbit/s" in output
