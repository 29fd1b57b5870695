"""Sheets to draw on: matplotlib without a display or global state, and the look of all plots.

Raises ``PlotError`` on import where matplotlib is missing.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from rfms_can.errors import RfmsError


class PlotError(RfmsError):
    """Plots cannot be drawn or written."""


try:
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
except ImportError as error:
    raise PlotError("plots need matplotlib: pip install 'rfms_can[viz]'") from error

INK: Final = "#22303c"
FAINT: Final = "#8a97a3"
LIMIT: Final = "#c0392b"
BAND: Final = "#e8eef4"
COMMANDED: Final = "#f2a33a"
MEASURED: Final = "#1f5f99"
JOINT_COLORS: Final = ("#1f5f99", "#e07b27", "#2f8f5b", "#b83a4b", "#7a5aa6", "#7c6a58")

_STYLE: Final[dict[str, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.xmargin": 0.01,
    "axes.formatter.useoffset": False,
    "grid.color": "#dfe5ea",
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "svg.fonttype": "none",
    "svg.hashsalt": "rfms_can",
}
_DPI: Final = 130


class Sheet:
    """One page: a title, and panels that share the time axis of their column.

    Args:
        title: first line, bold; says what is shown.
        subtitle: below it; says of which run.
        shape: rows and columns of panels.
        size: width and height, inches.
        heights: of the rows, relative.
        subtitle_lines: of the subtitle.
    """

    def __init__(
        self,
        title: str,
        subtitle: str,
        shape: tuple[int, int],
        size: tuple[float, float],
        heights: Sequence[float] | None = None,
        subtitle_lines: int = 1,
    ) -> None:
        with rc_context(_STYLE):
            titles = 0.48 + 0.18 * subtitle_lines
            below_titles = (0.0, 0.0, 1.0, 1.0 - titles / size[1])
            engine = ConstrainedLayoutEngine(rect=below_titles, w_pad=0.08, h_pad=0.06)
            self.figure: Any = Figure(figsize=size, layout=engine)
            grid = self.figure.subplots(
                *shape, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
            )
        self.panels: list[Any] = list(grid.flat)
        self._bottom: list[Any] = list(grid[-1])
        top = 1.0 - 0.16 / size[1]
        left = 0.14 / size[0]
        self.figure.text(
            left, top, title, ha="left", va="top", fontsize=13, fontweight="bold", color=INK
        )
        self.figure.text(
            left, top - 0.25 / size[1], subtitle, ha="left", va="top", fontsize=9.5, color=FAINT
        )

    def title_panel(self, index: int, title: str, unit: str) -> Any:
        """Name panel ``index`` (row by row) and its unit; returns its axes."""
        axes = self.panels[index]
        axes.set_title(title, loc="left", fontsize=10, fontweight="bold", color=INK)
        axes.set_ylabel(unit)
        axes.locator_params(axis="y", nbins=6)
        return axes

    def legend(self, handles: Sequence[Any], labels: Sequence[str]) -> None:
        """One legend for the sheet, above the panels at the right, beside the subtitle."""
        width, height = self.figure.get_size_inches()
        self.figure.legend(
            handles,
            labels,
            loc="upper right",
            bbox_to_anchor=(1.0 - 0.06 / width, 1.0 - 0.3 / height),
            ncols=len(labels),
            frameon=False,
            fontsize=9.5,
            labelcolor=INK,
            handlelength=1.6,
            columnspacing=1.2,
        )

    def legend_below(self, handles: Sequence[Any], labels: Sequence[str], columns: int) -> None:
        """One legend for the sheet, under the panels."""
        self.figure.legend(
            handles,
            labels,
            loc="outside lower left",
            ncols=columns,
            frameon=False,
            fontsize=9.5,
            labelcolor=INK,
            handlelength=1.6,
            columnspacing=1.2,
        )

    def save(self, path: Path, time_label: str = "time since enable, s") -> Path:
        """Write the sheet; the suffix of ``path`` says in which format.

        Raises:
            PlotError: the file cannot be written.
        """
        for axes in self._bottom:
            axes.set_xlabel(time_label)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with rc_context(_STYLE):
                self.figure.savefig(path, dpi=_DPI)
        except OSError as error:
            raise PlotError(f"cannot write {path}: {error.strerror or error}") from error
        except ValueError as error:  # of the suffix
            raise PlotError(f"cannot write {path}: {error}") from error
        return path
