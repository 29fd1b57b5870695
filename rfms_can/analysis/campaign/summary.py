"""Summary of a campaign: one row for each law, loop and friction."""

from collections.abc import Sequence
from statistics import fmean, median
from typing import Final, NamedTuple

from rich.table import Table

from rfms_can.analysis.campaign.job import Group, Insertion
from rfms_can.compliance import ControlLaw

BASELINE: Final = ControlLaw.POSITION
"""The law whose lateral peaks the others' are divided by."""
HEADINGS = (
    "law",
    "loop",
    "friction",
    "off by",
    "in",
    "lateral peak N, median",
    "largest",
    "to position's",
    "lateral mean N",
    "axial peak N, median",
    "time s",
)


class Row(NamedTuple):
    """A group in numbers.

    Attributes:
        group: what it is of.
        runs, inserted: how many, and how many went in.
        peak, largest: median and largest lateral peak, N.
        ratio: its lateral peaks over pure position control's on the same misalignments, mean over
            mean; None without them.
        mean: lateral force in contact, N, mean over all runs.
        axial: median of the axial peaks, N.
        seconds: median time from contact to the bottom, of those that went in.
    """

    group: Group
    runs: int
    inserted: int
    peak: float
    largest: float
    ratio: float | None
    mean: float
    axial: float
    seconds: float

    @property
    def cells(self) -> tuple[str, ...]:
        """For a table."""
        group = self.group
        return (
            group.law,
            group.loop,
            group.friction,
            f"{group.offset_mm:g} mm, {group.tilt_deg:g}°",
            f"{self.inserted} of {self.runs}",
            f"{self.peak:.1f}",
            f"{self.largest:.1f}",
            "" if self.ratio is None else f"{self.ratio:.2f}",
            f"{self.mean:.1f}",
            f"{self.axial:.1f}",
            f"{self.seconds:.2f}" if self.inserted else "",
        )


def rows_of(results: Sequence[Insertion]) -> list[Row]:
    """A row for each group, in the order they come."""
    groups: dict[Group, list[Insertion]] = {}
    for result in results:
        groups.setdefault(result.group, []).append(result)
    return [_row(group, found, groups) for group, found in groups.items()]


def _row(group: Group, found: list[Insertion], groups: dict[Group, list[Insertion]]) -> Row:
    into = [result for result in found if result.inserted]
    peaks = [result.lateral_peak for result in found]
    return Row(
        group,
        len(found),
        len(into),
        median(peaks),
        max(peaks),
        _ratio(group, found, groups),
        fmean(result.lateral_mean for result in found),
        median(result.axial_peak for result in found),
        median(result.seconds for result in into) if into else 0.0,
    )


def _ratio(
    group: Group, found: list[Insertion], groups: dict[Group, list[Insertion]]
) -> float | None:
    """Lateral peaks over those of position control, over the misalignments both have met."""
    rigid = group._replace(law=BASELINE.value, loop="open")
    theirs = {result.seed: result.lateral_peak for result in groups.get(rigid, [])}
    both = [(r.lateral_peak, theirs[r.seed]) for r in found if r.seed in theirs]
    if not both or group == rigid:
        return None
    return fmean(ours for ours, _ in both) / fmean(rigid_peak for _, rigid_peak in both)


def table(rows: Sequence[Row]) -> Table:
    """For a terminal."""
    drawn = Table(title="peg in hole")
    for heading in HEADINGS:
        drawn.add_column(heading, justify="left" if heading in HEADINGS[:4] else "right")
    for row in rows:
        drawn.add_row(*row.cells)
    return drawn


def markdown(rows: Sequence[Row]) -> str:
    """For a page."""
    lines = ["| " + " | ".join(HEADINGS) + " |", "|" + "---|" * len(HEADINGS)]
    lines += ["| " + " | ".join(row.cells) + " |" for row in rows]
    return "\n".join(lines) + "\n"
