"""List the verbs of ``rfms``, their arguments and flags in docs/command-line.md."""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import fields
from enum import Enum
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from generated import main, table
from typer.models import ArgumentInfo, OptionInfo

from rfms_can.cli.app import app
from rfms_can.rig.settings import RunSettings

WORDS = {int: "N", float: "X", str: "TEXT", Path: "PATH"}


def value(hint: Any) -> str:
    """What a flag takes; empty for a switch."""
    kinds = [kind for kind in get_args(hint) or (hint,) if kind is not NoneType]
    kind = kinds[0]
    if get_origin(kind) is list:  # repeatable
        return value(get_args(kind)[0])
    if kind is bool:
        return ""
    if isinstance(kind, type) and issubclass(kind, Enum):
        return " | ".join(str(member.value) for member in kind)
    return WORDS[kind]


def default(value: Any) -> str:
    """A default, if it says anything."""
    if value is None or value is False or value == "" or value is inspect.Parameter.empty:
        return ""
    return str(value.value if isinstance(value, Enum) else value)


def flags_of(info: OptionInfo, name: str) -> list[str]:
    """The flags of an option; in ``Annotated`` the first of them lands in ``default``."""
    given = [str(flag) for flag in (info.default, *(info.param_decls or ()))]
    return [flag for flag in given if flag.startswith("-")] or [f"--{name.replace('_', '-')}"]


def parameters(verb: Callable[..., Any]) -> Iterator[tuple[bool, tuple[str, ...]]]:
    """Whether it is an argument, and its row: flag, value, default, meaning."""
    hints = get_type_hints(verb, include_extras=True)
    for name, parameter in inspect.signature(verb).parameters.items():
        if get_origin(hints[name]) is not Annotated:
            raise TypeError(f"{verb.__name__}: parameter {name} has no help; annotate it")
        hint, info = get_args(hints[name])[:2]
        if isinstance(info, ArgumentInfo):
            choices = value(hint).replace(" ", "")
            word = choices if "|" in choices else name.upper()
            word = word if parameter.default is inspect.Parameter.empty else f"[{word}]"
            yield True, (f"`{word}`", info.help or "")
        elif isinstance(info, OptionInfo):
            flag = flags_of(info, name)[0]
            shown = f"`{flag} {value(hint)}`".replace(" `", "`")
            yield False, (shown, default(parameter.default), info.help or "")


def verb_section(verb: Callable[..., Any]) -> str:
    """A verb: how it is called, what it does, its arguments and flags."""
    rows = list(parameters(verb))
    arguments = [row for is_argument, row in rows if is_argument]
    flags = [row for is_argument, row in rows if not is_argument]
    usage = " ".join(["rfms", verb.__name__, *(row[0].strip("`") for row in arguments)])
    parts = [f"### {verb.__name__}", f"`{usage}`", inspect.getdoc(verb) or ""]
    if arguments:
        parts.append(table(("argument", "meaning"), arguments))
    if flags:
        parts.append(table(("flag", "default", "meaning"), flags))
    return "\n\n".join(parts)


def render() -> str:
    """The settings of a run and their defaults, then a section for each verb."""
    settings = [
        (f"`{field.name}`", default(field.default) or "follows from the others")
        for field in fields(RunSettings)
    ]
    verbs = [command.callback for command in app.registered_commands if command.callback]
    parts = ["## Settings of a run", table(("setting", "default"), settings), "## Verbs"]
    return "\n\n".join(parts + [verb_section(verb) for verb in verbs])


if __name__ == "__main__":
    main("draw_cli.py", "command-line.md", render)
