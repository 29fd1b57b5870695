"""Options that several verbs share, and where their values come from: flags, file, defaults."""

import dataclasses
import tomllib
from pathlib import Path
from typing import Annotated, Any

import typer

from rfms_can.errors import RfmsError
from rfms_can.rig.settings import RunSettings, SettingsError

CONFIG_FILE = Path("rfms.toml")

ArmOption = Annotated[str | None, typer.Option("--arm", help="puma260 | puma560")]
BusOption = Annotated[
    str | None,
    typer.Option("--bus", help="sim | hub:NAME | socketcan:DEVICE | INTERFACE:CHANNEL[?KEY=VALUE]"),
]
ClockOption = Annotated[
    str | None, typer.Option("--clock", help="virtual | lockstep | realtime; by the bus if absent")
]
RateOption = Annotated[float | None, typer.Option("--rate", help="control rate, Hz")]
FrictionOption = Annotated[
    str | None, typer.Option("--friction", help="friction of the plant: corke | thesis | none")
]
ServoFrictionOption = Annotated[
    str | None, typer.Option("--servo-friction", help="friction the servos compensate")
]
BlendOption = Annotated[
    str | None, typer.Option("--blend", help="transitions: continuous | thesis")
]
BarrierOption = Annotated[float | None, typer.Option("--barrier", help="longest lockstep cycle, s")]
PatienceOption = Annotated[
    float | None, typer.Option("--patience", help="how long absent nodes are waited for, s")
]
SeedOption = Annotated[int | None, typer.Option("--seed", help="makes the boot ids")]
ConfigOption = Annotated[
    Path | None, typer.Option("--config", help="TOML file with a [run] table; default rfms.toml")
]
JsonOption = Annotated[bool, typer.Option("--json", help="one JSON object instead of a table")]


def settings_from(config: Path | None, **flags: Any) -> RunSettings:
    """Settings of a run: flags beat the config file, the file beats the defaults.

    Raises:
        RfmsError: the file cannot be read, or holds a key or value that does not fit.
    """
    known = {field.name: field.type for field in dataclasses.fields(RunSettings)}
    values = {**_from_file(config, set(known)), **_given(flags)}
    try:
        return RunSettings(**values)
    except TypeError as error:
        raise SettingsError(f"settings do not fit: {error}") from error


def _given(flags: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in flags.items() if value is not None}


def _from_file(config: Path | None, known: set[str]) -> dict[str, Any]:
    path = config or CONFIG_FILE
    if config is None and not path.is_file():
        return {}
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8")).get("run", {})
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RfmsError(f"config file {path}: {error}") from error
    unknown = set(table) - known
    if unknown:
        raise SettingsError(
            f"config file {path}: no setting is called {', '.join(sorted(unknown))}; "
            f"there are: {', '.join(sorted(known))}"
        )
    return dict(table)
