"""The configuration dialogue, seen from a joint node."""

import pytest
from support.bench import PERIOD_NS
from support.joint_bench import JointBench

from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Config
from rfms_can.wire.vocabulary import Command, ConfigStatus, NodeState, Parameter

PERIOD = PERIOD_NS * 1e-9


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    return JointBench(wire).enable()


def test_each_parameter_is_acknowledged_with_what_was_taken(wire: Wire) -> None:
    bench = JointBench(wire)
    (answer,) = bench.say(Config, 2, Parameter.KP, 0, 0.1, 0)
    assert answer.name == "CONFIG_ACK_2"
    assert answer.values == (Parameter.KP, ConfigStatus.TAKEN, bench.wire_value(0.1), 0)


def test_unknown_parameters_are_refused_by_number(wire: Wire) -> None:
    bench = JointBench(wire)
    (answer,) = bench.say(Config, 2, 200, 0, 1.0, 0)
    assert answer.values[:2] == (200, ConfigStatus.UNKNOWN)
    assert not bench.node.parameters


@pytest.mark.parametrize("change", ["hash", "total", "missing", "value"])
def test_a_configuration_that_does_not_hold_together_is_refused(wire: Wire, change: str) -> None:
    bench = JointBench(wire)
    if change == "value":
        bench.parameters[Parameter.COUNTS_PER_UNIT] = 0.0
    if change == "missing":
        del bench.parameters[Parameter.KD]
    for parameter, value in bench.parameters.items():
        bench.say(Config, 2, parameter, 0, value, 0)
    (answer,) = bench.commit(
        total=3 if change == "total" else None, digest=7 if change == "hash" else None
    )
    assert answer.values.status == ConfigStatus.WRONG_HASH
    bench.command(Command.HOME)
    assert bench.state is NodeState.PREOP
    assert bench.node.ignored["HOME without configuration"] == 1


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        (Parameter.PERIOD, 0.0),
        (Parameter.TORQUE_LIMIT, 0.0),
        (Parameter.SPEED_LIMIT, -1.0),
        (Parameter.ACCELERATION_LIMIT, 0.0),
        (Parameter.INDEX_INTERVAL_COUNTS, 0.4),
        (Parameter.COUNTS_PER_UNIT, 0.0),
        (Parameter.TORQUE_PER_CODE, 0.0),
    ],
)
def test_scales_nothing_can_be_divided_by_are_refused(
    wire: Wire, parameter: Parameter, value: float
) -> None:
    bench = JointBench(wire, changes={parameter: value})
    for known, number in bench.parameters.items():
        bench.say(Config, 2, known, 0, number, 0)
    (answer,) = bench.commit()
    assert answer.values.status == ConfigStatus.WRONG_HASH


def test_an_enabled_joint_takes_no_configuration(bench: JointBench) -> None:
    (answer,) = bench.say(Config, 2, Parameter.KP, 0, 1.0, 0)
    assert answer.values.status == ConfigStatus.REFUSED_STATE
    assert bench.node.parameters[Parameter.KP] == bench.wire_value(bench.parameters[Parameter.KP])


def test_changed_parameters_need_a_new_hash_before_homing(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.say(Config, 2, Parameter.KP, 0, 1.0, 0)
    bench.command(Command.HOME)
    assert bench.state is NodeState.PREOP
    bench.configure()
    bench.home()


def test_start_for_another_configuration_is_ignored(wire: Wire) -> None:
    bench = JointBench(wire)
    bench.configure()
    bench.home()
    digest = bench.node.config_hash
    bench.command(Command.START, argument=digest ^ 1)
    assert bench.node.ignored["START for another configuration"] == 1
    bench.command(Command.START, argument=digest)
    assert bench.state is NodeState.OPERATIONAL
