"""The tables that guard the arm, written a second time: an entry changed by accident fails here.

A test that reads its expectation from a table cannot see that the table is wrong.
"""

from itertools import product

import pytest

from rfms_can.joint_nodes import controller, ladder, sensing, stop_ramp
from rfms_can.joint_nodes.detectors import (
    bus,
    drive,
    plausible_rows,
    runaway,
    sensors,
    setpoint_step,
)
from rfms_can.joint_nodes.ladder import LADDERS, Reaction, rung
from rfms_can.joint_nodes.state_actions import STATE_ACTIONS, StateAction, TorqueSource
from rfms_can.joint_nodes.states import TRANSITIONS, Event
from rfms_can.master import corruption, lateness, own_frames, traffic
from rfms_can.node import port_counts
from rfms_can.wire.vocabulary import FaultCode, NodeState

S, R, T, F, E = NodeState, Reaction, TorqueSource, FaultCode, Event

# --- the ladder -----------------------------------------------------------------------------------

RUNGS = {
    F.SYNC_MISSING: {1: R.HOLD, 3: R.STOP, 5: R.DAMP, 25: R.OFF},
    F.SETPOINT_MISSING: {1: R.HOLD, 3: R.STOP, 5: R.DAMP, 25: R.OFF},
    F.MEASURE_MISSING: {1: R.HOLD, 3: R.OFF},
    F.ERROR_MISSING: {1: R.HOLD, 3: R.STOP},
    F.ROWS_MISSING: {1: R.HOLD, 3: R.STOP},
    F.SETPOINT_STEP: {1: R.STOP},
    F.ENCODER_GLITCH: {1: R.HOLD, 3: R.STOP},
    F.SOFT_LIMIT: {1: R.STOP},
    F.HARD_LIMIT: {1: R.OFF},
    F.HOMING_FAILED: {1: R.OFF},
    F.DBC_MISMATCH: {1: R.OFF},
    F.EMERGENCY_STOP: {1: R.OFF},
    F.RUNAWAY: {5: R.OFF},
    F.DUPLICATE_NODE: {1: R.STOP},
    F.SENSOR_MISMATCH: {1: R.OFF},
    F.SENSOR_STUCK: {1: R.OFF},
    F.ADC_SATURATED: {1: R.HOLD, 3: R.DAMP},
    F.AMPLIFIER_FAULT: {1: R.HOLD, 2: R.OFF},
    F.OVERSPEED: {1: R.HOLD, 2: R.OFF},
    F.FOLLOWING_ERROR: {1: R.HOLD, 2: R.OFF},
    F.OVERLOAD: {1: R.DAMP},
    F.STALL: {1: R.DAMP},
    F.ROWS_IMPLAUSIBLE: {1: R.HOLD, 3: R.STOP},
    F.FOREIGN_MASTER: {1: R.STOP},
    F.BAD_FRAMES: {1: R.STOP},
    F.BUS_OFF: {1: R.DAMP},
    F.QUEUE_OVERFLOW: {1: R.HOLD, 3: R.STOP},
}
"""Cycles in a row with a fault, and what a node does then."""


@pytest.mark.parametrize("fault", RUNGS, ids=lambda fault: fault.name)
def test_each_fault_has_its_reactions_after_its_cycles(fault: FaultCode) -> None:
    assert set(LADDERS) == set(RUNGS)
    assert dict(LADDERS[fault]) == RUNGS[fault]
    assert [bound for bound, _ in LADDERS[fault]] == sorted(RUNGS[fault])


def test_reactions_are_ordered_by_hardness() -> None:
    assert [(r.name, int(r)) for r in Reaction] == [
        *(("NONE", 0), ("HOLD", 1), ("STOP", 2), ("DAMP", 3), ("OFF", 4)),
    ]


def test_rungs_are_asked_by_their_reaction() -> None:
    assert rung(F.SYNC_MISSING, R.DAMP) == 5
    assert rung(F.RUNAWAY, R.OFF) == 5
    assert rung(F.RUNAWAY, R.STOP) == 0


def test_a_new_ladder_and_one_that_is_reset_count_nothing() -> None:
    counts = ladder.Ladder()
    assert counts.misses == [0] * (max(F) + 1)
    for fault in RUNGS:
        counts.miss(fault)
        assert counts.misses[fault] == 1
    counts.reset()
    assert counts.misses == [0] * (max(F) + 1)


# --- what a joint does ----------------------------------------------------------------------------

BRIDGES, WATCHES = {"bridges_encoder": True, "watches_range": True}, {"watches_range": True}
SERVO = StateAction(T.SERVO, tells_error=True, owes_dac=True, **BRIDGES)
STOP = StateAction(T.STOP_RAMP, owes_dac=True, any_sample=True, **BRIDGES)
DAMP = StateAction(T.DAMPING, any_sample=True, **WATCHES)


def expected(state: NodeState, reaction: Reaction, bus: NodeState) -> StateAction:
    """By cases, as the pages of the protocol tell it."""
    led = bus is S.OPERATIONAL  # the master drives: its set-points are missed
    actions = {
        S.INIT: StateAction(T.NOTHING),
        S.PREOP: StateAction(T.NOTHING),
        S.HOMING: StateAction(T.HOMING)
        if bus is S.HOMING
        else StateAction(T.NOTHING, expects_setpoint=led),
        S.READY: StateAction(T.HOLD if bus is S.HOMING else T.NOTHING),
        S.OPERATIONAL: SERVO,
        S.QUICKSTOP: STOP._replace(expects_setpoint=led),
        S.FAULT: DAMP._replace(expects_setpoint=led)
        if reaction is R.DAMP
        else StateAction(T.NOTHING, any_sample=True),
    }
    return actions[state]


@pytest.mark.parametrize(("state", "reaction"), list(product(NodeState, Reaction)))
def test_each_case_has_its_action(state: NodeState, reaction: Reaction) -> None:
    for told in NodeState:
        assert STATE_ACTIONS[state][reaction][told] == expected(state, reaction, told), told


def test_frames_of_an_action_are_those_of_its_torque() -> None:
    assert StateAction(T.NOTHING).sends == ()
    assert StateAction(T.HOMING).sends == ("DAC",)
    assert SERVO.sends == ("ERROR", "DAC")
    assert StateAction(T.NOTHING, tells_error=True).sends == ("ERROR",)


# --- states ---------------------------------------------------------------------------------------

LEAVES = {
    S.INIT: {E.BOOT: S.PREOP},
    S.PREOP: {E.HOME: S.HOMING, E.STOP: S.PREOP, E.RESET: S.PREOP},
    S.HOMING: {E.HOMED: S.READY, E.STOP: S.PREOP, E.QUICKSTOP: S.PREOP, E.RESET: S.PREOP},
    S.READY: {
        **{E.HOME: S.HOMING, E.START: S.OPERATIONAL, E.STOP: S.READY},
        **{E.QUICKSTOP: S.READY, E.RESET: S.PREOP},
    },
    S.OPERATIONAL: {E.STOP: S.READY, E.QUICKSTOP: S.QUICKSTOP},
    S.QUICKSTOP: {E.QUICKSTOP: S.QUICKSTOP, E.RESET: S.PREOP},
    S.FAULT: {E.QUICKSTOP: S.FAULT, E.RESET: S.PREOP},
}
"""By what a node leaves its state, besides faults and a second node."""


@pytest.mark.parametrize("state", NodeState, ids=lambda state: state.name)
def test_each_state_is_left_as_the_protocol_says(state: NodeState) -> None:
    stops = S.QUICKSTOP if state in (S.OPERATIONAL, S.QUICKSTOP) else S.PREOP
    faults = {} if state is S.INIT else {E.FAULT: S.FAULT, E.DUPLICATE: stops}
    if state is S.FAULT:
        faults[E.DUPLICATE] = S.FAULT
    assert TRANSITIONS[state] == {**LEAVES[state], **faults}


# --- bounds ---------------------------------------------------------------------------------------


def test_bounds_of_a_joint_are_those_that_were_reasoned() -> None:
    """A change of one is a change of the protocol: its reason stands beside it in the code."""
    assert (controller.MAX_CYCLE_GAP, sensing.MAX_PREDICTED_CYCLES) == (4, 2)
    assert (sensing.SOFT_MARGIN_RAD, sensing.HARD_MARGIN_RAD, sensing.RAIL) == (0.02, 0.05, 2047)
    assert (stop_ramp.STILL_CYCLES, stop_ramp.SETTLING_S) == (12, 0.5)
    assert stop_ramp.STEP_FRACTION == 0.25
    assert (setpoint_step.STEP_MARGIN, setpoint_step.RATE_STEP_FRACTION) == (1.5, 0.2)
    assert setpoint_step.RATE_SETPOINTS == 4
    assert (runaway.ERROR_FRACTION, runaway.ERROR_TIME_S) == (0.5, 0.01)
    assert (runaway.SPEED_FRACTION, runaway.BRAKED_FRACTION) == (0.05, 0.9)
    assert (runaway.FAST_FRACTION, runaway.FAST_CYCLES) == (0.5, 2)
    assert (sensors.FOUND_CYCLES, sensors.SLACK_FRACTION) == (3, 0.05)
    assert (sensors.SLACK_LIMIT_FRACTION, sensors.VARIATION_FRACTION) == (0.01, 0.1)
    assert sensors.VARIATION_COUNTS == 3
    assert (drive.FULL_SCALE, drive.REMEMBERED) == (2048.0, 5)
    assert (drive.GAIN_FRACTION, drive.STALL_FRACTION) == (0.1, 0.02)
    assert (plausible_rows.GRAVITY_STEP, plausible_rows.INERTIA_FACTOR) == (0.25, 10.0)
    assert plausible_rows.AGREEMENT == 1e-3
    assert (bus.WINDOW_CYCLES, bus.BAD_IN_WINDOW, bus.FARTHEST_CYCLES) == (10, 3, 4)


def test_bounds_of_the_master_are_those_that_were_reasoned() -> None:
    assert (corruption.MOST, corruption.SUSPICIOUS, corruption.WINDOW) == (3, 2, 10)
    assert (lateness.LATE, lateness.LATE_CYCLES, lateness.OVERSLEPT) == (0.5, 3, 3)
    assert pytest.approx(1 / 3) == lateness.LATE_AGAIN
    assert own_frames.KEPT == 8
    assert (traffic.MOST_IN_A_CYCLE, traffic.BABBLING_CYCLES, traffic.FULL_CYCLES) == (2, 2, 2)
    assert (traffic.FULL, traffic.MOST_OF_IT) == (0.95, 0.5)
    assert (port_counts.MOST.bus_offs, port_counts.MOST.overflows) == (0xF, 0xFF)
