"""Validation of a message as by the server, and the error message of a program."""

import re
from typing import Any, Final, TypeVar

import msgspec
import numpy as np

from rfms_can.errors import ProgramError
from rfms_can.messages import Message

Checked = TypeVar("Checked", bound=Message)

_PLACE: Final = re.compile(r"(?P<what>.*) - at (?:`key` in )?`\$(?P<place>[^`]*)`")
_STEP: Final = re.compile(r"\.(\w+)|\[([^\]]+)\]")


def checked(message: Checked, error_class: type[ProgramError], what: str) -> Checked:
    """The message as the server would decode it.

    Raises:
        ProgramError: of the class given: a field is of a wrong type or out of bounds.
    """
    try:
        plain = msgspec.to_builtins(message, enc_hook=_number)
    except (TypeError, RecursionError) as error:
        raise error_class(f"{what}: {error}") from error
    try:
        return msgspec.convert(plain, type=type(message))
    except msgspec.ValidationError as error:
        raise error_class(f"{what}: {_with_value(str(error), plain)}") from error


def _number(value: Any) -> Any:
    """A number or array of numpy as Python's own.

    Raises:
        TypeError: it is neither.
    """
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{value!r} is not a number, a text or a table of them")


def _with_value(complaint: str, plain: Any) -> str:
    """msgspec's complaint with the value: msgspec names only its place."""
    found = _PLACE.fullmatch(complaint)
    if found is None:
        return complaint
    value, place = plain, found["place"]
    for name, index in _STEP.findall(place):
        if index == "...":  # one of the values of a table
            break
        value = value[name] if name else value[int(index)]
    return f"{place.lstrip('.')} {value!r}: {found['what'].lower()}"
