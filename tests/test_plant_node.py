"""The plant on the bus: when it samples, latches, brakes, and goes on by itself."""

from collections.abc import Sequence

import pytest
from support.bench import PERIOD_NS, Bench, Heard

from rfms_can.arm import PUMA_260
from rfms_can.plant.brake_watchdog import DEAF_CYCLES, SILENT_CYCLES, SPEECHLESS_CYCLES
from rfms_can.plant.node import PlantNode
from rfms_can.plant.physics import PlantPhysics
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER
from rfms_can.wire.records import Dac, Estop, Heartbeat, Measure, Nmt, Sync
from rfms_can.wire.vocabulary import DRIVEN, Command, FaultCode, NodeState


class ScriptedPhysics(PlantPhysics):
    """The real physics, and a record of what each period was run with."""

    def __init__(self) -> None:
        super().__init__(PUMA_260, "none", 250.0)
        self.periods: list[tuple[list[int], list[int], list[bool]]] = []

    def step_period(
        self,
        motor_current_codes: Sequence[int],
        force_set_point_codes: Sequence[int],
        brakes: Sequence[bool] = (False,) * 6,
    ) -> None:
        self.periods.append((list(motor_current_codes), list(force_set_point_codes), list(brakes)))
        super().step_period(motor_current_codes, force_set_point_codes, brakes)


class PlantBench(Bench[PlantNode]):
    """Speaks to a plant for the master and the nodes."""

    def __init__(self, wire: Wire) -> None:
        self.physics = ScriptedPhysics()
        super().__init__(PlantNode(self.physics, wire, 0x109, PERIOD_NS), wire)

    def dac(self, node: int, code: int, *, force: int = 0, cycle: int | None = None) -> None:
        low = (self.cycle if cycle is None else cycle) & 0xFF
        assert self.say(Dac, node, code, force, low) == []

    def dacs(self, code: int, *, force: int = 0) -> None:
        for joint in JOINTS:
            self.dac(joint, code, force=force)

    @property
    def codes(self) -> list[int]:
        """Motor-current codes of the last period."""
        return self.physics.periods[-1][0]

    @property
    def force_codes(self) -> list[int]:
        """Force-set-point codes of the last period."""
        return self.physics.periods[-1][1]

    @property
    def brakes(self) -> list[bool]:
        """Brakes of the last period."""
        return self.physics.periods[-1][2]


@pytest.fixture
def bench(wire: Wire) -> PlantBench:
    return PlantBench(wire)


def measures(answers: Sequence[Heard]) -> dict[int, Measure]:
    return {
        int(h.name.removeprefix("MEASURE_")): h.values
        for h in answers
        if h.name.startswith("MEASURE_")
    }


def braked(answers: Sequence[Heard]) -> list[bool]:
    """What MEASURE says of the six brakes."""
    return [bool(measure.braked) for node, measure in measures(answers).items() if node in JOINTS]


def test_boot_is_announced_and_time_stands_until_the_first_sync(bench: PlantBench) -> None:
    assert [heard.name for heard in bench.heard] == ["HEARTBEAT_9"]
    assert bench.node.next_deadline_ns() is None
    bench.sync()
    assert bench.physics.periods == []  # nothing was latched before
    bench.sync()
    assert len(bench.physics.periods) == 1


# --- latching ----------------------------------------------------------------------------------


def test_a_code_of_cycle_k_acts_from_sync_k_plus_1_on(bench: PlantBench) -> None:
    bench.sync()
    bench.dac(2, 100, force=7)
    bench.sync()  # the period that ends now ran without it
    assert bench.codes == [0] * 6
    bench.dac(2, 200)
    bench.sync()
    assert bench.codes == [0, 100, 0, 0, 0, 0]
    assert bench.force_codes == [0, 7, 0, 0, 0, 0]
    bench.sync()
    assert bench.codes == [0, 200, 0, 0, 0, 0]


def test_the_last_code_stays_where_none_comes(bench: PlantBench) -> None:
    bench.sync()
    bench.dacs(50)
    for _ in range(4):
        bench.sync()
    assert bench.codes == [50] * 6


def test_the_last_of_two_codes_in_a_cycle_acts(bench: PlantBench) -> None:
    bench.sync()
    bench.dac(1, 10)
    bench.dac(1, 20)
    bench.sync()
    bench.sync()
    assert bench.codes[0] == 20


def test_codes_of_another_cycle_are_ignored_and_counted(bench: PlantBench) -> None:
    bench.sync()
    bench.sync()
    bench.dac(3, 99, cycle=bench.cycle - 1)
    bench.dac(3, 98, cycle=bench.cycle + 1)
    assert bench.node.ignored["stale DAC"] == 2
    bench.sync()
    bench.sync()
    assert bench.codes == [0] * 6


def test_the_gripper_is_latched_like_a_joint(bench: PlantBench) -> None:
    before = bench.physics.jaw.opening
    bench.sync()
    bench.dac(GRIPPER, 1000)
    bench.sync()
    assert bench.physics.jaw.opening == before
    bench.sync()
    assert bench.physics.jaw.opening > before


# --- sampling ----------------------------------------------------------------------------------


def test_every_sync_is_answered_by_seven_measurements_of_that_cycle(bench: PlantBench) -> None:
    for _ in range(300):
        answers = measures(bench.sync())
        assert list(answers) == [*JOINTS, GRIPPER]
        assert {measure.cycle for measure in answers.values()} == {bench.cycle & 0xFF}


def test_samples_are_taken_at_sync_after_the_period_was_integrated(bench: PlantBench) -> None:
    bench.sync()
    bench.dac(6, 500)
    bench.sync()
    before = bench.physics.true_q[5]
    sampled = measures(bench.sync())[6].counts
    moved = bench.physics.true_q[5] - before
    per_rad = PUMA_260.drives[5].counts_per_radian
    park = PUMA_260.park[5]
    assert abs(moved * per_rad) > 1.0
    counts = round(bench.physics.true_q[5] * per_rad) - round(park * per_rad)
    assert sampled == pytest.approx(counts, abs=1)


def test_the_current_reads_back_as_latched(bench: PlantBench) -> None:
    bench.sync()
    bench.dac(4, -321)
    bench.dac(5, 10, force=80)
    bench.sync()
    answers = measures(bench.sync())
    assert answers[4].current_adc == -321
    assert answers[5].current_adc == 10 + 80 // 4


@pytest.mark.parametrize("state", NodeState)
def test_references_go_out_only_while_homing(bench: PlantBench, state: NodeState) -> None:
    names = [h.name for h in bench.sync(state) if h.name.startswith("REFERENCE_")]
    homing = [f"REFERENCE_{joint}" for joint in JOINTS]
    assert names == (homing if state is NodeState.HOMING else [])


def test_reference_tells_the_index_once_one_was_crossed(bench: PlantBench) -> None:
    (first,) = (h for h in bench.sync(NodeState.HOMING) if h.name == "REFERENCE_6")
    assert not first.values.index_valid
    for _ in range(200):
        bench.dac(6, 400)
        answers = bench.sync(NodeState.HOMING)
        (last,) = (h for h in answers if h.name == "REFERENCE_6")
        if last.values.index_valid:
            break
    assert last.values.index_valid
    assert last.values.index_counts == bench.physics.latched_index_counts(5)
    assert last.values.coarse_adc == bench.physics.coarse(5)
    assert measures(answers)[6].index_seen


# --- brakes ------------------------------------------------------------------------------------


def test_all_joints_are_braked_until_their_nodes_speak(bench: PlantBench) -> None:
    assert braked(bench.sync()) == [True] * 6
    bench.dac(5, 0)
    assert braked(bench.sync()) == [joint != 5 for joint in JOINTS]
    bench.dac(5, 0)
    bench.sync()
    assert bench.brakes == [joint != 5 for joint in JOINTS]


def test_three_silent_cycles_brake_a_joint_and_its_next_code_frees_it(bench: PlantBench) -> None:
    """While nothing is driven: joints are silent then when they please."""
    bench.sync(NodeState.READY)
    bench.dacs(0)
    bench.sync(NodeState.READY)
    history = []
    for _ in range(SILENT_CYCLES + 1):
        for joint in JOINTS[1:]:
            bench.dac(joint, 0)
        history.append(bool(measures(bench.sync(NodeState.READY))[1].braked))
    assert history == [False, False, True, True]
    assert bench.brakes == [True, False, False, False, False, False]
    bench.dacs(0)
    assert not measures(bench.sync(NodeState.READY))[1].braked
    bench.sync(NodeState.READY)
    assert bench.brakes == [False] * 6


def test_a_brake_that_closes_takes_current_and_force_set_point_away(bench: PlantBench) -> None:
    bench.sync()
    bench.dacs(50, force=60)
    for _ in range(SPEECHLESS_CYCLES + 1):
        bench.sync()
    assert (bench.codes, bench.force_codes) == ([50] * 6, [60] * 6)
    assert bench.brakes == [False] * 6
    bench.sync()
    assert (bench.codes, bench.force_codes) == ([0] * 6, [0] * 6)
    assert bench.brakes == [True] * 6


@pytest.mark.parametrize("state", NodeState)
def test_a_node_that_falls_silent_while_the_arm_is_driven_is_lost_until_reset(
    bench: PlantBench, state: NodeState
) -> None:
    bench.sync(state)
    bench.dacs(40)
    bench.sync(state)
    for _ in range(SILENT_CYCLES):
        for joint in JOINTS[:-1]:
            bench.dac(joint, 40)
        bench.sync(state)
    lost = state in DRIVEN
    for _ in range(5):
        bench.dacs(40)
        bench.sync(state)
    assert bench.brakes == [joint == 6 and lost for joint in JOINTS]
    assert bench.codes == [0 if joint == 6 and lost else 40 for joint in JOINTS]
    assert bool(bench.node.ignored["DAC of a node that was lost"]) == lost
    bench.say(Nmt, None, Command.START, 0, 0)
    bench.say(Nmt, None, Command.RESET, 6, 0)  # neither enabling nor another node's reset
    bench.dacs(40)
    bench.sync(state)
    bench.sync(state)
    assert bench.brakes == [joint == 6 and lost for joint in JOINTS]
    bench.say(Nmt, None, Command.RESET, 0, 0)
    bench.dacs(40)
    bench.sync(state)
    bench.sync(state)
    assert bench.brakes == [False] * 6


def test_joints_that_are_all_silent_are_waited_for_a_cycle_longer(bench: PlantBench) -> None:
    """They wait for one that died; on the third cycle their ladders make them speak again."""
    bench.sync(NodeState.OPERATIONAL)
    bench.dacs(40)
    for _ in range(SILENT_CYCLES + 1):
        bench.sync(NodeState.OPERATIONAL)
    for joint in JOINTS[1:]:
        bench.dac(joint, 10)
    assert braked(bench.sync(NodeState.OPERATIONAL)) == [True, *[False] * 5]
    bench.sync(NodeState.OPERATIONAL)
    assert bench.codes == [0, *[10] * 5]


@pytest.mark.parametrize("command", [Command.STOP, Command.RESET])
def test_nodes_that_are_told_to_fall_silent_are_not_lost(
    bench: PlantBench, command: Command
) -> None:
    bench.sync(NodeState.OPERATIONAL)
    bench.dacs(40)
    bench.say(Nmt, None, command, 0, 0)
    bench.miss_syncs(SPEECHLESS_CYCLES + 2)
    assert bench.brakes == [True] * 6
    bench.sync(NodeState.HOMING)
    bench.dacs(40)
    bench.sync(NodeState.HOMING)
    bench.sync(NodeState.HOMING)
    assert bench.brakes == [False] * 6


def test_silence_before_the_arm_is_enabled_does_not_count(bench: PlantBench) -> None:
    bench.sync(NodeState.HOMING)
    bench.dacs(40)
    bench.sync(NodeState.READY)
    bench.sync(NodeState.READY)
    bench.sync(NodeState.READY)
    bench.say(Nmt, None, Command.START, 0, 0)
    bench.sync(NodeState.OPERATIONAL)
    bench.sync(NodeState.OPERATIONAL)
    bench.dacs(40)
    assert braked(bench.sync(NodeState.OPERATIONAL)) == [False] * 6


def test_brakes_hold_the_arm_against_gravity_and_motor(bench: PlantBench) -> None:
    before = bench.physics.true_q
    for _ in range(100):
        bench.sync()
    assert bench.physics.true_q == pytest.approx(before, abs=1e-4)


# --- when the master fails ---------------------------------------------------------------------


def test_without_sync_the_plant_goes_on_by_its_own_clock(bench: PlantBench) -> None:
    bench.sync()
    began = bench.now_ns
    for k in range(1, 6):
        answers = measures(bench.miss_syncs(1))
        assert {m.cycle for m in answers.values()} == {k}
        assert bench.now_ns == began + PERIOD_NS * k + PERIOD_NS // 2
    assert len(bench.physics.periods) == 5


def test_nodes_may_stop_their_joints_while_the_plant_runs_free(bench: PlantBench) -> None:
    bench.sync()
    bench.miss_syncs(1)
    bench.dac(2, 77, cycle=1)
    bench.miss_syncs(1)
    bench.miss_syncs(1)
    assert bench.codes[1] == 77


def test_sync_takes_the_lead_again(bench: PlantBench) -> None:
    bench.sync()
    for _ in range(3):
        bench.miss_syncs(1)
    bench.cycle = 9
    answers = measures(bench.sync())
    assert {m.cycle for m in answers.values()} == {10}
    assert bench.node.next_deadline_ns() == bench.now_ns + PERIOD_NS * 3 // 2


def test_a_sync_of_another_dbc_moves_nothing(bench: PlantBench) -> None:
    assert bench.sync(dbc_hash=bench.wire.dbc_hash ^ 1) == []
    assert bench.node.ignored["SYNC with another DBC"] == 1
    assert bench.node.state is NodeState.PREOP


# --- commands ----------------------------------------------------------------------------------


def test_emergency_stop_brakes_whatever_the_nodes_say_until_reset(bench: PlantBench) -> None:
    bench.sync()
    bench.dacs(300, force=200)
    bench.sync()
    bench.dacs(300, force=200)
    bench.say(Estop, None, *ESTOP_VALUES)
    for _ in range(5):
        bench.dacs(300, force=200)
        assert braked(bench.sync()) == [True] * 6
        assert (bench.codes, bench.force_codes) == ([0] * 6, [0] * 6)
        assert bench.brakes == [True] * 6
    assert bench.node.ignored["DAC after ESTOP"] == 30
    bench.say(Nmt, None, Command.RESET, 0, 0)
    bench.dacs(1)
    assert braked(bench.sync()) == [False] * 6


def test_announce_and_every_twelfth_cycle_bring_a_heartbeat(bench: PlantBench) -> None:
    (beat,) = bench.say(Nmt, None, Command.ANNOUNCE, 0, 0)
    assert beat.name == "HEARTBEAT_9"
    assert beat.values.boot_id == 0x109
    assert bench.say(Nmt, None, Command.ANNOUNCE, 1, 0) == []
    beats = [any(h.name == "HEARTBEAT_9" for h in bench.sync()) for _ in range(25)]
    assert [k for k, beat in enumerate(beats) if beat] == [0, 12, 24]


def test_start_lets_counters_begin_anew(bench: PlantBench) -> None:
    for _ in range(200):
        bench.sync()
    bench.say(Nmt, None, Command.START, 0, 0)
    bench._senders.clear()
    bench.cycle = -1
    frames = bench.node.on_frame(
        bench.wire.sender(Sync).frame(0, NodeState.OPERATIONAL, 0, bench.wire.dbc_hash), 0
    )
    assert {frame.data[2] for frame in frames} == {0}
    assert bench.node.discarded == 0


@pytest.mark.parametrize("state", NodeState)
def test_a_second_master_is_heard_only_where_none_drives(
    bench: PlantBench, state: NodeState
) -> None:
    """Its RESET, of counter 0, would lift an emergency stop."""
    for boot_id in (8, 11):
        bench.sync(state)
        values = (state, 0, 0, boot_id, bench.wire.dbc_hash, 0, 0, 0)
        bench.give(bench.wire.sender(Heartbeat, MASTER).frame(*values))
        for _ in range(20):
            bench.command(Command.ANNOUNCE)
    bench.say(Estop, None, *ESTOP_VALUES)
    bench.give(bench.wire.sender(Heartbeat, MASTER).frame(state, 0, 0, 12, 0, 0, 0, 0))
    bench.give(bench.wire.sender(Nmt).frame(Command.RESET, 0, 0))
    assert bench.node._stopped == (state in DRIVEN)


# --- a plant that hears nothing -------------------------------------------------------------------


def driven(bench: PlantBench, state: NodeState = NodeState.OPERATIONAL) -> None:
    bench.sync(state)
    bench.dacs(40)
    bench.sync(state)


def test_a_plant_that_misses_sync_tells_it_once_in_the_third_period(bench: PlantBench) -> None:
    driven(bench)
    told = [[h.values for h in bench.miss_syncs(1) if h.name == "EMCY_9"] for _ in range(8)]
    assert [len(emergencies) for emergencies in told] == [0, 0, 1, 0, 0, 0, 0, 0]
    (emergency,) = told[2]
    assert (emergency.fault, emergency.culprit) == (FaultCode.SYNC_MISSING, MASTER)
    assert (emergency.frame, emergency.value, emergency.bound) == (bench.wire.id(Sync), 3.0, 3.0)


def test_where_nothing_is_driven_it_misses_nothing(bench: PlantBench) -> None:
    driven(bench, NodeState.READY)
    assert not [h for h in bench.miss_syncs(8) if h.name == "EMCY_9"]


@pytest.mark.parametrize("deaf", [DEAF_CYCLES - 1, DEAF_CYCLES])
def test_brakes_stay_open_where_a_deaf_plant_hears_again_in_time(
    bench: PlantBench, deaf: int
) -> None:
    """It hears SYNC first, and the joints' DAC behind it."""
    driven(bench)
    bench.dacs(40)
    bench.miss_syncs(deaf)
    assert braked(bench.sync(NodeState.OPERATIONAL)) == [deaf == DEAF_CYCLES] * 6
    bench.dacs(30)
    assert braked(bench.sync(NodeState.OPERATIONAL)) == [deaf == DEAF_CYCLES] * 6
