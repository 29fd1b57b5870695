"""``rfms coordinate PROGRAM.py``: runs a program against a server that is running."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress, SpinnerColumn, TextColumn

from rfms_can.cli.options import JsonOption
from rfms_can.cli.report import console, prints_to
from rfms_can.coordinator import ClientKeys, Status, connect
from rfms_can.errors import LinkError
from rfms_can.link.address import DEFAULT_NAME
from rfms_can.rig.interrupt import signals_noted

ServerOption = Annotated[str, typer.Option("--server", help="its NAME, or tcp://ADDRESS:PORT")]
ClientKeysOption = Annotated[
    Path | None,
    typer.Option("--keys", help="directory with this client's NAME.key_secret and server.key"),
]


def coordinate(
    program: Annotated[Path, typer.Argument(help="Python file with a function program(arm)")],
    *,
    server: ServerOption = DEFAULT_NAME,
    name: Annotated[
        str | None, typer.Option("--name", help="name of this coordinator; the program's if absent")
    ] = None,
    keys: ClientKeysOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run a program against a running server: take the lease, move the arm, return it at rest."""
    from rfms_can.rig.program import load_program

    run = load_program(program)
    pair = None if keys is None else client_keys(keys)
    with signals_noted() as interrupt:
        try:
            with (
                prints_to(as_json),
                _progress(program.stem, quiet=as_json) as watch,
                connect(
                    server,
                    name=name or program.stem,
                    keys=pair,
                    interrupted=interrupt,
                    program_runs=interrupt.program_runs,
                    watch=watch,
                ) as arm,
            ):
                began = arm.status
                run(arm)
                arm.wait()
                ended = arm.status
        except KeyboardInterrupt:
            signal = interrupt.signal
            name = "SIGINT" if signal is None else signal.name
            typer.echo(f"rfms: {name} ended the program; the arm has been stopped", err=True)
            raise typer.Exit(interrupt.exit_code) from None
    _report(program.stem, server, began, ended, as_json=as_json)


def client_keys(directory: Path) -> ClientKeys:
    """The keys of the one client whose files are in a directory.

    Raises:
        LinkError: the directory has no client key, or more than one.
    """
    pairs = sorted(directory.glob("*.key_secret"))
    if len(pairs) != 1:
        found = ", ".join(pair.name for pair in pairs) or "none"
        raise LinkError(
            f"--keys {directory}: one NAME.key_secret must be there, found: {found}; "
            f"rfms keys --client NAME makes it"
        )
    return ClientKeys.load(pairs[0], directory / "server.key")


@contextmanager
def _progress(title: str, *, quiet: bool) -> Iterator[Callable[[Status], None]]:
    """Show the arm's state while a program waits."""
    if quiet:
        yield lambda _: None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("[bold]{task.description}"),
        TextColumn("cycle {task.fields[cycle]:>6}"),
        TextColumn("{task.fields[state]}", markup=False),
    )
    shown = console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=not shown) as progress:
        task = progress.add_task(title, total=None, cycle=0, state="")

        def watch(status: Status) -> None:
            state = f"{status.stage:<6} move {status.sequence}, {status.waiting} wait"
            progress.update(task, cycle=status.cycle, state=state)

        yield watch


def _report(title: str, server: str, began: Status, ended: Status, *, as_json: bool) -> None:
    cycles = ended.cycle - began.cycle
    numbers = {
        "server": server,
        "cycles": cycles,
        "seconds": cycles * ended.period,
        "moves": ended.completed - began.completed,
        "joints": list(ended.joints),
    }
    if as_json:
        typer.echo(json.dumps(numbers))
        return
    console.print(
        f"{title} on server {server}: {numbers['moves']} moves in {cycles} cycles, "
        f"{numbers['seconds']:.3f} s of the arm's time; at rest and given back",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )
