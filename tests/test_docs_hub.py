"""docs/hub.md: the wire of a hub, spoken with a plain socket and nothing of ours but the hub."""

import json
import os
import re
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from generated import DOCS

from rfms_can.bus.hub.client import MAX_BACKLOG
from rfms_can.bus.hub.server import Hub

PAGE: Final = (DOCS / "hub.md").read_text(encoding="utf-8")
ROOM: Final = 32768
FRAME: Final = struct.Struct("=IBBxx64s")
"""``struct canfd_frame``, as the page has it."""
FD: Final = 5

pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def hub() -> Iterator[Hub]:
    hub = Hub("page")
    thread = threading.Thread(target=hub.run)
    thread.start()
    yield hub
    hub.stop()
    thread.join(5)
    hub.close()


def directory() -> Path:
    """Where the page says that a hub named ``page`` is."""
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    return Path(base) / f"rfms-hub-page-{os.getuid()}"


def connect() -> socket.socket:
    """A connection without a hello."""
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    sock.settimeout(5.0)
    sock.connect(str(directory() / "socket"))
    return sock


def greet(hello: object) -> tuple[socket.socket, dict[str, Any]]:
    """A connection with a hello, and the hub's answer."""
    sock = connect()
    sock.send(json.dumps(hello).encode())
    answer = json.loads(sock.recv(ROOM))
    assert isinstance(answer, dict)
    return sock, answer


def packed(identifier: int, data: bytes, flags: int = FD) -> bytes:
    """72 bytes of a frame."""
    return FRAME.pack(identifier, len(data), flags, data)


def unpacked(packet: bytes) -> list[tuple[int, bytes, int]]:
    """Identifier, payload and flags of the frames of a packet."""
    assert len(packet) % 72 == 0
    return [(i, data[:size], flags) for i, size, flags, data in FRAME.iter_unpack(packet)]


def test_the_hello_and_the_welcome_are_those_of_the_page(hub: Hub) -> None:
    hello, welcome = (json.loads(text) for text in re.findall(r"```json\n(.*)\n```", PAGE))
    sock, answer = greet(hello)
    assert answer == welcome
    assert (directory().stat().st_mode & 0o777) == 0o700
    sock.close()


def test_the_welcome_has_none_of_the_spaces_of_the_page(hub: Hub) -> None:
    _, shown = re.findall(r"```json\n(.*)\n```", PAGE)
    sock = connect()
    sock.send(b'{"client":"terse"}')
    answer = sock.recv(ROOM).decode()
    assert answer != shown
    assert answer == shown.replace(" ", "")
    sock.close()


def test_a_client_needs_only_its_name(hub: Hub) -> None:
    all_frames, answer = greet({"client": "all"})
    assert answer["refused"] == ""
    sender, _ = greet({"client": "none", "ids": []})
    sender.send(packed(0x123, b"x"))
    assert unpacked(all_frames.recv(ROOM)) == [(0x123, b"x", FD)]
    for sock in (all_frames, sender):
        sock.close()


@pytest.mark.parametrize(
    "hello", [{}, {"client": "a", "lane": 1}, {"client": 3}, {"client": "a", "version": 2}, []]
)
def test_other_hellos_are_refused_and_disconnected(hub: Hub, hello: object) -> None:
    sock, answer = greet(hello)
    assert answer["refused"]
    assert sock.recv(ROOM) == b""
    sock.close()


def test_the_frame_of_the_page_is_an_emergency_stop(hub: Hub) -> None:
    (text,) = re.findall(r"```\n(.*), then 56 times 00\n```", PAGE)
    listener, _ = greet({"client": "listener", "ids": [0]})
    sender, _ = greet({"client": "sender", "ids": []})
    frame = bytes.fromhex(text) + bytes(56)
    assert frame == packed(0, b"STOP\xac\xab\xb0\xaf")
    sender.send(frame)
    assert listener.recv(ROOM) == frame
    for sock in (listener, sender):
        sock.close()


def test_a_packet_of_several_frames_arrives_sorted_and_in_one(hub: Hub) -> None:
    listener, _ = greet({"client": "listener", "ids": [1, 2]})
    singly, _ = greet({"client": "singly", "batch": False})
    sender, _ = greet({"client": "sender", "echo": True})
    sender.send(b"".join((packed(2, b"a"), packed(3, b""), packed(2, b"b"), packed(1, b"c", 0))))
    own = [(1, b"c", 0), (2, b"a", FD), (2, b"b", FD)]
    assert unpacked(listener.recv(ROOM)) == own
    whole = [*own, (3, b"", FD)]
    assert unpacked(sender.recv(ROOM)) == whole
    assert [unpacked(singly.recv(ROOM)) for _ in whole] == [[frame] for frame in whole]
    for sock in (listener, singly, sender):
        sock.close()


def test_what_is_no_frame_is_dropped_without_a_word(hub: Hub) -> None:
    listener, _ = greet({"client": "listener"})
    sender, _ = greet({"client": "sender", "ids": []})
    sender.send(bytes(71))
    sender.send(bytes(72 * 65))
    bad = (packed(1, bytes(9)), packed(2, bytes(9), 0), packed(3, bytes(12), 0))
    sender.send(b"".join((*bad, packed(4, bytes(12)))))
    extended, remote = 0x80000000, 0x40000000
    sender.send(packed(extended | 5, b"e"))
    sender.send(packed(remote | 6, b""))
    got = [unpacked(listener.recv(ROOM)) for _ in range(3)]
    assert got == [[(4, bytes(12), FD)], [(extended | 5, b"e", FD)], [(remote | 6, b"", FD)]]
    for sock in (listener, sender):
        sock.close()


def test_a_slow_reader_loses_the_newest_and_holds_up_none(hub: Hub) -> None:
    slow, _ = greet({"client": "slow", "ids": [7]})
    sender, _ = greet({"client": "sender", "ids": [8], "echo": True})
    sent = 0
    for _ in range(60):
        block = b"".join(packed(7, struct.pack("<I", sent + k)) for k in range(63))
        sender.send(block + packed(8, b""))
        sent += 63
        assert unpacked(sender.recv(ROOM)) == [(8, b"", FD)]  # the hub has not waited for anyone
    numbers = []
    slow.settimeout(0.2)
    try:
        while True:
            numbers += [struct.unpack("<I", data)[0] for _, data, _ in unpacked(slow.recv(ROOM))]
    except TimeoutError:
        pass
    assert numbers == list(range(len(numbers))), "the first ones, in order"
    assert MAX_BACKLOG < len(numbers) < sent
    for sock in (slow, sender):
        sock.close()


def test_the_end_of_the_hub_is_an_empty_packet() -> None:
    hub = Hub("page")
    thread = threading.Thread(target=hub.run)
    thread.start()
    sock, _ = greet({"client": "a"})
    hub.stop()
    thread.join(5)
    hub.close()
    assert sock.recv(ROOM) == b""
    with pytest.raises(BrokenPipeError):
        sock.send(packed(1, b""))
    sock.close()


def test_the_bounds_of_the_page_are_the_hubs() -> None:
    from rfms_can.bus.hub import protocol

    assert f"of at most {protocol.MAX_HELLO_BYTES} bytes" in PAGE
    assert f"up to {protocol.MAX_FRAMES_PER_PACKET} of them" in PAGE
    assert (
        f"({protocol.MAX_PACKET_BYTES}\nbytes)" in PAGE
        or f"({protocol.MAX_PACKET_BYTES} bytes)" in PAGE
    )
    assert f"version {protocol.VERSION}" in PAGE
    assert re.search(rf"up to\s+{MAX_BACKLOG}\s+frames", PAGE)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc)")
def test_the_c_of_the_page_speaks_to_a_hub(hub: Hub, tmp_path: Path) -> None:
    (text,) = re.findall(r"```c\n(.*?)```", PAGE, re.DOTALL)
    headers = ("linux/can.h", "stdio.h", "string.h", "sys/socket.h", "sys/un.h", "unistd.h")
    includes = "".join(f"#include <{header}>\n" for header in headers)
    newer = "#ifndef CANFD_FDF\n#define CANFD_FDF 4\n#endif\n"
    body = f"int main(int c, char **v) {{\n(void)c; char *base = v[1], *name = v[2];\n{text}"
    done = "return n == sizeof in[0] && in[0].can_id == 128 ? 0 : 1;\n}\n"
    source, program = tmp_path / "client.c", tmp_path / "client"
    source.write_text(includes + newer + body + done, encoding="ascii")
    subprocess.run(["cc", "-Wall", "-Werror", "-o", program, source], check=True)
    listener, _ = greet({"client": "listener", "ids": [0x703]})
    base = str(directory().parent)
    with subprocess.Popen([program, base, "page"]) as client:
        while not any(known.name == "board 3" for known in list(hub.clients.values())):
            assert client.poll() is None
            time.sleep(0.01)
        listener.send(packed(128, b"sync"))
        assert unpacked(listener.recv(ROOM)) == [(0x703, bytes(20), FD)]
        assert client.wait(5) == 0
    listener.close()
