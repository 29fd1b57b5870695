"""Nine processes in lockstep on a real vcan0, with the tools of others around them."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import can
import pytest
from support.system import ROOT, SHORT

from rfms_can.cli.app import main
from rfms_can.coordinator import Arm
from rfms_can.rig.candump import Cycle, cycles_from_enable, read_candump
from rfms_can.rig.program import load_program
from rfms_can.rig.record import LOG
from rfms_can.rig.result import RunResult
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Program
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import NODE_NAMES, SIMULATED
from rfms_can.wire.records import Heartbeat

pytestmark = pytest.mark.vcan

BUS = "socketcan:vcan0"
PLAYED = 400
"""Frames that are played back: a part of the log, at one a millisecond."""
LONG_S = 60.0
ROOM = str(1 << 23)
"""Receive buffer of candump, bytes: with one processor for all it is not always on time."""
NAMES = [NODE_NAMES[node] for node in SIMULATED]


@contextmanager
def candump(path: Path) -> Iterator[None]:
    """A real ``candump -L vcan0`` that writes to a file."""
    with (
        path.open("w") as log,
        subprocess.Popen(["candump", "-r", ROOM, "-L", "vcan0"], stdout=log) as dump,
    ):
        time.sleep(0.5)  # it has no way to say that it listens
        yield
        time.sleep(0.5)
        dump.terminate()


class Run(NamedTuple):
    """A run on vcan0: its result, our own log, candump's log."""

    result: RunResult
    own: Path
    dumped: Path


def run_on_vcan0(directory: Path, program: Program) -> Run:
    """A program with nine processes, recorded by us and by candump."""
    dumped = directory / "candump.log"
    with candump(dumped):
        outcome = execute(program, RunSettings(bus=BUS, seed=1), record=directory / "own")
    assert outcome.fault is None
    return Run(outcome.result, directory / "own" / LOG, dumped)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return run_on_vcan0(tmp_path_factory.mktemp("plain"), load_program(SHORT))


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of the same program on the simulated bus."""
    directory = tmp_path_factory.mktemp("simulated")
    execute(load_program(SHORT), RunSettings(), record=directory)
    return directory / LOG


def cycles_of(log: Path) -> list[Cycle]:
    return cycles_from_enable((frame for _, frame in read_candump(log)), Wire())


def test_nobody_misses_a_cycle(plain: Run) -> None:
    assert plain.result.cycles > 350
    assert (plain.result.incomplete, plain.result.lost) == (0, 0)
    assert sum(plain.result.discarded.values()) == 0


def test_candump_and_we_record_the_same(plain: Run, simulated: Path) -> None:
    assert cycles_of(plain.dumped) == cycles_of(plain.own) == cycles_of(simulated)


def test_cantools_decodes_every_frame_candump_has_seen(plain: Run) -> None:
    dbc = str(ROOT / "dbc" / "rfms.dbc")
    decode = [sys.executable, "-m", "cantools", "decode", "--single-line", dbc]
    with plain.dumped.open() as log:
        decoded = subprocess.run(decode, stdin=log, capture_output=True, text=True, check=True)
    lines = decoded.stdout.splitlines()
    assert len(lines) == len(plain.dumped.read_text().splitlines()) > 10_000
    undecoded = [line for line in lines if not re.search(r" :: [A-Z_]+\w*\(.+\)$", line)]
    assert undecoded == []
    assert decoded.stderr == ""


def test_python_can_reads_the_log(plain: Run) -> None:
    frames = [frame for _, frame in read_candump(plain.dumped)]
    messages = list(can.LogReader(str(plain.dumped)))
    assert len(messages) == len(frames)
    for message, frame in zip(messages, frames, strict=True):
        assert isinstance(message, can.Message)
        assert (message.arbitration_id, bytes(message.data)) == (frame.id, frame.data)
        assert message.is_fd and message.bitrate_switch


@pytest.mark.skipif(shutil.which("canplayer") is None, reason="needs can-utils")
def test_canplayer_plays_our_log(plain: Run, tmp_path: Path) -> None:
    part = tmp_path / "part.log"
    with plain.own.open() as log:
        part.write_text("".join(islice(log, 5000, 5000 + PLAYED)))
    heard = tmp_path / "heard.log"
    with candump(heard):
        subprocess.run(["canplayer", "-I", part, "-t", "-g", "1"], check=True, timeout=LONG_S)
    assert [frame for _, frame in read_candump(heard)] == [frame for _, frame in read_candump(part)]


def test_a_foreign_frame_is_discarded_and_counted(simulated: Path, tmp_path: Path) -> None:
    """A wrong length, and a valid one without protection: the nodes' own frames do not change."""
    quiet = load_program(SHORT)
    foreign = ("201##1DEADBEEF", "283##1" + "00" * 8)

    def program(arm: Arm) -> None:
        for frame in foreign:
            subprocess.run(["cansend", "vcan0", frame], check=True)
        quiet(arm)

    run = run_on_vcan0(tmp_path, program)
    assert run.result.incomplete == 0
    discarded = run.result.discarded
    hears_error_1 = {"master", *(f"joint {joint}" for joint in range(1, 7))}
    hears_dac_3 = {"master", "plant", "joint 3"}  # its own: a second node would send it
    assert discarded == {name: (name in hears_error_1) + (name in hears_dac_3) for name in NAMES}
    assert own_payloads(run.dumped, foreign) == own_payloads(simulated, foreign)


def own_payloads(log: Path, foreign: tuple[str, ...]) -> list[list[tuple[object, ...]]]:
    """Cycles without the foreign frames; of heartbeats all that does not count them."""
    wire = Wire()
    beats = {wire.id(Heartbeat, node): wire.receiver(Heartbeat, node) for node in SIMULATED}
    aliens = {(int(text[:3], 16), bytes.fromhex(text[6:])) for text in foreign}
    cycles = []
    for cycle in cycles_of(log):
        payloads: list[tuple[object, ...]] = []
        for identifier, data in cycle:
            if identifier in beats:
                beat = beats[identifier].decoder.codec.unpack(data)
                assert beat is not None
                payloads.append((identifier, *beat._replace(discarded=0)))
            elif (identifier, data) not in aliens:
                payloads.append((identifier, data))
        cycles.append(payloads)
    return cycles


def test_up_runs_on_vcan0_and_leaves_nobody_behind(tmp_path: Path) -> None:
    out, err = tmp_path / "out", tmp_path / "err"
    pid = forked_rfms(out, err, "up", "--bus", BUS, "--json")
    until = time.monotonic() + LONG_S
    health: dict[str, str] = {}
    while set(health.values()) != {"READY", "OPERATIONAL"}:
        assert time.monotonic() < until, err.read_text()
        time.sleep(0.2)
        lines = out.read_text().splitlines(keepends=True)
        if lines and lines[-1].endswith("\n"):
            nodes = json.loads(lines[-1])
            health = {node["node"]: node["state"] for node in nodes}
    assert list(health) == ["master", *(n for n in NAMES if n != "master")]
    assert len({node["pid"] for node in nodes}) == 9
    os.kill(pid, signal.SIGINT)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    assert not any(Path(f"/proc/{node['pid']}").exists() for node in nodes)


def forked_rfms(out: Path, err: Path, *arguments: str) -> int:
    """The command in a process forked from this warm one: imports are slow in the guest."""
    pid = os.fork()
    if pid:
        return pid
    code: object = 1
    try:
        sys.stdout, sys.stderr = out.open("w", 1), err.open("w", 1)
        sys.argv = ["rfms", *arguments]
        main()
        code = 0
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)
