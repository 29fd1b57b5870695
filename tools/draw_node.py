"""Print frames, tables and test vectors of a joint into docs/node.md and the pages beside it."""

from collections.abc import Callable
from typing import Final

import draw_states
from generated import main_of_pages
from node_book import (
    configuration,
    detectors,
    examples,
    kinematics,
    laws,
    life,
    protection,
    setpoints,
    tables,
)

TOOL: Final = "draw_node.py"
_SECTIONS: Final[dict[str, dict[str, Callable[[], str]]]] = {
    "node.md": {
        "frames": tables.frames,
        "crc": protection.crc_vectors,
        "counters": protection.counter_vectors,
        "bring-up": life.bring_up,
        "homing": life.homing,
        "operation": life.operation,
        "quickstop": life.quickstop,
        "estop": life.emergency_stop,
        "no-sync": life.no_sync,
        "cycle": examples.whole_cycle,
        "commands": tables.commands,
        "answers": configuration.answers,
        "parameters": configuration.parameters_of_a_joint,
        "hashes": configuration.hashes,
        "actions": draw_states.actions,
        "reactions": tables.reactions,
        "faults": tables.faults,
        "glitches": examples.glitches,
    },
    "node-kinematics.md": {
        "geometry": kinematics.geometries,
        "branches": kinematics.branches,
        "poses": kinematics.poses,
        "straight": kinematics.straight,
        "turns": kinematics.turns,
        "told": kinematics.told,
    },
    "node-setpoint.md": {
        "succession": setpoints.succession,
        "weights": setpoints.weights,
        "joint": setpoints.joint_trace,
        "line": setpoints.line_trace,
        "stopped": setpoints.stopped_trace,
        "departing": setpoints.departing_trace,
    },
    "node-detectors.md": {
        "tachometer": detectors.tachometer,
        "currents": detectors.currents,
        "heat": detectors.heat,
        "begins": detectors.begins,
    },
    "node-law.md": {
        "given": laws.given,
        "single": laws.single,
        "rest": laws.rest,
        "complying": laws.complying,
        "codes": laws.codes,
        "references": laws.references,
        "stop": laws.stop,
        "hold": laws.hold,
    },
}
PAGES: Final = {
    file: {f"{TOOL}: {name}": render for name, render in sections.items()}
    for file, sections in _SECTIONS.items()
}
"""What stands between which markers, page by page."""

if __name__ == "__main__":
    main_of_pages(TOOL, PAGES)
