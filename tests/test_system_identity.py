"""One program, three buses: every payload of every cycle from enable on is the same."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from support.system import ROOT, SHORT

from rfms_can.rig.candump import Cycle, cycles_from_enable, read_candump
from rfms_can.rig.program import load_program
from rfms_can.rig.record import LOG
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.contract import Wire

VCAN = "socketcan:vcan0"
CONVEYOR = ROOT / "examples" / "conveyor.py"
"""A program that is part of the clock: what its camera sees depends on the arm's time."""
PEG = Path(__file__).parent / "support" / "programs" / "short_peg.py"
"""Force control: COMPLY, BIAS and FORCE, rows that comply, contact in the plant."""
IN_A_HOLE: dict[str, Any] = {
    "arm": "puma560",
    "scene": "peg:x_mm=0.8,tilt_y_deg=0.4",
    "friction": "thesis",
    "dither": 0.9,
    "sensor": "good",
}


def cycles(
    directory: Path, bus: str, seed: int = 1, program: Path = SHORT, **settings: Any
) -> list[Cycle]:
    """Cycles of a recorded run of a program, which ends well."""
    made = RunSettings(bus=bus, seed=seed, **settings)
    outcome = execute(load_program(program), made, record=directory)
    assert outcome.fault is None
    assert outcome.result.incomplete == 0
    summary = json.loads((directory / "summary.json").read_text())
    recorded = cycles_from_enable((f for _, f in read_candump(directory / LOG)), Wire())
    assert len(recorded) == summary["cycles"]
    return recorded


@cache
def on_the_simulated_bus(directory: Path, program: Path = SHORT) -> list[Cycle]:
    return cycles(directory, "sim", program=program, **(IN_A_HOLE if program == PEG else {}))


@pytest.fixture
def simulated(tmp_path_factory: pytest.TempPathFactory) -> list[Cycle]:
    return on_the_simulated_bus(tmp_path_factory.getbasetemp() / "simulated")


@pytest.fixture
def simulated_conveyor(tmp_path_factory: pytest.TempPathFactory) -> list[Cycle]:
    return on_the_simulated_bus(tmp_path_factory.getbasetemp() / "conveyor", CONVEYOR)


@pytest.fixture
def simulated_peg(tmp_path_factory: pytest.TempPathFactory) -> list[Cycle]:
    return on_the_simulated_bus(tmp_path_factory.getbasetemp() / "peg", PEG)


def assert_same(found: list[Cycle], expected: list[Cycle]) -> None:
    """Equal, or the first frames that differ."""
    for number, (one, other) in enumerate(zip(found, expected, strict=False)):
        assert one == other, f"cycle {number}: {sorted(set(one) ^ set(other))}"
    assert len(found) == len(expected)


@pytest.mark.system
def test_the_program_has_it_all(simulated: list[Cycle]) -> None:
    """What the identity below is worth: joint and straight motion, the gripper, every frame."""
    wire = Wire()
    identifiers = {identifier for cycle in simulated for identifier, _ in cycle}
    usual = ("MEASURE_7", "SETPOINT_1", "GRIPPER", "ERROR_6", "DAC_7", "ROWS_6", "HEARTBEAT_9")
    assert {wire.codecs[name].id for name in usual} <= identifiers
    assert wire.codecs["EMCY_1"].id not in identifiers
    assert 350 < len(simulated) < 600  # 1.5 to 2.4 s


@pytest.mark.system
def test_a_run_repeats_to_the_bit(simulated: list[Cycle], tmp_path: Path) -> None:
    assert_same(cycles(tmp_path, "sim"), simulated)


@pytest.mark.system
def test_another_seed_is_told_apart(simulated: list[Cycle], tmp_path: Path) -> None:
    """The comparison can fail: boot ids stand in the heartbeats, and nothing else differs."""
    wire = Wire()
    beats = {wire.codecs[f"HEARTBEAT_{node}"].id for node in range(1, 10)}
    different = {
        identifier
        for one, other in zip(cycles(tmp_path, "sim", seed=2), simulated, strict=True)
        for identifier, _ in set(one) ^ set(other)
    }
    assert different == beats


@pytest.mark.processes
def test_nine_processes_on_the_hub_say_the_same(
    simulated: list[Cycle], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert_same(cycles(tmp_path / "hub", "hub:identity"), simulated)


@pytest.mark.vcan
def test_nine_processes_on_vcan0_say_the_same(simulated: list[Cycle], tmp_path: Path) -> None:
    assert_same(cycles(tmp_path, VCAN), simulated)


@pytest.mark.processes
def test_a_camera_and_a_belt_are_the_same_on_the_hub(
    simulated_conveyor: list[Cycle], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert_same(cycles(tmp_path / "hub", "hub:conveyor", program=CONVEYOR), simulated_conveyor)


@pytest.mark.vcan
def test_a_camera_and_a_belt_are_the_same_on_vcan0(
    simulated_conveyor: list[Cycle], tmp_path: Path
) -> None:
    assert_same(cycles(tmp_path, VCAN, program=CONVEYOR), simulated_conveyor)


@pytest.mark.system
def test_the_peg_has_what_force_control_sends(simulated_peg: list[Cycle]) -> None:
    wire = Wire()
    sent = [identifier for cycle in simulated_peg for identifier, _ in cycle]
    for name in ("COMPLY", "BIAS", "FORCE"):
        assert sent.count(wire.codecs[name].id) > 120
    assert len(simulated_peg) < 1700


@pytest.mark.processes
def test_a_peg_goes_in_the_same_on_the_hub(
    simulated_peg: list[Cycle], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    found = cycles(tmp_path / "hub", "hub:peg", program=PEG, **IN_A_HOLE)
    assert_same(found, simulated_peg)


@pytest.mark.vcan
def test_a_peg_goes_in_the_same_on_vcan0(simulated_peg: list[Cycle], tmp_path: Path) -> None:
    assert_same(cycles(tmp_path, VCAN, program=PEG, **IN_A_HOLE), simulated_peg)
