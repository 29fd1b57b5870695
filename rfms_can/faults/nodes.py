"""Faults of nodes, at a tap: hung, stuck, or with wrong values under a right CRC and counter."""

import math
from collections.abc import Callable, Iterable
from typing import Any, Final

from rfms_can.faults.context import Context
from rfms_can.faults.forge import COUNTER
from rfms_can.faults.frames import identifier
from rfms_can.faults.tap import Tamper, Tap
from rfms_can.plant.faulty_board import ENCODER_FLOOR
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Heartbeat, JointError, Setpoint

STEP_M: Final = 0.05
"""How far a wrong set-point is from the right one, m."""
NAN: Final = float("nan")
FAR_RAD: Final = 50.0
"""An error of no joint, rad: out of the range of ERROR."""
BABBLE: Final = {JointError: 10, Heartbeat: 20}
"""How many times as many frames a babbling node sends."""
ROWS_FACTOR: Final = 4.0
DRIFT_FRACTION: Final = 0.3
"""Speed with which a wrong set-point runs away, over the speed limit."""

Install = Callable[[Context, Tap], None]
Change = Callable[[Context, Frame], Frame]
Differs = Callable[[Context, Frame, Frame], bool]


def hangs(context: Context, tap: Tap) -> None:
    """The node hears, does and sends nothing any more; its board goes on."""
    before = tap.into

    def noted(frame: Frame) -> Iterable[Frame]:
        tap.into = before
        tap.hung = True
        context.touch()
        return ()

    tap.into = noted


def stops_at_its_deadline(context: Context, tap: Tap) -> None:
    """The same of a node that begins the cycle: from the SYNC on that it does not send."""
    context.touch(tap.node.next_deadline_ns())
    tap.hung = True


def falls_silent(context: Context, tap: Tap) -> None:
    """The node goes on, but nothing that it sends arrives."""

    def out(_: Frame) -> Iterable[Frame]:
        context.touch()
        return ()

    tap.out = out


def sends(
    record: type[Any], change: Change, count: int = 1 << 30, differs: Differs | None = None
) -> Install:
    """The node sends other values in a message.

    Args:
        record: of the message.
        change: what is made of a frame.
        count: how many frames are changed.
        differs: whether a change has an effect; any has if it is not given.
    """

    def install(context: Context, tap: Tap) -> None:
        tap.out = _changing(context, record, change, count, differs or _is_other)

    return install


def hears(record: type[Any], change: Change, count: int = 1 << 30) -> Install:
    """The node hears other values in a message: its sender has sent wrong ones to it alone."""

    def install(context: Context, tap: Tap) -> None:
        tap.into = _changing(context, record, change, count, _is_other)

    return install


def _is_other(_: Context, frame: Frame, changed: Frame) -> bool:
    """Whether a change matters: what has the right values by chance is no fault yet."""
    return changed.data != frame.data


def other_torque(context: Context, frame: Frame, changed: Frame) -> bool:
    """Whether a change of DAC matters: what friction could be as well is no fault yet."""
    before, after = context.forge.read(frame), context.forge.read(changed)
    difference: int = after.current_dac - before.current_dac
    return abs(difference) > context.torque_floor


def other_error(context: Context, frame: Frame, changed: Frame) -> bool:
    """Whether a change of ERROR matters: an encoder's counts hunt by as much."""
    before, after = context.forge.read(frame), context.forge.read(changed)
    counts = context.counts(after.error) - context.counts(before.error)
    return abs(counts) > ENCODER_FLOOR


def _changing(
    context: Context, record: type[Any], change: Change, count: int, differs: Differs
) -> Tamper:
    wanted, left = identifier(context, record), count

    def tamper(frame: Frame) -> Iterable[Frame]:
        nonlocal left
        if frame.id != wanted or left <= 0:
            return (frame,)
        left -= 1
        changed = change(context, frame)
        if differs(context, frame, changed):
            context.touch()
        return (changed,)

    return tamper


def same_frame(record: type[Any]) -> Install:
    """The node sends one and the same frame of a message again and again: its counter is stuck."""

    def install(context: Context, tap: Tap) -> None:
        first: list[Frame] = []

        def change(_: Context, frame: Frame) -> Frame:
            first.append(frame)
            return first[0]

        sends(record, change)(context, tap)

    return install


def same_values(
    record: type[Any], live: tuple[str, ...], differs: Differs | None = None
) -> Install:
    """The node sends the same values again and again, with a counter that counts.

    Args:
        record: of the message.
        live: signals that go on.
        differs: see ``sends``.
    """

    def install(context: Context, tap: Tap) -> None:
        kept: list[Any] = []

        def change(context: Context, frame: Frame) -> Frame:
            now = context.forge.read(frame)
            kept.append(now)
            return context.forge.changed(
                frame, **kept[0]._replace(**{name: getattr(now, name) for name in live})._asdict()
            )

        sends(record, change, differs=differs)(context, tap)

    return install


def number(signal: str, value: float) -> Change:
    """A signal has a number that the codec does not send."""
    return lambda context, frame: context.forge.patched(frame, signal, value)


def values(change: Callable[[Context, Any], dict[str, float]]) -> Change:
    """Signals have other values."""
    return lambda context, frame: context.forge.changed(
        frame, **change(context, context.forge.read(frame))
    )


def step_away(context: Context, setpoint: Setpoint) -> dict[str, float]:
    """The pose is elsewhere."""
    return {"p_z": setpoint.p_z - STEP_M}


def scaled_rows(_: Context, rows: Any) -> dict[str, float]:
    """The rows of the law are too large by a factor."""
    return {f"law_{n}": ROWS_FACTOR * rows[n - 1] for n in range(1, 7)}


def heavy(context: Context, rows: Any) -> dict[str, float]:
    """Gravity is wrong by half the torque of the drive."""
    return {"gravity": rows.gravity + 0.5 * context.arm.drives[context.index].torque_limit}


def other_hash(_: Context, values: Any) -> dict[str, float]:
    """The sender was made for another DBC."""
    return {"dbc_hash": values.dbc_hash ^ 0x0F00}


def runs_on(context: Context, tap: Tap) -> None:
    """The set-point turns about the base for ever: joint 1 is commanded to its end and beyond."""
    turned = 0.0
    wanted = identifier(context, Setpoint)

    def out(frame: Frame) -> Iterable[Frame]:
        nonlocal turned
        if frame.id != wanted:
            return (frame,)
        turned += DRIFT_FRACTION * context.speed_limit * context.period_s
        return (context.forge.changed(frame, **_turned(context.forge.read(frame), turned)),)

    tap.out = out


def _turned(setpoint: Setpoint, angle: float) -> dict[str, float]:
    """The pose turned about the z axis of the base."""
    cos, sin = math.cos(angle), math.sin(angle)
    turned: dict[str, float] = {}
    for letter in "oap":
        x, y = getattr(setpoint, f"{letter}_x"), getattr(setpoint, f"{letter}_y")
        turned[f"{letter}_x"] = cos * x - sin * y
        turned[f"{letter}_y"] = sin * x + cos * y
    return turned


def babbles(record: type[Any], trigger: type[Any]) -> Install:
    """The node sends a message many times as often, each frame with a counter of its own.

    Args:
        record: of the message.
        trigger: with each frame of it that the node sends the others go out.
    """

    def install(context: Context, tap: Tap) -> None:
        wanted = context.wire.id(record, context.node)
        with_it = context.wire.id(trigger, context.node)
        last: Frame | None = None
        counter = 0

        def out(frame: Frame) -> Iterable[Frame]:
            nonlocal last, counter
            if frame.id == wanted:
                counter = frame.data[COUNTER] if last is None else counter + 1
                last = frame
                frame = context.forge.counted(frame, counter & 0xFF)
            yield frame
            if frame.id == with_it and last is not None:
                for _ in range(BABBLE[record] - 1):
                    context.touch()
                    counter += 1
                    yield context.forge.counted(last, counter & 0xFF)

        tap.out = out

    return install
