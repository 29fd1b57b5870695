"""Draw the state tables of nodes, master and trajectory generator into docs/states.md (mermaid)."""

from collections.abc import Mapping
from enum import Enum
from typing import TypeVar

from generated import main

from rfms_can.joint_nodes.states import TRANSITIONS as NODE
from rfms_can.master.phases import BUS_STATES, PHASES
from rfms_can.master.states import ON_THE_WIRE
from rfms_can.master.states import TRANSITIONS as GENERATOR

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


def words(heading: str, of: str, table: Mapping[State, Name]) -> str:
    """A table of what each state is called on the bus."""
    rows = [f"| {state.name} | {name.name} |" for state, name in table.items()]
    return "\n".join([f"| {heading} | {of} |", "|---|---|", *rows])


def render() -> str:
    """The three diagrams, each under its heading."""
    return "\n\n".join(
        [
            "## A node (`rfms_can/joint_nodes/states.py`)",
            diagram(NODE),
            "## The master (`rfms_can/master/phases.py`)",
            diagram(PHASES),
            words("phase", "state in SYNC", BUS_STATES),
            "## The trajectory generator (`rfms_can/master/states.py`)",
            diagram(GENERATOR),
            words("stage", "state in SETPOINT", ON_THE_WIRE),
        ]
    )


if __name__ == "__main__":
    main("draw_states.py", "states.md", render)
