#!/usr/bin/env python3
"""Make dbc/rfms.dbc, and its C header, from tools/dbc_template.toml: each block stands there once.

``dbc/rfms_wire.h`` has what the DBC says in attributes, which generators of C code drop: data IDs,
periods, the hash of the layout, the rule of the counters.
"""

import argparse
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cantools
from cantools.database.can import Database

from rfms_can.wire.codec import database_hash, layout_hash
from rfms_can.wire.frame import FD_LENGTHS

ROOT = Path(__file__).resolve().parents[1]
TEMPLATE = Path(__file__).with_name("dbc_template.toml")
DBC = ROOT / "dbc" / "rfms.dbc"
HEADER = ROOT / "dbc" / "rfms_wire.h"

PERIOD_MS: Final = 4
"""Control period that GenMsgCycleTime is written for."""
DATA_ID_BASE: Final = 0x5200

ALLOWED: Final = ("NS_DESC_", "CM_", "BA_DEF_", "BA_", "VAL_", "BA_DEF_DEF_", "BO_TX_BU_")
DEFINITIONS: Final = """\
BA_DEF_ "BusType" STRING ;
BA_DEF_ "RfmsCounterWindow" INT 1 255;
BA_DEF_ "RfmsCounterRestart" INT 1 255;
BA_DEF_ "RfmsDbcHash" INT 0 65535;
BA_DEF_ BO_ "VFrameFormat" ENUM {formats};
BA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";
BA_DEF_ BO_ "GenMsgSendType" ENUM "cyclic","event";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_ "RfmsEvery" INT 0 65535;
BA_DEF_ BO_ "RfmsE2EProfile" ENUM "None","Profile5";
BA_DEF_ BO_ "RfmsE2EDataId" INT 0 65535;
BA_DEF_ BO_ "RfmsClassicToo" INT 0 1;
BA_DEF_ BO_ "RfmsResponseTime" INT 0 1000000;
BA_DEF_ SG_ "GenSigStartValue" FLOAT 0 4294967295;
BA_DEF_ SG_ "RfmsUnknownValue" ENUM "refuse","take";
BA_DEF_DEF_ "BusType" "CAN FD";
BA_DEF_DEF_ "RfmsCounterWindow" {window};
BA_DEF_DEF_ "RfmsCounterRestart" {restart};
BA_DEF_DEF_ "RfmsDbcHash" 0;
BA_DEF_DEF_ "VFrameFormat" "StandardCAN_FD";
BA_DEF_DEF_ "CANFD_BRS" "1";
BA_DEF_DEF_ "GenMsgSendType" "event";
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "RfmsEvery" 0;
BA_DEF_DEF_ "RfmsE2EProfile" "Profile5";
BA_DEF_DEF_ "RfmsE2EDataId" 0;
BA_DEF_DEF_ "RfmsClassicToo" 0;
BA_DEF_DEF_ "RfmsResponseTime" 0;
BA_DEF_DEF_ "GenSigStartValue" 0;
BA_DEF_DEF_ "RfmsUnknownValue" "refuse";
"""
E2E: Final = (
    (
        "e2e_crc",
        "u16",
        "CRC-16 of AUTOSAR E2E profile 5 over the rest of the frame and the data ID.",
    ),
    ("e2e_counter", "u8", "Counts the frames of this ID; restarts at 0 when the arm is enabled."),
)


@dataclass(frozen=True)
class Signal:
    """One signal, in its place."""

    name: str
    start: int
    length: int
    kind: str
    bounds: tuple[int | float, int | float]
    scale: int | float
    unit: str
    comment: str
    first: int
    values: str


@dataclass(frozen=True)
class Message:
    """One message, its number put in."""

    name: str
    id: int
    length: int
    every: int
    event: bool
    protected: bool
    classic: bool
    response_time: int
    senders: tuple[str, ...]
    receivers: tuple[str, ...]
    comment: str
    signals: tuple[Signal, ...]


class Template:
    """The template as it is written, and the messages it stands for."""

    def __init__(self, path: Path = TEMPLATE) -> None:
        self.text: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        self.nodes: dict[str, int] = self.text["nodes"]
        self.enumerations: dict[str, dict[str, Any]] = self.text["enumerations"]
        self._names = {number: name for name, number in self.nodes.items()}
        self.messages = sorted(
            (m for block in self.text["messages"] for m in self.expand(block)), key=lambda m: m.id
        )

    def expand(self, block: dict[str, Any]) -> list[Message]:
        """The messages that a block stands for, by their numbers."""
        return list(self._expand(block))

    def _expand(self, block: dict[str, Any]) -> Iterator[Message]:
        for number in block.get("each", [0]):
            words = {"n": number, "node": self._names.get(number, "")}
            comment = block["comment"]
            event = block.get("event", False)
            every = block.get("every", 0)
            senders = self._people(block["senders"], words)
            name = block["name"].format(**words)
            signals = tuple(self._signals(block, words))
            _require_room(name, block["length"], signals)
            yield Message(
                name=name,
                id=block["id"] + number,
                length=block["length"],
                every=every,
                event=not every or (number in event if isinstance(event, list) else event),
                protected=block.get("protected", True),
                classic=block.get("classic", False),
                response_time=block.get("response_time", 0),
                senders=senders,
                receivers=tuple(
                    name
                    for name in self._people(block["receivers"], words)
                    if len(senders) > 1 or name not in senders
                ),
                comment=(comment if isinstance(comment, str) else comment[str(number)]).format(
                    **words
                ),
                signals=signals,
            )

    def _people(self, who: str | list[str], words: dict[str, Any]) -> tuple[str, ...]:
        """Names of nodes, groups written out; each once."""
        found: list[str] = []
        for word in [who] if isinstance(who, str) else who:
            name = word.format(**words)
            found += self.text["groups"].get(name, [name])
        return tuple(dict.fromkeys(found))

    def _signals(self, block: dict[str, Any], words: dict[str, Any]) -> Iterator[Signal]:
        bit = 0
        header = [dict(zip(("name", "type", "comment"), part, strict=True)) for part in E2E]
        for entry in [*(header if block.get("protected", True) else []), *block["signals"]]:
            for i in range(1, entry.get("repeat", 1) + 1):
                signal = self._signal(entry, bit, {**words, "i": i})
                yield signal
                bit += signal.length

    def _signal(self, entry: dict[str, Any], bit: int, words: dict[str, Any]) -> Signal:
        kind, length = entry["type"][0], int(entry["type"][1:])
        scale = entry.get("scale", 1)
        whole = {"u": (0, 2**length - 1), "i": (-(2 ** (length - 1)), 2 ** (length - 1) - 1)}
        reserved = self.enumerations.get(entry.get("values", ""), {}).get("range")
        low, high = entry.get("range") or reserved or whole[kind]
        return Signal(
            name=entry["name"].format(**words),
            start=bit,
            length=length,
            kind=kind,
            bounds=(low, high),
            scale=scale,
            unit=entry.get("unit", ""),
            comment=entry["comment"].format(**words),
            first=entry.get("start", low if low == high else 0),
            values=entry.get("values", ""),
        )


def _require_room(name: str, length: int, signals: Sequence[Signal]) -> None:
    """Signals end inside the message.

    Raises:
        SystemExit: they do not; names the length that does.
    """
    needed = signals[-1].start + signals[-1].length
    if needed > 8 * length:
        enough = next((size for size in sorted(FD_LENGTHS) if 8 * size >= needed), None)
        way_out = f"give it length = {enough}" if enough else "no CAN FD frame is as long"
        sys.exit(
            f"{name}: its signals need {needed} bits, {length} bytes hold {8 * length}: {way_out}"
        )


def lines_of(message: Message) -> Iterator[str]:
    """BO_ and its SG_ lines."""
    yield f"BO_ {message.id} {message.name}: {message.length} {message.senders[0]}"
    receivers = ",".join(message.receivers)
    for s in message.signals:
        sign = "+" if s.kind == "u" else "-"
        low, high = s.bounds
        yield (
            f' SG_ {s.name} : {s.start}|{s.length}@1{sign} ({s.scale},0) [{low}|{high}] "{s.unit}" '
            f"{receivers}"
        )
    yield ""


def attributes_of(message: Message) -> Iterator[str]:
    """All attributes, also those that are the default: a reader need not know it."""
    values: list[tuple[str, int]] = [
        ("VFrameFormat", 14),
        ("CANFD_BRS", 1),
        ("GenMsgSendType", int(message.event)),
        ("GenMsgCycleTime", PERIOD_MS * message.every),
        ("RfmsEvery", message.every),
        ("RfmsE2EProfile", int(message.protected)),
    ]
    if message.protected:
        values.append(("RfmsE2EDataId", DATA_ID_BASE + message.id))
    if message.classic:
        values.append(("RfmsClassicToo", 1))
    if message.response_time:
        values.append(("RfmsResponseTime", message.response_time))
    for name, value in values:
        yield f'BA_ "{name}" BO_ {message.id} {value};'


def signal_attributes(template: Template) -> Iterator[str]:
    """Start values other than 0, and what happens to values without a name."""
    for message in template.messages:
        for s in message.signals:
            if s.first:
                yield f'BA_ "GenSigStartValue" SG_ {message.id} {s.name} {s.first};'
            if template.enumerations.get(s.values, {}).get("unknown") == "take":
                yield f'BA_ "RfmsUnknownValue" SG_ {message.id} {s.name} 1;'


def dbc(template: Template) -> str:
    """The whole text, the hash of its layout in it."""
    database = cantools.database.load_string(_dbc(template, 0), "dbc", strict=True)
    assert isinstance(database, Database)
    return _dbc(template, layout_hash(database))


def _dbc(template: Template, its_hash: int) -> str:
    messages, text = template.messages, template.text
    window, restart = text["counter_window"], text["counter_restart"]
    formats = ["StandardCAN", "ExtendedCAN", *["reserved"] * 12, "StandardCAN_FD", "ExtendedCAN_FD"]
    definitions = DEFINITIONS.format(
        formats=",".join(f'"{name}"' for name in formats), window=window, restart=restart
    )
    parts: list[Iterable[str]] = [
        [f'VERSION "{text["version"]}"', "", "NS_ :", *(f"\t{word}" for word in ALLOWED)],
        ["\tSIG_VALTYPE_", "", "BS_:", "", f"BU_: {' '.join(template.nodes)}", ""],
        *(lines_of(message) for message in messages),
        (f"BO_TX_BU_ {m.id} : {','.join(m.senders)};" for m in messages if len(m.senders) > 1),
        ["", f'CM_ "{text["comment"]}";'],
        *(comments_of(message) for message in messages),
        ["", definitions.rstrip()],
        [
            'BA_ "BusType" "CAN FD";',
            f'BA_ "RfmsCounterWindow" {window};',
            f'BA_ "RfmsCounterRestart" {restart};',
            f'BA_ "RfmsDbcHash" {its_hash};',
        ],
        *(attributes_of(message) for message in messages),
        signal_attributes(template),
        [""],
        *(tables_of(message, template) for message in messages),
        [""],
        (
            f"SIG_VALTYPE_ {m.id} {s.name} : 1;"
            for m in messages
            for s in m.signals
            if s.kind == "f"
        ),
    ]
    return "\n".join(line for part in parts for line in part) + "\n"


def comments_of(message: Message) -> Iterator[str]:
    """CM_ of a message and its signals."""
    yield f'CM_ BO_ {message.id} "{message.comment}";'
    for s in message.signals:
        yield f'CM_ SG_ {message.id} {s.name} "{s.comment}";'


def tables_of(message: Message, template: Template) -> Iterator[str]:
    """VAL_ of its enumerations."""
    for s in message.signals:
        if s.values:
            values = template.enumerations[s.values]["values"].items()
            names = " ".join(f'{value} "{name}"' for name, value in values)
            yield f"VAL_ {message.id} {s.name} {names} ;"


def header(template: Template) -> str:
    """What a node in C needs and generated code does not have."""
    lines = [
        "/* Made by tools/make_dbc.py from tools/dbc_template.toml: do not edit. */",
        "#ifndef RFMS_WIRE_H",
        "#define RFMS_WIRE_H",
        "",
        "/* Hash of the layout, as SYNC and HEARTBEAT carry it. */",
        f"#define RFMS_DBC_HASH (0x{database_hash(DBC):04x}u)",
        "",
        "/* Counters: steps of 1 to RFMS_COUNTER_WINDOW are taken, and the RFMS_COUNTER_RESTART-th",
        "   frame in a row that lies elsewhere, if these count on among themselves. */",
        f"#define RFMS_COUNTER_WINDOW ({template.text['counter_window']}u)",
        f"#define RFMS_COUNTER_RESTART ({template.text['counter_restart']}u)",
        "",
        "/* End-to-end protection, AUTOSAR profile 5: CRC-16 0x1021 from 0xffff over bytes 2 and",
        "   on, then the data ID, low byte first; bytes 0 and 1 hold it, low byte first, byte 2 is",
        "   the counter. */",
        f"#define RFMS_DATA_ID_BASE (0x{DATA_ID_BASE:04x}u) /* data ID = base + identifier */",
    ]
    for message in template.messages:
        if message.protected:
            data_id = DATA_ID_BASE + message.id
            lines.append(f"#define RFMS_{message.name}_DATA_ID (0x{data_id:04x}u)")
    lines += ["", "/* Sent every so many control cycles; 0 on event. */"]
    lines += [f"#define RFMS_{m.name}_EVERY ({m.every}u)" for m in template.messages]
    lines += [
        "",
        "/* Longest time a node may take to answer, microseconds; see the DBC's comments. */",
    ]
    lines += [
        f"#define RFMS_{m.name}_RESPONSE_US ({m.response_time}u)"
        for m in template.messages
        if m.response_time
    ]
    return "\n".join([*lines, "", "#endif", ""])


def main() -> None:
    """Write both files, or with ``--check`` exit 1 if one is not what the template makes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if one is old")
    check: bool = parser.parse_args().check
    template = Template()
    for path, render in ((DBC, dbc), (HEADER, header)):
        text = render(template)
        if check and (not path.exists() or path.read_text(encoding="ascii") != text):
            sys.exit(f"{path.relative_to(ROOT)} is not up to date: run python tools/make_dbc.py")
        if not check:
            path.write_text(text, encoding="ascii")


if __name__ == "__main__":
    main()
