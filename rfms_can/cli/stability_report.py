"""Output of ``rfms stability``: the poles of a pose, the counts of a survey, JSON."""

from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from rfms_can.analysis.stability import Analysis, Study, Survey, largest_frequency

_SHOWN: Final = 20
"""Poses of a survey that are listed."""


def as_plain(found: Survey) -> dict[str, Any]:
    """A survey as plain data for JSON."""
    study = found.study
    return {
        "arm": study.arm.name,
        "word": study.selection.word,
        "tool": study.frame.rows(),
        "law": study.law.value,
        "rate_hz": study.rate_hz,
        "poses": len(found.analyses),
        "unstable": found.unstable,
        "unstable_sampled": found.unstable_sampled,
        "drifting": found.drifting,
        "damped": found.conflicting,
        "analyses": [_plain(analysis) for analysis in found.analyses],
    }


def _plain(a: Analysis) -> dict[str, Any]:
    return {
        "q": list(a.q),
        "verdict": a.verdict.value,
        "growth": a.growth,
        "poles": [[p.real, p.imag] for p in a.poles.tolist()],
        "sampled": [[p.real, p.imag] for p in a.sampled.tolist()],
        "sampled_stable": a.sampled_stable,
        "on_the_bus": a.on_the_bus.value,
        "margin": a.margin if a.margin is None or np.isfinite(a.margin) else None,
        "conflicts": list(a.conflicts),
    }


def print_pose(study: Study, a: Analysis) -> None:
    """Poles of both loops, and their stability margin."""
    console, period = Console(highlight=False), 1.0 / study.rate_hz
    name = f"{study.arm.name}, law {study.law.value}, {study.selection.word}"
    table = _table(f"{name}: continuous", "pole 1/s", "frequency rad/s", "damping")
    for p in a.poles.tolist():
        ratio = f"{-p.real / abs(p):.3f}" if abs(p) > 0.0 else "-"
        table.add_row(_complex(p, 3), f"{abs(p):.3f}", ratio)
    console.print(table)
    table = _table(f"{name}: from SYNC to SYNC", "pole", "size")
    for z in sorted(a.sampled.tolist(), key=abs, reverse=True):
        table.add_row(_complex(z, 4), f"{abs(z):.4f}")
    console.print(table)
    console.print(f"continuous: {a.verdict.value}, growth {a.growth:.4g} 1/s")
    console.print(
        f"on the bus at {study.rate_hz:g} Hz: {a.on_the_bus.value}; "
        f"unstable from {a.margin:.3g} times the natural frequency on; "
        f"a joint alone from {largest_frequency(period, study.damping_ratio):.4g} rad/s on"
    )
    for conflict in a.conflicts:
        console.print(conflict, markup=False)


def _table(title: str, *headings: str) -> Table:
    table = Table(title=title)
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def _complex(value: complex, digits: int) -> str:
    imaginary = f" {value.imag:+.{digits}f}j" if abs(value.imag) > 0.5 * 10.0**-digits else ""
    return f"{value.real:.{digits}f}{imaginary}"


def print_survey(found: Survey) -> None:
    """Number of unstable poses, and the worst of them."""
    console, study = Console(highlight=False), found.study
    total = len(found.analyses)
    unstable = [a for a in found.analyses if a.growth > 0.0 or not a.sampled_stable]
    bad = sorted(((a, float(np.abs(a.sampled).max())) for a in unstable), key=_badness)
    if bad:
        shown = min(len(bad), _SHOWN)
        title = f"the {shown} worst of {len(bad)} that are unstable, continuous or on the bus"
        table = _table(title, "joint angles rad", "growth 1/s", "on the bus")
        for a, size in bad[:_SHOWN]:
            angles = " ".join(f"{angle:7.3f}" for angle in a.q)
            table.add_row(angles, f"{a.growth:.3g}", f"{size:.4f}")
        console.print(table)
    console.print(
        f"{study.arm.name}, law {study.law.value}, {study.selection.word}: {found.unstable} of "
        f"{total} poses unstable, {found.unstable_sampled} on the bus at {study.rate_hz:g} Hz; "
        f"drifting, the compliant directions being undamped: {found.drifting}; "
        f"near a singularity, where C is bounded: {found.conflicting}"
    )


def _badness(pose: tuple[Analysis, float]) -> tuple[float, float]:
    a, size = pose
    return -max(a.growth, 0.0), -size
