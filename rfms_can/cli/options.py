"""Options shared by several verbs, and the sources of their values: flags, file, defaults."""

import dataclasses
import functools
import inspect
import tomllib
from collections.abc import Callable, Iterable, Mapping
from enum import IntEnum
from pathlib import Path
from types import MappingProxyType, NoneType
from typing import Annotated, Any, Final, get_args, get_type_hints

import typer

from rfms_can.arm import ARMS, FRICTION_SETS
from rfms_can.bus.url import GRAMMAR
from rfms_can.compliance import LAWS
from rfms_can.dynamics.model import KINDS
from rfms_can.engine.backends import CLUSTER_HELP, KEEP_HELP, WORKERS_HELP
from rfms_can.errors import RfmsError
from rfms_can.master.settings import CLOCKS
from rfms_can.plant.scene.catalogue import SCENES
from rfms_can.plant.variant import WORDS as PLANTS
from rfms_can.plant.wrist_sensor import NO_SENSOR, SENSORS
from rfms_can.rig.settings import FORCE_LOOPS, RunSettings, SettingsError
from rfms_can.wire.vocabulary import Blend

CONFIG_FILE = Path("rfms.toml")


def words(choices: Iterable[str]) -> str:
    """The words that exist, from the table that defines them, as help shows them."""
    return " | ".join(choices)


def _names(kinds: Iterable[IntEnum]) -> str:
    return words(kind.name.lower() for kind in kinds)


ARM_WORDS: Final = words(ARMS)

ArmOption = Annotated[str | None, typer.Option("--arm", help=ARM_WORDS)]
BusOption = Annotated[str | None, typer.Option("--bus", help=GRAMMAR)]
ClockOption = Annotated[
    str | None, typer.Option("--clock", help=f"{_names(CLOCKS)}; by the bus if absent")
]
RateOption = Annotated[float | None, typer.Option("--rate", help="control rate, Hz")]
FrictionOption = Annotated[
    str | None,
    typer.Option("--friction", help=f"friction of the plant: {words(FRICTION_SETS)}"),
]
PlantOption = Annotated[
    str | None,
    typer.Option("--plant", help=f"{words(PLANTS)}, or one +load"),
]
ServoFrictionOption = Annotated[
    str | None, typer.Option("--servo-friction", help="friction the servos compensate")
]
DynamicsOption = Annotated[
    str | None, typer.Option("--dynamics", help=f"model compensated: {words(KINDS)}")
]
CalibrationOption = Annotated[
    str | None, typer.Option("--calibration", help="calibration file written by rfms identify")
]
BlendOption = Annotated[
    str | None,
    typer.Option(
        "--blend",
        help=f"transitions: {_names(Blend)}; thesis matches position and velocity of the old "
        "motion, continuous acceleration and jerk as well",
    ),
]
BarrierOption = Annotated[float | None, typer.Option("--barrier", help="longest lockstep cycle, s")]
PatienceOption = Annotated[
    float | None, typer.Option("--patience", help="timeout for nodes to appear, s")
]
SeedOption = Annotated[
    int | None, typer.Option("--seed", help="seed of the boot ids and the sensor's noise")
]
SceneOption = Annotated[
    str | None,
    typer.Option(
        "--scene",
        help=f"tool and fixtures: {words(SCENES)}, with NAME:KEY=VALUE,... to displace it",
    ),
]
SensorOption = Annotated[
    str | None,
    typer.Option("--sensor", help=f"at the wrist: {words((NO_SENSOR, *SENSORS))}"),
]
ConfigOption = Annotated[
    Path | None, typer.Option("--config", help="TOML file with a [run] table; default rfms.toml")
]
JsonOption = Annotated[bool, typer.Option("--json", help="one JSON object instead of a table")]

WorkersOption = Annotated[
    int | None, typer.Option("--workers", help=f"{WORKERS_HELP}; one for each processor if absent")
]
ClusterOption = Annotated[str | None, typer.Option("--cluster", help=CLUSTER_HELP)]
KeepOption = Annotated[Path | None, typer.Option("--keep", help=KEEP_HELP)]

RecordOption = Annotated[
    Path | None, typer.Option("--record", help="directory for log, settings and summary")
]

LawOption = Annotated[
    str | None,
    typer.Option("--law", help=f"control law: {words(law.value for law in LAWS)}"),
]
ForceLoopOption = Annotated[
    str | None,
    typer.Option("--force-loop", help=f"{words(FORCE_LOOPS)}; by default closed with a sensor"),
]
DitherOption = Annotated[
    float | None,
    typer.Option("--dither", help="dither of complying joints at rest, fraction of the friction"),
]
FollowingErrorOption = Annotated[
    float | None,
    typer.Option(
        "--following-error",
        help="largest error of a joint against what was commanded, rad; by its stiffness if absent",
    ),
]

SETTINGS: Final[dict[str, Any]] = {
    "arm": ArmOption,
    "bus": BusOption,
    "clock": ClockOption,
    "rate": RateOption,
    "friction": FrictionOption,
    "plant": PlantOption,
    "servo_friction": ServoFrictionOption,
    "dynamics": DynamicsOption,
    "calibration": CalibrationOption,
    "blend": BlendOption,
    "barrier": BarrierOption,
    "patience": PatienceOption,
    "seed": SeedOption,
    "scene": SceneOption,
    "sensor": SensorOption,
    "law": LawOption,
    "force_loop": ForceLoopOption,
    "dither": DitherOption,
    "following_error": FollowingErrorOption,
}
"""The flag of each setting."""

DEFAULT_BUS: Final = MappingProxyType({"bus": "hub:rfms"})
"""Default bus of processes."""

Verb = Callable[..., None]


def takes_settings(
    *names: str, defaults: Mapping[str, Any] = MappingProxyType({})
) -> Callable[[Verb], Verb]:
    """Add the flags of some settings and ``--config`` to a verb; it is called with ``settings``.

    Args:
        names: of the settings; all of them if none is given.
        defaults: of this verb, where they are not those of ``RunSettings``.
    """
    flags = names or tuple(SETTINGS)

    def decorate(verb: Verb) -> Verb:
        hints = get_type_hints(verb, include_extras=True)
        own = [p for p in inspect.signature(verb).parameters.values() if p.name != "settings"]
        shared = {**{name: SETTINGS[name] for name in flags}, "config": ConfigOption}
        added = [_flag(name, option) for name, option in shared.items()]

        @functools.wraps(verb)
        def with_flags(*args: Any, **values: Any) -> None:
            given = {name: values.pop(name, None) for name in flags}
            settings = settings_from(values.pop("config", None), defaults, **given)
            verb(*args, settings=settings, **values)

        first = [p for p in own if p.default is inspect.Parameter.empty]
        rest = [p for p in own if p.default is not inspect.Parameter.empty]
        vars(with_flags)["__signature__"] = inspect.Signature([*first, *added, *rest])
        with_flags.__annotations__ = {
            name: hint for name, hint in hints.items() if name != "settings"
        } | shared
        return with_flags

    return decorate


def _flag(name: str, option: Any) -> inspect.Parameter:
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Parameter(name, kind, default=None, annotation=option)


def settings_from(
    config: Path | None, defaults: Mapping[str, Any] = MappingProxyType({}), **flags: Any
) -> RunSettings:
    """Settings of a run: flags beat the config file, the file beats the defaults.

    Args:
        config: TOML file; ``rfms.toml``, if there is one, when not given.
        defaults: of this verb, where they are not those of ``RunSettings``.
        flags: settings by name; None for a flag that was not given.

    Raises:
        RfmsError: the file cannot be read, or holds an invalid key or value.
    """
    known = {field.name for field in dataclasses.fields(RunSettings)}
    values = {**defaults, **_from_file(config, known), **_given(flags)}
    return RunSettings(**values)


def _given(flags: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in flags.items() if value is not None}


def _from_file(config: Path | None, known: set[str]) -> dict[str, Any]:
    path = config or CONFIG_FILE
    if config is None and not path.is_file():
        return {}
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RfmsError(f"config file {path}: {error}") from error
    table = tables.get("run", {})
    if tables.keys() - {"run"} or not isinstance(table, dict):
        raise SettingsError(f"config file {path}: settings belong in one table, [run]")
    unknown = set(table) - known
    if unknown:
        raise SettingsError(
            f"config file {path}: unknown setting {', '.join(sorted(unknown))}; "
            f"there are: {', '.join(sorted(known))}"
        )
    for name, value in table.items():
        _check_kind(path, name, value)
    return dict(table)


def _check_kind(path: Path, name: str, value: object) -> None:
    """A value of the file must have the type of its setting; None stands for a default."""
    kinds = get_args(hints := get_type_hints(RunSettings)[name]) or (hints,)
    kind = next(kind for kind in kinds if kind is not NoneType)
    fits = type(value) is kind or (kind is float and type(value) is int)
    if not fits:
        words = {str: "a word in quotes", int: "a whole number", float: "a number"}
        raise SettingsError(f"config file {path}: {name} is {words[kind]}, not {value!r}")
