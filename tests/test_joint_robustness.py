"""Robustness: frames a joint node must refuse, and values that must not be sent."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bench import PERIOD_NS
from support.joint_bench import JointBench
from support.wire_messages import known_of

from rfms_can.joint_nodes.joint import JointNode
from rfms_can.wire.codec import load_database
from rfms_can.wire.contract import ESTOP_VALUES, MESSAGES, Wire
from rfms_can.wire.frame import FD_LENGTHS, Frame
from rfms_can.wire.protection import Refusal
from rfms_can.wire.records import Estop, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, NodeState


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


# --- frames that are not taken ----------------------------------------------------------------


def test_stale_frames_are_ignored_and_counted(bench: JointBench) -> None:
    bench.sync()
    old = bench.cycle - 1
    assert bench.setpoint(cycle=old) == []
    assert bench.measure(cycle=old) == []
    assert bench.other_errors(cycle=old) == []
    ignored = bench.node.ignored
    assert (ignored["stale SETPOINT"], ignored["stale MEASURE"]) == (1, 1)
    assert ignored["stale ERROR"] == 5
    answers = bench.setpoint() + bench.measure() + bench.other_errors()
    assert [h.name for h in answers] == ["ERROR_2", "DAC_2"]


def _state_of(node: JointNode) -> tuple[Any, ...]:
    """What a refused frame must not change."""
    return (
        *(node.state, node.cycle, node.bus_state, node.reaction, node.theta, node.speed),
        *(node.torque, dict(node.parameters), node.config_hash, dict(node.faults)),
        *(node.rows.number, node.next_deadline_ns()),
    )


@pytest.mark.parametrize("spoil", ["bit", "short", "long", "classic", "repeated", "old"])
def test_refused_frames_are_counted_and_change_nothing(
    bench: JointBench, wire: Wire, spoil: str
) -> None:
    bench.run(3)
    node = bench.node
    for record, number in _heard_messages(bench.node, wire):
        frame = _good_frame(bench, wire, record, number)
        refused, before = node.discarded, _state_of(node)
        if spoil == "bit":
            data = bytearray(frame.data)
            data[-1] ^= 0x10
            bad = [Frame(frame.id, bytes(data))]
        elif spoil == "short":
            bad = [Frame(frame.id, frame.data[:7])]
        elif spoil == "long":
            length = min((n for n in FD_LENGTHS if n > len(frame.data)), default=8)
            bad = [Frame(frame.id, frame.data[:length].ljust(length, b"\0"))]
        elif record is Estop and spoil in ("classic", "repeated", "old"):
            continue  # constant, without a counter, and taken from any adapter
        elif spoil == "classic":
            bad = [Frame(frame.id, frame.data[:8], fd=False)]
        else:  # the counter stays, or goes back by one
            bench.give(frame)
            if spoil == "old":
                bench.give(_good_frame(bench, wire, record, number))
            before, refused = _state_of(node), node.discarded
            bad = [frame]
        assert bench.give(bad[0]) == []
        assert node.discarded == refused + 1
        assert _state_of(node) == before
    reasons = {"bit": Refusal.CRC, "short": Refusal.LENGTH, "long": Refusal.LENGTH}
    reasons |= {"classic": Refusal.KIND, "repeated": Refusal.DUPLICATE, "old": Refusal.ORDER}
    allowed = {reasons[spoil], Refusal.RANGE if spoil == "bit" else reasons[spoil]}
    assert set(node.refused) <= allowed


def _good_frame(bench: JointBench, wire: Wire, record: Any, node: int | None) -> Frame:
    """A good, harmless frame of a message the node hears."""
    values = dict.fromkeys(record._fields, 0)
    if record is Estop:
        values = ESTOP_VALUES._asdict()
    elif record is Sync:
        values = {**values, "cycle": bench.cycle, "dbc_hash": wire.dbc_hash}
        values |= {"state": NodeState.OPERATIONAL, "row_set": bench.row_set}
    elif record is Setpoint:
        values["poses"] = 1
    return bench.sender(record, node).frame(*values.values())


def _heard_messages(node: JointNode, wire: Wire) -> list[tuple[Any, int | None]]:
    by_id = {
        wire.id(record, n): (record, n)
        for record, template in MESSAGES.items()
        for n in ((None,) if "{}" not in template else range(1, 10))
        if template.format(n) in wire.codecs
    }
    return [by_id[identifier] for identifier in sorted(node.accepts)]


def test_frames_nobody_sent_us_are_not_even_counted(bench: JointBench) -> None:
    assert bench.node.on_frame(Frame(0x7FF, b""), 0) == ()
    assert bench.node.discarded == 0


# --- whatever comes ---------------------------------------------------------------------------


STATES = ("boot", "preop", "homing", "ready", "operational", "quickstop", "damped", "fault")


def node_in(state: str, wire: Wire) -> JointBench:
    bench = JointBench(wire)
    if state == "boot":
        bench.node = JointNode(2, wire, 1)
    elif state in ("homing", "ready"):
        bench.configure()
        bench.command(Command.HOME)
        if state == "ready":
            bench.home()
        bench.sync(NodeState.HOMING)
    elif state != "preop":
        bench.enable()
    if state == "quickstop":
        bench.command(Command.QUICKSTOP)
    if state in ("damped", "fault"):
        bench.miss_syncs(5 if state == "damped" else 30)
    return bench


@pytest.mark.parametrize("state", STATES)
@settings(max_examples=25)
@given(data=st.data())
def test_arbitrary_bytes_never_raise_and_change_nothing(
    state: str, wire: Wire, data: st.DataObject
) -> None:
    bench = node_in(state, wire)
    before = _state_of(bench.node)
    heard = sorted(bench.node.accepts - {wire.id(Estop)})
    # two of each at the most: a third is a fault
    places = st.lists(st.integers(0, 2 * len(heard) - 1), min_size=5, max_size=5, unique=True)
    for place in data.draw(places):
        identifier = heard[place // 2]
        length = data.draw(st.sampled_from(sorted(FD_LENGTHS)))
        payload = data.draw(st.binary(min_size=length, max_size=length))
        fd = length > 8 or data.draw(st.booleans())
        assert bench.give(Frame(identifier, payload, fd)) == []
    assert _state_of(bench.node) == before


@pytest.mark.parametrize("state", STATES)
@settings(max_examples=25)
@given(data=st.data())
def test_whole_frames_with_any_values_never_raise(
    state: str, wire: Wire, data: st.DataObject
) -> None:
    """A peer that keeps every rule of the wire and none of sense."""
    bench = node_in(state, wire)
    heard = _heard_messages(bench.node, wire)
    for _ in range(data.draw(st.integers(1, 12))):
        record, number = data.draw(st.sampled_from(heard))
        values = [_any_value(data, wire, record, number, field) for field in record._fields]
        if record is Sync:
            values[record._fields.index("dbc_hash")] = data.draw(
                st.sampled_from((wire.dbc_hash, 1))
            )
        if "cycle" in record._fields and record is not Sync and data.draw(st.booleans()):
            values[record._fields.index("cycle")] = max(bench.node.cycle, 0) & 0xFF
        bench.say(record, number, *values)
        bench.now_ns += data.draw(st.sampled_from((0, PERIOD_NS, 10 * PERIOD_NS)))
        bench.let_time_pass()


def _any_value(
    data: st.DataObject, wire: Wire, record: Any, number: int | None, field: str
) -> float:
    """Any value the DBC allows, its bounds and zero above all."""
    signal = _signal(wire.codec(record, number).name, field)
    low, high = signal.minimum, signal.maximum
    known = known_of(signal)
    if known:
        chosen: float = data.draw(st.sampled_from(known))
        return chosen
    likely = st.sampled_from([low, high, min(max(0, low), high)])
    anything = (
        st.floats(low, high, width=32) if signal.is_float else st.integers(int(low), int(high))
    )
    value: float = data.draw(st.one_of(likely, anything))
    return value if signal.is_float else int(value)


def _signal(message: str, field: str) -> Any:
    return load_database().get_message_by_name(message).get_signal_by_name(field)
