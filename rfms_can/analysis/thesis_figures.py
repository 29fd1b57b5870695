"""Thesis Figures 3.3 to 3.5 from a recorded run: one joint's trajectory in three ways of moving.

Each shows position, velocity, acceleration and jerk as commanded (differences of the trajectory in
double precision) with what the encoder and the tachometer measured. The three share their scales,
so that they can be compared. A run under ``--blend thesis`` shows what the thesis' own matching
polynomial does: in Cartesian mode the acceleration steps where a segment is left.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rfms_can.analysis.canvas import BAND, COMMANDED, MEASURED, Sheet
from rfms_can.analysis.cycles import Floats
from rfms_can.analysis.motions import Motion, ThesisMotions, thesis_motions
from rfms_can.analysis.plots import WIDE
from rfms_can.analysis.recording import Recording
from rfms_can.wire.vocabulary import TrajectoryState

REST_S: Final = 0.15
"""Rest shown before and after the motion, s."""

PANELS: Final = (
    ("Position", "rad"),
    ("Velocity", "rad/s"),
    ("Acceleration", "rad/s²"),
    ("Jerk", "rad/s³"),
)


class ThesisFigure(NamedTuple):
    """One of the figures: its number and what it shows."""

    number: str
    title: str


FIGURES: Final = (
    ThesisFigure("3.3", "Joint mode trajectory of joint {}"),
    ThesisFigure("3.4", "Joint mode trajectory of joint {} with longer acceleration time"),
    ThesisFigure("3.5", "Trajectory of joint {} in Cartesian mode"),
)


def draw_thesis(recording: Recording, joint: int, out: Path, suffix: str) -> Iterator[Path]:
    """Write fig_3_3, fig_3_4 and fig_3_5 of one joint (1 to 6); yields what it wrote.

    Raises:
        RecordingError: the run has not the three motions.
        PlotError: a file cannot be written.
    """
    for number, sheet in thesis_sheets(recording, joint):
        name = f"fig_{number.replace('.', '_')}.{suffix}"
        yield sheet.save(out / name, "time since the motion began, s")


def thesis_sheets(recording: Recording, joint: int) -> Iterator[tuple[str, Sheet]]:
    """Number and sheet of each figure.

    Raises:
        RecordingError: the run has not the three motions.
    """
    three = thesis_motions(recording)
    curves = [recording.commanded, *(recording.derivative(order) for order in (1, 2, 3))]
    scales = [_scale(recording, three, values[:, joint - 1]) for values in curves]
    for figure, motion in zip(FIGURES, three, strict=True):
        sheet = _figure(recording, figure, motion, joint)
        for axes, values, scale in zip(sheet.panels, curves, scales, strict=True):
            _draw(axes, recording, motion, values[:, joint - 1])
            axes.set_ylim(scale)
        _draw_measured(sheet, recording, motion, joint)
        yield figure.number, sheet


def _figure(recording: Recording, figure: ThesisFigure, motion: Motion, joint: int) -> Sheet:
    title = f"Figure {figure.number}  {figure.title.format(joint)}"
    how = (
        f"{len(motion.moves)} segments, t_acc = {motion.acceleration_time:.3g} s · "
        f"{recording.arm.name} · {1.0 / recording.period_s:g} Hz · {recording.blend} blend"
    )
    sheet = Sheet(title, how, (4, 1), (8.4, 9.0))
    for index, (name, unit) in enumerate(PANELS):
        sheet.title_panel(index, name, unit)
    return sheet


def _rows(recording: Recording, motion: Motion) -> slice:
    """Rows of the log in motion, and of the rest around it up to ``REST_S``."""
    rest = round(REST_S / recording.period_s)
    commanded = recording.log.cycle < len(recording.commanded)
    resting = (recording.log.state == TrajectoryState.IDLE) & commanded
    before = resting[max(0, motion.start - rest) : motion.start]
    after = resting[motion.stop : motion.stop + rest]
    return slice(motion.start - _leading(before[::-1]), motion.stop + _leading(after))


def _leading(flags: NDArray[np.bool_]) -> int:
    """How many flags are set before the first that is not."""
    return int(np.logical_and.accumulate(flags).sum())


def _clock(recording: Recording, motion: Motion) -> Floats:
    """Time since the motion began, s, of the rows shown."""
    time: Floats = recording.time
    since: Floats = time[_rows(recording, motion)] - time[motion.start]
    return since


def _scale(recording: Recording, three: ThesisMotions, values: Floats) -> tuple[float, float]:
    """Limits that hold one quantity of all three motions."""
    shown = np.concatenate([values[recording.log.cycle[_rows(recording, m)]] for m in three])
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    room = 0.08 * (high - low) or 1.0
    return low - room, high + room


def _draw(axes: Any, recording: Recording, motion: Motion, values: Floats) -> None:
    """The commanded curve over bands that mark the transitions."""
    rows = _rows(recording, motion)
    clock = _clock(recording, motion)
    blends = np.isin(recording.log.state[rows], (TrajectoryState.START, TrajectoryState.BLEND))
    edges = np.flatnonzero(np.diff(blends.astype(np.int8), prepend=0, append=0))
    for first, last in edges.reshape(-1, 2):
        axes.axvspan(clock[first], clock[last - 1], color=BAND, linewidth=0)
    axes.plot(clock, values[recording.log.cycle[rows]], color=COMMANDED, linewidth=2.0)


def _draw_measured(sheet: Sheet, recording: Recording, motion: Motion, joint: int) -> None:
    """Encoder and tachometer on the first two panels, and the legend."""
    rows, clock = _rows(recording, motion), _clock(recording, motion)
    position, velocity = sheet.panels[:2]
    for axes in (position, velocity):
        axes.lines[0].set_linewidth(WIDE)
    (measured,) = position.plot(clock, recording.q[rows, joint - 1], color=MEASURED, linewidth=1.1)
    velocity.plot(clock, recording.speed[rows, joint - 1], color=MEASURED, linewidth=1.1)
    band = position.patches[0]
    sheet.legend([position.lines[0], measured, band], ["commanded", "measured", "transition"])
