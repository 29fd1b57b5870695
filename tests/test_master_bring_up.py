"""From power-up to an enabled arm: who is there, what each holds, who is named when it fails."""

import pytest
from support.bench import PERIOD_NS
from support.fleet import Fleet

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.joint import JointNode
from rfms_can.master.phases import Phase
from rfms_can.master.start_up import configurator
from rfms_can.master.start_up.configurator import Configurator
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.node.protocol import Node
from rfms_can.wire.configuration import JOINT_PARAMETERS, configuration_hash
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, NODE_NAMES, PLANT
from rfms_can.wire.records import Config, ConfigAck, Heartbeat
from rfms_can.wire.vocabulary import Command, ConfigStatus, NodeState, Parameter

SERVOS = (*JOINTS, GRIPPER)


@pytest.fixture
def fleet(wire: Wire) -> Fleet:
    return Fleet(wire)


def test_the_dialogue_gives_every_node_its_parameters_in_order_and_the_hash(fleet: Fleet) -> None:
    fleet.reach(Phase.HOME)
    parameters = all_parameters(PUMA_260, "corke", PERIOD_NS * 1e-9)
    for node, field_node in zip(SERVOS, (*fleet.joints, fleet.gripper), strict=True):
        told = fleet.said(f"CONFIG_{node}")
        acks = fleet.said(f"CONFIG_ACK_{node}")
        assert [c.parameter for c in told] == [*sorted(parameters[node]), Parameter.COMMIT]
        assert [a.parameter for a in acks] == [c.parameter for c in told]
        assert {p: c.value for p, c in zip(sorted(parameters[node]), told, strict=False)} == (
            parameters[node]
        )
        assert field_node.config_hash == configuration_hash(parameters[node]) == told[-1].hash


def test_master_resets_everybody_first_and_announces_last(fleet: Fleet) -> None:
    fleet.pump.nodes.insert(0, fleet.pump.nodes.pop())  # it may be there first
    fleet.reach(Phase.CONFIGURE)
    assert [nmt.command for nmt in fleet.said("NMT")] == [Command.RESET, Command.ANNOUNCE]


def test_homing_ends_when_all_know_where_they_are(fleet: Fleet) -> None:
    fleet.reach(Phase.READY)
    assert {node.state for node in (*fleet.joints, fleet.gripper)} == {NodeState.READY}
    for zero, joint in zip(fleet.master.arm_state.zero_counts, fleet.joints, strict=True):
        assert joint.controller is not None
        assert joint.controller.sensing.encoder.zero_counts == zero
    counts = [drive.counts_per_radian for drive in PUMA_260.drives]
    truth = fleet.plant.physics.true_q
    for measured, true, per_rad in zip(fleet.master.arm_state.q, truth, counts, strict=True):
        assert abs((measured - true) * per_rad) <= 0.51


def test_nothing_is_enabled_without_being_asked(fleet: Fleet) -> None:
    fleet.reach(Phase.READY)
    fleet.run(30)
    assert Command.START not in {nmt.command for nmt in fleet.said("NMT")}
    assert all(fleet.master.arm_state.braked)


# --- lost frames -------------------------------------------------------------------------------


class LoseOnce:
    """Loses the first so many frames of some identifiers, wherever they go."""

    def __init__(self, identifiers: set[int], count: int = 1) -> None:
        self.identifiers = identifiers
        self.left = count

    def __call__(self, frame: Frame, _: Node) -> bool:
        if frame.id not in self.identifiers or not self.left:
            return False
        self.left -= 1
        return True


@pytest.mark.parametrize(
    ("record", "node"),
    [(Heartbeat, 3), (Heartbeat, PLANT), (Config, 2), (ConfigAck, 2), (ConfigAck, GRIPPER)],
)
@pytest.mark.parametrize("count", [1, 3])
def test_lost_frames_of_bring_up_are_asked_for_again(
    fleet: Fleet, record: type[Heartbeat], node: int, count: int
) -> None:
    fate = LoseOnce({fleet.id(record, node)}, count)
    fleet.pump.lose(fate)
    fleet.enable()
    assert fate.left == 0
    assert fleet.master.fault is None


def test_the_last_acknowledgement_may_get_lost_too(fleet: Fleet) -> None:
    commits = []

    def lose_first_commit_ack(frame: Frame, _: Node) -> bool:
        if frame.id != fleet.id(ConfigAck, 5):
            return False
        if fleet.reader.read(frame).values.parameter == Parameter.COMMIT:
            commits.append(frame)
        return len(commits) == 1

    fleet.pump.lose(lose_first_commit_ack)
    fleet.reach(Phase.READY)
    assert len(commits) == 2


def test_repeated_acknowledgements_skip_no_parameter(fleet: Fleet) -> None:
    acks = {fleet.id(ConfigAck, node) for node in SERVOS}
    fleet.pump.repeat(lambda frame, node: frame.id in acks and node is fleet.master)
    fleet.reach(Phase.READY)
    assert len(fleet.said("CONFIG_1")) == len(Parameter)


def test_an_acknowledgement_that_comes_again_skips_no_parameter(wire: Wire) -> None:
    """A CONFIG sent twice, because its answer took long, is answered twice."""
    dialogue = Configurator(3, {Parameter.KP: 2.5, Parameter.KI: 1.5}, wire.sender(Config, 3))
    taken = ConfigAck(Parameter.KP, ConfigStatus.TAKEN, 2.5, 0)
    following = dialogue.acknowledge(taken)
    assert following is not None
    assert dialogue.acknowledge(taken) is None
    assert dialogue.current().data[3:] == following.data[3:]  # KI still waits


# --- who is named ------------------------------------------------------------------------------


def test_absent_nodes_are_named(fleet: Fleet) -> None:
    for node in (fleet.joints[1], fleet.joints[4], fleet.plant):
        fleet.pump.nodes.remove(node)
    assert fleet.halted().startswith("not on the bus: joint 2, joint 5, plant; start them")
    assert fleet.master.next_deadline_ns() is None
    assert fleet.pump.now_ns == pytest.approx(3e9, rel=0.2)


def test_a_node_that_comes_late_is_waited_for(fleet: Fleet) -> None:
    late = fleet.joints[5]
    fleet.pump.nodes.remove(late)
    fleet.pump.run_until(lambda: fleet.pump.now_ns >= 2_000_000_000)
    assert fleet.master.phase is Phase.ROLL_CALL
    fleet.pump.nodes.append(late)
    fleet.reach(Phase.READY)


def test_a_node_that_does_not_answer_its_configuration_is_named(fleet: Fleet) -> None:
    fleet.pump.lose(lambda frame, _: frame.id == fleet.id(Config, 4))
    assert fleet.halted() == "no answer to CONFIG from joint 4"


def test_a_refused_parameter_is_named_with_node_and_value(wire: Wire) -> None:
    dialogue = Configurator(3, {Parameter.KP: 2.5}, wire.sender(Config, 3))
    answer = dialogue.acknowledge(ConfigAck(Parameter.KP, ConfigStatus.REFUSED_STATE, 2.5, 0))
    assert answer is None
    assert dialogue.problem == "joint 3 refuses KP = 2.5: REFUSED_STATE"


def test_a_node_that_holds_another_configuration_is_named(wire: Wire) -> None:
    dialogue = Configurator(3, {Parameter.KP: 2.5}, wire.sender(Config, 3))
    assert dialogue.acknowledge(ConfigAck(Parameter.KP, ConfigStatus.TAKEN, 2.5, 0)) is not None
    dialogue.acknowledge(ConfigAck(Parameter.COMMIT, ConfigStatus.TAKEN, 0.0, dialogue.hash ^ 1))
    assert not dialogue.done
    assert dialogue.problem is not None
    assert f"{dialogue.hash ^ 1:#06x}" in dialogue.problem


def test_an_acknowledgement_of_another_value_is_named(wire: Wire) -> None:
    """A node that is off by a scale must not be enabled because its answer came."""
    dialogue = Configurator(3, {Parameter.KP: 2.5}, wire.sender(Config, 3))
    assert dialogue.acknowledge(ConfigAck(Parameter.KP, ConfigStatus.TAKEN, 250.0, 0)) is None
    assert dialogue.problem == "joint 3 acknowledges KP = 250, sent was 2.5"


def test_a_parameter_that_an_earlier_node_does_not_know_is_left_out(
    wire: Wire, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its default holds; the hash is that of what the node has taken."""
    needed = JOINT_PARAMETERS - {Parameter.KI}
    monkeypatch.setattr(configurator, "JOINT_PARAMETERS", needed)
    dialogue = Configurator(3, {Parameter.KP: 2.5, Parameter.KI: 1.5}, wire.sender(Config, 3))
    dialogue.acknowledge(ConfigAck(Parameter.KP, ConfigStatus.TAKEN, 2.5, 0))
    dialogue.acknowledge(ConfigAck(Parameter.KI, ConfigStatus.UNKNOWN, 1.5, 0))
    assert dialogue.problem is None
    held = configuration_hash({Parameter.KP: 2.5})
    dialogue.acknowledge(ConfigAck(Parameter.COMMIT, ConfigStatus.TAKEN, 0.0, held))
    assert dialogue.done


def test_a_parameter_every_joint_needs_must_be_known(wire: Wire) -> None:
    dialogue = Configurator(3, {Parameter.KP: 2.5}, wire.sender(Config, 3))
    assert dialogue.acknowledge(ConfigAck(Parameter.KP, ConfigStatus.UNKNOWN, 2.5, 0)) is None
    assert dialogue.problem == "joint 3 refuses KP = 2.5: UNKNOWN"


@pytest.mark.parametrize("phase", [Phase.HOME, Phase.READY])
def test_a_node_whose_heartbeat_tells_another_configuration_is_never_enabled(
    fleet: Fleet, phase: Phase
) -> None:
    """Its COMMIT was right, and it holds something else: START says which hash it is for."""
    fleet.reach(phase)
    fleet.joints[3].config_hash = 1
    assert fleet.halted().startswith("joint 4 holds configuration 0x0001, not 0x")
    assert not fleet.said("SETPOINT_1")


def test_a_node_that_is_still_enabled_refuses_and_is_named(fleet: Fleet) -> None:
    fleet.pump.run_until(lambda: fleet.joints[3].state is NodeState.PREOP)
    fleet.joints[3].state = NodeState.OPERATIONAL  # of a master that was killed a moment ago
    assert fleet.halted() == "joint 4 refuses ARM_ID = 260: REFUSED_STATE"


def test_a_node_with_another_dbc_is_named(fleet: Fleet, wire: Wire) -> None:
    other = Wire()
    other.dbc_hash ^= 0x0F00
    index = fleet.pump.nodes.index(fleet.joints[2])
    fleet.pump.nodes[index] = JointNode(3, other, 3)
    reason = fleet.halted()
    assert reason.startswith("joint 3 runs another DBC")
    assert f"{other.dbc_hash:#06x}" in reason
    assert f"{wire.dbc_hash:#06x}" in reason


@pytest.mark.parametrize("phase", [Phase.READY, Phase.RUN])
def test_a_node_that_restarts_is_named_and_stays_in_preop(
    fleet: Fleet, wire: Wire, phase: Phase
) -> None:
    fleet.reach(Phase.READY)
    if phase is Phase.RUN:
        fleet.enable()
    index = fleet.pump.nodes.index(fleet.joints[0])
    again = JointNode(1, wire, 0xB007)
    fleet.pump.nodes[index] = again
    assert fleet.halted() == ("joint 1 restarted while the bus was up (boot id 0xb007); reset")
    fleet.run(50)
    assert again.state is NodeState.PREOP
    assert fleet.said("DAC_1", len(fleet.pump.sent) - 200) == []


def test_a_node_that_dies_while_the_arm_is_ready_is_missed_by_its_heartbeat(fleet: Fleet) -> None:
    fleet.reach(Phase.READY)
    fleet.pump.nodes.remove(fleet.joints[3])
    assert fleet.halted() == "joint 4: no HEARTBEAT_4 for 36 cycles"


def test_stop_before_cycles_run_ends_the_master(fleet: Fleet) -> None:
    fleet.pump.nodes.remove(fleet.plant)
    fleet.pump.run_until(lambda: len(fleet.pump.sent) > 5)
    fleet.master.stop()
    fleet.pump.run_until(lambda: fleet.master.ended)
    assert fleet.master.fault is None


def test_every_node_has_a_name_of_its_own() -> None:
    assert len(set(NODE_NAMES.values())) == len(NODE_NAMES) == 17
