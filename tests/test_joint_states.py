"""The state tables of nodes and of the master: every pair of state and event."""

from itertools import product

import pytest
from support.joint_bench import JointBench

from rfms_can.joint_nodes.joint import JointNode
from rfms_can.joint_nodes.states import (
    COMMAND_EVENTS,
    TRANSITIONS,
    Event,
    TransitionError,
    enter,
    successor,
)
from rfms_can.master.phases import (
    BUS_STATES,
    CYCLING,
    PHASES,
    Phase,
    PhaseError,
    PhaseEvent,
    next_phase,
)
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Nmt
from rfms_can.wire.vocabulary import Command, NodeState

S, E = NodeState, Event

STORY: dict[tuple[NodeState, Event], NodeState] = {
    (S.INIT, E.BOOT): S.PREOP,
    (S.PREOP, E.HOME): S.HOMING,
    (S.PREOP, E.STOP): S.PREOP,
    (S.PREOP, E.RESET): S.PREOP,
    (S.PREOP, E.FAULT): S.FAULT,
    (S.PREOP, E.DUPLICATE): S.PREOP,
    (S.HOMING, E.HOMED): S.READY,
    (S.HOMING, E.STOP): S.PREOP,
    (S.HOMING, E.QUICKSTOP): S.PREOP,
    (S.HOMING, E.RESET): S.PREOP,
    (S.HOMING, E.FAULT): S.FAULT,
    (S.HOMING, E.DUPLICATE): S.PREOP,
    (S.READY, E.HOME): S.HOMING,
    (S.READY, E.START): S.OPERATIONAL,
    (S.READY, E.STOP): S.READY,
    (S.READY, E.QUICKSTOP): S.READY,
    (S.READY, E.RESET): S.PREOP,
    (S.READY, E.FAULT): S.FAULT,
    (S.READY, E.DUPLICATE): S.PREOP,
    (S.OPERATIONAL, E.STOP): S.READY,
    (S.OPERATIONAL, E.QUICKSTOP): S.QUICKSTOP,
    (S.OPERATIONAL, E.FAULT): S.FAULT,
    (S.OPERATIONAL, E.DUPLICATE): S.QUICKSTOP,
    (S.QUICKSTOP, E.QUICKSTOP): S.QUICKSTOP,
    (S.QUICKSTOP, E.RESET): S.PREOP,
    (S.QUICKSTOP, E.FAULT): S.FAULT,
    (S.QUICKSTOP, E.DUPLICATE): S.QUICKSTOP,
    (S.FAULT, E.QUICKSTOP): S.FAULT,
    (S.FAULT, E.FAULT): S.FAULT,
    (S.FAULT, E.DUPLICATE): S.FAULT,
    (S.FAULT, E.RESET): S.PREOP,
}
"""What nodes do, written down a second time: a change of the table has to be meant."""

PAIRS = list(product(NodeState, Event))


@pytest.mark.parametrize(("state", "event"), PAIRS, ids=lambda x: x.name)
def test_own_events_go_where_the_table_says_or_raise(state: NodeState, event: Event) -> None:
    expected = STORY.get((state, event))
    assert successor(state, event) is expected
    if expected is None:
        with pytest.raises(TransitionError, match=f"joint 3: {event.name} in state {state.name} "):
            enter(state, event, "joint 3")
    else:
        assert enter(state, event, "joint 3") is expected


def test_only_reset_leaves_a_stop_or_a_fault() -> None:
    for state in (S.QUICKSTOP, S.FAULT):
        ways_out = {e for e, target in TRANSITIONS[state].items() if target not in (state, S.FAULT)}
        assert ways_out == {E.RESET}
        assert TRANSITIONS[state][E.RESET] is S.PREOP


def test_torque_needs_homing_and_start_after_every_reset() -> None:
    into = {s for s, row in TRANSITIONS.items() for t in row.values() if t is S.OPERATIONAL}
    assert into == {S.READY}
    assert {s for s, row in TRANSITIONS.items() if S.READY in row.values()} == {
        *(S.HOMING, S.READY, S.OPERATIONAL)
    }


def _node_in(state: NodeState, wire: Wire) -> JointBench:
    """A configured joint that really is in a state, not one that was put there."""
    bench = JointBench(wire)
    bench.configure()
    if state in (S.READY, S.OPERATIONAL, S.QUICKSTOP):
        bench.home()
    if state in (S.OPERATIONAL, S.QUICKSTOP):
        bench.start()
    if state is S.QUICKSTOP:
        bench.command(Command.QUICKSTOP)
    if state is S.HOMING:
        bench.command(Command.HOME)
    if state is S.FAULT:
        bench.sync(NodeState.PREOP, dbc_hash=bench.wire.dbc_hash ^ 1)
    assert bench.state is state
    return bench


@pytest.mark.parametrize("command", [c for c in Command if c is not Command.ANNOUNCE])
@pytest.mark.parametrize("state", [s for s in NodeState if s is not S.INIT])
def test_commands_without_a_transition_are_ignored_and_counted(
    state: NodeState, command: Command, wire: Wire
) -> None:
    bench = _node_in(state, wire)
    before = bench.node.ignored.total()
    bench.command(command)
    expected = STORY.get((state, COMMAND_EVENTS[command]))
    assert bench.state is (state if expected is None else expected)
    ignored = bench.node.ignored.total() - before
    assert ignored == (expected is None)
    if ignored:
        assert bench.node.ignored[f"{command.name} in {state.name}"] == 1


def test_a_node_that_has_not_booted_ignores_commands(wire: Wire) -> None:
    node = JointNode(1, wire, 1)
    sender = wire.sender(Nmt)
    for command in COMMAND_EVENTS:
        assert not node.on_frame(sender.frame(command, 0, 0), 0)
    assert node.state is S.INIT
    assert node.ignored.total() == len(COMMAND_EVENTS)


def test_commands_for_another_node_are_not_ours(wire: Wire) -> None:
    bench = _node_in(S.OPERATIONAL, wire)
    bench.say(Nmt, None, Command.QUICKSTOP, bench.number + 1, 0)
    assert bench.dacs(bench.run())
    bench.say(Nmt, None, Command.QUICKSTOP, bench.number, 0)
    assert bench.state is S.QUICKSTOP


def test_announce_is_answered_in_every_state_and_changes_none(wire: Wire) -> None:
    for state in NodeState:
        if state is S.INIT:
            continue
        bench = _node_in(state, wire)
        (beat,) = bench.command(Command.ANNOUNCE)
        assert beat.name == "HEARTBEAT_2"
        assert beat.values.state == bench.state == state


def test_every_state_of_the_wire_has_a_row() -> None:
    assert set(TRANSITIONS) == set(NodeState)


P, PE = Phase, PhaseEvent

PLAY: dict[tuple[Phase, PhaseEvent], Phase] = {
    (P.ROLL_CALL, PE.ALL_PRESENT): P.CONFIGURE,
    (P.CONFIGURE, PE.ALL_CONFIGURED): P.HOME,
    (P.HOME, PE.ALL_HOMED): P.READY,
    (P.READY, PE.START): P.RUN,
    **{(phase, PE.STOP): P.END for phase in Phase},
    **{(phase, PE.FAULT): P.HALT for phase in Phase if phase is not P.END},
    (P.END, PE.FAULT): P.END,
    (P.HALT, PE.RESET): P.RESET,
    (P.RESET, PE.RESTED): P.ROLL_CALL,
}


@pytest.mark.parametrize(("phase", "event"), list(product(Phase, PhaseEvent)))
def test_phases_go_where_the_table_says_or_raise(phase: Phase, event: PhaseEvent) -> None:
    expected = PLAY.get((phase, event))
    if expected is None:
        with pytest.raises(PhaseError, match=f"master: {event.name} in phase {phase.name} "):
            next_phase(phase, event)
    else:
        assert next_phase(phase, event) is expected


def test_a_halted_master_can_only_end_or_be_reset() -> None:
    assert set(PHASES[P.HALT].values()) == {P.HALT, P.END, P.RESET}
    ways = [(phase, event) for phase, row in PHASES.items() for event in row if row[event] is P.RUN]
    assert ways == [(P.READY, PE.START)]
    assert [phase for phase, row in PHASES.items() if PE.RESET in row] == [P.HALT]
    assert set(PHASES[P.END].values()) == {P.END}


def test_the_bus_is_operational_in_one_phase_only() -> None:
    assert set(BUS_STATES) == set(PHASES) == set(Phase)
    assert [p for p, state in BUS_STATES.items() if state is S.OPERATIONAL] == [P.RUN]
    assert {P.ROLL_CALL, P.CONFIGURE} == set(Phase) - CYCLING
