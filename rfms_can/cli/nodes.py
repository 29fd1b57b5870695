"""``rfms joint N``, ``gripper``, ``plant``, ``master``: one process each, not on bus ``sim``."""

import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from rfms_can.cli.options import (
    ArmOption,
    BarrierOption,
    BusOption,
    ClockOption,
    ConfigOption,
    FrictionOption,
    PatienceOption,
    RateOption,
    SeedOption,
    ServoFrictionOption,
    settings_from,
)
from rfms_can.cli.run import RecordOption, run_program
from rfms_can.node import Node
from rfms_can.rig.settings import RunSettings
from rfms_can.wire import JOINTS, Wire

DEFAULT_BUS = "hub:rfms"
"""Where processes meet if nobody says where."""


def joint(
    number: Annotated[int, typer.Argument(help="1 to 6", min=JOINTS[0], max=JOINTS[-1])],
    bus: BusOption = None,
    clock: ClockOption = None,
    rate: RateOption = None,
    barrier: BarrierOption = None,
    seed: SeedOption = None,
    config: ConfigOption = None,
) -> None:
    """Run joint node N until Ctrl-C."""
    from rfms_can.rig.nodes import make_joint

    settings = node_settings(config, bus=bus, clock=clock, rate=rate, barrier=barrier, seed=seed)
    serve(make_joint(number, settings, Wire()), settings)


def gripper(
    bus: BusOption = None,
    clock: ClockOption = None,
    rate: RateOption = None,
    barrier: BarrierOption = None,
    seed: SeedOption = None,
    config: ConfigOption = None,
) -> None:
    """Run the gripper node until Ctrl-C."""
    from rfms_can.rig.nodes import make_gripper

    settings = node_settings(config, bus=bus, clock=clock, rate=rate, barrier=barrier, seed=seed)
    serve(make_gripper(settings, Wire()), settings)


def plant(
    arm: ArmOption = None,
    bus: BusOption = None,
    clock: ClockOption = None,
    rate: RateOption = None,
    friction: FrictionOption = None,
    barrier: BarrierOption = None,
    seed: SeedOption = None,
    config: ConfigOption = None,
) -> None:
    """Run the plant until Ctrl-C."""
    from rfms_can.rig.nodes import make_plant

    settings = node_settings(
        config,
        arm=arm,
        bus=bus,
        clock=clock,
        rate=rate,
        friction=friction,
        barrier=barrier,
        seed=seed,
    )
    serve(make_plant(settings, Wire()), settings)


def master(
    program: Annotated[
        Path | None, typer.Argument(help="program to run; without one the master waits, braked")
    ] = None,
    arm: ArmOption = None,
    bus: BusOption = None,
    clock: ClockOption = None,
    rate: RateOption = None,
    servo_friction: ServoFrictionOption = None,
    barrier: BarrierOption = None,
    patience: PatienceOption = None,
    seed: SeedOption = None,
    record: RecordOption = None,
    config: ConfigOption = None,
) -> None:
    """Run the master: with a program until it ends, without one until Ctrl-C."""
    from rfms_can.rig.idle import run_idle

    settings = node_settings(
        config,
        arm=arm,
        bus=bus,
        clock=clock,
        rate=rate,
        servo_friction=servo_friction,
        barrier=barrier,
        patience=patience,
        seed=seed,
    )
    if program is not None:
        run_program(program, settings, record=record, attach=True)
    else:
        run_idle(settings, stop_on_signals())


def node_settings(config: Path | None, **flags: object) -> RunSettings:
    """Settings of a process of its own: the hub unless a bus is named."""
    return settings_from(config, {"bus": DEFAULT_BUS}, **flags)


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
