"""The suite itself: its table, its vectors, and that it does not lean on the nodes' code."""

import re
from collections.abc import Callable
from typing import Any

import pytest
from support.conform import the_wire

from rfms_can.arm import ARMS
from rfms_can.conform.protection import fits, sealed
from rfms_can.conform.table import CHECKS, Kind
from rfms_can.conform.talk import FENCE
from rfms_can.conform.vectors import Vectors, float32, read, set_hash
from rfms_can.kinematics import direct
from rfms_can.wire.configuration import PARAMETERS, configuration_hash
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Nmt
from rfms_can.wire.vocabulary import Command, Parameter

QUESTIONS = 53
MOVING = {"23", "52k"}


def test_every_question_has_its_checks_in_order() -> None:
    numbers = [int(re.match(r"\d+", check.id)[0]) for check in CHECKS]  # type: ignore[index]
    assert set(numbers) == set(range(1, QUESTIONS + 1))
    assert numbers == sorted(numbers)
    assert len({check.id for check in CHECKS}) == len(CHECKS)
    assert len({check.title for check in CHECKS}) == len(CHECKS)


def test_no_check_waits_and_those_of_an_axis_move_one() -> None:
    assert all(check.run is not None and not check.pending for check in CHECKS)
    assert {check.id for check in CHECKS if check.kind is Kind.AXIS} == MOVING


def test_the_testers_header_is_the_senders() -> None:
    wire = the_wire()
    sender = wire.sender(Nmt)
    codec = wire.codec(Nmt)
    assert codec.data_id is not None
    for counter in range(3):
        frame = sender.frame(Command.RESET, 0, 0)
        body = bytearray(frame.data)
        body[:3] = bytes(3)
        assert sealed(codec.id, body, counter, codec.data_id) == frame
        assert fits(frame.data, codec.data_id)
        assert not fits(frame.data, codec.data_id ^ 1)


def test_the_testers_hash_is_that_of_the_contract() -> None:
    for told in read("hashes"):
        values = {Parameter[name]: value for name, value in told["parameters"].items()}
        assert set_hash(values) == told["hash"] == configuration_hash(values)


def test_the_fence_is_a_reserved_parameter() -> None:
    assert FENCE not in {int(parameter) for parameter in Parameter}
    assert 40 <= FENCE <= 63


def test_the_ranges_are_those_of_the_contract() -> None:
    told = read("ranges")
    assert set(told) == {parameter.name for parameter in PARAMETERS}
    for parameter, known in PARAMETERS.items():
        limits = told[parameter.name]
        assert (limits["low"], limits["high"]) == (float32(known.low), float32(known.high))


def test_poses_and_angles_of_the_vectors_belong_together() -> None:
    """Direct kinematics lead from the angles back to the pose."""
    for name, poses in read("inverse").items():
        complete = [pose for pose in poses if None not in pose["angles"]]
        assert len(complete) > 40
        assert any(pose["angles"] == [None] * 6 for pose in poses)
        for pose in complete:
            found = direct(ARMS[name], pose["angles"])
            told = [*pose["o"], *pose["a"], *pose["p"]]
            got = [found.ox, found.oy, found.oz, found.ax, found.ay, found.az, *found[3::4]]
            assert got == pytest.approx(told, abs=1e-5)


def test_the_bench_has_every_parameter() -> None:
    vectors = Vectors()
    assert set(vectors.bench) == set(PARAMETERS)
    assert {arm: set(joints) for arm, joints in vectors.arms.items()} == {
        arm: set(JOINTS) for arm in ARMS
    }


def states(trace: dict[str, Any]) -> set[str]:
    return {cycle["state"] for cycle in trace["cycles"] if "state" in cycle}


SAID: dict[str, Callable[[dict[str, Any]], set[str]]] = {
    "state": states,
    "mode": lambda trace: {c["mode"] for c in trace["cycles"] if "mode" in c},
    "blend": lambda trace: {c["blend"] for c in trace["cycles"] if "blend" in c},
}


def test_golden_traces_have_every_state_mode_and_blend() -> None:
    traces = Vectors().traces("setpoints")
    said = {name: set().union(*map(of, traces)) for name, of in SAID.items()}
    assert said["state"] | {"IDLE"} == {"IDLE", "LINEAR", "PRE", "START", "BLEND"}
    assert said["mode"] | {"JOINT"} == {"JOINT", "CARTESIAN"}
    assert said["blend"] | {"CONTINUOUS"} == {"THESIS", "CONTINUOUS"}
