"""The plots of a recorded run: an overview, one sheet for each quantity, one for each joint."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from rfms_can.analysis.canvas import (
    COMMANDED,
    FAINT,
    INK,
    JOINT_COLORS,
    LIMIT,
    MEASURED,
    Sheet,
)
from rfms_can.analysis.cycles import Floats
from rfms_can.analysis.recording import Recording, TorqueTerms
from rfms_can.arm import JOINT_COUNT

PAGE: Final = (11.0, 7.8)
"""Size of a sheet, inches."""

WIDE: Final = 3.2
"""Width of a commanded line that a measured one runs on."""

_PALE: Final = {"linewidth": 5.0, "alpha": 0.28}


class Trace(NamedTuple):
    """One line of a quantity: what it is called, its time, its values for six joints."""

    label: str
    time: Floats
    values: Floats


class Quantity(NamedTuple):
    """What a sheet, or a panel of a joint's sheet, shows.

    Attributes:
        name: file name of the sheet.
        title: what it is.
        unit: of the values.
        traces: of a recording: the reference first, if there is one, then what was measured.
        limits: lower and upper bound by joint index, if they are to be seen.
    """

    name: str
    title: str
    unit: str
    traces: Callable[[Recording], tuple[Trace | None, Trace | None]]
    limits: Callable[[Recording, int], tuple[float, float]] | None = None


def _commanded(recording: Recording, order: int) -> Trace:
    values = recording.derivative(order) if order else recording.commanded
    return Trace("commanded", recording.commanded_time, values)


def _torque_limits(recording: Recording, joint: int) -> tuple[float, float]:
    limit = recording.arm.drives[joint].torque_limit
    return -limit, limit


QUANTITIES: Final = (
    Quantity(
        "position",
        "Joint position",
        "rad",
        lambda r: (_commanded(r, 0), Trace("measured", r.time, r.q)),
    ),
    Quantity(
        "velocity",
        "Joint velocity",
        "rad/s",
        lambda r: (_commanded(r, 1), Trace("measured (velocity ADC)", r.time, r.speed)),
    ),
    Quantity("acceleration", "Joint acceleration", "rad/s²", lambda r: (_commanded(r, 2), None)),
    Quantity("jerk", "Joint jerk", "rad/s³", lambda r: (_commanded(r, 3), None)),
    Quantity(
        "error",
        "Tracking error",
        "encoder counts",
        lambda r: (None, Trace("set-point - encoder", r.time, r.error_counts)),
    ),
    Quantity(
        "torque",
        "Joint torque",
        "Nm",
        lambda r: (
            Trace("gravity", r.time, r.log.gravity),
            Trace("driven (DAC)", r.time, r.torque),
        ),
        _torque_limits,
    ),
)
"""All that is drawn joint by joint."""


TERM_COLORS: Final = {
    "gravity": "#7a5aa6",
    "inertia": "#2f8f5b",
    "friction": "#e07b27",
    "proportional": "#1f5f99",
    "derivative": "#b83a4b",
    "integral": "#7c6a58",
    "dither": "#4fb3bf",
    "bias": "#c2185b",
    "compliant_damping": "#8a9a2b",
    "transfer": "#5c6bc0",
    "saturation": LIMIT,
}
"""The terms of a joint's torque, in the order they are drawn."""

TERM_PANELS: Final = (
    ("Torque, and what of it is feedforward", ("gravity", "inertia", "friction")),
    ("Feedback", ("proportional", "derivative", "integral")),
    (
        "Force control, transfers and limits",
        ("dither", "bias", "compliant_damping", "transfer", "saturation"),
    ),
)


def describe(recording: Recording) -> str:
    """Which run, in one line."""
    cycles = len(recording.log.cycle)
    fault = f" · halted: {recording.summary.fault}" if recording.summary.fault else ""
    return (
        f"{recording.arm.name} · {cycles} cycles at {1.0 / recording.period_s:g} Hz "
        f"({cycles * recording.period_s:.1f} s){fault}"
    )


def _numbers(recording: Recording) -> str:
    """What the run amounted to, in one line."""
    load = recording.log.busy_ns.mean() * 1e-9 / recording.period_s
    return (
        f"largest error {finite_peak(recording.error_counts):.1f} counts · "
        f"{recording.summary.incomplete} deadline misses · bus load {load:.1%}"
    )


def draw_run(recording: Recording, out: Path, suffix: str) -> Iterator[Path]:
    """The overview, a sheet for each quantity, and the bus load; yields what it wrote."""
    yield overview(recording).save(out / f"run.{suffix}")
    for quantity in QUANTITIES:
        yield quantity_sheet(recording, quantity).save(out / f"{quantity.name}.{suffix}")
    yield bus_sheet(recording).save(out / f"bus_load.{suffix}")
    if recording.terms is not None:
        yield terms_sheet(recording, recording.terms).save(out / f"terms.{suffix}")


def draw_joint(recording: Recording, joint: int, out: Path, suffix: str) -> Iterator[Path]:
    """All quantities of one joint (1 to 6) on one sheet, and its torque's terms on another."""
    yield joint_sheet(recording, joint).save(out / f"joint_{joint}.{suffix}")
    if recording.terms is not None:
        sheet = joint_terms_sheet(recording, recording.terms[joint - 1], joint)
        yield sheet.save(out / f"joint_{joint}_terms.{suffix}")


def overview(recording: Recording) -> Sheet:
    """The run on one sheet: positions, tracking errors, torques, bus load."""
    sheet = Sheet(
        f"Recorded run: {_numbers(recording)}",
        describe(recording),
        (4, 1),
        (11.0, 8.4),
        (1.7, 1.0, 1.2, 0.9),
    )
    positions = sheet.title_panel(0, "Joint position: measured on commanded (pale)", "rad")
    errors = sheet.title_panel(1, "Tracking error", "encoder counts")
    torques = sheet.title_panel(2, "Joint torque, part of the drive's limit", "%")
    lines = []
    for joint, color in enumerate(JOINT_COLORS):
        look = {"color": color, "linestyle": (0, (4, 3)) if joint == JOINT_COUNT - 1 else "-"}
        positions.plot(
            recording.commanded_time, recording.commanded[:, joint], color=color, **_PALE
        )
        lines += positions.plot(recording.time, recording.q[:, joint], **look)
        errors.plot(recording.time, recording.error_counts[:, joint], color=color, linewidth=0.6)
        limit = recording.arm.drives[joint].torque_limit
        torques.plot(recording.time, 100.0 * recording.torque[:, joint] / limit, **look)
    positions.margins(y=0.06)
    _symmetric(errors)
    for bound in (-100.0, 100.0):
        torques.axhline(bound, color=LIMIT, linestyle="--", linewidth=1.0)
    torques.set_yticks((-100, -50, 0, 50, 100))
    _draw_bus_load(sheet.title_panel(3, "Bus load", "%"), recording)
    sheet.legend(lines, [f"joint {joint + 1}" for joint in range(JOINT_COUNT)])
    return sheet


def quantity_sheet(recording: Recording, quantity: Quantity) -> Sheet:
    """One quantity of all six joints."""
    sheet = Sheet(quantity.title, describe(recording), (3, 2), PAGE)
    handles: dict[str, Any] = {}
    for joint in range(JOINT_COUNT):
        axes = sheet.title_panel(joint, f"joint {joint + 1}", quantity.unit)
        handles.update(_draw_quantity(axes, recording, quantity, joint))
    sheet.legend(list(handles.values()), list(handles))
    return sheet


def joint_sheet(recording: Recording, joint: int) -> Sheet:
    """All quantities of one joint (1 to 6)."""
    sheet = Sheet(f"Joint {joint}", describe(recording), (3, 2), PAGE)
    handles: dict[str, Any] = {}
    for index, quantity in enumerate(QUANTITIES):
        axes = sheet.title_panel(index, quantity.title, quantity.unit)
        handles.update(_draw_quantity(axes, recording, quantity, joint - 1))
    keys = ("commanded", "measured", "gravity", "limit")
    sheet.legend([handles[key] for key in keys], ("commanded", "measured, driven", *keys[2:]))
    return sheet


def terms_sheet(recording: Recording, terms: Sequence[TorqueTerms]) -> Sheet:
    """What the torques of all six joints were made of; terms that never acted are left out."""
    acted = [name for name in TERM_COLORS if any(joint.terms[name].any() for joint in terms)]
    sheet = Sheet("What the joint torques are made of", describe(recording), (3, 2), PAGE)
    handles: dict[str, Any] = {}
    for index, joint in enumerate(terms):
        axes = sheet.title_panel(index, f"joint {index + 1}", "Nm")
        handles.update(_draw_terms(axes, recording, joint, acted, torque=True))
    sheet.legend_below(list(handles.values()), [name.replace("_", " ") for name in handles], 8)
    return sheet


def joint_terms_sheet(recording: Recording, terms: TorqueTerms, joint: int) -> Sheet:
    """What the torque of one joint (1 to 6) was made of, over time: feedforward, feedback, rest."""
    panels = [
        (title, [name for name in names if terms.terms[name].any()]) for title, names in TERM_PANELS
    ]
    panels[1:] = [panel for panel in panels[1:] if panel[1]]
    heights = (1.6, 1.0, 1.0)[: len(panels)]
    sheet = Sheet(
        f"Joint {joint}: what its torque is made of",
        describe(recording),
        (len(panels), 1),
        (11.0, 1.2 + 2.0 * sum(heights)),
        heights,
    )
    for index, (title, names) in enumerate(panels):
        axes = sheet.title_panel(index, title, "Nm")
        lines = _draw_terms(axes, recording, terms, names, torque=index == 0)
        axes.legend(
            list(lines.values()),
            [name.replace("_", " ") for name in lines],
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=len(lines),
            frameon=False,
            fontsize=9,
            labelcolor=INK,
            borderaxespad=0.0,
        )
    return sheet


def _draw_terms(
    axes: Any, recording: Recording, terms: TorqueTerms, names: Sequence[str], *, torque: bool
) -> dict[str, Any]:
    """Some terms of one joint, on their sum if asked for; returns the lines by name."""
    time = terms.cycle * recording.period_s
    lines: dict[str, Any] = {}
    if torque:
        (lines["torque"],) = axes.plot(time, terms.torque, color=FAINT, linewidth=4.0, alpha=0.45)
    for name in names:
        look = {"linewidth": 0.9}
        if name == "dither":  # a square wave of a few cycles: behind everything else
            look = {"linewidth": 0.5, "alpha": 0.6, "zorder": 1.5}
        (lines[name],) = axes.plot(time, terms.terms[name], color=TERM_COLORS[name], **look)
    return lines


def bus_sheet(recording: Recording) -> Sheet:
    """Bus load over time, beside its bound."""
    sheet = Sheet("Bus load", describe(recording), (1, 1), (11.0, 4.2))
    window_ms = recording.load_window * recording.period_s * 1e3
    axes = sheet.title_panel(0, f"bus time of the frames, mean of {window_ms:g} ms", "%")
    _draw_bus_load(axes, recording)
    return sheet


def _draw_quantity(
    axes: Any, recording: Recording, quantity: Quantity, joint: int
) -> dict[str, Any]:
    """One panel; returns its lines by label."""
    reference, measured = quantity.traces(recording)
    lines: dict[str, Any] = {}
    if reference is not None:
        color = FAINT if reference.label == "gravity" else COMMANDED
        width = {"gravity": 2.0}.get(reference.label, WIDE if measured else 1.3)
        (lines[reference.label],) = axes.plot(
            reference.time, reference.values[:, joint], color=color, linewidth=width
        )
    if measured is not None:
        (lines[measured.label],) = axes.plot(
            measured.time, measured.values[:, joint], color=MEASURED, linewidth=1.1
        )
    if quantity.limits is not None:
        for bound in quantity.limits(recording, joint):
            lines["limit"] = axes.axhline(bound, color=LIMIT, linestyle="--", linewidth=1.0)
    if quantity.name != "position":
        _symmetric(axes)
    return lines


def _draw_bus_load(axes: Any, recording: Recording) -> None:
    """Load over time, and the bound."""
    time, load = recording.bus_load()
    bound = recording.bus_bound
    axes.fill_between(time, 100.0 * load, color=MEASURED, alpha=0.18, linewidth=0)
    axes.plot(time, 100.0 * load, color=MEASURED, label="measured")
    axes.axhline(
        100.0 * bound, color=LIMIT, linestyle="--", linewidth=1.0, label=f"bound {bound:.1%}"
    )
    axes.set_ylim(0.0, 112.0 * max(bound, *load.tolist()))
    axes.legend(loc="lower right", ncols=2, frameon=False, fontsize=9, labelcolor=INK)


def _symmetric(axes: Any) -> None:
    """Zero in the middle, with a little room."""
    bound = max(map(abs, axes.get_ylim()))
    axes.set_ylim(-bound, bound)


def finite_peak(values: Floats) -> float:
    """Largest magnitude, of what is there; 0 of nothing."""
    return float(np.nanmax(np.abs(values), initial=0.0))
