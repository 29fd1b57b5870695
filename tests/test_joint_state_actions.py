"""What a joint does in each state, under each reaction and each state in SYNC; tables complete."""

import re
from itertools import product

import pytest
from support.joint_bench import JointBench

from rfms_can.errors import TableError
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.joint_nodes.servo import LAW_TORQUES
from rfms_can.joint_nodes.state_actions import (
    ROWS,
    STATE_ACTIONS,
    StateAction,
    TorqueSource,
    by_case,
)
from rfms_can.tables import complete
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.records import Estop
from rfms_can.wire.vocabulary import Command, FaultCode, Law, NodeState

S, R, T = NodeState, Reaction, TorqueSource

CASES = list(product(NodeState, Reaction, NodeState))


# --- the tables ---------------------------------------------------------------------------------


def test_every_case_has_a_duty() -> None:
    assert sum(len(reactions) * len(syncs) for _, reactions, syncs, _ in ROWS) == len(CASES)
    for state, reaction, bus_state in CASES:
        assert STATE_ACTIONS[state][reaction][bus_state] in {
            action for s, _, _, action in ROWS if s is state
        }


@pytest.mark.parametrize("row", range(len(ROWS)))
def test_a_table_that_lacks_a_row_names_a_case_of_it(row: int) -> None:
    state, reactions, bus_states, _ = ROWS[row]
    case = f"NodeState.{state.name}, Reaction.{reactions[0].name}, NodeState.{bus_states[0].name}"
    with pytest.raises(TableError, match=re.escape(f"without an entry for ({case})")):
        by_case(ROWS[:row] + ROWS[row + 1 :])


def test_a_case_with_two_actions_is_named() -> None:
    with pytest.raises(TableError, match="two actions for INIT, NONE, SYNC INIT"):
        by_case((*ROWS, ROWS[0]))


def test_an_action_does_nothing_that_its_row_does_not_say() -> None:
    action = StateAction(T.NOTHING)
    assert action[1:] == (False,) * (len(StateAction._fields) - 1)


def test_torque_without_the_six_errors_is_homing_or_stopping() -> None:
    by_state = {
        s: {STATE_ACTIONS[s][r][b].torque for r, b in product(Reaction, NodeState)}
        for s in NodeState
    }
    assert by_state == {
        S.INIT: {T.NOTHING},
        S.PREOP: {T.NOTHING},
        S.HOMING: {T.NOTHING, T.HOMING},
        S.READY: {T.NOTHING, T.HOLD},
        S.OPERATIONAL: {T.SERVO},
        S.QUICKSTOP: {T.STOP_RAMP},
        S.FAULT: {T.NOTHING, T.DAMPING},
    }


def test_a_joint_whose_reaction_is_off_has_no_torque() -> None:
    assert {STATE_ACTIONS[S.FAULT][R.OFF][bus_state].torque for bus_state in NodeState} == {
        T.NOTHING
    }


def test_every_law_has_its_torque_and_a_missing_one_is_named() -> None:
    assert set(LAW_TORQUES) == set(Law)
    for law in Law:
        lacking = {other: made for other, made in LAW_TORQUES.items() if other != law}
        with pytest.raises(TableError, match=f"without an entry for Law.{law.name}"):
            complete(lacking, Law)


# --- and the node that follows them -------------------------------------------------------------


def _joint_in(state: NodeState, reaction: Reaction, wire: Wire) -> JointBench:
    bench = JointBench(wire)
    bench.configure()
    if state is S.HOMING:
        bench.command(Command.HOME)
        bench.rows(0)
    elif state is not S.PREOP:
        bench.home()
    if state in (S.OPERATIONAL, S.QUICKSTOP) or reaction is R.DAMP:
        bench.start()
    if state is S.QUICKSTOP:
        bench.command(Command.QUICKSTOP)
    if reaction is R.DAMP:
        bench.miss_syncs(5)
    elif state is S.FAULT:
        bench.say(Estop, None, *ESTOP_VALUES)
    assert (bench.state, bench.node.reaction) == (state, reaction)
    return bench


REACHED = [
    *((state, R.NONE) for state in (S.PREOP, S.HOMING, S.READY, S.OPERATIONAL, S.QUICKSTOP)),
    *((S.FAULT, R.DAMP), (S.FAULT, R.OFF)),
]


@pytest.mark.parametrize("bus_state", [s for s in NodeState if s is not S.INIT])
@pytest.mark.parametrize(("state", "reaction"), REACHED)
def test_a_joint_sends_what_its_duty_says(
    state: NodeState, reaction: Reaction, bus_state: NodeState, wire: Wire
) -> None:
    bench = _joint_in(state, reaction, wire)
    action = STATE_ACTIONS[state][reaction][bus_state]
    answers = bench.sync(bus_state)
    assert bench.controller.action == action
    answers += bench.setpoint() + bench.measure() + bench.reference() + bench.other_errors()
    sent = [heard.name for heard in answers if not heard.name.startswith("HEARTBEAT")]
    assert sent == [f"{name}_2" for name in action.sends]


@pytest.mark.parametrize("bus_state", [S.OPERATIONAL, S.QUICKSTOP])
@pytest.mark.parametrize(("state", "reaction"), REACHED)
def test_a_joint_misses_what_its_duty_says(
    state: NodeState, reaction: Reaction, bus_state: NodeState, wire: Wire
) -> None:
    """A cycle with MEASURE alone, and then one without any frame."""
    bench = _joint_in(state, reaction, wire)
    action = STATE_ACTIONS[state][reaction][bus_state]
    missed = bench.node.faults
    bench.sync(bus_state)
    bench.measure()
    before = missed[FaultCode.SETPOINT_MISSING], missed[FaultCode.MEASURE_MISSING]
    bench.sync(bus_state)
    servo = action.torque is T.SERVO  # it sent no DAC for want of a set-point; a stopped joint did
    assert missed[FaultCode.SETPOINT_MISSING] - before[0] == (servo or action.expects_setpoint)
    bench.sync(bus_state)
    assert missed[FaultCode.MEASURE_MISSING] - before[1] == action.owes_dac
