"""A map of stability over two joints, laws side by side."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.canvas import FAINT, INK, LIMIT, MEASURED, Sheet
from rfms_can.analysis.stability.survey import Grid, Survey
from rfms_can.kinematics import singularity_margins

_CALM: Final = "#e4efe6"
_SLOWEST, _FASTEST = 1e-1, 1e3
"""Growth rates, 1/s, at the ends of the colours."""

Values = npt.NDArray[np.float64]


def draw_stability_map(grid: Grid, surveys: Sequence[Survey], path: Path) -> Path:
    """Draw the growth of the fastest growing motion over a grid, one panel a law.

    Green is stable; colour is how fast a disturbance grows; hatched is stable without sampling and
    unstable on the bus; lines are the singularities of the arm.

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
    sheet = Sheet(
        f"Stability of {study.arm.name}, complying in {study.selection.word or 'nothing'}",
        f"compliance frame ({tool.px:g}, {tool.py:g}, {tool.pz:g}) m from T6; "
        f"{study.rate_hz:g} Hz; friction {study.friction}{gains}",
        (1, len(surveys)),
        (4.6 * len(surveys) + 1.2, 5.4),
    )
    image: Any = None
    for index, entry in enumerate(surveys):
        axes = sheet.title_panel(index, _title(entry), f"joint {grid.joints[0] + 1}, deg")
        image = _draw(axes, grid, entry)
    bar = sheet.figure.colorbar(image, ax=sheet.panels, shrink=0.85, extend="both")
    bar.set_label("growth of the fastest unstable motion, 1/s")
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
    _singularities(axes, grid, entry)
    axes.grid(visible=False)
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(down[0], down[-1])
    return image


def _log_norm() -> Any:
    from matplotlib.colors import LogNorm  # noqa: PLC0415  (matplotlib is an extra)

    return LogNorm(_SLOWEST, _FASTEST)


def _singularities(axes: Any, grid: Grid, entry: Survey) -> None:
    """Zero lines of the margins, named where they are met."""
    arm, shape = entry.study.arm, (len(grid.first), len(grid.second))
    margins = np.array([singularity_margins(arm, q) for q in grid.poses])
    across, down = np.degrees(grid.second), np.degrees(grid.first)
    for name, values, colour in zip(
        ("elbow", "shoulder", "wrist"), margins.T, (MEASURED, FAINT, LIMIT), strict=True
    ):
        if values.min() < 0.0 < values.max():
            lines = axes.contour(
                across, down, values.reshape(shape), levels=[0.0], colors=[colour], linewidths=1.0
            )
            axes.clabel(lines, fmt={0.0: name}, fontsize=8, colors=INK)
