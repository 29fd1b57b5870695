"""``rfms``: the command line. Exit code 0 only on success; errors are one line."""

import sys
from typing import Annotated, Final, cast

import typer
from rich.console import Console

from rfms_can import __version__
from rfms_can.cli.budget import budget
from rfms_can.cli.campaign import campaign
from rfms_can.cli.conform import conform
from rfms_can.cli.coordinate import coordinate
from rfms_can.cli.demo import demo
from rfms_can.cli.doctor import doctor
from rfms_can.cli.faults import faults
from rfms_can.cli.hub import hub
from rfms_can.cli.identify import identify
from rfms_can.cli.kin import kin
from rfms_can.cli.nodes import gripper, joint, master, plant
from rfms_can.cli.plot import plot
from rfms_can.cli.reset import reset
from rfms_can.cli.run import run
from rfms_can.cli.serve import keys, serve
from rfms_can.cli.stability import stability
from rfms_can.cli.up import up
from rfms_can.errors import RfmsError

_USAGE_ERROR: Final = cast("type[typer.BadParameter]", typer.BadParameter.__base__)
"""click's ``UsageError``, or that of the copy of click which newer typers bring along."""

app = typer.Typer(
    name="rfms",
    help="A robot force and motion server over CAN FD: master, joint nodes, plant.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for _verb in (
    demo,
    run,
    serve,
    keys,
    coordinate,
    reset,
    up,
    master,
    joint,
    gripper,
    plant,
    hub,
    conform,
    kin,
    budget,
    stability,
    campaign,
    faults,
    identify,
    plot,
    doctor,
):
    app.command(_verb.__name__)(_verb)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"rfms {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="and exit")
    ] = False,
) -> None:
    """Options of all verbs."""


def main() -> None:
    """Entry point: our own errors are one line and exit code 1, wrong usage one and 2."""
    try:
        sys.exit(app(prog_name="rfms", standalone_mode=False))
    except _USAGE_ERROR as error:
        text, verb = error.format_message(), error.ctx.command_path if error.ctx else "rfms"
        line = f"rfms: {text.removesuffix('.')}; see {verb} --help"
        typer.echo(text if "\n" in text else line, err=True)  # without a verb the text is the help
        sys.exit(2)
    except typer.Abort:  # Ctrl-C in a verb that does not handle it
        sys.exit(130)
    except RfmsError as error:
        Console(stderr=True, soft_wrap=True, highlight=False).print(
            f"rfms: {error}", markup=False, style="red"
        )
        sys.exit(1)
    except BrokenPipeError:
        sys.exit(1)
