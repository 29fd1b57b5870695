"""A recorded run is read back as it was: no value of the bus is lost or moved to another cycle."""

import gzip
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.bus_nodes import Listener
from support.programs.there_and_back import FAR, LONG

from rfms_can.analysis.motions import motions, thesis_motions
from rfms_can.analysis.recording import Recording, RecordingError, load_recording
from rfms_can.coordinator import Arm
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import ESTOP_VALUES, Wire
from rfms_can.wire.nodes import HEARTBEAT_EVERY
from rfms_can.wire.records import Estop
from rfms_can.wire.vocabulary import Mode

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def recording(recorded: Path, wire: Wire) -> Recording:
    return load_recording(recorded, wire)


def test_every_cycle_is_there_once_and_whole(recording: Recording, recorded: Path) -> None:
    log = recording.log
    summary = json.loads((recorded / "summary.json").read_text())
    assert log.cycle.tolist() == list(range(len(log.cycle)))
    assert len(log.cycle) == summary["cycles"] == len(recording.commanded)
    assert log.refused == 0
    for values in (log.counts, log.velocity_codes, log.errors, log.current_codes, log.gravity):
        assert values.shape == (len(log.cycle), 6)
        assert np.isfinite(values).all()


def test_the_blend_is_that_of_the_settings(recorded: Path, recording: Recording) -> None:
    settings = json.loads((recorded / "settings.json").read_text())["settings"]
    assert recording.blend == settings["blend"] == "continuous"


def test_commanded_less_measured_is_the_error_the_nodes_sent(recording: Recording) -> None:
    difference = recording.commanded - recording.q
    assert np.abs(difference - recording.log.errors).max() < 1e-5  # float32 on the wire


def test_measured_speed_is_the_slope_of_measured_position(recording: Recording) -> None:
    slope = np.gradient(recording.q[:, 0], recording.period_s)[2:-2]
    assert np.abs(slope).max() > 0.3
    count = 1.0 / abs(recording.counts_per_radian[0])
    acceleration = np.nanmax(np.abs(recording.derivative(2)[:, 0]))
    tolerance = count / recording.period_s + 0.5 * acceleration * recording.period_s
    assert np.abs(slope - recording.speed[2:-2, 0]).max() < tolerance


def test_torque_moves_the_joint_and_holds_gravity(recording: Recording) -> None:
    torque, limits = recording.torque, [d.torque_limit for d in recording.arm.drives]
    assert (np.abs(torque).max(axis=0) < limits).all()
    starts = motions(recording)[0].start
    assert np.abs(torque[0] - recording.log.gravity[0]).max() < 0.1  # at rest, before any motion
    assert torque[starts + 8, 0] - torque[starts, 0] > 0.3  # joint 1 is pushed its way


def test_bus_load_is_what_the_bus_counted(recording: Recording, recorded: Path) -> None:
    summary = json.loads((recorded / "summary.json").read_text())
    time, load = recording.bus_load()
    assert recording.load_window % HEARTBEAT_EVERY == 0
    assert load.mean() == pytest.approx(summary["bus_load"], rel=0.02)
    assert (load < recording.bus_bound).all()
    assert recording.bus_bound == summary["bus_bound"]
    assert (np.diff(time) > 0).all()


def test_derivatives_of_a_cubic_are_exact(recording: Recording) -> None:
    period = recording.period_s
    t = np.arange(40)[:, None] * period
    cubic = Recording(**{**vars_of(recording), "commanded": np.repeat(t**3, 6, axis=1)})
    assert cubic.derivative(3)[2:-2] == pytest.approx(6.0, rel=1e-6)
    assert cubic.derivative(2)[1:-1] == pytest.approx(6.0 * np.repeat(t, 6, axis=1)[1:-1], abs=1e-9)
    assert cubic.derivative(1)[1:-1, 0] == pytest.approx(3.0 * t[1:-1, 0] ** 2 + period**2)
    assert np.isnan(cubic.derivative(3)[[0, 1, -2, -1]]).all()


def vars_of(recording: Recording) -> dict[str, Any]:
    """The fields a recording was made of."""
    return {name: getattr(recording, name) for name in Recording.__dataclass_fields__}


def test_motions_are_found_from_rest_to_rest(recording: Recording) -> None:
    found = motions(recording)
    assert [[move.sequence for move in motion.moves] for motion in found] == [
        [number] for number in range(1, 7)
    ]
    assert [motion.mode for motion in found] == [Mode.JOINT] * 4 + [Mode.CARTESIAN, Mode.JOINT]
    for motion in found:
        before, after = motion.places
        assert abs(after[0] - before[0]) == pytest.approx(FAR, abs=1e-6)  # poses are float32


def test_thesis_motions_are_one_way_three_times(recording: Recording) -> None:
    joint, longer, cartesian = thesis_motions(recording)
    assert [m.moves[0].sequence for m in (joint, longer, cartesian)] == [1, 3, 5]
    assert longer.acceleration_time == pytest.approx(LONG)


def test_a_run_without_the_three_motions_says_what_is_needed(recording: Recording) -> None:
    log = recording.log
    shorter = log._replace(mode=np.where(log.state >= 0, int(Mode.JOINT), -1))
    without = Recording(**{**vars_of(recording), "log": shorter})
    with pytest.raises(RecordingError, match=r"examples/figures\.py"):
        thesis_motions(without)


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "copy"))


def test_a_corrupt_frame_is_left_out_and_counted(copy: Path, wire: Wire) -> None:
    lines = (copy / "bus.log").read_text().splitlines()
    place = max(i for i, line in enumerate(lines) if " 101##" in line and i < len(lines) // 2)
    last = lines[place][-1]
    lines[place] = lines[place][:-1] + ("0" if last != "0" else "1")
    (copy / "bus.log").write_text("\n".join(lines) + "\n")
    damaged = load_recording(copy, wire)
    assert damaged.log.refused == 1
    assert np.isnan(damaged.log.counts[:, 0]).sum() == 1
    assert np.isfinite(damaged.log.counts[:, 1:]).all()


@pytest.mark.parametrize("name", ["bus.log", "settings.json", "summary.json", "commanded.csv"])
def test_a_missing_file_is_named(copy: Path, name: str) -> None:
    (copy / name).unlink()
    with pytest.raises(RecordingError, match=name):
        load_recording(copy)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("bus.log", "", "none of its 0 frames"),
        ("bus.log", "(0.1) can0 123#00\n", "none of its 1 frames"),
        ("bus.log", "hello\n", "not a candump line"),
        ("settings.json", "{}", "settings"),
        ("settings.json", "not json", "JSON"),
        ("summary.json", "[]", "object"),
        ("commanded.csv", "cycle,q1\n0,1\n", "rows must be"),
        ("commanded.csv", "cycle,q1,q2,q3,q4,q5,q6\n5,1,2,3,4,5,6\n", "rows must be"),
        ("commanded.csv", "cycle\nx,y\n", "could not convert"),
    ],
)
def test_a_broken_file_is_one_clear_line(copy: Path, name: str, text: str, says: str) -> None:
    (copy / name).write_text(text)
    with pytest.raises(RecordingError, match=says) as caught:
        load_recording(copy)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_binary_log_is_one_clear_line(copy: Path) -> None:
    (copy / "bus.log").write_bytes(gzip.compress(b"(0.1) can0 123#00\n"))
    with pytest.raises(RecordingError, match=r"bus\.log"):
        load_recording(copy)


def test_no_directory_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="is not a directory"):
        load_recording(tmp_path / "nowhere")


def test_a_halted_run_shows_how_it_stopped(tmp_path: Path, wire: Wire) -> None:
    button = Listener("button", frozenset())
    estop = wire.sender(Estop).frame(*ESTOP_VALUES)
    press: list[Callable[[], None]] = []

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        bus, controller = rig.bus, rig.bus.attach(button)
        press.append(lambda: bus.send(controller, [estop]))

    def emergency(arm: Arm) -> None:
        arm.sleep(0.1)
        press[0]()
        arm.sleep(0.1)

    outcome = execute(emergency, RunSettings(), record=tmp_path, watch=watch)
    assert outcome.fault is not None
    halted = load_recording(tmp_path, wire)
    assert halted.summary.fault == "emergency stop on the bus"
    after = len(halted.commanded) + 2
    assert len(halted.log.cycle) > after + 20
    assert np.isfinite(halted.q[after:]).all()
    assert np.isnan(halted.error_counts[after:]).all()
    assert motions(halted) == []
