"""A peg's way into its hole: what it met, and where it went; needs matplotlib."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from rfms_can.analysis.canvas import BAND, COMMANDED, FAINT, INK, LIMIT, MEASURED, Sheet
from rfms_can.plant.scene.peg_in_hole import PegInHole
from rfms_can.rig.truth import Truth

PEG: Final = PegInHole()
BEFORE: Final = 0.6
"""Time shown before the first contact, s."""
STEEL: Final = "#c9d1d8"


def draw(rows: Sequence[Truth], period_s: float, subtitle: str, path: Path) -> Path:
    """Write the picture of an insertion.

    Args:
        rows: the truth of its cycles.
        period_s: control period, s.
        subtitle: of which run.
        path: where to.

    Raises:
        PlotError: the file cannot be written.
    """
    touched = [k for k, row in enumerate(rows) if row.contact.points]
    first = max(touched[0] - round(BEFORE / period_s), 0) if touched else 0
    shown = rows[first : (touched[-1] if touched else len(rows) - 1) + round(0.4 / period_s)]
    sheet = Sheet("A peg finds its hole", subtitle, (3, 1), (9.6, 6.2), (1.0, 1.0, 1.0))
    time = [row.cycle * period_s for row in shown]
    depth = sheet.title_panel(0, "Depth of the peg's end", "mm")
    depth.plot(time, [-1e3 * row.tip.pz for row in shown], color=MEASURED)
    depth.axhline(0.0, color=FAINT, linewidth=0.8)
    aside = sheet.title_panel(1, "Its end beside the axis of the hole", "mm")
    for axis, color in (("px", MEASURED), ("py", COMMANDED)):
        label = axis[1]
        aside.plot(time, [1e3 * getattr(row.tip, axis) for row in shown], color=color, label=label)
    aside.axhspan(-1e3 * PEG.clearance, 1e3 * PEG.clearance, color=BAND, zorder=0)
    aside.text(time[0], 1e3 * PEG.clearance, " clearance", color=FAINT, fontsize=8, va="bottom")
    aside.legend(frameon=False, ncols=2, loc="upper right", fontsize=9)
    force = sheet.title_panel(2, "Force of the hole on the peg, mean of each period", "N")
    across = [math.hypot(*row.contact.force[:2]) for row in shown]
    force.plot(time, across, color=LIMIT, label="across")
    along = [abs(row.contact.force[2]) for row in shown]
    force.plot(time, along, color=FAINT, label="along", linewidth=0.9)
    force.legend(frameon=False, ncols=2, loc="upper right", fontsize=9)
    _side_view(sheet, shown)
    return sheet.save(path)


def _side_view(sheet: Sheet, rows: Sequence[Truth]) -> None:
    """Hole and peg in the plane the hole is off in, at the right of the panels."""
    figure = sheet.figure
    figure.get_layout_engine().set(rect=(0.0, 0.0, 0.72, 0.9))
    axes = figure.add_axes((0.755, 0.09, 0.225, 0.76))
    axes.set_in_layout(False)
    axes.set_title("Side view, mm", loc="left", fontsize=10, fontweight="bold", color=INK)
    bore, mouth = 1e3 * (PEG.radius + PEG.clearance), 1e3 * PEG.chamfer
    depth, wall = 1e3 * PEG.depth, 9.0
    for side in (-1.0, 1.0):
        edge = [
            *((side * (bore + mouth), 0.0), (side * bore, -mouth), (side * bore, -depth)),
            *((side * (bore + wall), -depth), (side * (bore + wall), 0.0)),
        ]
        axes.fill(*zip(*edge, strict=True), color=STEEL, linewidth=0.0)
    start = next((row for row in rows if row.contact.points), rows[0])
    angle = math.atan2(start.tip.py, start.tip.px)
    deepest = min(rows, key=lambda row: row.tip.pz)
    for row, color, filled in ((start, COMMANDED, False), (deepest, MEASURED, True)):
        _peg(axes, row, angle, color, filled)
    path = [(_across(row, angle), 1e3 * row.tip.pz) for row in rows if row.tip.pz >= deepest.tip.pz]
    down = path[: path.index((_across(deepest, angle), 1e3 * deepest.tip.pz)) + 1]
    axes.plot(*zip(*down, strict=True), color=INK, linewidth=1.0)
    axes.set_aspect("equal")
    axes.set_xlim(-21.0, 21.0)
    axes.set_ylim(-54.0, 66.0)
    axes.grid(False)


def _across(row: Truth, angle: float) -> float:
    return 1e3 * (math.cos(angle) * row.tip.px + math.sin(angle) * row.tip.py)


def _peg(axes: Any, row: Truth, angle: float, color: str, filled: bool) -> None:
    """Outline of the peg, its end at the tip, leaning as it does in this plane."""
    tip = row.tip
    lean = -(math.cos(angle) * tip.ax + math.sin(angle) * tip.ay)  # z of the tip points down
    up = math.sqrt(max(0.0, 1.0 - lean * lean))
    x, z, radius, length = _across(row, angle), 1e3 * tip.pz, 1e3 * PEG.radius, 1e3 * PEG.length
    corners = [
        (x + a * radius * up + b * length * lean, z - a * radius * lean + b * length * up)
        for a, b in ((-1, 0), (1, 0), (1, 1), (-1, 1), (-1, 0))
    ]
    if filled:
        axes.fill(*zip(*corners, strict=True), color=color, alpha=0.25, linewidth=0.0)
    axes.plot(*zip(*corners, strict=True), color=color, linewidth=1.0)
