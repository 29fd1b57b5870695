"""The procedure over the simulated bus: parts of it, interrupted, resumed, and of what worth."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command_line import MAIN, Rfms
from support.identification import ideal_data

from rfms_can.arm import arm_by_name
from rfms_can.identification.compensation_comparison import (
    IDENTIFIED,
    UNCOMPENSATED,
    compare,
    compensations,
)
from rfms_can.identification.experiments.data import Data, DataError, fingerprint, load, save
from rfms_can.identification.experiments.plan import Experiment, experiments
from rfms_can.identification.experiments.procedure import run_all, run_one, tasks_of
from rfms_can.identification.fit.identify import _stretched
from rfms_can.identification.fit.torque import (
    KnownLoad,
    fit_vertical_joint,
    fit_weight_loaded_joint,
)
from rfms_can.identification.fit.trace import converter_fits, trace_of
from rfms_can.identification.fit.truth import truth_of
from rfms_can.identification.fit.windows import windows_of
from rfms_can.plant.variant import make_variant
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig, Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

pytestmark = pytest.mark.system

ARM = arm_by_name("puma560")
SETTINGS = RunSettings(arm="puma560", plant="table41")
VARIANT = make_variant("table41", ARM, "corke")


class Quiet:
    """A watcher that remembers."""

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.ended: list[tuple[str, bool]] = []

    def begin(self, experiment: Experiment) -> None:
        self.begun.append(experiment.name)

    def cycles(self, session: Session) -> None:
        assert session.master.fault is None

    def end(self, experiment: Experiment, kept: bool) -> None:
        self.ended.append((experiment.name, kept))


def short(*names: str) -> list[Experiment]:
    """Experiments, with the first of their actions alone; friction takes two speeds."""
    chosen = {e.name: e for e in experiments(ARM) if e.name in names}
    return [
        replace(
            chosen[name], actions=chosen[name].actions[: 2 if name in ("sweep-1", "sweep-3") else 1]
        )
        for name in names
    ]


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Data]:
    plan = short("sweep-1", "sweep-3", "sweep-3-load", "burst-1", "burst-1-load")
    tasks = tasks_of(plan, SETTINGS, tmp_path_factory.mktemp("data"))
    return dict(run_all(tasks, Quiet(), jobs=2))


def test_table_4_1_over_the_bus(part: dict[str, Data]) -> None:
    """Joint 3 by the load's weight, joint 1 by its inertia."""
    data = part
    converters = converter_fits(ARM, list(data.values()))
    traces = {name: trace_of(ARM, each, converters) for name, each in data.items()}
    windows = [w for trace in traces.values() for w in windows_of(trace)]
    known = KnownLoad.of(ARM)
    third = fit_weight_loaded_joint([w for w in windows if w.joint == 2], known, "joint 3")
    first = fit_vertical_joint(
        [w for w in windows if w.joint == 0], _stretched(traces), 0.004, known, "joint 1"
    )
    for joint, found in ((0, first.law), (2, third.law)):
        true = VARIANT.laws[joint]
        for side in ("positive", "negative"):
            for name, bound in (("slope", 0.01), ("offset", 0.05)):
                value, wanted = (getattr(law, f"{name}_{side}") for law in (found, true))
                assert value == pytest.approx(wanted, rel=bound), (joint, name, side)
    for fit in converters:
        assert fit.values["slope"] == pytest.approx(0.92, rel=1e-3)
        assert fit.values["offset"] == pytest.approx(-11.0, abs=0.2)


def test_data_are_the_same_whoever_runs_the_experiment(
    part: dict[str, Data], tmp_path: Path
) -> None:
    (experiment,) = short("burst-1-load")
    (task,) = tasks_of([experiment], SETTINGS, tmp_path)
    again = run_one(task)
    np.testing.assert_array_equal(again.table, part["burst-1-load"].table)


def test_what_is_there_is_kept_and_the_rest_is_run(tmp_path: Path) -> None:
    tasks = tasks_of(short("burst-3", "burst-wrist"), SETTINGS, tmp_path)
    first, second = tasks
    made = ideal_data(first.experiment, VARIANT)
    save(first.path, made, first.digest)
    watcher = Quiet()
    found = run_all(tasks, watcher)
    assert watcher.ended == [("burst-3", True), ("burst-wrist", False)]
    assert watcher.begun == ["burst-wrist"]
    np.testing.assert_array_equal(found["burst-3"].table, made.table)
    assert load(second.path, second.digest) is not None


def test_an_interrupt_ends_the_procedure_and_keeps_what_is_whole(tmp_path: Path) -> None:
    tasks = tasks_of(short("burst-wrist", "burst-3", "sweep-1"), SETTINGS, tmp_path)
    watcher = Quiet()
    with pytest.raises(KeyboardInterrupt):
        run_all(tasks, watcher, interrupted=lambda: bool(watcher.ended))
    assert [path.name for path in tmp_path.iterdir()] == ["burst-wrist.npz"]
    found = run_all(tasks[:2], watcher)
    assert watcher.ended[1:] == [("burst-wrist", True), ("burst-3", False)]
    assert found.keys() == {"burst-wrist", "burst-3"}


def test_data_of_another_plant_are_refused(tmp_path: Path) -> None:
    (experiment,) = short("burst-3")
    (task,) = tasks_of([experiment], SETTINGS, tmp_path)
    (other,) = tasks_of([experiment], replace(SETTINGS, plant="nominal"), tmp_path)
    save(task.path, ideal_data(experiment, VARIANT), task.digest)
    with pytest.raises(DataError, match="another experiment, arm, plant or rate"):
        run_all([other], Quiet())
    task.path.write_bytes(b"torn")
    with pytest.raises(DataError, match="remove it"):
        run_all([task], Quiet())
    assert fingerprint(experiment, SETTINGS) != fingerprint(experiment, other.settings)


def test_cut_and_damaged_data_are_refused_in_one_line(tmp_path: Path) -> None:
    (experiment,) = short("burst-3")
    (task,) = tasks_of([experiment], SETTINGS, tmp_path)
    save(task.path, ideal_data(experiment, VARIANT), task.digest)
    whole = task.path.read_bytes()
    draw = random.Random(12)
    broken = [whole[:length] for length in (0, 1, 3, 4, 30, 100, len(whole) // 2, len(whole) - 1)]
    for _ in range(200):
        damaged = bytearray(whole)
        damaged[
            draw.choice((draw.randrange(120), draw.randrange(len(whole)), -draw.randrange(1, 200)))
        ] ^= 1 << draw.randrange(8)
        broken.append(bytes(damaged))
    for data in broken:
        task.path.write_bytes(data)
        try:
            assert load(task.path, task.digest) is not None  # a byte that means nothing
        except DataError as error:
            assert re.search(r"name another directory", str(error))
            assert "\n" not in str(error)
    task.path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match=r"burst-3\.npz: File is not a zip file; remove it"):
        run_all([task], Quiet())


def test_knowing_the_arm_is_worth_a_fifth_of_the_error(tmp_path: Path) -> None:
    """With what a perfect experiment finds; a real one comes within 1.2 of it."""
    truth = truth_of(VARIANT)
    runs = compensations(SETTINGS, tmp_path, truth, None)
    chosen = {name: runs[name] for name in (UNCOMPENSATED, IDENTIFIED)}
    none, identified = compare(chosen, jobs=2)
    assert identified.rms < 0.2 * none.rms
    assert identified.largest < 0.2 * none.largest


@pytest.mark.parametrize("seed", [1, 2, 4])
def test_a_start_without_a_probe_ends_in_homing_and_not_in_a_stop(seed: int) -> None:
    """The guard of homing: joints 1, 2 and 6 count backwards here."""
    rigs: list[SimulatedRig] = []

    def keep(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rigs.append(rig)

    settings = replace(SETTINGS, plant=f"perturbed:{seed}")
    signs = [w.encoder_sign for w in make_variant(settings.plant, ARM, "corke").board_errors]
    outcome = execute(lambda arm: None, settings, watch=keep)
    reversed_joint = signs.index(-1) + 1
    told = rf"joint {reversed_joint}: SENSOR_MISMATCH \("
    assert re.match(told, str(outcome.fault)), outcome.fault
    moved = zip(rigs[0].plant.physics.true_q, ARM.park, strict=True)
    assert max(abs(q - park) for q, park in moved) < 0.2


# --- the command -----------------------------------------------------------------------------


def all_data(directory: Path, plant: str) -> None:
    """Data of all experiments, as an earlier run would have left them."""
    settings = replace(SETTINGS, plant=plant)
    variant = make_variant(plant, ARM, "corke")
    for task in tasks_of(experiments(ARM), settings, directory):
        save(task.path, ideal_data(task.experiment, variant), task.digest)


def test_the_command_writes_a_calibration_a_run_can_use(tmp_path: Path, rfms: Rfms) -> None:
    all_data(tmp_path / "data", "table41")
    out, arguments = tmp_path / "arm.toml", ("--arm", "puma560", "--plant", "table41")
    where = ("--out", str(out), "--data", str(tmp_path / "data"))
    ended = rfms("identify", *arguments, *where, "--json")
    told = json.loads(ended.out)
    assert told["constants"]["b12"]["verdict"] == "impossible"
    assert abs(told["constants"]["c21"]["error"]) < 0.02
    plots = ("--report", str(tmp_path / "figures"))
    ended = rfms("identify", *arguments, *where, *plots)
    for line in ("Table 4.1", "impossible: positive", "Newton-Euler, whole", str(out)):
        assert line in ended.out
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        "fig_4_1.png",
        "fig_4_2.png",
        "inertia.png",
    }
    assert RunSettings(arm="puma560", calibration=str(out)).master().calibration is not None


def test_the_command_refuses_an_encoder_that_counts_backwards(tmp_path: Path, rfms: Rfms) -> None:
    out = tmp_path / "arm.toml"
    arguments = ("--arm", "puma560", "--plant", "perturbed:1", "--out", str(out))
    ended = rfms("identify", *arguments)
    assert "joint 1: its encoder counts backwards" in ended.complaint
    assert not out.exists()


def test_a_killed_procedure_goes_on_where_it_was(tmp_path: Path) -> None:
    """SIGKILL, as when the power goes."""
    data = tmp_path / "data"
    command = [sys.executable, "-c", MAIN]
    command += ["identify", "--arm", "puma560", "--plant", "table41", "--jobs", "1"]
    command += ["--data", str(data), "--out", str(tmp_path / "arm.toml")]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 300.0
    while not list(data.glob("*.npz")) and time.monotonic() < until:
        assert process.poll() is None
        time.sleep(0.1)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in data.glob("*.npz")}
    assert kept and not (tmp_path / "arm.toml").exists()
    tasks = tasks_of(experiments(ARM), SETTINGS, data)
    for task in tasks:  # what is missing, without the hour it would take here
        if load(task.path, task.digest) is None:
            save(task.path, ideal_data(task.experiment, VARIANT), task.digest)
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert (tmp_path / "arm.toml").exists()
