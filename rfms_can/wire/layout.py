"""Layout of a message's signals in its bytes, and the generated Python code that packs them.

Signals that begin at a byte and have a size supported by ``struct`` are items of one ``struct``
format; all others are extracted with shifts and masks from little-endian words between them.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from cantools.database.can import Message, Signal

from rfms_can.errors import DbcError

_STRUCT_CODES: Final = {
    (8, False): "B",
    (8, True): "b",
    (16, False): "H",
    (16, True): "h",
    (32, False): "I",
    (32, True): "i",
}


@dataclass(slots=True)
class Layout:
    """Layout of one message behind its header.

    Attributes:
        offset: bytes of the header, which the layout does not contain.
        signals: the signals, in the order of their bits.
        format: ``struct`` format of everything behind the header; gaps are written as zero bits.
        defaults: values that ``pack_into`` need not be given, by signal; those of the last signals.
    """

    offset: int
    signals: list[Signal]
    format: str = "<"
    defaults: Mapping[str, float] = field(default_factory=dict)
    _packed: list[str] = field(default_factory=list)  # one expression for each struct item
    _targets: list[str] = field(default_factory=list)  # one variable for each struct item
    _words: list[str] = field(default_factory=list)  # the targets that hold several signals
    _values: dict[str, str] = field(default_factory=dict)  # signal -> expression of its value

    @classmethod
    def of(
        cls,
        message: Message,
        signals: list[Signal],
        offset: int,
        defaults: Mapping[str, float] = MappingProxyType({}),
    ) -> "Layout":
        """Lay out ``signals`` of ``message``.

        Raises:
            DbcError: a signal is of an unsupported kind.
        """
        _require_supported(message.name, signals, offset * 8)
        layout = cls(offset, signals, defaults=defaults)
        position, index = offset * 8, 0  # first free bit, always a whole byte; next signal
        while index < len(signals):
            signal = signals[index]
            start = signal.start // 8 * 8
            layout._skip((start - position) // 8)
            code = "f" if signal.is_float else _STRUCT_CODES.get((signal.length, signal.is_signed))
            if code and signal.start == start:
                count, size = layout._add_item(signal, code), signal.length // 8
            else:
                count, size = layout._add_word(signals[index:], start)
            position, index = start + size * 8, index + count
        layout._skip(message.length - position // 8)
        return layout

    def _skip(self, size: int) -> None:
        self.format += f"{size}x" if size else ""

    def _add_item(self, signal: Signal, code: str) -> int:
        self.format += code
        self._packed.append(_raw_of(signal))
        self._targets.append(signal.name)
        self._values[signal.name] = _value_of(signal, signal.name)
        return 1

    def _add_word(self, signals: list[Signal], start: int) -> tuple[int, int]:
        """Add signals from bit ``start`` until one ends a byte; return their number and bytes."""
        word, parts, count, size = f"_word{len(self._words)}", [], 0, 0
        for count, signal in enumerate(signals, 1):
            shift, mask = signal.start - start, (1 << signal.length) - 1
            parts.append(f"({_raw_of(signal)} & {mask:#x}) << {shift}")
            raw = f"({word} >> {shift} & {mask:#x})"
            if signal.is_signed:
                sign = 1 << (signal.length - 1)
                raw = f"(({raw} ^ {sign:#x}) - {sign:#x})"
            self._values[signal.name] = _value_of(signal, raw)
            size = -(-(shift + signal.length) // 8)
            if count == len(signals) or signals[count].start >= start + size * 8:
                break
        self.format += f"{size}s"
        self._packed.append(f"({' | '.join(parts)}).to_bytes({size}, 'little')")
        self._targets.append(word)
        self._words.append(word)
        return count, size

    def source(self) -> str:
        """Python source of ``pack_into`` and ``unpack``.

        It needs ``_layout`` (the ``struct.Struct`` of ``format``), ``_record``, ``_new``
        (``tuple.__new__``) and ``_refuse`` (raises for the value that does not fit) in its scope.
        A record's fields never begin with an underscore, so no signal can hide one of these.
        """
        names = ", ".join(s.name for s in self.signals)
        given = ", ".join(
            f"{s.name}={self.defaults[s.name]!r}" if s.name in self.defaults else s.name
            for s in self.signals
        )
        # ``struct`` refuses what a whole item cannot hold; bits of a word would be cut off silently
        whole = set(self._targets)
        packed = _all(_check(s) for s in self.signals if s.name not in whole or not _is_full(s))
        unpacked = _all(_check(s) for s in self.signals if not _is_full(s))
        lines = [
            f"def pack_into(_buffer, {given}):",
            f"    if not ({packed}): _refuse({names})",
            "    try:",
            f"        _layout.pack_into(_buffer, {self.offset}, {', '.join(self._packed)})",
            f"    except Exception: _refuse({names})",
            "def unpack(_data):",
            f"    {', '.join(self._targets)}, = _layout.unpack_from(_data, {self.offset})",
            *(f"    {word} = int.from_bytes({word}, 'little')" for word in self._words),
            *(f"    {n} = {value}" for n, value in self._values.items() if n != value),
            f"    if {unpacked}: return _new(_record, ({names},))",
            "    return None",
        ]
        return "\n".join(lines)


def bounds(signal: Signal) -> tuple[float, float]:
    """The least and greatest value of a signal.

    Raises:
        DbcError: it has no range, or a float's bounds are not float32 numbers, so that a value
            inside them could be rounded to one outside.
    """
    low, high = signal.minimum, signal.maximum
    if low is None or high is None:
        raise DbcError(f"signal {signal.name} has no range in the DBC; give it [min|max]")
    if signal.is_float and struct.unpack("<2f", struct.pack("<2f", low, high)) != (low, high):
        raise DbcError(
            f"signal {signal.name}: {low!r}..{high!r} are not float32 numbers; round them"
        )
    return low, high


def known_values(signal: Signal) -> tuple[int, ...]:
    """Values of an enumeration that have a name, ascending; empty where any value may travel.

    An enumeration's range is wider than its value table, so that a new value changes no layout. A
    node that does not know one cannot act on it: it refuses the frame, unless the DBC's
    RfmsUnknownValue says that it shall be taken (a fault or parameter that only a later version
    knows).
    """
    attributes = signal.dbc.attributes if signal.dbc else {}
    if "RfmsUnknownValue" in attributes and attributes["RfmsUnknownValue"].value:
        return ()
    return tuple(sorted(signal.choices or ()))


def _all(checks: Iterable[str]) -> str:
    return " and ".join(checks) or "True"


def _check(signal: Signal) -> str:
    """Expression that a value is in its range and has a name; written so that a NaN fails it."""
    low, high = bounds(signal)
    values = known_values(signal)
    if values and values != tuple(range(values[0], values[-1] + 1)):
        return f"{signal.name} in {values!r}"
    if values:
        low, high = max(low, values[0]), min(high, values[-1])
    return f"{low!r} <= {signal.name} <= {high!r}"


def _is_full(signal: Signal) -> bool:
    """Whether every value that its bits can say is taken."""
    if signal.is_float or is_scaled(signal) or known_values(signal):
        return False
    least = -(1 << signal.length - 1) if signal.is_signed else 0
    return bool(bounds(signal) == (least, least + (1 << signal.length) - 1))


def is_scaled(signal: Signal) -> bool:
    """Whether physical and raw value differ."""
    return bool(signal.conversion.scale != 1 or signal.conversion.offset != 0)


def _require_supported(message: str, signals: list[Signal], free: int) -> None:
    """Refuse unsupported signals; ``free`` is the first bit after the header."""
    for signal in signals:
        name = f"{message}.{signal.name}"
        if signal.byte_order != "little_endian":
            raise DbcError(f"{name}: only little-endian signals are used")
        if signal.start < free:
            raise DbcError(f"{name}: bit {signal.start} is taken; signals must not overlap")
        if signal.is_float and (signal.length != 32 or signal.start % 8 or is_scaled(signal)):
            raise DbcError(f"{name}: floats must be 32 bits, begin a byte, have scale 1, offset 0")
        if not signal.is_float and not _holds_range(signal):
            raise DbcError(f"{name}: {signal.length} bits cannot hold its range; make it narrower")
        free = signal.start + signal.length


def _holds_range(signal: Signal) -> bool:
    """Whether the bits of an integer can represent every value of its range."""
    least = -(1 << signal.length - 1) if signal.is_signed else 0
    scale, offset = signal.conversion.scale, signal.conversion.offset
    low, high = (round((bound - offset) / scale) for bound in bounds(signal))
    return bool(least <= low <= high < least + (1 << signal.length))


def _raw_of(signal: Signal) -> str:
    """Expression of the raw value of a physical one; rounds as cantools does."""
    scale, offset = signal.conversion.scale, signal.conversion.offset
    if not is_scaled(signal):
        return str(signal.name)
    return f"round(({signal.name} - {offset!r}) / {scale!r})"


def _value_of(signal: Signal, raw: str) -> str:
    scale, offset = signal.conversion.scale, signal.conversion.offset
    return f"({raw} * {scale!r} + {offset!r})" if is_scaled(signal) else raw
