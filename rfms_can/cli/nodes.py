"""``rfms joint N``, ``gripper``, ``plant``, ``master``: one process each, not on bus ``sim``."""

import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Annotated, Final

import typer

from rfms_can.cli.options import DEFAULT_BUS, RecordOption, takes_settings
from rfms_can.cli.run import run_program
from rfms_can.node.protocol import Node
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS

OF_A_NODE: Final = ("bus", "clock", "rate", "barrier", "seed")


@takes_settings(*OF_A_NODE, defaults=DEFAULT_BUS)
def joint(
    number: Annotated[int, typer.Argument(help="1 to 6", min=JOINTS[0], max=JOINTS[-1])],
    *,
    settings: RunSettings,
) -> None:
    """Run joint node N until Ctrl-C."""
    from rfms_can.rig.nodes import make_joint

    serve(make_joint(number, settings, Wire()), settings)


@takes_settings(*OF_A_NODE, defaults=DEFAULT_BUS)
def gripper(*, settings: RunSettings) -> None:
    """Run the gripper node until Ctrl-C."""
    from rfms_can.rig.nodes import make_gripper

    serve(make_gripper(settings, Wire()), settings)


@takes_settings("arm", *OF_A_NODE, "friction", "plant", "scene", "sensor", defaults=DEFAULT_BUS)
def plant(*, settings: RunSettings) -> None:
    """Run the plant until Ctrl-C."""
    from rfms_can.rig.nodes import make_plant

    serve(make_plant(settings, Wire()), settings)


@takes_settings(
    "arm",
    *OF_A_NODE,
    *("servo_friction", "dynamics", "calibration", "patience", "following_error"),
    defaults=DEFAULT_BUS,
)
def master(
    program: Annotated[
        Path | None, typer.Argument(help="program to run; without one the master waits, braked")
    ] = None,
    *,
    settings: RunSettings,
    record: RecordOption = None,
) -> None:
    """Run the master: with a program until it ends, without one until Ctrl-C."""
    from rfms_can.rig.idle import run_idle

    if program is not None:
        run_program(program, settings, record=record, attach=True)
    else:
        run_idle(settings, stop_on_signals())


def serve(node: Node, settings: RunSettings) -> None:
    """Drive a node until Ctrl-C or SIGTERM."""
    from rfms_can.bus.driver import open_port, run_node

    port = open_port(settings.bus, node.accepts, client=node.name)
    try:
        run_node(node, port, stop=stop_on_signals())
    finally:
        port.close()


def stop_on_signals() -> Callable[[], bool]:
    """A function that says whether Ctrl-C or SIGTERM has come."""
    stopped = False

    def stop(_signal: int, _frame: FrameType | None) -> None:
        nonlocal stopped
        stopped = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    return lambda: stopped
