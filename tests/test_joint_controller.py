"""The parts of a joint node alone: bus life without a joint, cycle inputs, controller."""

from typing import Any

import pytest
from support.bench import PERIOD_NS, FieldNodeBench
from support.joint_bench import JointBench

from rfms_can.arm import ARMS, PUMA_260
from rfms_can.joint_nodes.controller import JointController, usable_arm
from rfms_can.joint_nodes.field_node import FieldNode, Parameters
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, ESTOP_VALUES, Wire
from rfms_can.wire.records import Config, Estop, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, NodeState, Parameter

PARAMETERS = all_parameters(PUMA_260, "corke", PERIOD_NS * 1e-9)[2]


# --- bus life -----------------------------------------------------------------------------------


class Listener:
    """A controller that does nothing but note what it is told."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def enter(self, state: NodeState) -> None:
        self.told.append(state)

    def begin_cycle(self, sync: Sync) -> None:
        self.told.append(sync.cycle)

    def lose_cycle(self) -> None:
        self.told.append("lost")


class LifeBench(FieldNodeBench[FieldNode]):
    """A field node that drives nothing."""

    def __init__(self, wire: Wire) -> None:
        self.built: list[Listener | None] = []
        self.dropped = 0
        node = FieldNode(3, wire, 3, PERIOD_NS, self.build, self.drop)
        super().__init__(node, wire, {Parameter.KP: 2.0})

    def build(self, parameters: Parameters) -> Listener | None:
        self.built.append(Listener() if parameters[Parameter.KP] > 0.0 else None)
        return self.built[-1]

    def drop(self) -> None:
        self.dropped += 1


def test_a_controller_is_made_by_commit_and_told_of_states_and_cycles(wire: Wire) -> None:
    bench = LifeBench(wire)
    bench.sync(NodeState.PREOP)
    assert bench.node.controller is None
    bench.configure()
    (listener,) = bench.built
    assert listener is not None
    assert bench.node.controller is listener
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    bench.miss_syncs(1)
    assert listener.told == [NodeState.HOMING, 1, "lost"]


def test_a_refused_or_changed_configuration_leaves_no_controller(wire: Wire) -> None:
    bench = LifeBench(wire)
    bench.configure()
    bench.say(Config, 3, Parameter.KP, 0, -1.0, 0)
    assert bench.node.controller is None
    bench.parameters[Parameter.KP] = -1.0
    bench.commit()
    assert bench.built[-1] is None
    assert bench.node.controller is None
    assert bench.node.config_hash == 0


def test_torque_is_dropped_once_and_after_the_emergency_message(wire: Wire) -> None:
    bench = LifeBench(wire)
    bench.configure()
    assert [h.name for h in bench.say(Estop, None, *ESTOP_VALUES)] == ["EMCY_3"]
    bench.say(Estop, None, *ESTOP_VALUES)
    assert bench.dropped == 1


# --- what has been received ---------------------------------------------------------------------


def _setpoint(poses: int = 1, extras: int = 0) -> Setpoint:
    values = dict.fromkeys(Setpoint._fields, 0)
    return Setpoint(**{**values, "poses": poses, "extras": extras})


@pytest.mark.parametrize("poses", [1, 2])
@pytest.mark.parametrize("extras", [0, COMPLY_BELONGS, BIAS_BELONGS, COMPLY_BELONGS | BIAS_BELONGS])
def test_a_set_point_is_complete_with_all_that_belongs_to_it(poses: int, extras: int) -> None:
    inputs = CycleInputs()
    assert not inputs.setpoint_complete
    if poses == 2:
        inputs.second_setpoint = _setpoint(poses, extras)
    if extras & COMPLY_BELONGS:
        inputs.displacement = 0.0
    if extras & BIAS_BELONGS:
        inputs.bias = 0.0
    assert not inputs.setpoint_complete
    inputs.setpoint = _setpoint(poses, extras)
    assert inputs.setpoint_complete
    for part in ("second_setpoint", "displacement", "bias"):
        had = getattr(inputs, part)
        setattr(inputs, part, None)
        assert inputs.setpoint_complete is (had is None)
        setattr(inputs, part, had)


def test_a_new_cycle_forgets_the_frames_of_the_one_before() -> None:
    inputs = CycleInputs()
    inputs.setpoint, inputs.displacement, inputs.bias = _setpoint(), 0.1, 0.2
    for index in range(6):
        inputs.take_error(index, 1.0, 2.0, 3.0)
    assert inputs.heard == ALL_ERRORS
    inputs.begin(dac_due=True)
    assert inputs.dac_due
    assert inputs.heard == 0
    assert not inputs.setpoint_complete
    for part in (inputs.setpoint, inputs.displacement, inputs.bias):
        assert part is None


def test_errors_heard_before_the_start_are_not_servoed_on() -> None:
    inputs = CycleInputs()
    inputs.begin(dac_due=True)
    for index in range(6):
        inputs.take_error(index, 1.0, 2.0, 3.0)
    inputs.start()
    assert inputs.servoed
    assert not inputs.dac_due
    assert inputs.errors == inputs.rates == inputs.accelerations == [0.0] * 6


# --- the controller -----------------------------------------------------------------------------


def test_nothing_of_a_joint_exists_before_commit(wire: Wire) -> None:
    bench = JointBench(wire)
    assert bench.node.controller is None
    assert (bench.node.theta, bench.node.speed, bench.node.torque) == (0.0, 0.0, 0.0)
    bench.configure()
    for name in JointController.__slots__:
        assert hasattr(bench.controller, name), name


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
def test_a_whole_configuration_names_its_arm(arm: Any) -> None:
    for joint in range(1, 7):
        assert usable_arm(all_parameters(arm, "corke", 0.004)[joint]) is arm


@pytest.mark.parametrize("parameter", [p for p in PARAMETERS])
def test_a_configuration_that_lacks_one_parameter_is_refused(parameter: Parameter) -> None:
    assert usable_arm({p: value for p, value in PARAMETERS.items() if p is not parameter}) is None


def test_a_cycle_owes_one_dac_frame_until_it_has_gone_out(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    inputs = bench.node.inputs
    bench.sync()
    assert inputs.dac_due
    bench.setpoint()
    bench.measure()
    assert inputs.dac_due
    bench.other_errors()
    assert not inputs.dac_due
    bench.sync()
    bench.miss_syncs(1)
    assert not inputs.dac_due  # what comes now belongs to no cycle
