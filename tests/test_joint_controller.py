"""The parts of a joint node alone: bus life without a joint, cycle inputs, controller."""

from typing import Any, Final

import pytest
from support.bench import PERIOD_NS, FieldNodeBench
from support.joint_bench import JointBench

from rfms_can.arm import ARMS, PUMA_260, Arm
from rfms_can.errors import KinematicsError
from rfms_can.joint_nodes import field_node
from rfms_can.joint_nodes.controller import JointController
from rfms_can.joint_nodes.field_node import FieldNode, Parameters
from rfms_can.joint_nodes.inputs import ALL_ERRORS, CycleInputs
from rfms_can.kinematics import JointSolver, configuration_of, direct
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.configuration import DEFAULTS, Clock
from rfms_can.wire.configuration import PARAMETERS as RANGES
from rfms_can.wire.contract import (
    BIAS_BELONGS,
    COMPLY_BELONGS,
    ESTOP_VALUES,
    JOINT_SETPOINT_BELONGS,
    Wire,
)
from rfms_can.wire.nodes import JOINTS, PLANT
from rfms_can.wire.records import Config, Estop, JointAngles, Setpoint, Sync
from rfms_can.wire.vocabulary import Command, ConfigStatus, NodeState, Parameter

PARAMETERS = all_parameters(PUMA_260, "corke", PERIOD_NS * 1e-9)[2]


# --- bus life -----------------------------------------------------------------------------------


class Listener:
    """A controller that does nothing but note what it is told."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    drives = True

    def enter(self, state: NodeState) -> None:
        self.told.append(state)

    def begin_cycle(self, sync: Sync) -> None:
        self.told.append(sync.cycle)

    def lose_cycle(self) -> None:
        self.told.append("lost")


LIFE: Final = {
    Parameter.KP: 2.0,
    Parameter.PERIOD: PERIOD_NS * 1e-9,
    Parameter.CLOCK: float(Clock.VIRTUAL),
    Parameter.BARRIER: 2.0,
    Parameter.SENSOR_SOURCE: float(PLANT),
}
"""What a node needs that drives nothing."""


class LifeBench(FieldNodeBench[FieldNode]):
    """A field node that drives nothing."""

    def __init__(self, wire: Wire) -> None:
        self.built: list[Listener] = []
        self.heard_of: Parameters = {}
        self.dropped = 0
        node = FieldNode(3, wire, 3, frozenset(LIFE), frozenset(), self.build, self.drop)
        super().__init__(node, wire, LIFE)

    def build(self, parameters: Parameters) -> Listener:
        if parameters[Parameter.KP] == 0.0:
            raise KinematicsError("an arm that this node cannot solve")
        self.heard_of = dict(parameters)
        self.built.append(Listener())
        return self.built[-1]

    def drop(self) -> None:
        self.dropped += 1


def test_a_controller_is_made_by_commit_and_told_of_states_and_cycles(wire: Wire) -> None:
    bench = LifeBench(wire)
    bench.sync(NodeState.PREOP)
    assert bench.node.controller is None
    bench.configure()
    (listener,) = bench.built
    assert bench.node.controller is listener
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    bench.miss_syncs(1)
    assert listener.told == [NodeState.HOMING, 1, "lost"]


def test_a_refused_or_changed_configuration_leaves_no_controller(wire: Wire) -> None:
    bench = LifeBench(wire)
    bench.configure()
    bench.say(Config, 3, Parameter.KP, 0, 0.0, 0)
    assert bench.node.controller is None
    bench.parameters[Parameter.KP] = 0.0
    *_, answer = bench.dialogue()
    assert answer.values.status == ConfigStatus.UNSUPPORTED
    assert len(bench.built) == 1
    assert bench.node.controller is None
    assert bench.node.config_hash == 0


def test_a_master_that_does_not_know_a_parameter_leaves_its_default(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = LifeBench(wire)
    del bench.parameters[Parameter.KP]
    assert bench.dialogue()[-1].values.status == ConfigStatus.WRONG_HASH  # it is needed
    monkeypatch.setattr(field_node, "DEFAULTS", {Parameter.KP: 3.0})
    monkeypatch.setattr(bench.node, "_needed", frozenset(bench.parameters))
    bench.configure()
    assert bench.heard_of == pytest.approx({**bench.parameters, Parameter.KP: 3.0})


@pytest.mark.parametrize("clock", Clock)
def test_the_clock_in_the_configuration_says_when_a_sync_is_overdue(
    wire: Wire, clock: Clock
) -> None:
    """In lockstep a cycle may take as long as the barrier; else it takes a period."""
    bench = LifeBench(wire)
    bench.parameters[Parameter.CLOCK] = float(clock)
    assert bench.node.next_deadline_ns() is None
    bench.configure()
    bench.sync(NodeState.READY)
    deadline_ns = bench.node.next_deadline_ns()
    assert deadline_ns is not None
    longest_s = 2.0 if clock is Clock.LOCKSTEP else 0.004
    assert deadline_ns - bench.now_ns == round(1.5e9 * longest_s)


@pytest.mark.parametrize(("source", "taken"), [(9, True), (13, True), (3, False), (12, False)])
def test_samples_may_come_from_the_plant_or_the_own_board(
    wire: Wire, source: int, taken: bool
) -> None:
    bench = LifeBench(wire)
    bench.parameters[Parameter.SENSOR_SOURCE] = float(source)
    *_, answer = bench.dialogue()
    expected = ConfigStatus.TAKEN if taken else ConfigStatus.UNSUPPORTED
    assert answer.values.status == expected
    assert (bench.node.controller is not None) == taken


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
@pytest.mark.parametrize("extras", range(8))
def test_a_set_point_is_complete_with_all_that_belongs_to_it(poses: int, extras: int) -> None:
    inputs = CycleInputs()
    assert not inputs.setpoint_complete
    if poses == 2:
        inputs.second_setpoint = _setpoint(poses, extras)
    if extras & COMPLY_BELONGS:
        inputs.displacement = 0.0
    if extras & BIAS_BELONGS:
        inputs.bias = 0.0
    if extras & JOINT_SETPOINT_BELONGS:
        inputs.joint_setpoint = JointAngles(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 1)
        inputs.second_joint_setpoint = inputs.joint_setpoint if poses == 2 else None
    assert not inputs.setpoint_complete
    inputs.setpoint = _setpoint(poses, extras)
    assert inputs.setpoint_complete
    frames = ("second_setpoint", "displacement", "bias", "joint_setpoint", "second_joint_setpoint")
    for part in frames:
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


# --- the controller -----------------------------------------------------------------------------


def test_nothing_of_a_joint_exists_before_commit(wire: Wire) -> None:
    bench = JointBench(wire)
    assert bench.node.controller is None
    assert (bench.node.theta, bench.node.speed, bench.node.torque) == (0.0, 0.0, 0.0)
    bench.configure()
    for name in JointController.__slots__:
        assert hasattr(bench.controller, name), name


@pytest.mark.parametrize("arm", ARMS.values(), ids=lambda arm: arm.name)
def test_a_node_solves_its_joint_by_the_geometry_it_was_sent(wire: Wire, arm: Arm) -> None:
    """No list of arms: the closed form of the parameters has the doubles of the arm's data."""
    q = arm.park
    pose, configuration = direct(arm, q), configuration_of(arm, q)
    for joint in JOINTS:
        bench = JointBench(wire, joint, arm)
        bench.configure()
        for solver in (bench.controller._solver, JointSolver(arm, joint)):
            solver.hold(q[3])
            assert solver.solve(pose, configuration, q[joint - 1]) == pytest.approx(q[joint - 1])
        here, there = bench.controller._solver, JointSolver(arm, joint)
        assert here.solve(pose, configuration, 0.0) == there.solve(pose, configuration, 0.0)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        (Parameter.DH_ALPHA_1, 899_999.0),
        (Parameter.DH_OFFSET_6, 1.0),
        (Parameter.DH_D_5, 1.0),
        (Parameter.DH_A_2, 0.0),
        (Parameter.KINEMATICS, 2.0),
    ],
)
def test_a_geometry_without_this_closed_form_is_not_supported(
    wire: Wire, parameter: Parameter, value: float
) -> None:
    bench = JointBench(wire, changes={parameter: value})
    *_, answer = bench.dialogue()
    assert answer.values.status == ConfigStatus.UNSUPPORTED
    assert bench.node.controller is None


def test_where_the_master_solves_a_joint_takes_the_angle_it_is_given(wire: Wire) -> None:
    """KINEMATICS 0: the pose tells nothing; the angle of JOINT_SETPOINT is the set-point."""
    bench = JointBench(wire, changes={Parameter.KINEMATICS: 0.0, Parameter.DH_ALPHA_1: 0.0})
    bench.configure()
    bench.home()
    bench.command(Command.START)
    bench.cycle = -1
    given = [*bench.q]
    given[bench.index] += 0.001
    bench.sync()
    bench.setpoint(extras=JOINT_SETPOINT_BELONGS)
    assert bench.errors(bench.measure()) == []  # its angles belong to the set-point
    angles = (*given, bench.cycle & 0xFF, 1 << bench.index)
    (error,) = bench.errors(bench.say(JointAngles, 1, *angles))
    assert error.error == pytest.approx(given[bench.index] - bench.angle(), abs=1e-6)


def test_a_joint_without_its_bit_goes_on_solving(wire: Wire) -> None:
    bench = JointBench(wire, joint=6).enable()
    bench.sync()
    bench.setpoint(extras=JOINT_SETPOINT_BELONGS)
    bench.measure()
    angles = (*(0.3,) * 6, bench.cycle & 0xFF, 1 << 3)
    (error,) = bench.errors(bench.say(JointAngles, 1, *angles))
    assert abs(error.error) < 1e-3


def test_an_angle_beyond_the_range_is_no_set_point(wire: Wire) -> None:
    bench = JointBench(wire).enable()
    for _ in range(3):
        bench.sync()
        bench.setpoint(extras=JOINT_SETPOINT_BELONGS)
        bench.measure()
        beyond = bench.parameters[Parameter.POSITION_MAX] + 0.01
        angles = (*(beyond,) * 6, bench.cycle & 0xFF, 1 << bench.index)
        assert bench.errors(bench.say(JointAngles, 1, *angles)) == []
    bench.sync()
    assert bench.state is NodeState.QUICKSTOP


@pytest.mark.parametrize("parameter", sorted(PARAMETERS.keys() - DEFAULTS.keys()))
def test_a_configuration_that_lacks_one_parameter_is_refused(
    wire: Wire, parameter: Parameter
) -> None:
    bench = JointBench(wire)
    del bench.parameters[parameter]
    *_, answer = bench.dialogue()
    assert answer.values.status == ConfigStatus.WRONG_HASH
    assert bench.node.controller is None


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_a_value_beyond_its_range_is_refused_and_changes_nothing(
    wire: Wire, parameter: Parameter
) -> None:
    bench = JointBench(wire)
    bench.configure()
    controller, digest = bench.node.controller, bench.node.config_hash
    beyond = min(2.0 * RANGES[parameter].high + 1.0, 1e9)
    if beyond > RANGES[parameter].high:
        (answer,) = bench.say(Config, bench.number, parameter, 0, beyond, 0)
        assert answer.values[:2] == (parameter, ConfigStatus.REFUSED_VALUE)
    assert bench.node.controller is controller
    assert bench.node.config_hash == digest


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
