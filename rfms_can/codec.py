"""The DBC, compiled once into pack and unpack functions without branches for formats.

The DBC (``dbc/rfms.dbc``) is the single source of the wire. Reading it is cantools' work; packing
and unpacking on every cycle is not: each message is compiled, as ``collections.namedtuple`` is,
into one function each way that holds its struct, its bit fields and its ranges as constants.
Both ways are strict: exact length, every value finite and inside its DBC range.
"""

import hashlib
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

Record = TypeVar("Record", bound=NamedTuple)

HEADER_SIGNALS: Final = ("e2e_crc", "e2e_counter")
"""Signals of the end-to-end header: ``protection`` fills them, not the codec."""

HEADER_BYTES: Final = 3


def database_path() -> Path:
    """Where the DBC lies: beside the installed package, or in the source tree's ``dbc/``."""
    package = Path(str(resources.files("rfms_can")))
    for path in (package / "rfms.dbc", package.parent / "dbc" / "rfms.dbc"):
        if path.is_file():
            return path
    raise DbcError(f"rfms.dbc is neither in {package} nor in {package.parent / 'dbc'}; reinstall")


@cache
def load_database(path: Path | None = None) -> Database:
    """The wire contract as cantools reads it.

    Raises:
        DbcError: the file is missing or is no DBC.
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
    """First 16 bits of SHA-256 of the DBC's text, line ends normalised: SYNC's ``dbc_hash``."""
    text = (path or database_path()).read_bytes().replace(b"\r\n", b"\n")
    return int.from_bytes(hashlib.sha256(text).digest()[:2], "big")


@dataclass(frozen=True, slots=True)
class MessageCodec(Generic[Record]):
    """One message of the DBC, compiled.

    Attributes:
        name: message name in the DBC.
        id: CAN identifier.
        length: payload length, bytes; no other length is taken.
        data_id: E2E data ID, or None for a message without protection.
        every: sent every so many control cycles; 0 on event.
        pack_into: ``pack_into(buffer, *values)`` writes everything but the E2E header; raises
            ``EncodeError`` for a value that is not finite or out of range.
        unpack: ``unpack(data) -> Record | None``; None when a value is out of range or no number.
            The length must have been checked.
    """

    name: str
    id: int
    length: int
    data_id: int | None
    every: int
    pack_into: Callable[..., None]
    unpack: Callable[[bytes], Record | None]


def compile_message(message: Message, record: type[Record]) -> MessageCodec[Record]:
    """Compile one message; ``record``'s fields must be the message's signals, in order.

    Raises:
        DbcError: the record and the DBC disagree, or a signal is of a kind we do not use.
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
    layout = _Layout.of(message, signals, HEADER_BYTES if protected else 0)
    scope: dict[str, Any] = {
        "layout": struct.Struct(layout.format),
        "new": tuple.__new__,
        "record": record,
        "refuse": _refuser(message.name, signals),
    }
    exec(layout.source(), scope)  # compiled from the DBC, as namedtuple compiles
    return MessageCodec(
        name=message.name,
        id=message.frame_id,
        length=message.length,
        data_id=int(attributes["RfmsE2EDataId"].value) if protected else None,
        every=int(attributes["RfmsEvery"].value) if "RfmsEvery" in attributes else 0,
        pack_into=scope["pack_into"],
        unpack=scope["unpack"],
    )


def _refuser(message: str, signals: list[Signal]) -> Callable[..., None]:
    """The slow path of packing: find the value that does not fit and say so."""

    def refuse(*values: float) -> None:
        for signal, value in zip(signals, values, strict=True):
            low, high = _bounds(signal)
            whole = signal.is_float or signal.conversion.scale != 1 or isinstance(value, int)
            if not (low <= value <= high and whole):
                kind = "" if whole else ", a whole number"
                unit = f" {signal.unit}" if signal.unit else ""
                raise EncodeError(
                    f"{message}.{signal.name}: {value!r} does not fit {low:g}..{high:g}{unit}{kind}"
                )
        raise EncodeError(f"{message}: {values!r} cannot be packed")

    return refuse


def _bounds(signal: Signal) -> tuple[float, float]:
    low, high = signal.minimum, signal.maximum
    if low is None or high is None:
        raise DbcError(f"signal {signal.name} has no range in the DBC; give it [min|max]")
    if signal.is_float and struct.unpack("<2f", struct.pack("<2f", low, high)) != (low, high):
        raise DbcError(
            f"signal {signal.name}: {low!r}..{high!r} are no float32 numbers; round them"
        )
    return low, high


_STRUCT_CODES: Final = {
    (8, False): "B",
    (8, True): "b",
    (16, False): "H",
    (16, True): "h",
    (32, False): "I",
    (32, True): "i",
}


@dataclass(frozen=True, slots=True)
class _Layout:
    """How a message's signals lie in its bytes, and the source text that moves them."""

    format: str
    offset: int
    signals: list[Signal]
    packed: list[str]  # one expression for each struct item
    targets: list[str]  # one variable for each struct item
    fields: dict[str, str]  # signal -> expression of its raw value after unpacking

    @classmethod
    def of(cls, message: Message, signals: list[Signal], offset: int) -> "_Layout":
        """Lay out: aligned signals are struct items; the rest are cut from words of bytes."""
        layout = cls("<", offset, signals, [], [], {})
        codes, position, index = "<", offset * 8, 0
        while index < len(signals):
            signal = signals[index]
            if signal.byte_order != "little_endian":
                raise DbcError(f"{message.name}.{signal.name}: only little-endian signals are used")
            if signal.start < position:
                raise DbcError(f"{message.name}.{signal.name}: signals must not overlap")
            codes += f"{(signal.start - position) // 8}x" if signal.start > position else ""
            code = "f" if signal.is_float else _STRUCT_CODES.get((signal.length, signal.is_signed))
            if code and signal.start % 8 == 0:
                layout._add_item(signal)
                codes, position, index = codes + code, signal.start + signal.length, index + 1
            else:
                count, size = layout._add_word(signals[index:])
                codes, position, index = codes + f"{size}s", signal.start + size * 8, index + count
        tail = message.length * 8 - position
        return cls(f"{codes}{tail // 8}x", offset, signals, *layout._parts())

    def _parts(self) -> tuple[list[str], list[str], dict[str, str]]:
        return self.packed, self.targets, self.fields

    def _add_item(self, signal: Signal) -> None:
        self.packed.append(_raw_of(signal))
        self.targets.append(signal.name)
        self.fields[signal.name] = _value_of(signal, signal.name)

    def _add_word(self, signals: list[Signal]) -> tuple[int, int]:
        """Take signals until a byte boundary is reached; return their number and the bytes."""
        start, word, parts, end = signals[0].start, f"word{len(self.targets)}", [], 0
        for count, signal in enumerate(signals, 1):
            shift, mask = signal.start - start, (1 << signal.length) - 1
            parts.append(f"({_raw_of(signal)} & {mask:#x}) << {shift}")
            raw = f"({word} >> {shift} & {mask:#x})"
            if signal.is_signed:
                sign = 1 << (signal.length - 1)
                raw = f"(({raw} ^ {sign:#x}) - {sign:#x})"
            self.fields[signal.name] = _value_of(signal, raw)
            end = signal.start + signal.length
            following = signals[count].start if count < len(signals) else end + 8
            if end % 8 == 0 or following >= -(-end // 8) * 8:
                break
        size = -(-(end - start) // 8)
        self.packed.append(f"({' | '.join(parts)}).to_bytes({size}, 'little')")
        self.targets.append(word)
        return count, size

    def source(self) -> str:
        """Python text of ``pack_into`` and ``unpack``."""
        names = ", ".join(s.name for s in self.signals)
        checks = " and ".join(f"{lo!r} <= {s.name} <= {hi!r}" for s, lo, hi in self._ranges())
        words = [t for t in self.targets if t.startswith("word")]
        lines = [
            f"def pack_into(buffer, {names}):",
            f"    if not ({checks}): refuse({names})",
            "    try:",
            f"        layout.pack_into(buffer, {self.offset}, {', '.join(self.packed)})",
            "    except Exception: refuse(" + names + ")",
            "def unpack(data):",
            f"    {', '.join(self.targets)}, = layout.unpack_from(data, {self.offset})",
            *(f"    {word} = int.from_bytes({word}, 'little')" for word in words),
            *(f"    {n} = {e}" for n, e in self.fields.items() if n != e),
            f"    if {checks}: return new(record, ({names},))",
            "    return None",
        ]
        return "\n".join(lines)

    def _ranges(self) -> list[tuple[Signal, float, float]]:
        return [(s, *_bounds(s)) for s in self.signals]


def _raw_of(signal: Signal) -> str:
    """Expression of the raw value of a physical one; rounds as cantools does."""
    scale, offset = signal.conversion.scale, signal.conversion.offset
    if signal.is_float or (scale == 1 and offset == 0):
        return str(signal.name)
    return f"round(({signal.name} - {offset!r}) / {scale!r})"


def _value_of(signal: Signal, raw: str) -> str:
    scale, offset = signal.conversion.scale, signal.conversion.offset
    if signal.is_float or (scale == 1 and offset == 0):
        return raw
    return f"({raw} * {scale!r} + {offset!r})"
