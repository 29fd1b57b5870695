"""What ``rfms stability`` prints: the poles of a pose, the count of a survey, JSON."""

from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from rfms_can.analysis.stability import Analysis, Study, Survey, largest_frequency

_SHOWN: Final = 20
"""Poses of a survey that are listed."""


def as_plain(found: Survey) -> dict[str, Any]:
    """A survey as JSON takes it."""
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
        "margin": a.margin if a.margin is None or np.isfinite(a.margin) else None,
        "conflicts": list(a.conflicts),
    }


def print_pose(study: Study, a: Analysis) -> None:
    """Poles of both loops, and how far they are from instability."""
    console, period = Console(highlight=False), 1.0 / study.rate_hz
    table = Table(title=f"{study.arm.name}, law {study.law.value}, {study.selection.word}")
    for heading in ("pole 1/s", "frequency rad/s", "damping", "on the bus", "size"):
        table.add_column(heading, justify="right")
    sampled = sorted(a.sampled.tolist(), key=abs, reverse=True)
    for p, z in zip(a.poles.tolist(), sampled, strict=False):
        ratio = f"{-p.real / abs(p):.3f}" if abs(p) > 0.0 else "-"
        table.add_row(_complex(p, 3), f"{abs(p):.3f}", ratio, _complex(z, 4), f"{abs(z):.4f}")
    console.print(table)
    console.print(f"continuous: {a.verdict.value}, growth {a.growth:.4g} 1/s")
    console.print(
        f"on the bus at {study.rate_hz:g} Hz: {'stable' if a.sampled_stable else 'unstable'}; "
        f"unstable from {a.margin:.3g} times the natural frequency on; "
        f"a joint alone from {largest_frequency(period, study.damping_ratio):.4g} rad/s on"
    )
    for conflict in a.conflicts:
        console.print(conflict, markup=False)


def _complex(value: complex, digits: int) -> str:
    imaginary = f" {value.imag:+.{digits}f}j" if abs(value.imag) > 0.5 * 10.0**-digits else ""
    return f"{value.real:.{digits}f}{imaginary}"


def print_survey(found: Survey) -> None:
    """How many poses are unstable, and the worst of them."""
    console, study = Console(highlight=False), found.study
    total = len(found.analyses)
    bad = sorted((a for a in found.analyses if a.growth > 0.0), key=lambda a: -a.growth)
    if bad:
        table = Table(title="fastest growing")
        for heading in ("joint angles rad", "growth 1/s", "on the bus"):
            table.add_column(heading, justify="right")
        for a in bad[:_SHOWN]:
            angles = " ".join(f"{angle:7.3f}" for angle in a.q)
            table.add_row(angles, f"{a.growth:.3g}", f"{float(np.abs(a.sampled).max()):.4f}")
        console.print(table)
    console.print(
        f"{study.arm.name}, law {study.law.value}, {study.selection.word}: {found.unstable} of "
        f"{total} poses unstable, {found.unstable_sampled} on the bus at {study.rate_hz:g} Hz; "
        f"C damped at {found.conflicting}"
    )
