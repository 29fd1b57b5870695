"""A map of stability over two joints, laws side by side."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.canvas import INK, LIMIT, MEASURED, Sheet
from rfms_can.analysis.stability.survey import Grid, Survey
from rfms_can.kinematics import singularity_margins

_CALM: Final = "#e4efe6"
_SLOWEST, _FASTEST = 1e-1, 1e3
"""Growth rates, 1/s, at the ends of the colours."""

_LINES: Final = {"elbow": MEASURED, "shoulder": INK, "wrist": LIMIT}

Values = npt.NDArray[np.float64]


def draw_stability_map(grid: Grid, surveys: Sequence[Survey], path: Path) -> Path:
    """Draw the growth of the fastest growing motion over a grid, one panel a law.

    Green grows nowhere (it may drift); colour is how fast a disturbance grows; hatched grows on the
    bus only; lines are the singularities of the arm.

    Args:
        grid: the poses.
        surveys: one for each law, over the poses of the grid.
        path: of the picture; its suffix says in which format.

    Raises:
        PlotError: the file cannot be written.
    """
    study = surveys[0].study
    tool = study.frame
    natural = " ".join(f"{wn:g}" for wn in study.natural)
    gains = f"; {study.law.value} with {natural} rad/s" if natural else ""
    others = ", ".join(
        f"θ{joint + 1} {np.degrees(angle):.0f}°"
        for joint, angle in enumerate(grid.poses[0])
        if joint not in grid.joints
    )
    sheet = Sheet(
        f"Stability of {study.arm.name}, complying in {study.selection.word or 'nothing'}",
        f"compliance frame ({tool.px:g}, {tool.py:g}, {tool.pz:g}) m from T6; "
        f"{study.rate_hz:g} Hz; friction {study.friction}{gains}\n{others}",
        (1, len(surveys)),
        (4.6 * len(surveys) + 1.2, 6.0),
        subtitle_lines=2,
    )
    image: Any = None
    met: dict[str, str] = {}
    for index, entry in enumerate(surveys):
        axes = sheet.title_panel(index, _title(entry), f"joint {grid.joints[0] + 1}, deg")
        image = _draw(axes, grid, entry)
        met |= _singularities(axes, grid, entry)
    bar = sheet.figure.colorbar(image, ax=sheet.panels, shrink=0.85, extend="both")
    bar.set_label("growth of the fastest unstable motion, 1/s")
    marks = {"grows nowhere": _patch(), "grows on the bus": _patch("////")}
    marks |= {f"{name} singularity": _line(colour) for name, colour in met.items()}
    sheet.legend_below(list(marks.values()), list(marks), columns=2 * len(surveys))
    return sheet.save(path, f"joint {grid.joints[1] + 1}, deg")


def _title(entry: Survey) -> str:
    total, word = len(entry.analyses), entry.study.law.value
    sampled = entry.unstable_sampled
    return f"{word}: {entry.unstable} of {total} unstable, {sampled} on the bus"


def _draw(axes: Any, grid: Grid, entry: Survey) -> Any:
    shape = (len(grid.first), len(grid.second))
    down, across = np.degrees(grid.first), np.degrees(grid.second)
    growth = np.array([a.growth for a in entry.analyses]).reshape(shape)
    late = np.array([a.growth <= 0.0 and not a.sampled_stable for a in entry.analyses])
    axes.set_facecolor(_CALM)
    image = axes.pcolormesh(
        across,
        down,
        np.ma.masked_less_equal(growth, 0.0),
        norm=_log_norm(),
        cmap="YlOrRd",
        shading="nearest",
        rasterized=True,
    )
    if late.any():
        axes.contourf(
            across, down, late.reshape(shape), levels=[0.5, 1.5], colors="none", hatches=["////"]
        )
    axes.grid(visible=False)
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(down[0], down[-1])
    return image


def _patch(hatch: str = "") -> Any:
    """What stands in the legend for a region."""
    from matplotlib.patches import Patch  # noqa: PLC0415  (matplotlib is an extra)

    return Patch(facecolor=_CALM, edgecolor=INK, hatch=hatch, linewidth=0.4)


def _line(colour: str) -> Any:
    """What stands in the legend for a line."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  (matplotlib is an extra)

    return Line2D([], [], color=colour, linewidth=1.2)


def _log_norm() -> Any:
    from matplotlib.colors import LogNorm  # noqa: PLC0415  (matplotlib is an extra)

    return LogNorm(_SLOWEST, _FASTEST)


def _singularities(axes: Any, grid: Grid, entry: Survey) -> dict[str, str]:
    """Draw the zero lines of the margins; those that are met, and their colours."""
    arm, shape = entry.study.arm, (len(grid.first), len(grid.second))
    margins = np.array([singularity_margins(arm, q) for q in grid.poses])
    across, down = np.degrees(grid.second), np.degrees(grid.first)
    met = {}
    for (name, colour), values in zip(_LINES.items(), margins.T, strict=True):
        if values.min() < 0.0 < values.max():
            axes.contour(
                across, down, values.reshape(shape), levels=[0.0], colors=[colour], linewidths=1.2
            )
            met[name] = colour
    return met
