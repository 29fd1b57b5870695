"""A bus has one master: another one is refused before it acts, and a dead one is seen."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from support.command_line import end, kill, start
from support.system import SHORT

from rfms_can.wire.nodes import MASTER, NODE_NAMES, SIMULATED

pytestmark = pytest.mark.processes

BUS = "hub:one"
LONG_S = 20.0
Health = dict[str, dict[str, Any]]
OTHERS = [NODE_NAMES[node] for node in SIMULATED if node != MASTER]


class Up:
    """``rfms up`` without a program: the arm is homed, and waits with its brakes on."""

    def __init__(self, *arguments: str) -> None:
        self.process = start("up", "--bus", BUS, "--json", *arguments)
        self.health = self.until(
            lambda h: all(h[n]["state"] == "READY" for n in OTHERS if n != "plant")
        )

    def until(self, holds: Callable[[Health], bool]) -> Health:
        """The next state of all nodes that fulfils a condition."""
        assert self.process.stdout is not None and self.process.stderr is not None
        stop = time.monotonic() + LONG_S
        while time.monotonic() < stop:
            line = self.process.stdout.readline()
            assert line, self.process.stderr.read()
            self.health = {node["node"]: node for node in json.loads(line)}
            if holds(self.health):
                return self.health
        raise AssertionError(f"not within {LONG_S} s: {self.health}")


@pytest.fixture
def up(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Up]]:
    """Starts it in a place of its own, and leaves nothing behind."""
    monkeypatch.chdir(runtime)
    started: list[subprocess.Popen[str]] = []

    def begin(*arguments: str) -> Up:
        one = Up(*arguments)
        started.append(one.process)
        return one

    yield begin
    for process in started:
        kill(process)
        process.wait(10.0)
        for stream in (process.stdout, process.stderr):
            if stream is not None:
                stream.close()


def test_another_master_is_refused_and_the_first_is_not_disturbed(up: Callable[..., Up]) -> None:
    first = up()
    others = [
        start("master", "--bus", BUS),
        start("up", "--bus", BUS),
        start("run", SHORT, "--bus", BUS),
    ]
    for other in others:
        ended = end(other)
        assert ended.code == 1
        assert "another master drives" in ended.complaint
        assert "stop it first, or take another bus" in ended.complaint
    for _ in range(3):
        health = first.until(lambda _: True)
    assert {health[name]["state"] for name in OTHERS if name != "plant"} == {"READY"}
    assert not any(node["emergency"] for node in health.values())
    assert all(node["alive"] for node in health.values())


def test_when_the_master_has_died_no_node_is_shown_as_it_was(up: Callable[..., Up]) -> None:
    first = up("--keep-going")
    os.kill(first.health[NODE_NAMES[MASTER]]["pid"], signal.SIGKILL)
    health = first.until(lambda h: all(node["state"] == "SILENT" for node in h.values()))
    assert not health[NODE_NAMES[MASTER]]["alive"]
    assert all(health[name]["alive"] for name in OTHERS)
