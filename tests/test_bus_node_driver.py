"""The driver loop on a port and a clock that a test winds by hand: no socket, no sleeping."""

import os
import signal
import subprocess
import sys
from collections import Counter, deque
from collections.abc import Sequence
from pathlib import Path

import pytest
from support.bus_nodes import Listener, Responder, Talker

from rfms_can.bus.hub.port import HubPort
from rfms_can.bus.node_driver import MAX_FRAMES_BEFORE_TIMER, NodeDriver, run_node
from rfms_can.bus.port import LONGEST_WAIT_S
from rfms_can.errors import BusError
from rfms_can.wire.frame import Frame

MS = 1_000_000


class ScriptedPort:
    """A port that holds what is readable; waiting winds the clock."""

    def __init__(self) -> None:
        self.statistics: Counter[str] = Counter()
        self.readable: deque[Frame] = deque()
        self.sent: list[tuple[int, Frame]] = []
        self.now_ns = 0

    def clock(self) -> int:
        return self.now_ns

    def send(self, frames: Sequence[Frame]) -> None:
        self.sent.extend((self.now_ns, frame) for frame in frames)

    def recv(self, timeout_s: float) -> Frame | None:
        if self.readable:
            return self.readable.popleft()
        self.now_ns += round(min(timeout_s, LONGEST_WAIT_S) * 1e9)
        return None

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        pass


def test_answers_go_out_and_a_node_without_deadline_waits_for_frames_only() -> None:
    port = ScriptedPort()
    driver = NodeDriver(Responder("node", {1: [Frame(2, b"")]}), port, port.clock)
    driver.pump()
    assert (port.sent, port.now_ns) == ([], round(LONGEST_WAIT_S * 1e9))
    port.readable.append(Frame(1, b""))
    driver.pump()
    assert [frame.id for _, frame in port.sent] == [2]


def test_on_time_is_called_at_the_deadline_and_not_before() -> None:
    port = ScriptedPort()
    node = Talker("node", [Frame(5, b"")], period_ns=4 * MS, rounds=3, first_ns=7 * MS)
    run_node(node, port, port.clock, stop=lambda: len(port.sent) == 3)
    assert [time_ns for time_ns, _ in port.sent] == [7 * MS, 11 * MS, 15 * MS]


def test_what_is_readable_comes_before_a_deadline_that_has_passed() -> None:
    order: list[str] = []

    class Node(Talker):
        def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
            order.append(f"frame {frame.id}")
            return ()

        def on_time(self, now_ns: int) -> Sequence[Frame]:
            order.append("time")
            return super().on_time(now_ns)

    port = ScriptedPort()
    port.readable.extend([Frame(1, b""), Frame(2, b"")])
    NodeDriver(Node("node", ()), port, port.clock).pump()
    assert order == ["frame 1", "frame 2", "time"]


def test_a_frame_may_push_the_deadline_away() -> None:
    class Watchdog(Listener):
        due_ns = 0

        def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
            self.due_ns = now_ns + MS
            return ()

        def on_time(self, now_ns: int) -> Sequence[Frame]:
            raise AssertionError("its frame was there in time")

        def next_deadline_ns(self) -> int | None:
            return self.due_ns

    port = ScriptedPort()
    port.readable.append(Frame(1, b""))
    NodeDriver(Watchdog("node", frozenset()), port, port.clock).pump()
    assert not port.readable


def test_frames_of_a_node_without_deadline_come_at_the_time_they_came() -> None:
    """SYNC after a quiet dialogue sets the first deadline: by an old clock it had passed."""
    times: list[int] = []

    class Node(Listener):
        def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
            times.append(now_ns)
            return ()

    class SlowPort(ScriptedPort):
        def recv(self, timeout_s: float) -> Frame | None:
            self.now_ns += 150 * MS
            return super().recv(timeout_s)

    port = SlowPort()
    port.readable.extend([Frame(1, b"")] * 4)
    driver = NodeDriver(Node("node", frozenset()), port, port.clock)
    driver.run_until(lambda: len(times) == 4)
    assert times == [150 * MS, 300 * MS, 450 * MS, 600 * MS]


def test_a_babbling_bus_does_not_keep_a_node_from_its_deadline() -> None:
    port = ScriptedPort()
    port.readable.extend([Frame(1, b"")] * 10 * MAX_FRAMES_BEFORE_TIMER)
    node = Talker("node", [Frame(5, b"")], accepts=frozenset({1}))
    NodeDriver(node, port, port.clock).pump()
    assert len(port.sent) == 1
    assert len(node.heard) == MAX_FRAMES_BEFORE_TIMER


@pytest.mark.processes
def test_a_node_on_the_verbs_hub_answers_until_the_hub_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    verb = "import typer; from rfms_can.cli.hub import hub; typer.run(hub)"
    node = """
import rfms_can.bus.driver as driver
from support.bus_nodes import Responder
from rfms_can.wire.frame import Frame
answer = Responder("node", {1: [Frame(2, bytes(64))]})
driver.run_node(answer, driver.open_port("hub:verb", answer.accepts))
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}

    def start(code: str, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-c", code, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )

    with start(verb, "verb", "--json") as hub:
        assert hub.stdout is not None
        assert hub.stdout.readline() == '{"ready": "verb"}\n'
        port = HubPort("verb", frozenset({2}), client="test")
        with start(node) as answering:
            frame = None
            for _ in range(200):  # until the node is up; it answers every question once
                port.send([Frame(1, b"")])
                frame = port.recv(1.0)
                if frame is not None:
                    break
            assert frame == Frame(2, bytes(64))
            hub.send_signal(signal.SIGINT)
            assert '"frames":' in hub.stdout.readline()
            _, complaint = answering.communicate(timeout=30)
            assert answering.returncode == 1
            assert "hub 'verb' has gone" in complaint
        assert hub.wait(30) == 0
        with pytest.raises(BusError, match="has gone"):
            for _ in range(200):  # further answers may be waiting
                port.recv(1.0)
        port.close()
