"""Draw the state tables of nodes, master and trajectory generator into docs/states.md (mermaid)."""

from collections.abc import Collection, Mapping
from enum import Enum
from typing import TypeVar

from generated import main, table

from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.joint_nodes.state_actions import ROWS, StateAction
from rfms_can.joint_nodes.states import TRANSITIONS as NODE
from rfms_can.master.phases import BUS_STATES, PHASES
from rfms_can.master.trajectory.states import ON_THE_WIRE
from rfms_can.master.trajectory.states import TRANSITIONS as GENERATOR
from rfms_can.wire.vocabulary import NodeState

State = TypeVar("State", bound=Enum)
Event = TypeVar("Event", bound=Enum)
Name = TypeVar("Name", bound=Enum)


def diagram(table: Mapping[State, Mapping[Event, State]]) -> str:
    """A mermaid state diagram of a table; transitions that share both ends share an arrow."""
    arrows: dict[tuple[str, str], list[str]] = {}
    for source, row in table.items():
        for event, target in row.items():
            arrows.setdefault((source.name, target.name), []).append(event.name)
    lines = [f"    {a} --> {b} : {', '.join(events)}" for (a, b), events in arrows.items()]
    first = next(iter(table)).name
    return "\n".join(["```mermaid", "stateDiagram-v2", f"    [*] --> {first}", *lines, "```"])


def names(heading: str, of: str, entries: Mapping[State, Name]) -> str:
    """A table of what each state is called on the bus."""
    return table((heading, of), [(state.name, name.name) for state, name in entries.items()])


def ladders() -> str:
    """A table of the safety ladder: which fault leads to what, after how many cycles."""
    columns = ("fault", *(reaction.name for reaction in Reaction if reaction))
    rows = []
    for fault, steps in LADDERS.items():
        bounds = {reaction: str(cycles) for cycles, reaction in steps}
        rows.append((fault.name, *(bounds.get(r, "") for r in Reaction if r)))
    return table(columns, rows)


def some(chosen: Collection[Enum], members: Collection[Enum]) -> str:
    """Some members of an enumeration, by the shorter of what they are and what they are not."""
    if len(chosen) == len(members):
        return "any"
    if 2 * len(chosen) <= len(members):
        return ", ".join(member.name for member in chosen)
    return "not " + ", ".join(member.name for member in members if member not in chosen)


def missed(action: StateAction) -> str:
    """What is missed at the next SYNC: after a cycle that owes a DAC, and after any other."""
    without = ["no DAC: MEASURE, else SETPOINT, else ERROR"] * action.owes_dac
    return "; ".join([*without, *["no SETPOINT_1: SETPOINT"] * action.expects_setpoint])


def actions() -> str:
    """A table of what a joint does where its state, its reaction and SYNC's state meet."""
    columns = (
        *("state", "reaction", "SYNC", "torque", "sends"),
        *("missed at the next SYNC", "watches", "MEASURE of"),
    )
    rows = []
    for state, reactions, bus_states, action in ROWS:
        watches = ["encoder"] * action.bridges_encoder + ["range"] * action.watches_range
        rows.append(
            (
                *(state.name, some(reactions, tuple(Reaction)), some(bus_states, tuple(NodeState))),
                *(action.torque.name, ", ".join(action.sends), missed(action), ", ".join(watches)),
                "any cycle" if action.any_sample else "this cycle",
            )
        )
    return table(columns, rows)


def render() -> str:
    """The three diagrams, each under its heading, the safety ladder, and a joint's actions."""
    return "\n\n".join(
        [
            "## A node (`rfms_can/joint_nodes/states.py`)",
            diagram(NODE),
            "The safety ladder: after how many cycles in a row a fault leads to which reaction.",
            ladders(),
            "What a joint does (`rfms_can/joint_nodes/state_actions.py`), by its state, its "
            "reaction and the state in SYNC.",
            actions(),
            "## The master (`rfms_can/master/phases.py`)",
            diagram(PHASES),
            names("phase", "state in SYNC", BUS_STATES),
            "## The trajectory generator (`rfms_can/master/trajectory/states.py`)",
            diagram(GENERATOR),
            names("stage", "state in SETPOINT", ON_THE_WIRE),
        ]
    )


if __name__ == "__main__":
    main("draw_states.py", "states.md", render)
