"""Figures of an identification: torque against current as in Fig. 4.1 and 4.2, inertia, tracking.

Raises ``PlotError`` on import where matplotlib is missing.
"""

from collections.abc import Iterator, Sequence
from math import degrees
from pathlib import Path
from typing import Any, Final

import numpy as np

from rfms_can.analysis.canvas import (
    BAND,
    COMMANDED,
    FAINT,
    INK,
    JOINT_COLORS,
    LIMIT,
    MEASURED,
    Sheet,
)
from rfms_can.arm import JOINT_COUNT
from rfms_can.arm.calibration import Calibration
from rfms_can.dynamics.terms import inertia_row, value
from rfms_can.identification.compensation_comparison import Tracking
from rfms_can.identification.fit.result import Identification
from rfms_can.identification.fit.torque import TorqueFit

POSITIVE: Final = MEASURED
NEGATIVE: Final = COMMANDED
ONE_JOINT: Final = 1
"""Index of the joint of Fig. 4.1."""


def draw(
    found: Identification,
    truth: Calibration,
    tracking: Sequence[Tracking] | None,
    out: Path,
    suffix: str = "png",
) -> Iterator[Path]:
    """Write fig_4_1, fig_4_2, inertia, and tracking if it was compared; yields their paths."""
    current = "motor current, DAC codes, positive towards positive angles"
    yield _one(found).save(out / f"fig_4_1.{suffix}", current)
    yield _all(found).save(out / f"fig_4_2.{suffix}", current)
    yield _inertia(found, truth).save(out / f"inertia.{suffix}", "joint, one place for each pose")
    if tracking is not None:
        yield _tracking(tracking).save(out / f"tracking.{suffix}", "joint")


def _one(found: Identification) -> Sheet:
    joint = ONE_JOINT + 1
    sheet = Sheet(
        f"Figure 4.1  Torque against motor current, joint {joint}",
        f"{found.arm.name} · constant speed, viscous friction subtracted",
        (1, 1),
        (8.0, 5.6),
    )
    axes = sheet.title_panel(0, "Joint torque", "Nm")
    handles = _law(axes, found.torque[ONE_JOINT])
    sheet.legend(handles, ["positive", "negative", "at rest"])
    law = found.torque[ONE_JOINT].law
    below, above = (30.0, -26.0), (-120.0, 20.0)
    for offset, name, aside in (
        (law.offset_positive, "B_p", below),
        (law.offset_negative, "B_n", above),
    ):
        axes.annotate(
            f"${name}$ = {offset:.2f} Nm",
            (0.0, offset),
            xytext=aside,
            textcoords="offset points",
            color=INK,
            arrowprops={"arrowstyle": "-", "color": FAINT},
        )
    return sheet


def _all(found: Identification) -> Sheet:
    sheet = Sheet(
        "Figure 4.2  Torque against motor current of six joints",
        f"{found.arm.name} · joints 2 to 6 carry the known load's weight, joint 1 its inertia",
        (3, 2),
        (11.0, 9.6),
    )
    handles: list[Any] = []
    for joint, torque in enumerate(found.torque):
        law = torque.law
        title = (
            f"Joint {joint + 1}: A = {law.slope_positive:.4f}, {law.slope_negative:.4f} Nm/code; "
            f"B = {law.offset_positive:.2f}, {law.offset_negative:.2f} Nm"
        )
        handles = _law(sheet.title_panel(joint, title, "Nm"), torque)
    sheet.legend(handles, ["positive", "negative", "at rest"])
    return sheet


def _law(axes: Any, torque: TorqueFit) -> list[Any]:
    """Points and lines of both directions, and the region between them."""
    current, required, direction = torque.points.T
    law = torque.law
    ends = np.array([current.min(), current.max()])
    upper = law.slope_negative * ends + law.offset_negative
    lower = law.slope_positive * ends + law.offset_positive
    between = axes.fill_between(ends, lower, upper, color=BAND, zorder=0)
    handles = []
    for sign, line, color in ((1.0, lower, POSITIVE), (-1.0, upper, NEGATIVE)):
        own = direction == sign
        axes.plot(current[own], required[own], ".", markersize=3.5, color=color, zorder=2)
        axes.plot(ends, line, color=INK, linewidth=0.7, zorder=3)
        handles.append(axes.plot([], [], "o", markersize=4, color=color)[0])
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.axvline(0.0, color=FAINT, linewidth=0.8)
    return [*handles, between]


def _inertia(found: Identification, truth: Calibration) -> Sheet:
    sheet = Sheet(
        "Effective inertia by double integration, against the plant's",
        f"{found.arm.name} · Ia + D_ii at each pose (Eq. 4.23); bars: two standard deviations",
        (1, 1),
        (9.5, 5.2),
    )
    axes = sheet.title_panel(0, "Found less plant", "% of the plant's")
    places, names = [], []
    for k, pose in enumerate(sorted(found.poses, key=lambda pose: pose.joint)):
        place = k + 0.8 * pose.joint
        true = value(inertia_row(pose.joint + 1, pose.pose.tolist()), truth.constants)
        error, spread = 100.0 * (pose.inertia / true - 1.0), 200.0 * pose.deviation / true
        color = JOINT_COLORS[pose.joint]
        axes.errorbar(place, error, spread, fmt="o", markersize=5, capsize=2.5, color=color)
        places.append(place)
        names.append(str(pose.joint + 1))
    axes.axhline(0.0, color=LIMIT, linewidth=1.2)
    axes.set_xticks(places, names)
    return sheet


def _tracking(runs: Sequence[Tracking]) -> Sheet:
    sheet = Sheet(
        "Tracking with different compensations",
        "largest error, the same gains",
        (1, 1),
        (9.5, 5.2),
    )
    axes = sheet.title_panel(0, "Tracking error", "degrees")
    width = 0.8 / len(runs)
    colors = (FAINT, COMMANDED, "#7a5aa6", MEASURED, LIMIT)
    handles = []
    for k, (run, color) in enumerate(zip(runs, colors, strict=False)):
        places = np.arange(1, JOINT_COUNT + 1) + (k - 0.5 * (len(runs) - 1)) * width
        heights = [degrees(joint.moving_max) for joint in run.joints]
        handles.append(axes.bar(places, heights, width, color=color))
    axes.set_yscale("log")
    axes.set_xticks(range(1, JOINT_COUNT + 1))
    sheet.legend(handles, [run.name for run in runs])
    return sheet
