"""The life of joint 3 as frames: a run from power on to STOP, and what stops it besides."""

from collections.abc import Callable
from functools import cache
from typing import Final

from node_book.printed import candump, in_words
from node_book.pump import JOINT, Passed, Pump
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import JOINTS, MASTER
from rfms_can.wire.records import (
    Config,
    ConfigAck,
    Dac,
    Emcy,
    Estop,
    Heartbeat,
    JointError,
    Measure,
    Nmt,
    Reference,
    Rows,
    Setpoint,
    Sync,
)
from rfms_can.wire.vocabulary import Command, NodeState

DATA_WIDTH: Final = 12
"""Bytes of a payload that are printed; longer ones are cut."""
WIDTH: Final = 3 * DATA_WIDTH + 13
Timed = tuple[int, Frame]


@cache
def run() -> tuple[Timed, ...]:
    """What concerns joint 3 in a run of a program that does nothing: times (ns) and frames."""
    wire = Wire()
    own = (Emcy, Measure, Reference, JointError, Dac, Rows, Config, ConfigAck, Heartbeat)
    wanted = {
        *(wire.id(record, JOINT) for record in own),
        *(wire.id(record) for record in (Nmt, Sync)),
        *(wire.id(Setpoint, 1), wire.id(Heartbeat, MASTER)),
        *(wire.id(JointError, joint) for joint in JOINTS),
    }
    found: list[Timed] = []

    def look(time_ns: int, frame: Frame) -> None:
        if frame.id in wanted:
            found.append((time_ns, frame))

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rig.observe(look)

    execute(lambda _: None, RunSettings(), watch=watch)
    return tuple(found)


def line(wire: Wire, frame: Frame, time_ns: int | None = None) -> str:
    """A frame as candump prints it, and what it says."""
    whole = candump(frame)
    if len(frame.data) > DATA_WIDTH:
        cut = Frame(frame.id, frame.data[:DATA_WIDTH], frame.fd)
        whole = candump(cut).replace(f"[{DATA_WIDTH:02d}]", f"[{len(frame.data):02d}]") + " ..."
    before = "" if time_ns is None else f"({time_ns * 1e-6:9.3f})  "
    return f"{before}{whole:<{WIDTH + 6}}{in_words(wire, frame)}"


class Excerpt:
    """Picks frames of a run.

    Attributes:
        lines: the printed lines.
    """

    def __init__(self, frames: tuple[Timed, ...]) -> None:
        self._wire = Wire()
        self._frames = frames
        self._at = 0
        self.lines: list[str] = []

    def _values(self, frame: Frame) -> object:
        codec = next(c for c in self._wire.codecs.values() if c.id == frame.id)
        return codec.unpack(frame.data)

    def skip_to(self, record: type, test: Callable[[object], bool] = lambda _: True) -> None:
        """Go on with the next frame of a kind, another left out behind an ellipsis."""
        while True:
            values = self._values(self._frames[self._at][1])
            if isinstance(values, record) and test(values):
                break
            self._at += 1
        if self.lines:
            self.lines.append("...")

    def take_until(self, record: type, count: int = 1) -> None:
        """Print frames up to the ``count``-th of a kind, and that one."""
        while count:
            time_ns, frame = self._frames[self._at]
            self.lines.append(line(self._wire, frame, time_ns))
            self._at += 1
            count -= isinstance(self._values(frame), record)

    def take_before(self, record: type) -> None:
        """Print frames up to the next of a kind, without it."""
        while not isinstance(self._values(self._frames[self._at][1]), record):
            time_ns, frame = self._frames[self._at]
            self.lines.append(line(self._wire, frame, time_ns))
            self._at += 1


def _block(lines: list[str]) -> str:
    return "\n".join(["```", *lines, "```"])


def bring_up() -> str:
    """Power on, roll call, configuration."""
    excerpt = Excerpt(run())
    excerpt.take_until(ConfigAck, 2)
    excerpt.skip_to(Config, lambda c: c.parameter == 255)  # type: ignore[attr-defined]
    excerpt.take_until(ConfigAck)
    return _block(excerpt.lines)


def homing() -> str:
    """HOME: the first two cycles, and the one after which the joint says READY."""
    excerpt = Excerpt(run())
    excerpt.skip_to(Nmt, lambda n: n.command == Command.HOME)  # type: ignore[attr-defined]
    excerpt.take_until(Dac, 2)
    excerpt.skip_to(Sync, _has_beat_of(NodeState.READY))
    excerpt.take_until(Heartbeat)
    return _block(excerpt.lines)


def _has_beat_of(state: NodeState) -> Callable[[object], bool]:
    """Whether a SYNC is the one with which the joint first tells a state."""
    wire = Wire()
    beat, sync = wire.codec(Heartbeat, JOINT), wire.codec(Sync)
    cycle = -1
    for _, frame in run():
        if frame.id == sync.id:
            values = sync.unpack(frame.data)
            assert values is not None
            cycle = values.cycle
        if frame.id == beat.id:
            told = beat.unpack(frame.data)
            assert told is not None
            if told.state == state:
                break
    return lambda values: isinstance(values, Sync) and values.cycle == cycle


def operation() -> str:
    """START, a cycle, STOP."""
    excerpt = Excerpt(run())
    excerpt.skip_to(Nmt, lambda n: n.command == Command.START)  # type: ignore[attr-defined]
    excerpt.take_until(Sync)
    excerpt.take_before(Sync)  # the program ends at once: STOP is the last of them
    excerpt.take_until(Measure)
    return _block(excerpt.lines)


# --- what a run does not show -------------------------------------------------------------------


def _printed(pump: Pump, since: int) -> list[str]:
    return [_passed(pump.wire, one) for one in pump.passed[since:]]


def _passed(wire: Wire, one: Passed) -> str:
    return f"{'node ->' if one.from_node else '-> node'}  {line(wire, one.frame)}"


def quickstop() -> str:
    """QUICKSTOP in motion, a cycle of the stop, RESET."""
    pump = Pump().enabled()
    since = len(pump.passed)
    pump.command(Command.QUICKSTOP)
    pump.sync(NodeState.QUICKSTOP)
    pump.measure()
    pump.command(Command.RESET)
    pump.command(Command.ANNOUNCE)
    return _block(_printed(pump, since))


def emergency_stop() -> str:
    """ESTOP in motion."""
    pump = Pump().enabled()
    since = len(pump.passed)
    pump.say(Estop, None, *ESTOP_VALUES)
    pump.sync(NodeState.QUICKSTOP)
    pump.measure()
    pump.command(Command.ANNOUNCE)
    return _block(_printed(pump, since))


def no_sync() -> str:
    """SYNC stays out."""
    pump = Pump().enabled()
    since = len(pump.passed)
    for _ in range(25):
        pump.miss_sync()
        pump.measure()
    shown = [
        _passed(pump.wire, one)
        for one in pump.passed[since:]
        if one.frame.id == pump.wire.id(Emcy, JOINT)
    ]
    last = _passed(pump.wire, pump.passed[-2])
    return _block([*shown, last])
