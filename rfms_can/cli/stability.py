"""``rfms stability``: closed-loop poles of a compliant arm, at a pose, on a path, on a map."""

import dataclasses
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer
from rich.console import Console
from rich.progress import Progress

from rfms_can.analysis.stability import (
    Analyst,
    ControlLaw,
    Grid,
    Study,
    Survey,
    grid_poses,
    parse_pose,
    path_poses,
    random_poses,
    survey,
)
from rfms_can.arm import FRICTION_SETS, arm_by_name
from rfms_can.cli.options import ARM_WORDS, words
from rfms_can.cli.stability_report import as_plain, print_pose, print_survey
from rfms_can.compliance import Selection
from rfms_can.errors import RfmsError
from rfms_can.transform import Transform

COMPARED: Final = ControlLaw.WEIGHTED
"""The law a map of another law is drawn beside."""
POINTS: Final = 61
"""Grid points along either side."""
FARTHEST_TOOL: Final = 10.0
"""Largest distance of a compliance frame from T6 along each axis, m."""


def stability(
    *,
    arm: Annotated[str, typer.Option(help=ARM_WORDS)] = "puma560",
    word: Annotated[
        str, typer.Option(help="compliant directions, of fx fy fz rx ry rz")
    ] = "fx fy rx ry",
    tool: Annotated[
        str,
        typer.Option(help="compliance frame in T6: z, or x,y,z, or x,y,z,phi,theta,psi (m, rad)"),
    ] = "0",
    law: Annotated[ControlLaw, typer.Option(help="the control law")] = ControlLaw.HYBRID,
    pose: Annotated[
        str, typer.Option(help="six joint angles, rad, comma-separated; the park pose if absent")
    ] = "",
    path: Annotated[Path | None, typer.Option(help="file with six angles (rad) a line")] = None,
    grid: Annotated[str, typer.Option(help="two joints to vary over their ranges, e.g. 2,3")] = "",
    points: Annotated[
        int | None, typer.Option(help="grid points along either side; 61 if absent")
    ] = None,
    random: Annotated[int, typer.Option(help="number of random poses in the joint ranges")] = 0,
    seed: Annotated[int, typer.Option(help="of the random poses")] = 1,
    natural: Annotated[
        str, typer.Option(help="natural frequency, rad/s, or six; the nodes' if absent")
    ] = "",
    damping: Annotated[float, typer.Option(help="damping ratio")] = 1.0,
    rate: Annotated[float, typer.Option(help="control rate, Hz")] = 250.0,
    compliant: Annotated[
        float, typer.Option(help="damping of the compliant directions, 1/s")
    ] = 0.0,
    friction: Annotated[
        str, typer.Option(help=f"viscous friction of the plant: {words(FRICTION_SETS)}")
    ] = "none",
    diagonal: Annotated[
        bool, typer.Option("--diagonal", help="the thesis' plant: constant diagonal inertia")
    ] = False,
    scheduled: Annotated[
        float, typer.Option(help="velocity gains after Maples and Goldman: A of (5.13); 0: none")
    ] = 0.0,
    payload: Annotated[
        float, typer.Option(help="unmodelled mass at the compliance frame, kg")
    ] = 0.0,
    plot: Annotated[
        Path | None, typer.Option(help="picture of the grid: this law beside the weighted one")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Closed-loop poles (Eq. 5.22) of a compliant arm, in continuous and in sampled time.

    At one pose the poles and the gain margin; on a path, a grid or random poses the number of
    unstable ones, and the worst. Exit code 1 if any pose is unstable.
    """
    study = Study(
        arm_by_name(arm),
        Selection.parse(word),
        frame_of(tool),
        law,
        _frequencies(natural),
        damping,
        rate,
        compliant,
        friction,
        diagonal,
        scheduled,
        payload,
    )
    if sum(map(bool, (pose and not grid, path, grid, random))) > 1:
        raise RfmsError("give one of --pose, --path, --grid and --random")
    if plot is not None and not grid:
        raise RfmsError("--plot draws a map: give --grid, e.g. --grid 2,3")
    if points is not None and not grid:
        raise RfmsError("--points works only with a grid: give --grid, e.g. --grid 2,3")
    base = parse_pose(pose, study.arm) if pose else study.arm.park
    if grid:
        a_side = POINTS if points is None else points
        found = _grid(study, grid_poses(study.arm, _joints(grid), a_side, base), plot, as_json)
    elif path is not None or random:
        poses = (
            path_poses(path, study.arm)
            if path is not None
            else random_poses(study.arm, random, seed)
        )
        found = _survey(study, poses, as_json)
    else:
        analysis = Analyst(study).analyse(base, margin=True)
        found = Survey(study, (analysis,))
        if not as_json:
            print_pose(study, analysis)
    if as_json:
        sys.stdout.write(json.dumps(as_plain(found)) + "\n")
    if found.unstable or found.unstable_sampled:
        raise typer.Exit(1)


def frame_of(text: str) -> Transform:
    """The compliance frame given by a flag.

    Raises:
        RfmsError: it is not one, three or six numbers, or it is too far away.
    """
    numbers = _numbers(text, "tool")
    if any(abs(offset) > FARTHEST_TOOL for offset in numbers[:3]):
        raise RfmsError(f"tool {text!r} is not within {FARTHEST_TOOL:g} m of the hand (T6)")
    if len(numbers) == 1:
        return Transform.translation(0.0, 0.0, numbers[0])
    if len(numbers) == 3:
        return Transform.translation(*numbers)
    if len(numbers) == 6:
        return Transform.translation(*numbers[:3]) @ Transform.rpy(*numbers[3:])
    raise RfmsError(f"tool {text!r}: give z, or x,y,z, or x,y,z,phi,theta,psi (m, rad)")


def _grid(study: Study, grid: Grid, plot: Path | None, as_json: bool) -> Survey:
    found = _survey(study, grid.poses, as_json)
    if plot is not None:
        from rfms_can.analysis.stability.stability_map import draw_stability_map

        # one frequency for all joints: the weighted law has no other
        beside = dataclasses.replace(study, law=COMPARED, natural=(), scheduled=0.0)
        laws = [found]
        if study.law is not COMPARED:
            laws.append(_survey(beside, grid.poses, True))
        written = draw_stability_map(grid, laws, plot)
        if not as_json:
            typer.echo(written)
    return found


def _survey(study: Study, poses: Sequence[tuple[float, ...]], quiet: bool) -> Survey:
    with Progress(console=Console(stderr=True), transient=True, disable=quiet) as progress:
        task = progress.add_task(f"{study.law.value}, {study.selection.word}", total=len(poses))
        found = survey(study, poses, lambda: progress.advance(task))
    if not quiet:
        print_survey(found)
    return found


def _numbers(text: str, what: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        numbers = []
    if not numbers or not np.isfinite(numbers).all():
        raise RfmsError(f"{what} {text!r} is not a list of numbers: e.g. 0.1 or 0,0,0.1")
    return numbers


def _frequencies(text: str) -> tuple[float, ...]:
    if not text:
        return ()
    numbers = _numbers(text, "natural")
    return tuple(numbers * 6 if len(numbers) == 1 else numbers)


def _joints(text: str) -> tuple[int, int]:
    numbers = _numbers(text, "grid")
    if len(numbers) != 2 or any(n != int(n) for n in numbers):
        raise RfmsError(f"grid {text!r}: give two joints, e.g. 2,3")
    return int(numbers[0]) - 1, int(numbers[1]) - 1
