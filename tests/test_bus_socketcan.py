"""The raw SocketCAN path on a socket pair that stands for the kernel: same structs, same sizes."""

import errno
import socket
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.bus.canfd_struct import pack_canfd, pack_socketcan, unpack_canfd, unpack_socketcan
from rfms_can.bus.socketcan_port import TX_RETRIES, SocketCanPort
from rfms_can.errors import BusError
from rfms_can.wire.frame import FD_LENGTHS, Frame

frames = st.one_of(
    st.sampled_from(sorted(FD_LENGTHS)).flatmap(
        lambda length: st.builds(
            Frame, st.integers(0, 0x7FF), st.binary(min_size=length, max_size=length)
        )
    ),
    st.builds(Frame, st.integers(0, 0x7FF), st.binary(max_size=8), st.just(False)),
)


@pytest.fixture
def kernel_and_port() -> Iterator[tuple[socket.socket, SocketCanPort]]:
    kernel, ours = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    port = SocketCanPort(ours, "vcan0", on_close=ours.close)
    yield kernel, port
    port.close()
    kernel.close()


@given(frames)
def test_frames_survive_both_structs(frame: Frame) -> None:
    assert unpack_canfd(pack_canfd(frame)) == frame
    assert unpack_socketcan(pack_socketcan(frame)) == frame


def test_the_structs_are_those_of_linux_can_h() -> None:
    fd = pack_socketcan(Frame(0x123, b"\x01\x02\x03"))
    # identifier, length, CANFD_BRS | CANFD_FDF, two reserved bytes, payload
    assert (len(fd), fd[4], fd[5] & 0x01, fd[8:11]) == (72, 3, 1, b"\x01\x02\x03")
    classic = pack_socketcan(Frame(0x123, b"\x01\x02\x03", fd=False))
    assert (len(classic), classic[4], classic[8:11]) == (16, 3, b"\x01\x02\x03")
    assert int.from_bytes(fd[:4], "little") == int.from_bytes(classic[:4], "little") == 0x123


def test_frames_go_both_ways(kernel_and_port: tuple[socket.socket, SocketCanPort]) -> None:
    kernel, port = kernel_and_port
    frame = Frame(0x140, bytes(range(64)))
    port.send([frame])
    packet = kernel.recv(100)
    assert packet == pack_socketcan(frame)
    kernel.send(packet)
    assert port.recv(0.0) == frame
    assert port.recv(0.0) is None
    assert port.statistics == {"sent": 1, "received": 1}


def test_foreign_frames_are_counted_by_kind_and_the_next_good_one_comes_through() -> None:
    kernel, ours = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    kinds: list[str] = []
    port = SocketCanPort(ours, "can0", on_foreign=kinds.append)
    good = bytearray(pack_socketcan(Frame(0x10, b"", fd=False)))
    for flag in (0x80, 0x40):  # extended, remote
        kernel.send(bytes([*good[:3], flag, *good[4:]]))
    bus_off = (0x20000000 | 0x040).to_bytes(4, "little") + bytes([8, 0, 0, 0]) + bytes(8)
    overrun = (0x20000000 | 0x004).to_bytes(4, "little") + bytes([8, 0, 0, 0, 0, 1, *bytes(6)])
    kernel.send(bus_off)
    kernel.send(overrun)
    kernel.send(bytes(good))
    assert port.recv(0.0) == Frame(0x10, b"", fd=False)
    assert kinds == ["not 11-bit data"] * 2 + ["error"] * 2
    assert port.statistics == {
        "received": 1,
        "foreign": 2,
        "error_frames": 2,
        "bus_off": 1,
        "rx_overflow": 1,
    }
    kernel.close()
    ours.close()


class FullQueue(socket.socket):
    """A device whose transmit queue stays full for some attempts, or that has gone."""

    def __init__(self, failures: int, number: int) -> None:
        super().__init__(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.failures, self.number, self.attempts = failures, number, 0

    def send(self, data: object, flags: int = 0) -> int:
        self.attempts += 1
        if self.attempts <= self.failures:
            raise OSError(self.number, "as the kernel would")
        return 72


def test_a_full_device_queue_is_retried_then_counted() -> None:
    with FullQueue(3, errno.ENOBUFS) as sock:
        port = SocketCanPort(sock, "can0")
        port.send([Frame(1, b"")])
        assert (port.statistics["sent"], port.statistics["tx_overflow"]) == (1, 0)
    with FullQueue(TX_RETRIES, errno.ENOBUFS) as sock:
        port = SocketCanPort(sock, "can0")
        port.send([Frame(1, b""), Frame(2, b"")])
        assert (port.statistics["sent"], port.statistics["tx_overflow"]) == (1, 1)


@pytest.mark.parametrize("number", [errno.ENETDOWN, errno.ENODEV])
def test_a_device_that_has_gone_is_a_bus_error_with_the_way_out(number: int) -> None:
    with FullQueue(1, number) as sock, pytest.raises(BusError, match="ip link set can0 up"):
        SocketCanPort(sock, "can0").send([Frame(1, b"")])
