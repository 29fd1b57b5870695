"""A plot around a fault: where the joints are, how fast, what their nodes do."""

from pathlib import Path
from typing import Any, Final

from rfms_can.analysis.canvas import FAINT, JOINT_COLORS, LIMIT, Sheet
from rfms_can.arm import Arm
from rfms_can.faults.facts import Facts
from rfms_can.faults.trial import Result, Trial
from rfms_can.faults.watch import Moment
from rfms_can.wire.nodes import JOINTS

PERIOD_S: Final = 0.004


def draw(trial: Trial, result: Result, arm: Arm, moments: list[Moment], path: Path) -> Path:
    """Draw a trial; the file.

    Raises:
        PlotError: it cannot be written.
    """
    facts = result.facts
    verdict = "met" if result.met else "; ".join(result.problems)
    sheet = Sheet(
        f"{trial.row} {trial.variant}, seed {trial.seed}, {trial.arm}",
        verdict if len(verdict) <= _LONGEST else f"{verdict[:_LONGEST]} ...",
        (4, 1),
        (9.0, 9.0),
        heights=(2.0, 2.0, 1.0, 1.0),
    )
    time = [moment.time_s for moment in moments]
    off = sheet.title_panel(0, "joint angle less commanded", "rad")
    speed = sheet.title_panel(1, "joint speed over its limit", "1")
    states = sheet.title_panel(2, "node state (2 homing, 4 operational, 5 quickstop, 6 fault)", "")
    brakes = sheet.title_panel(3, "brakes that hold", "joint")
    handles: list[Any] = []
    for index, (color, limit) in enumerate(zip(JOINT_COLORS, arm.speed_limits, strict=True)):
        errors = [moment.q[index] - moment.goal[index] for moment in moments]
        handles += off.plot(time, errors, color=color)
        speed.plot(time, [moment.qd[index] / limit for moment in moments], color=color)
        states.step(time, [moment.states[index] for moment in moments], color=color, where="post")
        held = [index + 1 if moment.brakes[index] else None for moment in moments]
        brakes.plot(time, held, color=color, linewidth=4.0)
    speed.axhline(1.0, color=LIMIT, linewidth=0.8)
    speed.axhline(-1.0, color=LIMIT, linewidth=0.8)
    brakes.set_ylim(0.5, len(JOINTS) + 0.5)
    for axes in (off, speed, states, brakes):
        _mark(axes, facts)
    sheet.legend_below(handles, [f"joint {joint}" for joint in JOINTS], len(JOINTS))
    return sheet.save(path, f"time since the fault was put in, s ({_LINES})")


_LONGEST: Final = 110
_LINES: Final = "solid: its effect begins; dotted: it is counted; dashed: the first joint stops"


def _mark(axes: Any, facts: Facts | None) -> None:
    """Lines at the first effect, and where the fault was counted and reacted to."""
    if facts is None or facts.effect is None:
        return
    for cycles, style in ((0.0, "-"), (facts.counted, ":"), (facts.stopped, "--")):
        if cycles is not None:
            axes.axvline((facts.effect + cycles) * PERIOD_S, color=FAINT, linestyle=style)
