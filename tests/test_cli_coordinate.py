"""``rfms coordinate``: a program against a server with real sockets; good ends and bad ones."""

import json
import os
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from support.command_line import Rfms, end, start
from support.server import Running
from support.system import SHORT

from rfms_can.link.keys import new_client_keys, new_server_keys
from rfms_can.messages import Query
from rfms_can.rig.serve import Listening
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

SWING = """\
from rfms_can.coordinator import Transform
def program(arm):
    aside = arm.transform("aside", Transform.rotation((0.0, 0.0, 1.0), 0.3) @ arm.pose)
    there = arm.position("there", arm.t6 == aside)
    slow = arm.mode("slow", segment_time={seconds}, acceleration_time=0.1)
    arm.move(there, slow)
    print("moves", flush=True)
    arm.wait()
"""


@pytest.fixture
def running(runtime: Path) -> Iterator[Running]:
    with Running(RunSettings(friction="none"), Listening("cell")) as server:
        yield server


@pytest.fixture
def coordinate(rfms: Rfms) -> Rfms:
    return partial(rfms, "coordinate")


def written(text: str, name: str = "swing.py") -> Path:
    path = Path(name)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_program_ends_at_rest_and_gives_the_arm_back(coordinate: Rfms, running: Running) -> None:
    ended = coordinate(SHORT, "--server", "cell", "--json")
    assert ended.code == 0, ended.err
    numbers = json.loads(ended.out)
    assert numbers["server"] == "cell"
    assert numbers["moves"] == 2
    assert numbers["seconds"] == pytest.approx(numbers["cycles"] * 0.004)
    reader = running.client("reader")
    told = reader.ask(Query()).status
    assert (told.lease, told.at_rest, told.completed) == (None, True, 2)
    assert told.joints == tuple(numbers["joints"])
    again = coordinate(SHORT, "--server", "cell")  # another program, with the same names
    assert again.code == 0
    assert "2 moves in" in again.err


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("def program(arm):\n    arm.move('a', 'b')\n", "swing.py, line 2: position 'a'"),
        ("def program(arm):\n    {}['part']\n", "swing.py, line 2: KeyError: 'part'"),
        ("def program(arm):\n    arm.lock('fx')\n", "line 2: lock 'fx': fx does not comply"),
        ("x = 1\n", "has no function program(arm)"),
    ],
)
def test_what_is_wrong_with_a_program_is_one_line(
    coordinate: Rfms, running: Running, text: str, complaint: str
) -> None:
    ended = coordinate(written(text), "--server", "cell")
    assert ended.code == 1
    assert complaint in ended.complaint


def test_no_server_says_what_to_start(coordinate: Rfms) -> None:
    line = coordinate(SHORT, "--server", "nobody").complaint
    assert "no server 'nobody' is running" in line
    assert "rfms serve --name nobody" in line


def test_an_address_that_is_none(coordinate: Rfms) -> None:
    assert "tcp://127.0.0.1:PORT" in coordinate(SHORT, "--server", "tcp://localhost:5").complaint


def test_who_controls_the_arm_is_named(coordinate: Rfms, running: Running) -> None:
    running.client("left cell").acquire(10.0)
    assert "controlled by 'left cell'" in coordinate(SHORT, "--server", "cell").complaint


def test_a_fault_is_one_line_and_exit_code_1(coordinate: Rfms, running: Running) -> None:
    running.client("guard").emergency("smoke")
    running.client("reader").watch(lambda status: status.fault is not None)
    assert "emergency stop by 'guard': 'smoke'" in coordinate(SHORT, "--server", "cell").complaint


@pytest.mark.parametrize("clients", [(), ("left", "right")])
def test_keys_are_those_of_one_client(
    coordinate: Rfms, tmp_path: Path, clients: tuple[str, ...]
) -> None:
    new_server_keys(tmp_path / "server")
    (tmp_path / "client").mkdir()
    for name in clients:
        pair = new_client_keys(tmp_path / "server", name)
        pair.rename(tmp_path / "client" / pair.name)
    line = coordinate(SHORT, "--keys", tmp_path / "client").complaint
    assert "one NAME.key_secret must be there" in line
    assert (clients[0] if clients else "none") in line


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_stops_the_arm_and_says_so(
    running: Running,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    number: signal.Signals,
    code: int,
) -> None:
    monkeypatch.chdir(tmp_path)
    process = start("coordinate", written(SWING.format(seconds=90.0)), "--server", "cell")
    assert process.stdout is not None
    assert process.stdout.readline() == "moves\n"
    reader = running.client("reader")
    reader.watch(lambda status: status.sequence == 1 and not status.at_rest)
    os.kill(process.pid, number)
    ended = end(process)
    assert ended.code == code
    assert ended.complaint.endswith(f"{number.name} ended the program; the arm has been stopped")
    told = reader.ask(Query()).status
    assert (told.lease, told.at_rest, told.waiting, told.fault) == (None, True, 0, None)


def test_a_program_that_is_killed_leaves_an_arm_at_rest(
    running: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    process = start("coordinate", written(SWING.format(seconds=90.0)), "--server", "cell")
    assert process.stdout is not None
    assert process.stdout.readline() == "moves\n"
    process.kill()
    end(process)
    reader = running.client("reader")
    until = time.monotonic() + 20.0
    while reader.ask(Query()).status.lease is not None:
        assert time.monotonic() < until
    assert reader.watch(lambda status: status.at_rest).waiting == 0


STANDS = """\
import time
def program(arm):
    print("stands", flush=True)
    while not arm.status.fault:
        time.sleep({seconds})
"""


@pytest.mark.parametrize("verb", [("run",), ("coordinate", "--server", "cell")])
@pytest.mark.parametrize("seconds", [0.02, 60.0])
def test_the_first_signal_ends_a_program_that_lets_no_time_pass(
    running: Running,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    verb: tuple[str, ...],
    seconds: float,
) -> None:
    monkeypatch.chdir(tmp_path)
    process = start(*verb, written(STANDS.format(seconds=seconds)))
    assert process.stdout is not None
    for line in process.stdout:
        if "stands" in line:
            break
    os.kill(process.pid, signal.SIGTERM)
    ended = end(process)
    assert ended.code == 143, ended
    assert "SIGTERM ended the" in ended.err
