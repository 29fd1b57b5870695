"""Terminal output of a run: a progress line while it runs, a table at its end."""

import math
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, redirect_stdout

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn
from rich.table import Column, Table
from rich.text import Text

from rfms_can.rig.result import RunResult
from rfms_can.rig.session import Progress as OnProgress
from rfms_can.rig.session import Session
from rfms_can.rig.truth import SceneResult

console = Console(stderr=True, emoji=False)
"""Progress and tables go to standard error: standard output is for other programs. No emoji: one is
in ``hub:up: tracking``."""


@contextmanager
def progress_line(title: str, *, quiet: bool) -> Iterator[OnProgress | None]:
    """Show a progress line during a run; yields the callback for its progress."""
    if quiet:
        yield None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("[bold]{task.description}"),
        TextColumn("{task.fields[phase]:<9}", table_column=_whole()),
        TextColumn("cycle {task.fields[cycle]:>6}", table_column=_whole()),
        TextColumn("{task.fields[seconds]:6.2f} s", table_column=_whole()),
        TextColumn("{task.fields[speed]:4.1f}x real time", table_column=_whole()),
    )
    with Progress(*columns, console=console, transient=False) as progress:
        task = progress.add_task(
            title, total=None, phase="ROLL_CALL", cycle=0, seconds=0.0, speed=0.0
        )
        began: dict[str, float] = {}

        def report(session: Session) -> None:
            master = session.master
            cycles = master.statistics.cycles
            seconds = cycles / master.settings.rate_hz
            elapsed = time.perf_counter() - began.setdefault("at", time.perf_counter())
            progress.update(
                task,
                phase=master.phase.name,
                cycle=cycles,
                seconds=seconds,
                speed=seconds / elapsed if elapsed > 0.0 else 0.0,
            )

        try:
            yield report
        except BaseException:
            progress.remove_task(task)  # the error is printed alone, in one line
            progress.disable = not console.is_terminal
            raise
        progress.update(task, total=1, completed=1)


def _whole() -> Column:
    """A column that is never truncated."""
    return Column(no_wrap=True, min_width=9)


def print_result(title: str, result: RunResult) -> None:
    """The table at the end of a run."""
    table = Table(title=f"{title}: tracking", title_justify="left")
    for heading in ("joint", "moving max, deg", "moving rms, deg", "settled max, counts"):
        table.add_column(heading, justify="right")
    for joint in result.joints:
        table.add_row(
            str(joint.joint),
            f"{math.degrees(joint.moving_max):.4f}",
            f"{math.degrees(joint.moving_rms):.4f}",
            "-" if joint.settled_max_counts is None else f"{joint.settled_max_counts:.2f}",
        )
    console.print(table)
    print_rows(_run_rows(result))
    for missing in result.unrecorded:
        console.print(f"[red bold]record incomplete:[/] {escape(missing)}")
    if result.fault is not None:
        console.print(f"[red bold]halted by a latched fault:[/] {result.fault}")
    if result.culprit is not None:
        console.print(f"[red bold]culprit:[/] {escape(result.culprit.words)}")


def print_rows(rows: Iterable[tuple[str, str]]) -> None:
    """Print names and values as two columns."""
    run = Table(show_header=False, box=None, padding=(0, 1))
    for name, value in rows:
        run.add_row(name, Text(value, overflow="fold"))  # no markup in brackets; paths are folded
    console.print(run)


def _run_rows(result: RunResult) -> Iterator[tuple[str, str]]:
    speed = f"{result.cycles_per_s:.0f} cycles/s"
    yield "cycles", f"{result.cycles} in {result.wall_s:.2f} s ({speed})"
    yield "deadline misses", str(result.incomplete)
    for names, count in sorted(result.missing.items()):
        yield "", f"{count} x without {names}"
    bound = "" if result.bus_bound is None else f"bound {100 * result.bus_bound:.1f} %"
    load = "not measured on this bus"
    if result.bus_load is not None:
        load = f"measured {100 * result.bus_load:.1f} %"
    yield "bus load", ", ".join(filter(None, (load, bound)))
    yield "frames", str(result.frames)
    for k, fault in enumerate(result.reset_faults):
        yield "" if k else "faults reset", fault
    if result.scene is not None:
        yield from _scene_rows(result.scene)
    for k, words in enumerate(result.reported):
        yield "" if k else "compliance", words
    discarded = {name: count for name, count in result.discarded.items() if count}
    yield "discarded", ", ".join(f"{n}: {c}" for n, c in discarded.items()) or "0"
    for name, counts in (("bus-off", result.bus_offs), ("overflows", result.overflows)):
        if counts:
            yield name, ", ".join(f"{node}: {count}" for node, count in counts.items())
    yield "foreign", str(result.foreign)
    yield "lost", str(result.lost)
    if any(result.lateness):
        yield "SYNC lateness", _lateness(result.lateness)


def _scene_rows(scene: SceneResult) -> Iterator[tuple[str, str]]:
    yield "scene", scene.scene
    yield "contact", f"{scene.contact_cycles} cycles, {1e3 * scene.largest_depth:.4f} mm deep"
    across, along = scene.largest_lateral, scene.largest_axial
    yield (
        "",
        f"up to {scene.largest_force:.1f} N: {across:.1f} N across, {along:.1f} N along the tool",
    )
    x, y, z = (1e3 * value for value in scene.tip)
    touching = ", touching" if scene.touching else ""
    lowest = f"lowest {1e3 * scene.lowest:.2f} mm"
    yield "tip in its place", f"{x:.2f}, {y:.2f}, {z:.2f} mm{touching}; {lowest}"


def _lateness(counts: list[int]) -> str:
    """The histogram as cumulative percentages."""
    total, passed, parts = sum(counts), 0, []
    for place, count in enumerate(counts[:-1]):
        passed += count
        if count:
            parts.append(f"{100 * passed / total:.1f} % under {10 * 2**place} us")
    return "; ".join(parts[-4:])


def prints_to(as_json: bool) -> AbstractContextManager[object]:
    """Redirect a program's own ``print`` to standard error if standard output has the JSON."""
    return redirect_stdout(sys.stderr) if as_json else nullcontext()
