"""List every frame and signal of the wire contract in docs/wire.md, a kind of message at a time."""

from typing import Any

from generated import main, table
from make_dbc import E2E, Message, Signal, Template

from rfms_can.bus.timing import BusTiming
from rfms_can.wire.configuration import PARAMETERS

TEMPLATE = Template()
TIMING = BusTiming()
GENERAL = {"n": "n", "node": "node n", "i": "i"}
"""What stands for a number, or for the node with that number, on the page."""


def signal_row(signal: Signal, block: dict[str, Any]) -> tuple[str, ...]:
    """Name, first bit, type, range and meaning of a signal."""
    kind = "float" if signal.kind == "f" else signal.kind
    unit = f" {signal.unit}" if signal.unit else ""
    steps = "" if signal.scale == 1 else f" in steps of {signal.scale:g}"
    texts = [entry["comment"] for entry in block["signals"] if _is_of(entry, signal)]
    meaning = texts[0].format(**{**GENERAL, "i": _digit(signal)})
    if signal.values:
        values = TEMPLATE.enumerations[signal.values]["values"].items()
        meaning += " " + ", ".join(f"{value} {name}" for name, value in values)
    low, high = signal.bounds
    span = f"{low} ... {high}{unit}{steps}"
    return (signal.name, str(signal.start), f"{kind}{signal.length}", span, meaning)


def _digit(signal: Signal) -> str:
    return signal.name.rpartition("_")[2]


def _is_of(entry: dict[str, Any], signal: Signal) -> bool:
    """Whether a signal is the one of an entry, or one of several it stands for."""
    return str(entry["name"].format(**{**GENERAL, "i": _digit(signal)})) == signal.name


def people(who: str | list[str]) -> str:
    """Nodes in words."""
    words = [who] if isinstance(who, str) else who
    names = (word.format(**GENERAL).replace("_n", " n").replace("_", " ") for word in words)
    return ", ".join(name.lower() for name in names)


def comment_of(block: dict[str, Any]) -> str:
    """What a kind of message is."""
    comment = block["comment"]
    text = comment if isinstance(comment, str) else " ".join(comment.values())
    general: str = text.format(**GENERAL)
    return general[0].upper() + general[1:]


def period_of(block: dict[str, Any]) -> str:
    """How often it is sent."""
    every = block.get("every", 0)
    return {0: "event", 1: "cycle"}.get(every, f"{every} cycles")


def frame_row(block: dict[str, Any], messages: list[Message]) -> tuple[str, ...]:
    """One line of the table of frames."""
    first, last = messages[0], messages[-1]
    name, ids = first.name, f"0x{first.id:03X}"
    if first is not last:
        name, ids = f"{name}..{block['each'][-1]}", f"{ids}..0x{last.id:03X}"
    link = heading(block).lower()
    microseconds = f"{TIMING.worst_case_ns(first.length) * 1e-3:.1f}"
    return (
        ids, f"[{name}](#{link})", str(first.length), period_of(block),
        people(block["senders"]), people(block["receivers"]), microseconds, comment_of(block),
    )  # fmt: skip


def heading(block: dict[str, Any]) -> str:
    """The name of a kind."""
    name: str = block["name"].format(**GENERAL)
    return name


def render() -> str:
    """The table of frames, and for each kind of frame the table of its signals."""
    kinds = [(block, TEMPLATE.expand(block)) for block in TEMPLATE.text["messages"]]
    frames = table(
        ("id", "frame", "bytes", "every", "from", "to", "µs", "what"),
        [frame_row(block, messages) for block, messages in kinds],
    )
    parts = ["## Frames", frames, "## Signals"]
    for block, messages in kinds:
        header = {name for name, *_ in E2E}
        signals = [s for s in messages[0].signals if s.name not in header]
        unprotected = "" if messages[0].protected else " No CRC, no counter."
        rows = [signal_row(signal, block) for signal in signals]
        parts += [
            f"### {heading(block)}",
            comment_of(block) + unprotected,
            table(("signal", "bit", "type", "range", "meaning"), rows),
        ]
    parts += ["## Parameters", parameters()]
    return "\n\n".join(parts)


def parameters() -> str:
    """The table of CONFIG's parameters."""
    rows = []
    for parameter, known in sorted(PARAMETERS.items()):
        size = "magnitude " if known.signed else ""
        whole = ", whole" if known.whole else ""
        unit = known.unit.replace("u", "rad or m", 1) if known.unit in ("u", "1/u") else known.unit
        marks = ["gripper"] * known.gripper
        marks += [] if known.default is None else [f"default {known.default:g}"]
        span = f"{size}{known.low:.9g} ... {known.high:.9g}{whole}"
        rows.append((str(int(parameter)), parameter.name, unit, span, ", ".join(marks)))
    return table(("number", "parameter", "unit", "range", ""), rows)


if __name__ == "__main__":
    main("draw_wire.py", "wire.md", render)
