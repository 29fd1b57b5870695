"""The comparison as tables."""

from collections.abc import Sequence

from rich.table import Table

from planners.bench import Figures, Row

COLUMNS = (
    "line mm", "deg", "corner mm", "goal mm", "rad/s²", "rad/s³", "order",
    "us", "x ours", "worst us", "x ours", "before ms", "time s",
)  # fmt: skip

NOTES = (
    "line, deg: tool from the straight line and its rotation (in the goal's frame, if it moves); "
    "corner: the same in transitions, from the nearer line; goal: from the last goal, once reached",
    "rad/s², rad/s³: largest joint acceleration and jerk, as differences at the sample rate; "
    "* is a step, which grows with the rate",
    "order: joint derivatives that are continuous; us: a set-point of six joints, median and "
    "dearest; before: what is computed before the motion",
)


def table(title: str, rows: Sequence[Row]) -> Table:
    """One task's rows."""
    made = Table(title=title, title_justify="left")
    made.add_column("planner", no_wrap=True)
    for column in COLUMNS:
        made.add_column(column, justify="right")
    for row in rows:
        if row.figures is not None:
            made.add_row(row.planner, *cells(row.figures))
        else:
            made.add_row(row.planner, *("-" for _ in COLUMNS))
    return made


def reasons(rows: Sequence[Row]) -> list[str]:
    """Why the planners without figures have none."""
    return [
        f"{row.planner}: not possible: {row.not_possible}"
        for row in rows
        if row.not_possible is not None
    ]


def cells(figures: Figures) -> list[str]:
    """One row without its name, in the order of ``COLUMNS``."""
    f = figures
    return [
        _length(f.line_mm),
        "-" if f.line_deg is None else f"{f.line_deg:.2f}",
        _length(f.corner_mm),
        _length(f.goal_mm),
        f"{f.acceleration:.1f}" + ("" if f.order >= 1 else "*"),
        f"{f.jerk:.0f}" + ("" if f.order >= 2 else "*"),
        f"{f.order}" + ("+" if f.order >= 4 else ""),
        f"{f.cost_us:.1f}",
        f"{f.cost_ratio:.2f}",
        f"{f.worst_us:.1f}",
        f"{f.worst_ratio:.2f}",
        f"{f.prepared_ms:.1f}",
        f"{f.duration_s:.2f}",
    ]


def _length(mm: float | None) -> str:
    """Millimetres; what is rounding of doubles is 0."""
    if mm is None:
        return "-"
    return "0" if mm < 1e-6 else f"{mm:.3f}" if mm >= 5e-4 else f"{mm:.0e}"
