"""The tables of ``rfms identify``."""

import math
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from rfms_can.arm.calibration import Calibration
from rfms_can.identification.compensation_comparison import (
    IDENTIFIED,
    TRUTH,
    UNCOMPENSATED,
    Tracking,
)
from rfms_can.identification.fit.result import Identification
from rfms_can.identification.fit.significance import significance
from rfms_can.identification.fit.summary import (
    compare_models,
    constant_figures,
    torque_figures,
)
from rfms_can.identification.fit.truth import VERDICTS, identities, thesis_constants
from rfms_can.rig.gains import gains
from rfms_can.rig.settings import RunSettings

LABELS = {
    "slope_positive": "A_p Nm/code",
    "offset_positive": "B_p Nm",
    "slope_negative": "A_n Nm/code",
    "offset_negative": "B_n Nm",
    "viscous": "viscous Nms/rad",
    "static_positive": "static + Nm",
    "static_negative": "static - Nm",
}
_WIDTH = 132


def _console() -> Console:
    """Standard output, wide enough for the tables."""
    return Console(highlight=False, width=max(Console().width, _WIDTH))


def _table(title: str, *headings: str) -> Table:
    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def print_report(
    found: Identification, calibration: Calibration, truth: Calibration, beside: str
) -> None:
    """All tables but that of the comparison; ``beside`` is the column title of ``truth``."""
    console = _console()
    _print_torque(console, calibration, truth, beside)
    _print_converters(console, found)
    _print_fits(console, found)
    _print_constants(console, calibration, truth, beside)
    _print_identities(console, found)
    models = compare_models(found, calibration, truth)
    table = _table(f"Over random poses: largest difference from the {beside}, %", "", *"123456")
    for name, errors in zip(("simplified D_ii", "full D_ii"), models.effective, strict=True):
        table.add_row(name, *(f"{100.0 * error:.2f}" for error in errors))
    console.print(table)
    console.print(
        f"gravity: largest error {100 * models.gravity[0]:.2f} % (simplified), "
        f"{100 * models.gravity[1]:.2f} % (full) of the largest; coupling D_ij: rms "
        f"{models.coupling[0]:.4f} kg m2, error {models.coupling[1]:.4f}"
    )
    table = _table("Motions no fit has seen: torque, rms Nm", "", *"123456")
    for name, values in zip(("measured", "not explained"), found.validation, strict=True):
        table.add_row(name, *(f"{value:.3f}" for value in values))
    console.print(table)
    for note in found.notes:
        console.print(note, markup=False)


def _print_torque(console: Console, found: Calibration, truth: Calibration, beside: str) -> None:
    table = _table(
        "Torque against current (Eq. 4.13, Table 4.1)",
        *("joint", "", "found", "deviation", beside, "error %"),
    )
    for joint, row in enumerate(torque_figures(found, truth), start=1):
        for figure in row:
            digits = 5 if "slope" in figure.name else 3
            table.add_row(
                str(joint) if figure is row[0] else "",
                LABELS[figure.name],
                f"{figure.value:.{digits}f}",
                f"{figure.deviation:.{digits}f}",
                f"{figure.truth:.{digits}f}",
                f"{100.0 * figure.error:+.2f}",
            )
        table.add_section()
    console.print(table)


def _print_converters(console: Console, found: Identification) -> None:
    table = _table("I_adc = A_c I_dac + B_c (Eq. 4.14)", "joint", "A_c", "B_c codes")
    for joint, fit in enumerate(found.converters, start=1):
        slope, offset = (
            f"{fit.values[name]:.4f} +- {fit.deviations[name]:.4f}" for name in ("slope", "offset")
        )
        table.add_row(str(joint), slope, offset)
    console.print(table)


def _print_fits(console: Console, found: Identification) -> None:
    table = _table("Least squares", "", "equations", "unknowns", "residual, rms", "condition")
    fits = [(f"torque of joint {k}, Nm", torque.fit) for k, torque in enumerate(found.torque, 1)]
    for name, fit in (*fits, ("gravity, Nm", found.gravity), ("inertia, kg m2", found.inertia)):
        numbers = (str(fit.equations), str(len(fit.values)))
        table.add_row(name, *numbers, f"{fit.residual:.4f}", f"{fit.condition:.1f}")
    for joint, (count, left) in enumerate(
        zip(found.links.equations, found.links.residual, strict=True), start=1
    ):
        unknowns = str(found.links.determined) if joint == 1 else ""
        table.add_row(f"links, joint {joint}, Nm", f"{count:.0f}", unknowns, f"{left:.4f}", "")
    console.print(table)


def _print_constants(console: Console, found: Calibration, truth: Calibration, beside: str) -> None:
    thesis = thesis_constants()
    table = _table(
        "Simplified dynamics: c Nm, b kg m2, convention B; errors in % of the largest of a kind",
        *("", "found", "deviation", beside, "error %", "thesis", "verdict on the thesis"),
    )
    table.columns[-1].justify = "left"
    table.columns[-1].no_wrap = False
    for figure in constant_figures(found, truth):
        verdict = VERDICTS.get(figure.name)
        said = "" if verdict is None else f"{verdict.word}: {verdict.why}".removesuffix(": ")
        table.add_row(
            figure.name,
            f"{figure.value:.4f}",
            f"{figure.deviation:.4f}",
            f"{figure.truth:.4f}",
            f"{100.0 * figure.error:+.2f}",
            f"{thesis[figure.name]:.3f}" if figure.name in thesis else "",
            said,
        )
    console.print(table)


def _print_identities(console: Console, found: Identification) -> None:
    """Identities that hold for any arm of this shape: here, and in Eq. 4.16 and 4.30."""
    table = _table(
        "One for every such arm", "", "must equal", "found", "", "thesis", "", "thesis ratio"
    )
    theirs = identities(found.arm, thesis_constants())
    for ours, other in zip(identities(found.arm, found.constants), theirs, strict=True):
        table.add_row(
            ours.name,
            ours.equals,
            *(f"{number:.3f}" for number in (ours.value, ours.expected)),
            *(f"{number:.3f}" for number in (other.value, other.expected)),
            f"{other.value / other.expected:.1f}",
        )
    console.print(table)


def print_significance(found: Identification) -> None:
    """Computation time and error of the simpler models (thesis IV.3, IV.4)."""
    table = _table(
        "Significance: torque a model misses, % of a joint's largest, worst joint",
        *("model", "us an update", "gross motion", "fine motion"),
    )
    for row in significance(found.arm, found.constants):
        table.add_row(
            row.model,
            f"{row.microseconds:.1f}",
            f"{100.0 * row.gross:.1f}",
            f"{100.0 * row.fine:.1f}",
        )
    _console().print(table)


def print_tracking(settings: RunSettings, runs: Sequence[Tracking]) -> None:
    """Tracking errors of one fast program with the same gains and different compensations."""
    console = _console()
    table = _table(
        "Fast motion: largest error of each joint while it moves, degrees",
        *("compensation", *"123456", "rms of all"),
    )
    for run in runs:
        largest = (f"{math.degrees(joint.moving_max):.4f}" for joint in run.joints)
        table.add_row(run.name, *largest, f"{math.degrees(run.rms):.4f}")
    console.print(table)
    table = _table("The same gains in all of them", "joint", "K_p Nm/rad", "K_i", "K_d Nms/rad")
    for joint, gain in enumerate(gains(settings), start=1):
        table.add_row(str(joint), f"{gain.kp:.1f}", f"{gain.ki:.0f}", f"{gain.kd:.2f}")
    console.print(table)
    rms = {run.name: run.rms for run in runs}
    line = f"identified: 1/{rms[UNCOMPENSATED] / rms[IDENTIFIED]:.1f} of no compensation"
    if TRUTH in rms:
        line += f", {rms[IDENTIFIED] / rms[TRUTH]:.2f} times the plant's truth"
    console.print(line)
