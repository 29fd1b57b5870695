"""``rfms run PROGRAM.py``: runs a program against the nine nodes."""

import json
import signal
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfms_can.cli.options import JsonOption, RecordOption, takes_settings
from rfms_can.cli.report import print_result, prints_to, progress_line
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.realtime import set_real_time
from rfms_can.rig.settings import RunSettings

if TYPE_CHECKING:
    from rfms_can.rig.session import Rig

FifoOption = Annotated[int | None, typer.Option("--fifo", help="SCHED_FIFO priority, 1 to 99")]
CpuOption = Annotated[int | None, typer.Option("--cpu", help="run the master on this CPU alone")]
TermsOption = Annotated[
    bool,
    typer.Option("--terms", help="record the terms of each joint torque (bus sim, with --record)"),
]
LockOption = Annotated[bool, typer.Option("--mlockall", help="lock the master's memory")]


@takes_settings()
def run(
    program: Annotated[Path, typer.Argument(help="Python file with a function program(arm)")],
    *,
    settings: RunSettings,
    attach: Annotated[
        bool, typer.Option("--attach", help="the other nodes are on the bus already")
    ] = False,
    record: RecordOption = None,
    terms: TermsOption = False,
    fifo: FifoOption = None,
    cpu: CpuOption = None,
    mlockall: LockOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run a program: on the simulated bus in this process, or as nine processes on a real one."""
    run_program(
        program,
        settings,
        record=record,
        terms=terms,
        attach=attach,
        as_json=as_json,
        watch=lambda _: set_real_time(fifo, cpu, mlockall),
    )


def run_program(
    path: Path,
    settings: RunSettings,
    *,
    record: Path | None = None,
    terms: bool = False,
    attach: bool = False,
    as_json: bool = False,
    watch: Callable[["Rig"], None] | None = None,
    more: Callable[[], Mapping[str, Any]] = dict,
) -> None:
    """Run a program file, show progress and result; ``more`` gives further keys of the JSON.

    Exit code 1 after a latched fault; 130 after Ctrl-C and 143 after SIGTERM, the arm braked.
    """
    from rfms_can.rig.program import load_program
    from rfms_can.rig.runner import execute

    program = load_program(path)
    title = f"{path.stem} on {settings.arm}, {settings.bus}"
    with signals_noted() as interrupt:
        try:
            with progress_line(path.stem, quiet=as_json) as progress, prints_to(as_json):
                outcome = execute(
                    program,
                    settings,
                    record=record,
                    progress=progress,
                    attach=attach,
                    watch=watch,
                    interrupted=interrupt,
                    program_runs=interrupt.program_runs,
                    terms=terms,
                )
        except KeyboardInterrupt:
            name = (interrupt.signal or signal.SIGINT).name
            typer.echo(f"rfms: {name} ended the run; the arm has been stopped", err=True)
            raise typer.Exit(interrupt.exit_code) from None
    if as_json:
        typer.echo(json.dumps({**outcome.result.as_dict(), **more()}))
    else:
        print_result(title, outcome.result)
    if outcome.fault is not None:
        raise outcome.fault
