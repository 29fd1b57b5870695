"""``rfms serve``: brings the arm up and serves coordinators; ``rfms keys``: keys for TCP."""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import Progress, SpinnerColumn, TextColumn

from rfms_can.cli.options import JsonOption, RecordOption, takes_settings
from rfms_can.cli.report import console, print_result
from rfms_can.cli.run import CpuOption, FifoOption, LockOption
from rfms_can.link.address import DEFAULT_NAME, checked
from rfms_can.link.keys import ServerKeys, new_client_keys, new_server_keys
from rfms_can.messages import ServerNumbers
from rfms_can.messages.numbers import LATENCY_EDGES_NS
from rfms_can.messages.sensors import MAX_REFERENCES, MAX_SENSORS
from rfms_can.rig.interrupt import signals_noted
from rfms_can.rig.realtime import set_real_time
from rfms_can.rig.settings import RunSettings, SettingsError

if TYPE_CHECKING:
    from rfms_can.rig.serve import Listening, Served, Serving

LONGEST_NAME = 64
"""Characters of a name on the link."""

Shown = Callable[["Serving"], None]

NameOption = Annotated[str, typer.Option("--name", help="name of the server for coordinators")]
TcpOption = Annotated[
    int | None, typer.Option("--tcp", help="listen on this TCP port and the two after it too")
]
BindOption = Annotated[str, typer.Option("--bind", help="TCP address; without keys only loopback")]
KeysOption = Annotated[
    Path | None, typer.Option("--keys", help="key directory (rfms keys); TCP requires these keys")
]
GrantOption = Annotated[
    list[str] | None,
    typer.Option(
        "--grant",
        metavar="SENSOR=REFERENCE,...",
        help="references that a sensor may observe in a session of its own; repeatable",
    ),
]


@takes_settings()
def serve(
    *,
    settings: RunSettings,
    name: NameOption = DEFAULT_NAME,
    tcp: TcpOption = None,
    bind: BindOption = "127.0.0.1",
    keys: KeysOption = None,
    grant: GrantOption = None,
    attach: Annotated[
        bool, typer.Option("--attach", help="the other nodes are on the bus already")
    ] = False,
    record: RecordOption = None,
    fifo: FifoOption = None,
    cpu: CpuOption = None,
    mlockall: LockOption = False,
    as_json: JsonOption = False,
) -> None:
    """Bring the arm up and serve coordinators until Ctrl-C; then stop it and brake."""
    from rfms_can.rig import serve as rig

    listening = _listening(name, tcp, bind, keys)
    grants = grants_of(grant or [])

    def ready() -> None:
        if as_json:
            _line({"ready": name})

    with signals_noted() as interrupt, _status_line(name, quiet=as_json) as shown:
        served = rig.serve(
            settings,
            listening,
            record=record,
            attach=attach,
            watch=lambda _: set_real_time(fifo, cpu, mlockall),
            ready=ready,
            shown=shown,
            interrupted=interrupt,
            grants=grants,
        )
    _report(f"{name} served {settings.arm}, {settings.bus}", served, as_json=as_json)
    if served.fault is not None:
        raise served.fault


def keys(
    directory: Annotated[Path, typer.Argument(help="the server's key directory")],
    client: Annotated[
        str | None, typer.Option("--client", help="make a pair for this client and authorise it")
    ] = None,
) -> None:
    """Make the CURVE keys of a server that listens on TCP, and of its clients."""
    public = new_server_keys(directory)
    typer.echo(f"{public}: the server's public key; every client needs a copy")
    if client is not None:
        secret = new_client_keys(directory, client)
        typer.echo(f"{secret}: keys of {client!r}; move it to the client and leave no copy")


def grants_of(texts: Sequence[str]) -> dict[str, list[str]]:
    """References by sensor, of texts like ``camera=part,tray``.

    Raises:
        SettingsError: a text is of another form, or there are too many of something.
    """
    grants: dict[str, list[str]] = {}
    for text in texts:
        sensor, equals, names = text.partition("=")
        sensor, references = sensor.strip(), [name.strip() for name in names.split(",")]
        if not equals or not all(0 < len(name) <= LONGEST_NAME for name in (sensor, *references)):
            raise SettingsError(
                f"--grant {text!r}: give SENSOR=REFERENCE,REFERENCE, each of 1 to {LONGEST_NAME} "
                f"characters, as in camera=part"
            )
        grants[sensor] = [*grants.get(sensor, []), *references]
        if len(grants[sensor]) > MAX_REFERENCES:
            raise SettingsError(
                f"--grant {text!r}: {len(grants[sensor])} references for sensor {sensor!r}, "
                f"{MAX_REFERENCES} may be; give it fewer"
            )
    if len(grants) > MAX_SENSORS:
        raise SettingsError(f"--grant: {len(grants)} sensors, {MAX_SENSORS} may be; give fewer")
    return grants


def _listening(name: str, tcp: int | None, bind: str, keys: Path | None) -> "Listening":
    from rfms_can.rig.serve import Listening

    if tcp is None:
        if keys is not None:
            raise SettingsError("--keys works only with TCP connections: give --tcp PORT too")
        return Listening(name)
    return Listening(name, checked(bind, tcp), None if keys is None else ServerKeys.load(keys))


@contextmanager
def _status_line(name: str, *, quiet: bool) -> Iterator[Shown | None]:
    """Show the arm's state and who controls it, with the server's events above."""
    if quiet:
        yield None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("[bold]{task.description}"),
        TextColumn("{task.fields[phase]:<9} cycle {task.fields[cycle]:>6}"),
        TextColumn("{task.fields[state]}", markup=False),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(name, total=None, phase="ROLL_CALL", cycle=0, state="")

        def show(serving: "Serving") -> None:
            server = serving.server
            while server.events:
                console.print(f"{name}: {server.events.popleft()}", markup=False, highlight=False)
            status = server.status()
            who = "no coordinator" if status.lease is None else repr(status.lease)
            progress.update(
                task,
                phase=status.phase,
                cycle=status.cycle,
                state=f"{status.stage:<6} move {status.sequence}  controlled by {who}",
            )

        try:
            yield show
        except BaseException:
            progress.remove_task(task)  # the error is printed alone, in one line
            progress.disable = not console.is_terminal
            raise


def _report(title: str, served: "Served", *, as_json: bool) -> None:
    numbers = served.numbers
    if as_json:
        import msgspec

        _line({**served.result.as_dict(), "server": msgspec.to_builtins(numbers)})
        return
    print_result(title, served.result)
    for line in latency_lines(numbers):
        console.print(line, markup=False, highlight=False)
    console.print(
        f"requests {numbers.requests}, repeated {numbers.repeated}, refused {numbers.refused}; "
        f"emergency stops {numbers.emergencies}; stopped for want of a lease {numbers.lapses}; "
        f"cycles without the coordinator {numbers.unattended}",
        highlight=False,
    )


def latency_lines(numbers: ServerNumbers) -> Iterator[str]:
    """The histograms: from a request's receipt to the SETPOINT that carries it."""
    names = ("in the same cycle", "one cycle on", "two cycles on", "later")
    parts = [f"{n} {name}" for n, name in zip(numbers.latency_cycles, names, strict=True) if n]
    yield f"from request to SETPOINT: {', '.join(parts) or 'none'}"
    total = sum(numbers.latency_ns)
    if not total:
        return
    edges = [f"under {edge // 1_000_000} ms" for edge in LATENCY_EDGES_NS]
    for label, count in zip((*edges, "more"), numbers.latency_ns, strict=True):
        if count:
            bar = "#" * max(1, round(40 * count / total))
            yield f"{label:>12} {count:>7} {bar}"
    yield f"{'longest':>12} {numbers.latency_max_ns * 1e-6:.2f} ms"


def _line(report: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(report) + "\n")
    sys.stdout.flush()
