"""Nine processes on a hub: they start together, are watched, and none is left behind."""

import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from support.command_line import Ended, assert_none_left, end, kill, processes_of, start
from support.system import ROOT, SHORT, TRANSFER

from rfms_can.rig.candump import read_candump
from rfms_can.wire.codec import DBC_VARIABLE
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import JOINTS, MASTER, NODE_NAMES, SIMULATED
from rfms_can.wire.records import Measure

pytestmark = pytest.mark.processes

LONG_S = 20.0
BARRIER = "0.5"
"""Longest lockstep cycle of runs in which a node fails, s: a busy machine must not miss it."""
OTHERS = [NODE_NAMES[node] for node in SIMULATED if node != MASTER]

Start = Callable[..., subprocess.Popen[str]]
Health = dict[str, dict[str, Any]]


@pytest.fixture
def begin(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Start]:
    """Starts ``rfms`` in a place of its own; whatever a test left running is killed."""
    monkeypatch.chdir(runtime)
    started: list[subprocess.Popen[str]] = []

    def begin_one(*arguments: str | Path, **options: Any) -> subprocess.Popen[str]:
        started.append(start(*arguments, **options))
        return started[-1]

    yield begin_one
    for process in started:
        kill(process)
        process.wait(10.0)
        for stream in (process.stdout, process.stderr):
            if stream is not None:
                stream.close()


def health_of(process: subprocess.Popen[str], until: Callable[[Health], bool]) -> Health:
    """The first line of ``rfms up --json`` that fulfils a condition."""
    assert process.stdout is not None
    stop = time.monotonic() + LONG_S
    while time.monotonic() < stop:
        line = process.stdout.readline()
        assert line, process.stderr.read() if process.stderr else ""
        health = {node["node"]: node for node in json.loads(line)}
        if until(health):
            return health
    raise AssertionError(f"not within {LONG_S} s: {health}")


def all_ready(health: Health) -> bool:
    """Homed, braked, and heard of a moment ago."""
    return all(
        node["state"] in ("READY", "OPERATIONAL") and node["silent_s"] < 1.0
        for node in health.values()
    ) and all(health[name]["state"] == "READY" for name in OTHERS if name != "plant")


def up(begin: Start, *arguments: str) -> tuple[subprocess.Popen[str], Health]:
    """``rfms up`` with everybody ready."""
    process = begin("up", "--bus", "hub:up", "--json", *arguments)
    return process, health_of(process, all_ready)


def wait_for_hub(directory: Path, name: str) -> None:
    until = time.monotonic() + LONG_S
    while not (directory / f"rfms-hub-{name}-{os.getuid()}" / "socket").exists():
        assert time.monotonic() < until
        time.sleep(0.02)


def wait_until_it_moves(process: subprocess.Popen[str], record: Path) -> None:
    """Wait until a recorded run has been under way for a while."""
    log = record / "bus.log"
    until = time.monotonic() + LONG_S
    while not log.exists() or log.stat().st_size < 2_000_000:
        assert process.poll() is None, end(process)
        assert time.monotonic() < until, "the run does not move"
        time.sleep(0.01)


def child_named(session: int, parent: int, place: int) -> int:
    """The process started as number ``place`` by a parent: hub, recorder, joints, ..."""
    children = []
    for pid in processes_of(session):
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        if int(fields[1]) == parent:
            children.append(pid)
    return sorted(children)[place]


def assert_arm_is_braked(log: Path) -> None:
    """What the plant measured last: every joint's brake on, no joint has moved any more."""
    wire = Wire()
    boards = {wire.id(Measure, joint): wire.receiver(Measure, joint) for joint in JOINTS}
    last: dict[int, list[Measure]] = {identifier: [] for identifier in boards}
    for _, frame in read_candump(log)[-500:]:
        if frame.id in boards:
            measure = boards[frame.id].decoder.decode(frame)
            assert isinstance(measure, Measure)
            last[frame.id].append(measure)
    for measures in last.values():
        assert measures[-1].braked
        assert measures[-1].counts == pytest.approx(measures[-3].counts, abs=1)


# --- rfms up ------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_up_starts_nine_processes_and_stops_them_all(begin: Start, number: signal.Signals) -> None:
    process, health = up(begin)
    pids = {node["pid"] for node in health.values()}
    assert list(health) == ["master", *OTHERS]
    assert len(pids) == 9 and pids < set(processes_of(process.pid))
    assert all(node["alive"] and not node["emergency"] for node in health.values())
    if number is signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does: to all of them
    else:
        process.send_signal(number)
    assert end(process).code == 0
    assert_none_left(process.pid)


@pytest.mark.parametrize("victim", ["joint 3", "plant", "master"])
def test_when_one_dies_the_others_are_stopped(begin: Start, victim: str) -> None:
    process, health = up(begin)
    os.kill(health[victim]["pid"], signal.SIGKILL)
    ended = end(process)
    assert ended.code == 1
    assert re.search(rf"rfms: {victim} \(pid \d+\) has ended with exit code -9", ended.err)
    assert_none_left(process.pid)


def test_keep_going_leaves_the_others(begin: Start) -> None:
    process, health = up(begin, "--keep-going")
    os.kill(health["gripper"]["pid"], signal.SIGKILL)
    after = health_of(process, lambda now: not now["gripper"]["alive"])
    assert [node["node"] for node in after.values() if not node["alive"]] == ["gripper"]
    health_of(process, lambda now: all(now[n]["alive"] for n in now if n != "gripper"))
    process.send_signal(signal.SIGINT)
    ended = end(process)
    assert ended.code == 0
    assert "gripper (pid" in ended.err and "the others go on" in ended.err
    assert_none_left(process.pid)


def test_no_orphan_survives_a_killed_parent(begin: Start) -> None:
    process, _ = up(begin)
    assert len(processes_of(process.pid)) == 11  # these nine, the hub, and the parent
    process.kill()
    process.wait(5.0)
    assert_none_left(process.pid)


def test_up_runs_a_program_to_its_end_and_records_it(begin: Start, tmp_path: Path) -> None:
    process = begin("up", SHORT, "--bus", "hub:up", "--record", tmp_path / "run")
    ended = end(process)
    assert ended.code == 0, ended.err
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["cycles"] > 350
    assert (tmp_path / "run" / "bus.log").stat().st_size > 1_000_000
    assert_none_left(process.pid)


def test_up_prints_what_run_prints_and_that_the_master_has_finished(begin: Start) -> None:
    ended = end(begin("up", SHORT, "--bus", "hub:up"))
    assert ended.code == 0, ended.err
    assert re.search(r"master .* finished", ended.err) and " dead " not in ended.err
    assert re.search(r"short_program\s+on\s+puma260,\s+hub:up:\s+tracking", ended.err)
    assert re.search(r"cycles +4\d\d in ", ended.err)


def test_up_with_json_ends_with_the_result(begin: Start) -> None:
    ended = end(begin("up", SHORT, "--bus", "hub:up", "--json"))
    assert ended.code == 0, ended.err
    *health, result = map(json.loads, ended.out.splitlines())
    assert health[-1][0]["node"] == "master" and health[-1][0]["exit_code"] == 0
    assert result["cycles"] > 350 and result["fault"] is None and len(result["joints"]) == 6


def test_up_tells_the_error_of_its_program_or_of_its_run(begin: Start, tmp_path: Path) -> None:
    (tmp_path / "wrong.py").write_text("def program(arm):\n    arm.wait(1)\n")
    ended = end(begin("up", tmp_path / "wrong.py", "--bus", "hub:up"))
    assert ended.code == 1
    (line,) = [text for text in ended.err.splitlines() if text.startswith("rfms: ")]
    assert re.match(
        r"rfms: master \(pid \d+\) has ended with exit code 1: program .*, line 2: ", line
    )
    assert "wait for move 1" in line and line.endswith("; the others are stopped")
    ended = end(begin("up", SHORT, "--bus", "hub:up", "--without", "3", "--patience", "3"))
    assert ended.code == 1
    assert "has ended with exit code 1: not on the bus: joint 3" in ended.err


def test_up_with_a_program_brakes_the_arm_when_it_is_stopped(begin: Start, tmp_path: Path) -> None:
    process = begin("up", TRANSFER, "--bus", "hub:up", "--record", tmp_path / "run")
    wait_until_it_moves(process, tmp_path / "run")
    process.send_signal(signal.SIGTERM)
    assert end(process).code == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["fault"] is None and 50 < summary["cycles"] < 3500
    assert_arm_is_braked(tmp_path / "run" / "bus.log")
    assert_none_left(process.pid)


def test_a_malformed_program_starts_nobody(begin: Start, tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text("def program(arm)\n")
    ended = end(begin("up", tmp_path / "bad.py", "--bus", "hub:up"))
    assert ended.code == 1
    assert ended.err.splitlines() == [f"rfms: program {tmp_path}/bad.py, line 1: expected ':'"]


# --- processes that find each other ---------------------------------------------------------------


def test_runs_attach_to_nodes_that_are_up_one_after_the_other(begin: Start) -> None:
    nodes = begin("up", "--bus", "hub:up", "--without", "8", "--json")
    health_of(nodes, lambda now: all(now[name]["state"] == "PREOP" for name in OTHERS))
    for _ in range(2):
        ended = end(begin("run", SHORT, "--bus", "hub:up", "--attach", "--json"))
        assert ended.code == 0, ended.err
        result = json.loads(ended.out)
        assert result["fault"] is None and result["incomplete"] == 0
    assert nodes.poll() is None
    nodes.send_signal(signal.SIGINT)
    assert end(nodes).code == 0
    assert_none_left(nodes.pid)


def test_single_verbs_make_a_whole_bus(begin: Start, tmp_path: Path) -> None:
    hub = begin("hub", "bench", "--json")
    wait_for_hub(tmp_path, "bench")
    bus = ("--bus", "hub:bench")
    nodes = [begin("joint", str(joint), *bus) for joint in range(1, 7)]
    nodes += [begin("gripper", *bus), begin("plant", *bus)]
    ended = end(begin("master", SHORT, *bus, "--record", tmp_path / "run"))
    assert ended.code == 0, ended.err
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["incomplete"] == 0
    for number, node in enumerate(nodes):
        node.send_signal((signal.SIGINT, signal.SIGTERM)[number % 2])
        assert end(node) == Ended(0, "", "")
    hub.send_signal(signal.SIGINT)
    report = [json.loads(line) for line in end(hub).out.splitlines()]
    assert report[0] == {"ready": "bench"}
    assert report[1]["frames"] > 10_000


def test_a_node_with_another_dbc_is_refused_by_name(begin: Start, tmp_path: Path) -> None:
    other = tmp_path / "other.dbc"
    text = (ROOT / "dbc" / "rfms.dbc").read_text()
    other.write_text(text.replace("[-2|2]", "[-3|3]", 1))
    nodes = begin("up", "--bus", "hub:up", "--without", "3,8", "--json")
    health_of(nodes, lambda now: now["joint 1"]["state"] == "PREOP")
    stranger = begin("joint", "3", "--bus", "hub:up", environment={DBC_VARIABLE: str(other)})
    health_of(nodes, lambda now: now["joint 3"]["state"] == "PREOP")
    ended = end(begin("run", SHORT, "--bus", "hub:up", "--attach", "--json"))
    assert ended.code == 1
    assert ended.err.count("\n") == 1
    assert "joint 3 runs another DBC (hash 0x" in ended.err
    assert "give all nodes the same rfms.dbc" in ended.err
    result = json.loads(ended.out)
    assert result["cycles"] == 0 and "another DBC" in result["fault"]
    assert stranger.poll() is None, "a refused node stays, and drives nothing"


# --- what goes wrong while the arm moves ----------------------------------------------------------


def run_transfer(begin: Start, record: Path, *flags: str) -> subprocess.Popen[str]:
    process = begin("run", TRANSFER, "--bus", "hub:run", "--json", "--record", record, *flags)
    wait_until_it_moves(process, record)
    return process


def test_ctrl_c_stops_the_arm(begin: Start, tmp_path: Path) -> None:
    process = run_transfer(begin, tmp_path / "run")
    os.killpg(process.pid, signal.SIGINT)
    ended = end(process)
    assert ended == Ended(130, "", "rfms: SIGINT ended the run; the arm has been stopped\n")
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["incomplete"] == 0
    assert_arm_is_braked(tmp_path / "run" / "bus.log")
    assert_none_left(process.pid)


def test_a_killed_node_halts_the_run_and_is_named(begin: Start, tmp_path: Path) -> None:
    process = run_transfer(begin, tmp_path / "run", "--barrier", BARRIER)
    os.kill(child_named(process.pid, process.pid, 2 + 2), signal.SIGKILL)
    ended = end(process)
    assert ended.code == 1
    assert re.fullmatch(
        r"rfms: the process of joint 3 \(pid \d+\) has ended with exit code -9\n", ended.err
    )
    result = json.loads(ended.out)
    assert "joint 3" in result["fault"]
    assert json.loads((tmp_path / "run" / "summary.json").read_text()) == result
    assert_arm_is_braked(tmp_path / "run" / "bus.log")
    assert_none_left(process.pid)


def test_a_hub_that_dies_ends_the_run(begin: Start, tmp_path: Path) -> None:
    process = run_transfer(begin, tmp_path / "run")
    os.kill(child_named(process.pid, process.pid, 0), signal.SIGKILL)
    ended = end(process)
    assert ended.code == 1
    assert "rfms: hub 'run' has gone" in ended.err
    assert "Traceback" not in ended.err
    assert_none_left(process.pid)


def test_the_barrier_counts_a_node_that_hangs_and_names_it(begin: Start, tmp_path: Path) -> None:
    process = run_transfer(begin, tmp_path / "run", "--barrier", BARRIER)
    hung = child_named(process.pid, process.pid, 2 + 2)
    os.kill(hung, signal.SIGSTOP)
    time.sleep(1.5 * float(BARRIER))  # less than the three barriers that count as lost
    os.kill(hung, signal.SIGCONT)
    ended = end(process)
    result = json.loads(ended.out)
    assert 1 <= result["incomplete"] <= 3
    assert any("DAC_3" in names for names in result["missing"])


def test_a_node_that_hangs_for_three_barriers_is_lost(begin: Start, tmp_path: Path) -> None:
    process = run_transfer(begin, tmp_path / "run", "--barrier", BARRIER)
    hung = child_named(process.pid, process.pid, 2 + 2)
    os.kill(hung, signal.SIGSTOP)
    ended = end(process)
    assert ended.code == 1
    result = json.loads(ended.out)
    assert result["incomplete"] >= 3
    assert re.fullmatch("joint 3: no (ERROR|DAC)_3 for 3 cycles", result["fault"])
    assert_none_left(process.pid)
