"""A candump log (``candump -L`` form): what canplayer, python-can and cantools read."""

from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Sync
from rfms_can.wire.vocabulary import NodeState

_FLAGS_BRS = "1"


def log_line(time_ns: int, channel: str, frame: Frame) -> str:
    """One line, newline included; CAN FD frames carry the bit-rate-switch flag."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    mark = "##" + _FLAGS_BRS if frame.fd else "#"
    data = frame.data.hex().upper()
    return f"({seconds}.{rest // 1000:06d}) {channel} {frame.id:03X}{mark}{data}\n"


class CandumpWriter:
    """Writes frames to a log; losing the disk loses the log and nothing else.

    Args:
        path: file to write.
        channel: interface name in the log.
        origin_ns: added to every time.

    Attributes:
        lost: whether writing failed and the rest of the log is missing.
    """

    def __init__(self, path: Path, channel: str, origin_ns: int = 0) -> None:
        self._file: TextIO | None = path.open("w", encoding="ascii", buffering=1 << 20)
        self._channel = channel
        self._origin_ns = origin_ns
        self.lost = False

    def write(self, time_ns: int, frame: Frame) -> None:
        """Append a frame."""
        if self._file is None:
            return
        try:
            self._file.write(log_line(self._origin_ns + time_ns, self._channel, frame))
        except OSError:
            self._file, self.lost = None, True

    def close(self) -> None:
        """Finish the file."""
        if self._file is None:
            return
        try:
            self._file.close()
        except OSError:
            self.lost = True
        self._file = None


def read_candump(path: Path) -> list[tuple[float, Frame]]:
    """Times (s) and frames of a candump log; a last line that was cut off is left out.

    Raises:
        ValueError: a line is not in candump format.
    """
    frames = []
    text = path.read_text(encoding="ascii")
    whole = text[: text.rfind("\n") + 1]
    for number, line in enumerate(whole.splitlines(), 1):
        try:
            stamp, _, sent, *_ = line.split()
            identifier, _, rest = sent.partition("#")
            fd = rest.startswith("#")
            data = bytes.fromhex(rest[2:] if fd else rest)
            frames.append((float(stamp.strip("()")), Frame(int(identifier, 16), data, fd)))
        except ValueError as error:
            raise ValueError(f"{path}, line {number}: not a candump line: {line[:60]!r}") from error
    return frames


Cycle = tuple[tuple[int, bytes], ...]
"""Identifiers and payloads of one control cycle, sorted: the order on the bus may differ."""


def cycles_from_enable(frames: Iterable[Frame], wire: Wire) -> list[Cycle]:
    """Control cycles from enable to disable, for the comparison of two runs."""
    sync = wire.receiver(Sync)
    sync_id = wire.id(Sync)
    cycles: list[Cycle] = []
    current: list[tuple[int, bytes]] | None = None
    for frame in frames:
        if frame.id == sync_id:
            values = sync.decoder.decode(frame)
            if current is not None:
                cycles.append(tuple(sorted(current)))
            enabled = isinstance(values, Sync) and values.state == NodeState.OPERATIONAL
            current = [] if enabled else None
        if current is not None:
            current.append((frame.id, frame.data))
    if current is not None:
        cycles.append(tuple(sorted(current)))
    return cycles
