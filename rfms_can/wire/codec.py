"""The DBC, compiled once into pack and unpack functions without branches for formats.

The DBC (``dbc/rfms.dbc``) is the single source of the wire. Reading it is cantools' work; packing
and unpacking on every cycle is not: each message is compiled, as ``collections.namedtuple`` is,
into one function each way that holds its struct, its bit fields and its ranges as constants.
Both ways are strict: exact length, every value finite and inside its DBC range.
"""

import hashlib
import os
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Final, Generic, NamedTuple, TypeVar

import cantools
from cantools.database.can import Database, Message, Signal

from rfms_can.errors import DbcError, EncodeError
from rfms_can.wire.layout import Layout, bounds, is_scaled, known_values

Record = TypeVar("Record", bound=NamedTuple)

HEADER_SIGNALS: Final = ("e2e_crc", "e2e_counter")
"""Signals of the end-to-end header, filled by ``protection`` and not by the codec."""

HEADER_BYTES: Final = 3

LAYOUT_ATTRIBUTES: Final = ("RfmsE2EDataId", "RfmsEvery", "VFrameFormat", "RfmsClassicToo")
"""Attributes of a message that are part of the layout."""

DBC_VARIABLE: Final = "RFMS_DBC"


def database_path() -> Path:
    """Path of the DBC: beside the installed package, or in the source tree's ``dbc/``.

    The environment variable ``RFMS_DBC`` overrides it.
    """
    if DBC_VARIABLE in os.environ:
        return Path(os.environ[DBC_VARIABLE])
    package = Path(str(resources.files("rfms_can")))
    for path in (package / "rfms.dbc", package.parent / "dbc" / "rfms.dbc"):
        if path.is_file():
            return path
    raise DbcError(f"rfms.dbc is neither in {package} nor in {package.parent / 'dbc'}; reinstall")


@cache
def load_database(path: Path | None = None) -> Database:
    """The wire contract as cantools reads it.

    Raises:
        DbcError: the file is missing or is not a DBC.
    """
    path = path or database_path()
    try:
        database = cantools.database.load_file(path, strict=True)
    except (OSError, cantools.Error, ValueError) as error:
        raise DbcError(f"{path} cannot be read as a DBC: {error}") from error
    if not isinstance(database, Database):
        raise DbcError(f"{path} is not a CAN database")
    return database


@cache
def database_hash(path: Path | None = None) -> int:
    """First 16 bits of SHA-256 of the DBC's layout: SYNC's ``dbc_hash``.

    The layout is what two nodes must agree on to understand one another: identifiers, names,
    lengths, bits, types, units, ranges, data IDs and periods. Comments and value tables are not
    part of it: a new fault, parameter or law inside its reserved range leaves the hash as it is.
    """
    return layout_hash(load_database(path))


def layout_hash(database: Database) -> int:
    """``database_hash`` of a database that is loaded already."""
    text = "\n".join(layout_lines(database))
    return int.from_bytes(hashlib.sha256(text.encode("ascii")).digest()[:2], "big")


def layout_lines(database: Database) -> list[str]:
    """The layout in words, a line for each message and signal, by identifier and first bit."""
    lines = []
    for message in sorted(database.messages, key=lambda m: m.frame_id):
        attributes = message.dbc.attributes if message.dbc else {}
        own = [attributes[name].value if name in attributes else "-" for name in LAYOUT_ATTRIBUTES]
        lines.append(f"{message.frame_id:03x} {message.name} {message.length} {own}")
        for s in sorted(message.signals, key=lambda s: s.start):
            kind = "f" if s.is_float else "i" if s.is_signed else "u"
            numbers = (s.conversion.scale, s.conversion.offset, *bounds(s))
            scaled = " ".join(f"{number:.17g}" for number in numbers)
            lines.append(
                f" {s.name} {s.start} {kind}{s.length} {s.byte_order} {scaled} {s.unit or ''}"
            )
    return lines


@dataclass(frozen=True, slots=True)
class MessageCodec(Generic[Record]):
    """One message of the DBC, compiled.

    Attributes:
        name: message name in the DBC.
        id: CAN identifier.
        length: payload length, bytes; other lengths are refused.
        data_id: E2E data ID, or None for a message without protection.
        senders: names of the nodes that may send it.
        every: sent every so many control cycles; 0 on event.
        classic: whether it is taken from a classic CAN frame too.
        pack_into: ``pack_into(buffer, *values)`` writes everything but the E2E header; raises
            ``EncodeError`` for a value that is not finite or out of range.
        unpack: ``unpack(data) -> Record | None``; None when a value is out of range or NaN. The
            length must have been checked.
    """

    name: str
    id: int
    length: int
    data_id: int | None
    senders: frozenset[str]
    every: int
    classic: bool
    pack_into: Callable[..., None]
    unpack: Callable[[bytes], Record | None]


def compile_message(message: Message, record: type[Record]) -> MessageCodec[Record]:
    """Compile one message; ``record``'s fields must be the message's signals, in order.

    Raises:
        DbcError: the record and the DBC disagree, or a signal is of an unsupported kind.
    """
    signals = [s for s in message.signals if s.name not in HEADER_SIGNALS]
    names = tuple(s.name for s in signals)
    if names != record._fields:
        raise DbcError(
            f"{message.name}: the DBC has signals {', '.join(names)}, "
            f"but {record.__name__} has {', '.join(record._fields)}; they must be the same"
        )
    attributes = message.dbc.attributes if message.dbc else {}
    protected = "RfmsE2EDataId" in attributes
    if len(message.signals) - len(signals) != (len(HEADER_SIGNALS) if protected else 0):
        # a data ID missing in the DBC must not disable the check
        raise DbcError(
            f"{message.name}: signals {' and '.join(HEADER_SIGNALS)} and attribute RfmsE2EDataId "
            "go together; give it all three or none"
        )
    layout = Layout.of(message, signals, HEADER_BYTES if protected else 0, record._field_defaults)
    scope: dict[str, Any] = {
        "_layout": struct.Struct(layout.format),
        "_new": tuple.__new__,
        "_record": record,
        "_refuse": _refuser(message.name, signals),
    }
    exec(layout.source(), scope)  # compiled from the DBC, as namedtuple compiles
    return MessageCodec(
        name=message.name,
        id=message.frame_id,
        length=message.length,
        data_id=int(attributes["RfmsE2EDataId"].value) if protected else None,
        senders=frozenset(message.senders),
        every=int(attributes["RfmsEvery"].value) if "RfmsEvery" in attributes else 0,
        classic=bool("RfmsClassicToo" in attributes and attributes["RfmsClassicToo"].value),
        pack_into=scope["pack_into"],
        unpack=scope["unpack"],
    )


def _refuser(message: str, signals: list[Signal]) -> Callable[..., None]:
    """The slow path of packing: report the value that does not fit."""

    def refuse(*values: float) -> None:
        for signal, value in zip(signals, values, strict=True):
            low, high = bounds(signal)
            whole = is_scaled(signal) or signal.is_float or hasattr(value, "__index__")
            if not (low <= value <= high and whole):
                kind = "" if whole else ", a whole number"
                unit = f" {signal.unit}" if signal.unit else ""
                raise EncodeError(
                    f"{message}.{signal.name}: {value!r} does not fit {low}..{high}{unit}{kind}"
                )
            known = known_values(signal)
            if known and value not in known:
                raise EncodeError(
                    f"{message}.{signal.name}: {value!r} has no name in the DBC's value table; "
                    f"there are {', '.join(map(str, known))}"
                )
        raise EncodeError(f"{message}: {values!r} cannot be packed")

    return refuse
