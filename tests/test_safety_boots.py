"""Whose counters a node goes on with: a master that has started again is no echo of the old."""

from support.joint_bench import JointBench

from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Config, Heartbeat
from rfms_can.wire.vocabulary import ConfigStatus, Parameter


def beat(bench: JointBench, boot_id: int) -> None:
    bench.say(Heartbeat, MASTER, 1, 0, 0, boot_id, bench.wire.dbc_hash, 0, 0, 0)


def test_an_old_frame_is_taken_after_another_boot_and_not_after_another_heartbeat(
    wire: Wire,
) -> None:
    bench = JointBench(wire)
    period = bench.parameters[Parameter.PERIOD]
    beat(bench, 7)
    frame = bench.sender(Config, bench.number).frame(Parameter.PERIOD, 0, period, 0)
    (answer,) = bench.give(frame)
    assert answer.values.status == ConfigStatus.TAKEN
    assert bench.give(frame) == []
    beat(bench, 7)
    assert bench.give(frame) == []
    beat(bench, 8)
    assert len(bench.give(frame)) == 1
    beat(bench, 8)
    assert bench.give(frame) == []
