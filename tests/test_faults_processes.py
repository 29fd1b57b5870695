"""Faults of processes on a hub: a trial of each, and that no process is left whatever ends it."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.command_line import assert_none_left, end, kill, processes_of, start

from rfms_can.cli.app import main
from rfms_can.faults.processes.command import SEAM_SIGNAL, Command
from rfms_can.faults.processes.injectors import PROCESS_INJECTORS
from rfms_can.faults.processes.system import System
from rfms_can.faults.processes.trial import made
from rfms_can.faults.table import GOES_ON, Where, variants
from rfms_can.faults.trial import Result, Trial

pytestmark = pytest.mark.processes

ALL = [(row, variant) for row, variant in variants() if variant.where is Where.PROCESSES]
NAMES = [variant.name for _, variant in ALL]
NOT_YET = {
    "start_master": "the master takes no notice of another one",
}
"""What the system does not do yet; the row is not met."""
RACES = ("brakes of joints that are sound", "asks for torque after its brake")
"""A halted master waits for no joint: one that is late is braked, now and then (docs/faults.md)."""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Result]]:
    """A trial of each variant."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
        yield {
            variant.name: made(Trial(row, variant.name, "puma260", 1), "hub:trial", main)
            for row, variant in ALL
        }


@pytest.mark.parametrize("name", NAMES)
def test_each_fault_of_processes_is_found_named_and_survived(
    results: dict[str, Result], name: str
) -> None:
    if name in NOT_YET:
        assert results[name].problems, f"not true any more: {NOT_YET[name]}; take it out"
        return
    facts = results[name].facts
    assert facts is not None, results[name].problems
    problems = [why for told in results[name].problems for why in told.split("; ")]
    assert [why for why in problems if not any(race in why for race in RACES)] == []
    assert facts.left == []


@pytest.mark.parametrize("name", [v.name for _, v in ALL if v.expected in GOES_ON])
def test_what_must_not_matter_does_not(results: dict[str, Result], name: str) -> None:
    facts = results[name].facts
    assert facts is not None
    assert (facts.exit_code, facts.named, facts.reactions) == (0, "", [0] * 6)
    assert 0.5 < facts.speed < 1.0, "the arm has gone on"
    if name == "full_disk":
        assert facts.unrecorded == ["bus.log is cut: File too large"]


@pytest.fixture
def begun(runtime: Path) -> Iterator[int]:
    """A campaign whose first system is up; its process id."""
    process = start("faults", "--bus", "hub", "--rows", "11", "--seeds", "1", "--arm", "puma260")
    until = time.monotonic() + 30.0
    while not systems(process.pid):
        assert time.monotonic() < until
        assert process.poll() is None, end(process)
        time.sleep(0.05)
    yield process.pid
    for session in systems(process.pid):
        os.kill(session, signal.SIGKILL)
    kill(process)
    process.wait(10.0)
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()


def systems(campaign: int) -> list[int]:
    """Sessions of the commands that a campaign has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == campaign and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found if len(found) > 1 else []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_whatever_ends_a_campaign_leaves_no_process(begun: int, number: signal.Signals) -> None:
    sessions = systems(begun)
    time.sleep(1.0)  # until the nodes are there
    assert sum(len(processes_of(session)) for session in sessions) > len(sessions)
    os.kill(begun, number)
    for session in (*sessions, begun):
        assert_none_left(session, within_s=20.0)


def test_a_trial_that_breaks_off_is_not_met_and_leaves_no_process(
    runtime: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    seen: dict[int, int] = {}

    def broken(system: System) -> None:
        assert system.hub is not None
        for session in (system.hub.pid, system.up.pid):
            seen[session] = len(processes_of(session))
        raise ValueError("no such thing")

    injector = PROCESS_INJECTORS["kill_joint"]._replace(make=broken)
    monkeypatch.setitem(PROCESS_INJECTORS, "kill_joint", injector)
    result = made(Trial(11, "kill_joint", "puma260", 0), "hub:broken", main)
    assert result.problems == ["the trial broke off: ValueError: no such thing"]
    assert "no such thing" in capfd.readouterr().err
    assert list(seen.values()) == [1, 10]
    for session in seen:
        assert processes_of(session) == []


def test_a_system_that_does_not_come_up_says_why(runtime: Path) -> None:
    def broken() -> None:
        raise SystemExit(3)

    result = made(Trial(11, "kill_joint", "puma260", 0), "hub:none", broken)
    assert result.problems == [
        "the trial broke off: RfmsError: the system did not come up: no word"
    ]


def test_a_command_is_as_a_shell_starts_it(tmp_path: Path) -> None:
    told: list[int] = []

    def shows() -> None:
        print("out", os.getsid(0) == os.getpid())
        signal.pause()
        raise SystemExit(5)

    command = Command(shows, ["a", "b"], tmp_path, lambda: told.append(1))
    until = time.monotonic() + 10.0
    while "True" not in (command.out.read_text() if command.out.exists() else ""):
        assert time.monotonic() < until
    command.signal(SEAM_SIGNAL)
    assert command.end() == []
    assert command.exit_code in (5, 1)
    assert told == [], "it is another process"
