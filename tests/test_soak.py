"""The soak: what it measures, that it sees what is wrong, and a few programs of it."""

from pathlib import Path
from random import Random

import numpy as np
import pytest
from soak.bounds import QUANTITIES, bound_of
from soak.kinds import KINDS, Job, jobs_of
from soak.margins import COLUMNS, GROUPS, Array, Cycles, Largest, Scales, heat, lasting, longest
from soak.results import FILE, Conditions
from soak.table import beyond_bounds
from soak.trial import run
from soak.watch import Watch

from rfms_can.arm import PUMA_560
from rfms_can.coordinator import Arm
from rfms_can.engine import Serial, carry_out
from rfms_can.engine import run as run_jobs
from rfms_can.plant.imperfect_board import BoardErrors, ImperfectBoard
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig

PERIOD_S = 0.004
SCALES = Scales.of(PUMA_560, PERIOD_S)


def moving(fraction: float = 0.5, cycles: int = 60) -> Array:
    """Rows of joints that turn at a part of their speed limits, sound in everything."""
    rows = np.zeros((cycles, len(COLUMNS), 6))
    speed = fraction * SCALES.speed
    time = PERIOD_S * np.arange(cycles)[:, None]
    set_column(rows, "counts", np.round(time * speed / SCALES.step))
    set_column(rows, "speed", speed)
    set_column(rows, "tachometer", np.arange(cycles, dtype=float)[:, None] % 2.0)
    set_column(rows, "current", 500.0)
    set_column(rows, "dac", 500.0)
    for name in ("rigid", "driven", "servoed"):
        set_column(rows, name, 1.0)
    return rows


def set_column(rows: Array, name: str, values: Array | float) -> None:
    rows[:, COLUMNS.index(name), :] = values


def found(rows: Array) -> Largest:
    """All quantities but heat."""
    cycles = Cycles.of(rows)
    return {name: values for group in GROUPS for name, values in group(cycles, SCALES).items()}


def test_sound_joints_are_far_from_all_bounds() -> None:
    margins = found(moving())
    assert margins["speed"] == pytest.approx(0.5)
    for name in ("sensors apart", "current off, 1", "speed error, 1", "mean tachometer over"):
        assert margins[name].max() < 1e-6, name
    assert margins["encoder stands, 0.05"].max() == 0


def test_an_encoder_that_stands_is_seen_cycle_by_cycle() -> None:
    rows = moving()
    rows[20:33, COLUMNS.index("counts"), 2] = rows[20, COLUMNS.index("counts"), 2]
    margins = found(rows)
    assert margins["encoder stands, 0.05"].tolist() == [0, 0, 12, 0, 0, 0]
    catching_up = 12 * 0.5 - 0.035  # in the one cycle in which it counts again
    assert margins["sensors apart"][2] == pytest.approx(catching_up, rel=0.02)


def test_a_tachometer_that_stands_is_seen() -> None:
    rows = moving()
    rows[10:40, COLUMNS.index("tachometer"), 5] = 7.0
    assert found(rows)["tachometer stands, 0.05"].tolist() == [0, 0, 0, 0, 0, 29]


def test_a_current_is_compared_with_the_dac_of_two_cycles_before() -> None:
    rows = moving()
    column = COLUMNS.index("current")
    rows[30, COLUMNS.index("dac"), 1] = 900.0
    assert found(rows)["current off, 1"][1] == 400.0
    rows[32, column, 1] = 900.0
    assert found(rows)["current off, 1"].max() == 0.0
    rows[40:43, column, 4] -= 80.0
    margins = found(rows)
    assert [margins[f"current off, {n}"][4] for n in (1, 2, 3, 4)] == [80.0, 80.0, 80.0, 0.0]
    assert margins["current over, 1"][4] == pytest.approx(30.0)


def test_an_error_of_speed_must_last_and_keep_its_sign() -> None:
    rows = moving()
    rate = COLUMNS.index("rate")
    rows[10:14, rate, 0] = 0.2 * SCALES.speed[0] * np.array([1.0, -1.0, 1.0, 1.0])
    margins = found(rows)
    assert margins["speed error, 2"][0] == pytest.approx(0.2)
    assert margins["speed error, 3"][0] == 0.0
    set_column(rows, "rigid", 0.0)
    assert found(rows)["speed error, 1"][0] == 0.0


def test_heat_is_whole_after_five_seconds_at_the_limit_and_fades() -> None:
    torque = np.tile(SCALES.torque, (round(5.0 / PERIOD_S), 1))
    most, last = heat(torque, SCALES, np.zeros(6))
    assert most == pytest.approx(1.0)
    assert heat(0.0 * torque, SCALES, last)[1] == pytest.approx(0.4375)
    assert heat(0.5 * torque, SCALES, np.zeros(6))[0].max() < 1e-3


def test_what_lasts_and_how_long() -> None:
    values = np.zeros((6, 6))
    values[:, 0] = [3.0, -2.0, -5.0, -4.0, 1.0, 0.0]
    assert [lasting(values, n)[0] for n in (1, 2, 3, 4)] == [5.0, 4.0, 2.0, 0.0]
    assert longest(values < 0.0).tolist() == [3, 0, 0, 0, 0, 0]


def test_every_quantity_of_the_page_is_measured() -> None:
    measured = {*found(moving()), "heat"}
    assert [name for name in QUANTITIES if name not in measured] == []
    assert bound_of("speed") is not None
    assert bound_of("current off, 1") is None


def test_every_kind_draws_the_same_program_settings_from_a_seed() -> None:
    for job in jobs_of(list(KINDS), ["puma560", "puma260"], range(1)):
        first, again = (job.drawn(job.draw) for _ in range(2))
        assert (first.settings, first.load, first.starts) == (
            again.settings,
            again.load,
            again.starts,
        )
        assert job.settings(first, 0) == job.settings(again, 0)


@pytest.mark.system
def test_a_tachometer_that_is_wrong_shows_in_a_run() -> None:
    """The watch has to see more than worn boards make, or its margins would mean nothing."""
    watches: list[Watch] = []

    def program(arm: Arm) -> None:
        there = arm.joint_position("there", [q + 0.6 for q in PUMA_560.park])
        arm.wait(arm.move(there, arm.mode("go", joint_speed=0.8, acceleration_time=0.2)))

    def begin(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        errors, physics = BoardErrors(tachometer_gain=1.3), rig.plant.physics
        wrong = ImperfectBoard(PUMA_560, 3, physics.true_q[3], errors, Random(0))
        physics.exchange_board(3, lambda _: wrong)
        watches.append(Watch(PUMA_560, PERIOD_S))
        watches[0].attach(rig)

    execute(program, RunSettings(arm="puma560"), watch=begin)
    watches[0].close()
    largest = watches[0].largest
    assert largest["mean tachometer over"][3] > 0.02
    assert np.delete(largest["mean tachometer over"], 3).max() < 0.005


JOBS = [
    Job("conveyor", "puma260", 3),
    Job("floating", "puma260", 2),
    Job("guarded", "puma560", 3),
    Job("restarts", "puma260", 1),
    Job("strokes", "puma560", 5),
]


@pytest.mark.system
def test_a_few_programs_trip_nothing(tmp_path: Path) -> None:
    file = tmp_path / "soak.jsonl"
    conditions = Conditions(RunSettings().rate)
    results = carry_out(
        JOBS,
        lambda left: run_jobs(run, left, Serial()),
        FILE.open(file, conditions),
        what="programs",
        job_key=lambda job: job,
        result_key=lambda result: result.job,
    )
    assert [result.trips for result in results] == [[]] * len(JOBS)
    assert [result.job for result in results if result.passed] == [JOBS[0], JOBS[2]]
    assert FILE.read(file)[1] == results
    assert results[3].cycles - results[3].enabled > 500, "each start homes"
    assert beyond_bounds(results) == []
