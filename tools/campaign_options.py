"""What the campaigns in this folder have in common: flags, and how they end."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from rfms_can.engine import Backend, backend_of
from rfms_can.engine.backends import CLUSTER_HELP, KEEP_HELP, WORKERS_HELP
from rfms_can.engine.signals import exit_code
from rfms_can.errors import RfmsError

FOLDERS = ("tools",)
"""Of the checkout, that the code of the jobs lies in."""


def campaign_parser(description: str | None, kept: str) -> argparse.ArgumentParser:
    """A parser with the flags of every campaign.

    Args:
        description: of the tool, whose first line is shown.
        kept: where its results are, as an example.
    """
    first = (description or "").partition("\n")[0]
    parser = argparse.ArgumentParser(description=first)
    parser.add_argument("--workers", type=int, help=f"{WORKERS_HELP}; 1 if absent")
    parser.add_argument("--cluster", metavar="ADDRESS", help=CLUSTER_HELP)
    parser.add_argument("--keep", type=Path, help=f"{KEEP_HELP}, e.g. {kept}")
    return parser


def backend(options: argparse.Namespace) -> Backend:
    """What ``--workers`` or ``--cluster`` ask for.

    Raises:
        EngineError: they cannot be had.
    """
    return backend_of(options.workers, options.cluster, folders=FOLDERS)


def exit_with(main: Callable[[], int]) -> None:
    """End with the exit code of ``main``; what goes wrong is told in a line."""
    tool = Path(sys.argv[0]).name
    try:
        sys.exit(main())
    except RfmsError as error:
        print(f"{tool}: {error}", file=sys.stderr)
        for note in getattr(error.__cause__, "__notes__", ()):
            print(note, file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt as error:
        print(f"{tool}: interrupted; with --keep the same command goes on", file=sys.stderr)
        sys.exit(exit_code(error))
