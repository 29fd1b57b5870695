"""The joints' accelerations under each planner, one panel each; needs matplotlib."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from planners.bench import PLANNERS
from planners.planner import NotPossibleError
from planners.run import Run
from planners.smoothness import differences, peak
from planners.task import Task
from rfms_can.analysis.canvas import JOINT_COLORS, Sheet

SHOWN: Final = 16.0
"""Accelerations shown, rad/s2; what is beyond is told in words."""


def draw(task: Task, names: Sequence[str], period_s: float, path: Path) -> None:
    """Write the picture of the planners that can do ``task``.

    Raises:
        PlotError: the file cannot be written.
    """
    runs: dict[str, Run] = {}
    for name in names:
        try:
            runs[name] = Run(PLANNERS[name], task, period_s)
        except NotPossibleError:
            continue
    sheet = Sheet(
        f"Six joints' accelerations in the task {task.name}",
        f"{task.arm.name} · {1.0 / period_s:g} Hz · second differences",
        (len(runs), 1),
        (8.4, 0.8 + 1.35 * len(runs)),
    )
    for index, (name, run) in enumerate(runs.items()):
        most = peak(run, 2)
        title = name if most <= SHOWN else f"{name} (up to {most:.0f} rad/s²)"
        axes = sheet.title_panel(index, title, "rad/s²")
        axes.set_ylim(-SHOWN, SHOWN)
        for joint, color in enumerate(JOINT_COLORS):
            axes.plot(run.time, differences(run, 2)[:, joint], color=color, linewidth=1.0)
    lines = sheet.panels[0].lines
    sheet.legend(lines, [f"joint {number}" for number in range(1, len(lines) + 1)])
    sheet.save(path, "time, s")
