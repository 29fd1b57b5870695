"""Run through tools/with-vcan by the tests: says on standard output what it finds, as JSON."""

import json
import os
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import can

FRAME = struct.Struct("=IBB2x64s")  # struct canfd_frame of <linux/can.h>


def fd_frame(identifier: int, data: bytes) -> can.Message:
    """Make a CAN FD frame with bit-rate switching."""
    return can.Message(
        arbitration_id=identifier,
        data=data,
        is_extended_id=False,
        is_fd=True,
        bitrate_switch=True,
    )


def echo_one_frame() -> None:
    """Answer one frame with its payload reversed, on a raw socket in a process of its own."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
        bus.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        bus.bind(("vcan0",))
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        _, length, flags, data = FRAME.unpack(bus.recv(FRAME.size))
        bus.send(FRAME.pack(0x321, length, flags, data[:length][::-1]))


def exchange_with_another_process() -> list[object]:
    """Send a CAN FD frame through python-can; return what another process answers."""
    with (
        can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus,
        subprocess.Popen([sys.executable, __file__, "echo"], stdout=subprocess.PIPE) as other,
    ):
        assert other.stdout is not None
        other.stdout.readline()
        data = bytes(range(64))
        bus.send(
            can.Message(0x123, data=data, is_extended_id=False, is_fd=True, bitrate_switch=True)
        )
        answer = bus.recv(timeout=10.0)
    assert answer is not None
    return [answer.arbitration_id, answer.data.hex(), answer.is_fd, answer.bitrate_switch]


def record_with_candump() -> str:
    """Record one frame with candump, sending until it has started to listen."""
    with (
        can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus,
        subprocess.Popen(["candump", "-L", "-n", "1", "vcan0"], stdout=subprocess.PIPE) as recorder,
    ):
        while recorder.poll() is None:
            bus.send(fd_frame(0x140, bytes(12)))
            time.sleep(0.02)
        assert recorder.stdout is not None
        return recorder.stdout.read().decode().split()[-1]


def main() -> None:
    """Report on standard output, complain on standard error, leave a file, exit with 7."""
    report = {
        "arguments": sys.argv[1:],
        "directory": os.getcwd(),
        "variable": os.environ["WITH_VCAN_TEST"],
        "user": os.getuid(),
        "mtu": int(Path("/sys/class/net/vcan0/mtu").read_text()),
        "answer": exchange_with_another_process(),
        "record": record_with_candump(),
    }
    Path("left by the command").write_text("whole\n" * 10_000)
    print(json.dumps(report))
    print("a complaint", file=sys.stderr)
    sys.exit(7)


if __name__ == "__main__":
    echo_one_frame() if sys.argv[1:] == ["echo"] else main()
