"""Candump logs: what we write, candump's readers read; what we read, we wrote."""

import contextlib
import resource
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.rig.candump import CandumpWriter, cycles_from_enable, log_line, read_candump
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import FD_LENGTHS, Frame
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import Dac, Sync
from rfms_can.wire.vocabulary import NodeState


@contextlib.contextmanager
def limited(size: int) -> Iterator[None]:
    """No file of this process grows beyond a size."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


frames = st.one_of(
    st.sampled_from(sorted(FD_LENGTHS)).flatmap(
        lambda length: st.builds(
            Frame, st.integers(0, 0x7FF), st.binary(min_size=length, max_size=length)
        )
    ),
    st.builds(Frame, st.integers(0, 0x7FF), st.binary(max_size=8), st.just(False)),
)
times_ns = st.integers(0, 2**61)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("candump") / "bus.log"


@given(st.lists(st.tuples(times_ns, frames)))
def test_what_is_written_is_read(log: Path, written: list[tuple[int, Frame]]) -> None:
    writer = CandumpWriter(log, "vcan0")
    for time_ns, frame in written:
        writer.write(time_ns, frame)
    writer.close()
    read = read_candump(log)
    assert [frame for _, frame in read] == [frame for _, frame in written]
    whole_us = [time_ns // 1000 for time_ns, _ in written]
    assert [time_s for time_s, _ in read] == [us / 1e6 for us in whole_us]  # the nearest floats
    assert not writer.cut


@given(st.lists(frames, min_size=1, max_size=8))
def test_python_can_reads_the_same(log: Path, written: list[Frame]) -> None:
    writer = CandumpWriter(log, "vcan0", origin_ns=1_700_000_000_000_000_000)
    for number, frame in enumerate(written):
        writer.write(number * 1_000_000, frame)
    writer.close()
    messages = list(can.LogReader(str(log)))
    assert len(messages) == len(written)
    for number, (message, frame) in enumerate(zip(messages, written, strict=True)):
        assert isinstance(message, can.Message)
        assert (message.arbitration_id, bytes(message.data)) == (frame.id, frame.data)
        assert (message.is_fd, message.bitrate_switch) == (frame.fd, frame.fd)
        assert not message.is_extended_id
        assert message.timestamp == pytest.approx(1_700_000_000 + number * 1e-3, abs=1e-6)


def test_the_form_is_that_of_candump() -> None:
    assert log_line(0, "sim0", Frame(0x80, b"", True)) == "(0.000000) sim0 080##1\n"
    late = 1_234_567_890_123_456_789
    classic = log_line(late, "can0", Frame(0x7FF, b"\x0a\xff", False))
    assert classic == "(1234567890.123456) can0 7FF#0AFF\n"


def test_lines_of_candump_itself_are_read(tmp_path: Path) -> None:
    path = tmp_path / "candump.log"
    path.write_text("(1.5) vcan0 201##1DEADBEEF\n(2.000001) vcan0 123#00 R\n")
    assert read_candump(path) == [
        (1.5, Frame(0x201, bytes.fromhex("DEADBEEF"))),
        (2.000001, Frame(0x123, b"\0", False)),
    ]


@pytest.mark.parametrize("line", ["", "hello", "(1.0) can0 12Z#00", "(1.0) can0 100#0"])
def test_what_is_no_candump_line_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "bad.log"
    path.write_text(f"(1.0) can0 100#00\n{line}\n")
    with pytest.raises(ValueError, match=r"bad.log, line 2: not a candump line"):
        read_candump(path)


def test_a_full_disk_loses_the_log_and_nothing_else() -> None:
    writer = CandumpWriter(Path("/dev/full"), "vcan0")
    for _ in range(20_000):
        writer.write(0, Frame(0x100, bytes(64)))
    writer.write(1, Frame(0x100, bytes(64)))
    writer.close()
    assert writer.cut == "No space left on device"


@pytest.mark.parametrize("room", [100, 150_000, 1_300_000])
def test_a_log_that_is_cut_says_so_at_its_end(tmp_path: Path, room: int) -> None:
    """A limit of the file's size stands for the disk's: 1.2 million bytes are written at a time."""
    path = tmp_path / "bus.log"
    writer = CandumpWriter(path, "vcan0")
    with limited(room):
        for number in range(20_000):
            writer.write(number * 1_000_000, Frame(number % 0x800, bytes(64)))
        writer.close()
    assert writer.cut == "File too large"
    text = path.read_text()
    assert path.stat().st_size <= room
    assert text.endswith("vcan0 20000084#0001000000000000\n")
    kept = read_candump(path)
    assert len(kept) == text.count("\n") - 1
    assert len(kept) > (room - 5_000) // 160
    assert [frame.id for _, frame in kept] == [number % 0x800 for number in range(len(kept))]
    *messages, last = can.LogReader(str(path))
    assert isinstance(last, can.Message)
    assert last.is_error_frame
    assert len(messages) == len(kept)


def test_cycles_are_counted_from_enable_to_disable(wire: Wire) -> None:
    """Order within a cycle does not matter; what stands before and after does not count."""
    sync: Sender[Sync] = wire.sender(Sync)
    dacs: list[Sender[Dac]] = [wire.sender(Dac, joint) for joint in (1, 2)]

    def cycle(number: int, state: NodeState, *, swap: bool) -> list[Frame]:
        answers = [dac.frame(number, 0, number) for dac in dacs]
        return [sync.frame(number, state, 0, wire.dbc_hash), *(answers[::-1] if swap else answers)]

    def run(*, swap: bool) -> list[Frame]:
        sync.reset()
        for dac in dacs:
            dac.reset()
        return [
            *cycle(7, NodeState.READY, swap=swap),
            *cycle(0, NodeState.OPERATIONAL, swap=swap),
            *cycle(1, NodeState.OPERATIONAL, swap=swap),
            *cycle(2, NodeState.READY, swap=swap),
        ]

    counted = cycles_from_enable(run(swap=False), wire)
    assert [len(frames) for frames in counted] == [3, 3]
    assert counted == cycles_from_enable(run(swap=True), wire)
    assert counted != cycles_from_enable(run(swap=False)[:-4], wire)


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "killed.log"
    whole = log_line(1_000_000, "sim0", Frame(0x123, b"\x01\x02"))
    path.write_text(whole + whole[: len(whole) // 2], encoding="ascii")
    assert [frame for _, frame in read_candump(path)] == [Frame(0x123, b"\x01\x02")]
