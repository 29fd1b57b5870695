"""What a peg in a hole came to, in numbers, from the plant's truth."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.rig.truth import Truth

INSERTED: Final = 0.039
"""Depth, m, from which a peg that goes in by 40 mm counts as in: the rest is the servo's error."""


class PegFigures(NamedTuple):
    """Of one insertion, until the peg was in or the run was over.

    Attributes:
        depth: deepest that the peg's end was, m.
        lateral_peak, lateral_mean: force across the peg, period means, N: the largest, and the
            mean over the cycles in contact.
        axial_peak: the largest along it, N.
        cycles: from the first contact until it was in.
        end: index of the row at which it was.
    """

    depth: float
    lateral_peak: float
    lateral_mean: float
    axial_peak: float
    cycles: int
    end: int


def peg_figures(rows: Sequence[Truth]) -> PegFigures:
    """The figures of a run, from the truth of its cycles."""
    deepest = max((-row.tip.pz for row in rows), default=0.0)
    end = next((k for k, row in enumerate(rows) if -row.tip.pz >= INSERTED), len(rows) - 1)
    touching = [row.contact.force for row in rows[: end + 1] if row.contact.points]
    first = next((k for k, row in enumerate(rows) if row.contact.points), end)
    lateral = [math.hypot(x, y) for x, y, _ in touching]
    return PegFigures(
        deepest,
        max(lateral, default=0.0),
        sum(lateral) / len(lateral) if lateral else 0.0,
        max((abs(z) for _, _, z in touching), default=0.0),
        max(end - first, 0),
        end,
    )
