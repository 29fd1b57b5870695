"""List every frame and signal of dbc/rfms.dbc in docs/wire.md, messages of one kind together."""

import re
from dataclasses import dataclass

from cantools.database.can import Message, Signal
from generated import main, table

from rfms_can.bus.timing import BusTiming
from rfms_can.wire.codec import load_database

NODES = (*(f"JOINT_{n}" for n in range(1, 7)), "GRIPPER", "MASTER", "PLANT")
"""By their numbers, from 1."""
HEADER = ("e2e_crc", "e2e_counter")
TIMING = BusTiming()


@dataclass(frozen=True)
class Kind:
    """What the messages of one kind share, with their own number written as n."""

    length: int
    every: str
    protected: bool
    comment: str
    signals: tuple[tuple[str, ...], ...]


def number(message: Message) -> int | None:
    """The node a message is of, if it is one of several."""
    digits = re.search(r"_(\d+)$", message.name)
    return int(digits[1]) if digits else None


def general(text: str | None, n: int | None) -> str:
    """A comment with the number of its message, or the name of its node, replaced by n."""
    text = text or ""
    if n is None:
        return text
    text = re.sub(rf"^{NODES[n - 1]}", "Node n", text).replace(NODES[n - 1], "node n")
    text = re.sub(rf"\b(joint|Row) {n}\b", r"\1 n", text)
    return text.replace(f"({n},", "(n,")


def attribute(message: Message, name: str) -> str:
    """A DBC attribute of a message; empty if it has none."""
    attributes = message.dbc.attributes if message.dbc else {}
    return str(attributes[name].value) if name in attributes else ""


def bound(value: float | None) -> str:
    """A bound, whole numbers with all their digits."""
    return "" if value is None else str(int(value)) if value == int(value) else f"{value:g}"


def signal_row(signal: Signal, n: int | None) -> tuple[str, ...]:
    """Name, first bit, type, range and meaning of a signal."""
    kind = "float" if signal.is_float else "i" if signal.is_signed else "u"
    unit = f" {signal.unit}" if signal.unit else ""
    steps = "" if signal.scale == 1 else f" in steps of {signal.scale:g}"
    meaning = general(signal.comment, n)
    if signal.choices:
        names = ", ".join(f"{value} {name}" for value, name in signal.choices.items())
        meaning = f"{meaning} {names}"
    span = f"{bound(signal.minimum)} ... {bound(signal.maximum)}{unit}{steps}"
    return (signal.name, str(signal.start), f"{kind}{signal.length}", span, meaning)


def kind_of(message: Message) -> Kind:
    """What a message is, its number apart."""
    n = number(message)
    every = attribute(message, "RfmsEvery")
    return Kind(
        message.length,
        {"": "event", "0": "event", "1": "cycle"}.get(every, f"{every} cycles"),
        attribute(message, "RfmsE2EDataId") != "",
        general(message.comment, n),
        tuple(signal_row(signal, n) for signal in message.signals if signal.name not in HEADER),
    )


def node_list(nodes: set[str], n: int | None) -> str:
    """Nodes in words; the one the message is of as ``node n``."""
    own = NODES[n - 1] if n is not None else ""
    if len(nodes) >= len(NODES) - 1:
        return "all"
    others = nodes - {own}
    joints = {name for name in others if name.startswith("JOINT_")}
    words = ["node n"] if own in nodes and not joints else []
    words += ["joints"] if joints else []
    return ", ".join(words + [name.lower() for name in NODES if name in others - joints])


def heading(messages: list[Message]) -> str:
    """The name of a kind."""
    name = messages[0].name
    return name if len(messages) == 1 else re.sub(r"\d+$", "n", name)


def frame_row(kind: Kind, messages: list[Message]) -> tuple[str, ...]:
    """One line of the table of frames."""
    first, last = messages[0], messages[-1]
    n = number(first) if first is not last else None
    name, ids = first.name, f"0x{first.frame_id:03X}"
    if first is not last:
        name, ids = f"{name}..{number(last)}", f"{ids}..0x{last.frame_id:03X}"
    microseconds = f"{TIMING.worst_case_ns(kind.length) * 1e-3:.1f}"
    return (
        ids, f"[{name}](#{heading(messages).lower()})", str(kind.length), kind.every,
        node_list(set(first.senders), n), node_list(first.receivers, n), microseconds, kind.comment,
    )  # fmt: skip


def render() -> str:
    """The table of frames, and for each kind of frame the table of its signals."""
    kinds: dict[Kind, list[Message]] = {}
    for message in sorted(load_database().messages, key=lambda m: m.frame_id):
        kinds.setdefault(kind_of(message), []).append(message)
    frames = table(
        ("id", "frame", "bytes", "every", "from", "to", "µs", "what"),
        [frame_row(kind, messages) for kind, messages in kinds.items()],
    )
    parts = ["## Frames", frames, "## Signals"]
    known: dict[tuple[tuple[str, ...], ...], str] = {}
    for kind, messages in kinds.items():
        name = heading(messages)
        same = known.setdefault(kind.signals, name)
        signals = table(("signal", "bit", "type", "range", "meaning"), list(kind.signals))
        header = "" if kind.protected else " No CRC, no counter."
        as_before = f"Signals as in [{same}](#{same.lower()})."
        parts += [f"### {name}", kind.comment + header, signals if same == name else as_before]
    return "\n\n".join(parts)


if __name__ == "__main__":
    main("draw_wire.py", "wire.md", render)
