"""The parts of the master, each alone: timer, inputs, phases, row sets, requests."""

from collections import Counter
from dataclasses import replace

import pytest
from support.fleet import Fleet

from rfms_can.arm import PUMA_260
from rfms_can.arm.load import NOTHING
from rfms_can.compliance import ControlLaw, Selection
from rfms_can.dynamics.model import FULL, make_dynamics
from rfms_can.errors import ProgramError
from rfms_can.master.answers import bit
from rfms_can.master.arm_state import ArmState
from rfms_can.master.force.control import ForceControl, ForceSettings
from rfms_can.master.inputs import CycleInputs
from rfms_can.master.motion import Motion
from rfms_can.master.phases import Phase, PhaseError, PhaseEvent, PhaseMachine
from rfms_can.master.requests import ProgramRequests
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import MathProcessor
from rfms_can.master.rows.sets import RowSets
from rfms_can.master.settings import MasterSettings
from rfms_can.master.start_up.node_parameters import parameters_for
from rfms_can.master.stillness import STILL_CYCLES, Stillness
from rfms_can.master.timer import CycleTimer
from rfms_can.messages import (
    GripperRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TareRequest,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.configuration import Clock
from rfms_can.wire.contract import NO_SET, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import GRIPPER, JOINTS, MASTER
from rfms_can.wire.records import Dac, Force, JointError, Measure
from rfms_can.wire.vocabulary import Blend, GripperCommand

PERIOD_NS = 4_000_000
BARRIER_NS = 2_000_000_000

# --- timer ------------------------------------------------------------------------------------


def timer(clock: Clock, *, paced: bool = False) -> CycleTimer:
    return CycleTimer(MasterSettings(clock=clock, paced=paced))


@pytest.mark.parametrize("clock", [Clock.VIRTUAL, Clock.REALTIME])
def test_cycles_begin_on_the_schedule_however_late_they_are_sent(clock: Clock) -> None:
    cycles = timer(clock)
    assert cycles.deadline_ns == 0
    cycles.begin(1000)
    assert cycles.close() is False  # the next one waits for its time
    assert cycles.due(1000 + PERIOD_NS - 1) is None
    assert cycles.due(1000 + PERIOD_NS + 700) == 1000 + PERIOD_NS
    assert cycles.realtime is (clock is Clock.REALTIME)


def test_a_lockstep_cycle_begins_when_the_last_one_is_closed_and_waits_for_the_barrier() -> None:
    cycles = timer(Clock.LOCKSTEP)
    cycles.begin(1000)
    assert cycles.deadline_ns == 1000 + BARRIER_NS
    assert cycles.close() is True


def test_a_paced_lockstep_cycle_is_not_shorter_than_the_period() -> None:
    cycles = timer(Clock.LOCKSTEP, paced=True)
    cycles.begin(1000)
    assert cycles.deadline_ns == 1000 + BARRIER_NS
    assert cycles.close() is False
    assert cycles.deadline_ns == 1000 + PERIOD_NS
    cycles.pace(False)  # a program asks for something
    cycles.begin(1000 + PERIOD_NS)
    assert cycles.close() is True


@pytest.mark.parametrize("clock", Clock)
def test_a_stopped_timer_begins_nothing_but_sends_what_is_urgent(clock: Clock) -> None:
    cycles = timer(clock)
    cycles.begin(0)
    cycles.stop()
    assert cycles.stopped
    assert cycles.close() is False
    assert cycles.deadline_ns is cycles.due(10 * BARRIER_NS) is None
    cycles.send_now()
    assert cycles.deadline_ns == 0
    assert [cycles.take_urgent(), cycles.take_urgent()] == [True, False]
    assert cycles.deadline_ns is None


# --- phases and the fault ---------------------------------------------------------------------


def run_machine() -> PhaseMachine:
    machine = PhaseMachine()
    for event in ("ALL_PRESENT", "ALL_CONFIGURED", "ALL_HOMED", "START"):
        machine.change(PhaseEvent[event])
    return machine


def test_the_first_fault_is_latched_and_halts_once() -> None:
    machine = run_machine()
    assert (machine.phase, machine.fault, machine.cycling) == (Phase.RUN, None, True)
    assert machine.latch("first") is True
    assert machine.latch("second") is False
    assert (machine.phase, machine.fault) == (Phase.HALT, "first")


def test_after_the_end_there_is_nothing_to_stop() -> None:
    machine = run_machine()
    machine.change(PhaseEvent.STOP)
    assert machine.latch("too late") is False
    assert (machine.phase, machine.fault) == (Phase.END, None)


def test_a_fault_without_its_reason_is_a_bug_and_changes_nothing() -> None:
    machine = run_machine()
    for event in (PhaseEvent.FAULT, PhaseEvent.RESET):
        with pytest.raises(PhaseError, match=r"call latch\(\) or reset\(\)"):
            machine.change(event)
    with pytest.raises(PhaseError, match="START in phase RUN"):
        machine.change(PhaseEvent.START)
    assert (machine.phase, machine.fault) == (Phase.RUN, None)


@pytest.mark.parametrize("name", ["phase", "fault"])
def test_nothing_but_the_machine_changes_a_phase_or_a_fault(name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(run_machine(), name, None)


# --- inputs -----------------------------------------------------------------------------------


class Inputs:
    """Inputs of a cycle, and what they called."""

    def __init__(self, *, sensor: bool = False) -> None:
        self.events: list[str] = []
        self.ignored: Counter[str] = Counter()
        parameters = parameters_for(PUMA_260, MasterSettings())
        self.inputs = CycleInputs(
            ArmState(parameters),
            [(0.5 * joint, 0.01) for joint in JOINTS],
            self.ignored,
            lambda: self.events.append("sampled"),
            lambda: self.events.append("complete"),
            sensor=sensor,
        )

    def sample(self, cycle: int) -> None:
        """All MEASUREs, the jaw's included."""
        for joint in JOINTS:
            self.inputs.on_measure(joint, bit("MEASURE", joint), measure(cycle))
        self.inputs.on_jaw(measure(cycle))

    def confirm_rows(self) -> None:
        for joint in JOINTS:
            self.inputs.answered(bit("ROWS", joint))

    def answer(self, cycle: int) -> None:
        """All ERRORs and DACs."""
        for joint in JOINTS:
            error = JointError(0.1 * joint, 0.0, 0.0, cycle)
            self.inputs.on_error(joint, bit("ERROR", joint), error)
        for node in (*JOINTS, GRIPPER):
            self.inputs.on_dac(node, bit("DAC", node), Dac(2, 1, cycle))


def measure(cycle: int) -> Measure:
    return Measure(77, 0, 0, cycle & 0xFF, 0, 0)


def test_a_cycle_is_sampled_once_and_complete_with_the_last_answer() -> None:
    bench = Inputs()
    bench.inputs.begin(Phase.RUN, 0x101)
    assert not bench.inputs.complete
    bench.sample(0x101)
    assert bench.events == ["sampled"]
    bench.confirm_rows()
    bench.answer(1)
    assert bench.events == ["sampled", "complete"]
    assert bench.inputs.complete
    bench.answer(1)  # repeated: nothing is complete a second time
    assert bench.events == ["sampled", "complete"]
    assert bench.inputs.errors == pytest.approx([0.1 * joint for joint in JOINTS])
    assert bench.inputs.torques == pytest.approx([joint + 0.01 for joint in JOINTS])
    assert bench.inputs.arm_state.jaw_counts == 77


def test_homing_is_sampled_with_the_last_reference() -> None:
    bench = Inputs()
    bench.inputs.begin(Phase.HOME, 1)
    bench.sample(1)
    assert bench.events == []


def test_answers_of_another_cycle_are_counted_and_have_no_effect() -> None:
    bench = Inputs(sensor=True)
    bench.inputs.begin(Phase.RUN, 5)
    bench.sample(4)
    bench.answer(6)
    bench.inputs.on_force(Force(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 4))
    assert bench.ignored == {
        "stale MEASURE": 7,
        "stale ERROR": 6,
        "stale DAC": 7,
        "stale FORCE": 1,
    }
    assert bench.inputs.errors == bench.inputs.torques == [0.0] * 6
    assert bench.inputs.take_reading() is None


def test_what_is_given_up_is_named_and_no_longer_waited_for() -> None:
    bench = Inputs()
    for cycle in (1, 2, 3):
        bench.inputs.begin(Phase.RUN, cycle)
        bench.sample(cycle)
        bench.confirm_rows()
        missing, lost = bench.inputs.give_up(cycle)
        assert "ERROR_1" in missing
        assert bench.inputs.complete
        bench.answer(cycle)  # late
    assert lost is not None and lost[:3] == (MASTER, "SETPOINT_1", 3)  # no joint has it
    assert "complete" not in bench.events


def test_a_reading_of_the_sensor_is_taken_once() -> None:
    bench = Inputs(sensor=True)
    bench.inputs.begin(Phase.RUN, 1)
    bench.inputs.on_force(Force(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 1))
    assert bench.inputs.take_reading() == (0, 1, 2, 3, 4, 5)
    assert bench.inputs.take_reading() is None


# --- sets of rows -----------------------------------------------------------------------------


RIGIDLY = Compliance()


def row_sets(wire: Wire, law: ControlLaw = ControlLaw.WEIGHTED) -> RowSets:
    math = MathProcessor(PUMA_260, make_dynamics(PUMA_260, FULL), law)
    return RowSets(math, wire.sender, PUMA_260.park)


def send(sets: RowSets, compliance: Compliance = RIGIDLY) -> list[Frame]:
    out: list[Frame] = []
    sets.send(PUMA_260.park, compliance, NOTHING, out)
    return out


def test_a_set_is_in_force_when_all_of_it_has_gone_out(wire: Wire) -> None:
    sets = row_sets(wire)
    assert sets.in_force.number == NO_SET
    frames = send(sets)
    for frame in frames[:-1]:
        assert sets.gone_out(frame)
        assert sets.in_force.number == NO_SET
    assert sets.gone_out(frames[-1])
    assert sets.in_force is sets.newest


def test_rows_of_a_set_that_was_superseded_do_not_count(wire: Wire) -> None:
    sets = row_sets(wire)
    late, frames = send(sets), send(sets)
    assert not any(sets.gone_out(frame) for frame in late)
    assert all(sets.gone_out(frame) for frame in frames)
    assert sets.in_force.number == 2


def test_a_set_says_what_it_complies_in_and_keeps_the_model_it_was_made_of(wire: Wire) -> None:
    wanted = Compliance().changed(Selection.parse("fz"), Transform.translation(0.0, 0.0, 0.1))
    sets = row_sets(wire)
    send(sets, wanted)
    complying = sets.newest
    assert complying.compliance == wanted
    assert complying.law is not None
    J, M = complying.J.copy(), complying.M.copy()
    sets.send((0.1,) * 6, Compliance(), NOTHING, [])
    assert (complying.J == J).all() and (complying.M == M).all()
    assert sets.newest.law is None
    assert (sets.newest.J != J).any()


def test_a_law_that_does_not_comply_says_so(wire: Wire) -> None:
    sets = row_sets(wire, ControlLaw.POSITION)
    send(sets, Compliance().changed(Selection.parse("fz"), Transform.identity()))
    assert not sets.newest.compliance.selection.size


def test_a_lost_measure_leaves_force_control_the_newest_set(wire: Wire) -> None:
    """One MEASURE is lost to the master: no rows go out, and the cycle goes on with the last."""
    fleet = Fleet(wire).enable()
    fleet.run(5)
    before = fleet.master.rows.newest
    lost, since = fleet.id(Measure, 3), len(fleet.pump.sent)
    fleet.pump.lose(lambda frame, to: frame.id == lost and to is fleet.master)
    fleet.run(1)
    assert fleet.master.rows.newest is before
    assert not fleet.said("ROWS_1", since)
    fleet.pump.heal()
    fleet.run(2)
    assert fleet.master.rows.newest.number == before.number + 2
    assert fleet.master.fault is None


# --- the whole --------------------------------------------------------------------------------


def test_two_masters_share_nothing(wire: Wire) -> None:
    one, other = (Fleet(wire).enable().master for _ in range(2))
    one.emergency_stop("here")
    assert (one.fault, one.phase) == ("here", Phase.HALT)
    assert (other.fault, other.phase) == (None, Phase.RUN)
    assert one.number == MASTER
    assert replace(one.settings) == other.settings


# --- requests of programs ---------------------------------------------------------------------


class Requests:
    """Requests on parts that nothing drives."""

    def __init__(self, wire: Wire, *, sensor: bool = False) -> None:
        self.machine = run_machine()
        gains = (1.0,) * 6
        settings = ForceSettings(ControlLaw.WEIGHTED, closed=False, friction="none", Kp=gains)
        force = ForceControl(PUMA_260, settings, 0.004)
        self.motion = Motion(PUMA_260, 0.004, Blend.CONTINUOUS, force.refusal)
        self.motion.enable(PUMA_260.park)
        self.force, self.stillness = force, Stillness(PUMA_260)
        self.requests = ProgramRequests(
            *(self.machine, self.motion, force, self.stillness, row_sets(wire)), sensor=sensor
        )

    def rest(self) -> None:
        """Long enough that the arm stands still."""
        state = ArmState(parameters_for(PUMA_260, MasterSettings()))
        for _ in range(STILL_CYCLES + 1):
            self.stillness.watch(state)


def test_a_gripper_command_waits_for_the_end_of_the_cycle(wire: Wire) -> None:
    bench = Requests(wire)
    bench.rest()
    assert bench.stillness.jaw
    bench.requests.handle(GripperRequest(True, 0.333))
    assert bench.requests.gripper == (GripperCommand.OPEN, 33.5)
    assert not bench.stillness.jaw


def test_a_halted_arm_takes_no_requests(wire: Wire) -> None:
    bench = Requests(wire)
    bench.machine.latch("broken")
    with pytest.raises(ProgramError, match=r"not enabled \(phase HALT\)"):
        bench.requests.handle(GripperRequest(True, 1.0))
    assert bench.requests.gripper == (GripperCommand.HOLD, 0.0)


def test_a_tare_needs_a_sensor_and_rest(wire: Wire) -> None:
    with pytest.raises(ProgramError, match="no wrist sensor"):
        Requests(wire).requests.handle(TareRequest())
    bench = Requests(wire, sensor=True)
    with pytest.raises(ProgramError, match="the arm moves"):
        bench.requests.handle(TareRequest())
    bench.rest()
    bench.requests.handle(TareRequest())
    assert bench.force.wrench_estimate.taring


# --- force control, handed its set ------------------------------------------------------------


def test_a_wrench_is_estimated_with_the_set_that_was_handed_over(wire: Wire) -> None:
    """At rest the motors exert J^T f + g of that set, whatever was computed since."""
    bench, sets = Requests(wire), row_sets(wire)
    send(sets)
    model, wrench = sets.newest, (0.0, 0.0, 5.0, 0.0, 0.0, 0.0)
    sets.send((0.1,) * 6, RIGIDLY, NOTHING, [])
    torques = (model.J.T @ wrench + model.gravity).tolist()
    for _ in range(300):
        bench.force.sense(None, torques, bench.motion.commanded, PUMA_260.park, model, True)
    assert bench.force.wrench_estimate.wrench == pytest.approx(wrench, abs=1e-6)


def test_an_arm_that_has_stopped_keeps_its_force_request_and_one_that_is_enabled_has_none(
    wire: Wire,
) -> None:
    motion = Requests(wire).motion
    here = motion.generator.tick().T6_1
    for message in (
        TransformMessage("there", here @ Transform.translation(0.0, 0.0, 0.03)),
        PositionMessage("there", ["t6"], ["there"]),
        ModeMessage("slow", "cartesian", 0.1, 1.0, comply={"fz": 0.0}),
        MoveRequest("there", "slow"),
    ):
        motion.handle(message)
    for _ in range(100):
        motion.next_setpoint()
    request = motion.force_request
    assert request is not None and request.specification.selection.word == "fz"
    motion.handle(StopRequest())
    for _ in range(150):
        motion.next_setpoint()
    assert motion.at_rest
    assert motion.force_request is request
    motion.generator.disable()
    motion.enable(PUMA_260.park)
    assert motion.force_request is None
