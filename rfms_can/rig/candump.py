"""A candump log (``candump -L`` form): what canplayer, python-can and cantools read.

A log that is cut, because the disk is full, ends with an error frame: the receiver lost frames
(``CAN_ERR_CRTL`` with ``CAN_ERR_CRTL_RX_OVERFLOW``, linux/can/error.h). It has ``CAN_ERR_BUSERROR``
too, without which python-can takes it for a data frame.
"""

import contextlib
import os
from collections.abc import Iterable
from io import FileIO
from pathlib import Path
from typing import Final

from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Sync
from rfms_can.wire.vocabulary import NodeState

_FLAGS_BRS = "1"
_ERROR_FLAG: Final = 0x2000_0000  # CAN_ERR_FLAG
_CUT: Final = f"{_ERROR_FLAG | 0x084:08X}#0001000000000000"
"""What stands at the end of a log that is cut."""
BUFFERED_BYTES: Final = 1 << 20
"""Bytes of a log that are written at a time."""
_LAST_BYTES: Final = 4096
"""So much of a file that is full is looked at for the end of a line, and given up."""


def log_line(time_ns: int, channel: str, frame: Frame) -> str:
    """One line, newline included; CAN FD frames carry the bit-rate-switch flag."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    mark = "##" + _FLAGS_BRS if frame.fd else "#"
    data = frame.data.hex().upper()
    return f"({seconds}.{rest // 1000:06d}) {channel} {frame.id:03X}{mark}{data}\n"


class CandumpWriter:
    """Writes frames to a log; losing the disk loses the rest of the log and nothing else.

    Args:
        path: file to write.
        channel: interface name in the log.
        origin_ns: added to every time.

    Attributes:
        cut: why writing failed and the rest of the log is missing; empty while it is whole.
    """

    def __init__(self, path: Path, channel: str, origin_ns: int = 0) -> None:
        self._file: FileIO | None = FileIO(path, "w+")
        self._channel = channel
        self._origin_ns = origin_ns
        self._lines: list[str] = []
        self._buffered = 0
        self.cut = ""

    def write(self, time_ns: int, frame: Frame) -> None:
        """Append a frame."""
        if self._file is None:
            return
        line = log_line(self._origin_ns + time_ns, self._channel, frame)
        self._lines.append(line)
        self._buffered += len(line)
        if self._buffered >= BUFFERED_BYTES:
            self._flush(self._file)

    def close(self) -> None:
        """Finish the file."""
        if self._file is not None:
            self._flush(self._file)
        if self._file is not None:
            self._file.close()
            self._file = None

    def _flush(self, file: FileIO) -> None:
        data = memoryview("".join(self._lines).encode("ascii"))
        last = self._lines[-1] if self._lines else ""
        self._lines, self._buffered = [], 0
        try:
            while data:
                data = data[file.write(data) :]
        except OSError as error:
            self.cut = error.strerror or str(error)
            self._mark_the_cut(file, last.partition(" ")[0])
            with contextlib.suppress(OSError):
                file.close()
            self._file = None

    def _mark_the_cut(self, file: FileIO, stamp: str) -> None:
        """End the file with a whole line and the error frame; room for it is taken from its end."""
        line = f"{stamp} {self._channel} {_CUT}\n".encode("ascii")
        with contextlib.suppress(OSError):
            begin = max(0, file.seek(0, os.SEEK_END) - _LAST_BYTES)
            file.seek(begin)
            kept = file.read(_LAST_BYTES)[: -len(line)]
            file.truncate(begin + kept.rfind(b"\n") + 1)
            file.seek(0, os.SEEK_END)
            file.write(line)


def read_candump(path: Path) -> list[tuple[float, Frame]]:
    """Times (s) and frames of a candump log, without error frames and a last line that is cut off.

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
            can_id = int(identifier, 16)
            if not can_id & _ERROR_FLAG:
                frames.append((float(stamp.strip("()")), Frame(can_id, data, fd)))
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
