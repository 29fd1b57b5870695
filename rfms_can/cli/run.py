"""``rfms run PROGRAM.py``: runs a program against the nine nodes."""

import json
import signal
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfms_can.bus.url import is_simulated
from rfms_can.cli.options import JsonOption, RecordOption, takes_settings
from rfms_can.cli.report import print_result, prints_to, progress_line
from rfms_can.errors import RfmsError
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.processes import Front, as_made
from rfms_can.rig.realtime import set_real_time
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.nodes import MASTER, NODE_NAMES

if TYPE_CHECKING:
    from rfms_can.rig.session import Rig

FifoOption = Annotated[int | None, typer.Option("--fifo", help="SCHED_FIFO priority, 1 to 99")]
CpuOption = Annotated[int | None, typer.Option("--cpu", help="run the master on this CPU alone")]
TermsOption = Annotated[
    bool,
    typer.Option("--terms", help="record the terms of each joint torque (bus sim, with --record)"),
]
FaultOption = Annotated[
    str | None,
    typer.Option("--fault", help="put in NAME:NODE@CYCLE, e.g. freeze_encoder:3@120; rfms faults"),
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
    fault: FaultOption = None,
    allow_motion: Annotated[
        bool, typer.Option("--allow-motion", help="--fault where a motor may be connected")
    ] = False,
    fifo: FifoOption = None,
    cpu: CpuOption = None,
    mlockall: LockOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run a program: on the simulated bus in this process, or as nine processes on a real one."""
    put_in, front = _fault(fault, settings, attach, allow_motion)

    def watch(rig: "Rig") -> None:
        set_real_time(fifo, cpu, mlockall)
        put_in(rig)

    run_program(
        program,
        settings,
        record=record,
        terms=terms,
        attach=attach,
        as_json=as_json,
        watch=watch,
        front=front,
    )


def _fault(
    text: str | None, settings: RunSettings, attach: bool, allow_motion: bool
) -> tuple[Callable[["Rig"], None], Front]:
    """What puts a fault into the rig, and what stands in front of the nodes."""
    if text is None:
        return lambda _: None, as_made
    from rfms_can.faults.fuse import in_process, on_rig, parse_fault
    from rfms_can.rig.simulated import SimulatedRig

    fault = parse_fault(text)
    if not (allow_motion or is_simulated(settings.bus)):
        raise RfmsError(
            f"fault {text} on {settings.bus!r} makes what may be a motor run wild: give "
            f"--allow-motion if it may"
        )
    if attach and fault.at != MASTER:
        raise RfmsError(
            f"fault {text} is put in at {NODE_NAMES[fault.at]}, which --attach leaves to others"
        )
    if not settings.simulated:
        return lambda _: None, in_process(fault, settings)

    def put_in(rig: "Rig") -> None:
        assert isinstance(rig, SimulatedRig)
        on_rig(fault, settings, rig)

    return put_in, as_made


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
    front: Front = as_made,
) -> None:
    """Run a program file, show progress and result; ``more`` gives further keys of the JSON.

    ``front`` is what stands in front of each node where nodes are processes.

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
                    front=front,
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
