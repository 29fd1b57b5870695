"""List the messages of the coordinator's link, their fields and bounds in docs/link.md."""

import inspect
import re
from collections.abc import Sequence
from enum import EnumType
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

import msgspec
from generated import main, table

from rfms_can.messages import (
    Answer,
    AnyCondition,
    AnyFunction,
    ArmRequest,
    Culprit,
    EmergencyLift,
    EmergencyStop,
    Envelope,
    LeaseRequest,
    MoveOutcome,
    OutcomeQuery,
    PlannedMove,
    Query,
    Refusal,
    Reply,
    SensorRequest,
    ServerNumbers,
    Status,
    TableRow,
    WaitRequest,
    WorldNames,
)

GROUPS: Final[tuple[tuple[str, str, tuple[Any, ...]], ...]] = (
    ("Envelope", "What a coordinator sends to `requests`.", (Envelope,)),
    ("Requests that need the lease", "", get_args(ArmRequest)),
    (
        "Requests that do not",
        "",
        (LeaseRequest, SensorRequest, Query, OutcomeQuery, WaitRequest),
    ),
    ("Conditions of a WAIT", "", get_args(AnyCondition)),
    ("Functions of a functional transform", "", (*get_args(AnyFunction), TableRow)),
    (
        "Replies",
        "What comes back.",
        (Reply, Answer, PlannedMove, Refusal, MoveOutcome, WorldNames, ServerNumbers),
    ),
    (
        "Status",
        "What `status` broadcasts after every cycle; also part of every reply.",
        (Status, Culprit),
    ),
    ("Emergency stop", "What `emergency` takes.", (EmergencyStop,)),
    ("Operator", "What `operator` takes.", (EmergencyLift,)),
)
"""The messages, as they are told apart: heading, a line about them, classes."""

_PLAIN: Final[dict[Any, str]] = {
    float: "number",
    int: "integer",
    str: "text",
    bool: "true or false",
    NoneType: "null",
}
_WORDS: Final = {"ge": ">=", "gt": ">", "le": "<=", "lt": "<"}


def kind(hint: Any) -> str:
    """A field's type as a reader of the page wants it."""
    arguments = get_args(hint)
    match get_origin(hint):
        case origin if origin is Annotated:
            text = f"{kind(arguments[0])}{bounds(arguments[1:])}"
        case origin if origin is Literal:
            text = " | ".join(f'"{word}"' for word in arguments)
        case origin if origin in (Union, UnionType):
            text = "a request" if Query in arguments else " | ".join(map(kind, arguments))
        case origin if origin is tuple:
            text = f"{len(arguments)} {kind(arguments[0])}s"
        case origin if origin is list:
            text = f"list of {kind(arguments[0])}"
        case origin if origin is dict:
            text = f"{kind(arguments[0])} to {kind(arguments[1])}"
        case _ if isinstance(hint, EnumType):
            members: list[Any] = list(hint.__members__.values())
            text = " | ".join(f'"{member.value}"' for member in members)
        case _:
            text = _PLAIN.get(hint) or name(hint)
    return text


def name(cls: type[Any]) -> str:
    """A message's tag; its class where it has none."""
    return str(cls.__struct_config__.tag or cls.__name__)


def bounds(metas: Sequence[Any]) -> str:
    """The bounds of a field."""
    parts = []
    for meta in metas:
        parts += [
            f"{sign} {getattr(meta, name):g}"
            for name, sign in _WORDS.items()
            if getattr(meta, name) is not None
        ]
        low, high = meta.min_length, meta.max_length
        if high is not None:
            parts.append(f"{low or 0} to {high} long")
        elif low is not None:
            parts.append(f"{low} or longer")
    return f" ({', '.join(parts)})" if parts else ""


def meanings(cls: type[Any]) -> dict[str, str]:
    """What the docstring says of each field; one line may speak of several."""
    _, _, listed = (inspect.getdoc(cls) or "").partition("Attributes:\n")
    found: dict[str, str] = {}
    for entry in re.split(r"\n(?=    \w)", listed):
        names, _, text = entry.strip().partition(": ")
        for name in names.split(","):
            found[name.strip()] = re.sub(r"\s+", " ", text).replace("``", "`")
    return found


def default(field: msgspec.structs.FieldInfo) -> str:
    """A default as JSON; empty without one."""
    if field.default is msgspec.NODEFAULT:
        return "required" if field.default_factory is msgspec.NODEFAULT else "[]"
    return msgspec.json.encode(field.default).decode()


def section(cls: type[Any]) -> str:
    """A message: its tag, what it is for, its fields."""
    head = f"#### {name(cls)}"
    summary = (inspect.getdoc(cls) or "").partition("\n\n")[0].replace("\n", " ")
    hints = get_type_hints(cls, include_extras=True)
    said = meanings(cls)
    rows = [
        (f"`{field.name}`", kind(hints[field.name]), default(field), said.get(field.name, ""))
        for field in msgspec.structs.fields(cls)
    ]
    parts = [head, summary.replace("``", "`")]
    if rows:
        parts.append(table(("field", "type", "default", "meaning"), rows))
    return "\n\n".join(parts)


def render() -> str:
    """All messages, by what they are for."""
    parts = ["## Messages"]
    for heading, about, classes in GROUPS:
        parts += [f"### {heading}", *([about] if about else []), *map(section, classes)]
    return "\n\n".join(parts)


if __name__ == "__main__":
    main("draw_link.py", "link.md", render)
