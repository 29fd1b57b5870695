"""Draw the state tables of nodes, master and trajectory generator into docs/states.md (mermaid)."""

from collections.abc import Mapping
from enum import Enum
from typing import TypeVar

from generated import main, table

from rfms_can.joint_nodes.ladder import LADDERS, Reaction
from rfms_can.joint_nodes.states import TRANSITIONS as NODE
from rfms_can.master.phases import BUS_STATES, PHASES
from rfms_can.master.trajectory.states import ON_THE_WIRE
from rfms_can.master.trajectory.states import TRANSITIONS as GENERATOR

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


def render() -> str:
    """The three diagrams, each under its heading, and the safety ladder."""
    return "\n\n".join(
        [
            "## A node (`rfms_can/joint_nodes/states.py`)",
            diagram(NODE),
            "The safety ladder: after how many cycles in a row a fault leads to which reaction.",
            ladders(),
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
