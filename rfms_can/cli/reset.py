"""``rfms reset``: leads a halted arm out of a fault; lifts an emergency stop for a person."""

import getpass
import json
import sys
import time
from typing import Annotated, Final

import msgspec
import typer

from rfms_can.cli.coordinate import ClientKeysOption, ServerOption, client_keys
from rfms_can.cli.options import JsonOption
from rfms_can.coordinator import ClientKeys, Status, connect
from rfms_can.errors import FaultError, LinkError, RfmsError
from rfms_can.link.address import DEFAULT_NAME, operator_endpoint
from rfms_can.link.client import ClientSocket, send_as_operator
from rfms_can.messages import EmergencyLift

NAME: Final = "rfms reset"
WORD: Final = "lift"
"""What a person types to lift an emergency stop."""
HEARD_S: Final = 3.0
"""Longest time for the server's state to be heard, s."""
_status: Final = msgspec.msgpack.Decoder(Status)


def reset(
    *,
    server: ServerOption = DEFAULT_NAME,
    keys: ClientKeysOption = None,
    lift_emergency_stop: Annotated[
        bool,
        typer.Option(
            "--lift-emergency-stop",
            help="lift it first; asks the person at this terminal, on the server's machine",
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Lead a halted arm out of its fault: reset, home if needed, enable; it holds where it is."""
    pair = None if keys is None else client_keys(keys)
    if lift_emergency_stop:
        _lift(server, pair)
    with connect(server, name=NAME, keys=pair) as arm:
        fault = arm.status.fault
        arm.reset()
        ended = arm.status
    if as_json:
        typer.echo(json.dumps({"server": server, "reset": fault, "phase": ended.phase}))
    else:
        typer.echo(
            f"{server}: the fault is reset ({fault}); the arm is enabled and holds", err=True
        )


def _lift(server: str, keys: ClientKeys | None) -> None:
    """Ask the person at the terminal, and lift the emergency stop.

    Raises:
        RfmsError: there is no terminal, none is in force, or the person does not want to.
    """
    operator_endpoint(server)  # before anything is asked
    if not sys.stdin.isatty():
        raise RfmsError(
            "--lift-emergency-stop: standard input is no terminal; a person lifts an emergency "
            "stop, who sees the arm: run it at a terminal of the server's machine"
        )
    with ClientSocket(server, keys) as socket:
        status = _heard(socket, server)
        if not status.emergency:
            state = status.fault or f"the arm is in phase {status.phase}"
            raise RfmsError(f"--lift-emergency-stop: no emergency stop is in force ({state})")
        typer.echo(f"{status.fault}", err=True)
        typer.echo(f"is the arm's surrounding safe? type '{WORD}' to lift the stop: ", err=True)
        if sys.stdin.readline().strip() != WORD:
            raise FaultError("the emergency stop stays in force")
        send_as_operator(server, msgspec.msgpack.encode(EmergencyLift(getpass.getuser())))
        until = time.monotonic() + HEARD_S
        while _heard(socket, server).emergency:
            if time.monotonic() > until:
                raise LinkError(f"server {server!r} has not lifted the emergency stop: is it busy?")


def _heard(socket: ClientSocket, server: str) -> Status:
    """The server's newest state."""
    data = socket.newest_status(HEARD_S)
    if data is None:
        raise LinkError(
            f"server {server!r} has told nothing for {HEARD_S:g} s: see whether it runs"
        )
    return _status.decode(data)
