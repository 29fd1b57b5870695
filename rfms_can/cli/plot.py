"""``rfms plot DIR``: the plots of a recorded run, and thesis Figures 3.3 to 3.5."""

import json
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Final, NamedTuple

import typer

from rfms_can.analysis.recording import Recording, load_recording
from rfms_can.tables import complete


class Figures(StrEnum):
    """Which figures are drawn."""

    RUN = "run"
    THESIS = "thesis"
    ALL = "all"


class Content(NamedTuple):
    """What belongs to a choice of figures.

    Attributes:
        run: overview and quantities of the run.
        thesis: the thesis' figures.
        joints: joints with a sheet of their own.
    """

    run: bool
    thesis: bool
    joints: tuple[int, ...] = ()


CONTENTS: Final = complete(
    {
        Figures.RUN: Content(run=True, thesis=False),
        Figures.THESIS: Content(run=False, thesis=True),
        Figures.ALL: Content(run=True, thesis=True, joints=(1, 2, 3, 4, 5, 6)),
    },
    Figures,
)


class Format(StrEnum):
    """File format of the figures."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


def plot(
    directory: Annotated[Path, typer.Argument(help="directory written by rfms run --record")],
    *,
    out: Annotated[
        Path | None, typer.Option(help="directory of the figures; default DIRECTORY/figures")
    ] = None,
    joint: Annotated[
        int | None,
        typer.Option(min=1, max=6, help="one sheet of this joint; thesis figures show it too"),
    ] = None,
    figures: Annotated[
        Figures,
        typer.Option(help="run: overview and quantities; thesis: Figs 3.3 to 3.5; all: both"),
    ] = Figures.RUN,
    file_format: Annotated[Format, typer.Option("--format", help="file format")] = Format.PNG,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Draw a recorded run: position, velocity, acceleration, jerk, error, torque, bus load.

        What the joint torques are made of is drawn too, where rfms run --terms has recorded it.

    thesis needs a run of examples/figures.py, or any that makes one motion in joint mode, again
    with a longer acceleration time, and in Cartesian mode.
    """
    recording = load_recording(directory)
    written = _draw(recording, out or directory / "figures", figures, joint, file_format.value)
    if as_json:
        report = {
            "figures": [str(path) for path in written],
            "cycles": len(recording.log.cycle),
            "frames": recording.log.frames,
            "refused": recording.log.refused,
        }
        sys.stdout.write(json.dumps(report) + "\n")
        return
    if recording.log.refused:
        typer.echo(f"{recording.log.refused} frames of the log violate the DBC: skipped", err=True)
    for path in written:
        typer.echo(path)


def _draw(
    recording: Recording, out: Path, figures: Figures, joint: int | None, suffix: str
) -> list[Path]:
    """Draw the requested figures; matplotlib is loaded only here."""
    from rfms_can.analysis.plots import draw_joint, draw_run
    from rfms_can.analysis.thesis_figures import draw_thesis

    written: list[Path] = []
    content = CONTENTS[figures]
    if content.run:
        if joint is None:
            written += draw_run(recording, out, suffix)
        for number in content.joints if joint is None else (joint,):
            written += draw_joint(recording, number, out, suffix)
    if content.thesis:
        written += draw_thesis(recording, joint or 1, out, suffix)
    return written
