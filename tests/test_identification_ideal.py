"""The whole analysis on data of arms that follow perfectly: Table 4.1, and arms drawn by a seed."""

from dataclasses import replace

import numpy as np
import pytest
from support.identification import ideal_data, ideal_experiments

from rfms_can.arm import JOINT_COUNT, arm_by_name
from rfms_can.arm.calibration import Calibration
from rfms_can.identification.experiments.plan import experiments
from rfms_can.identification.experiments.tap import MISSING
from rfms_can.identification.fit.identify import VALIDATION, identify
from rfms_can.identification.fit.least_squares import IdentificationError
from rfms_can.identification.fit.result import Identification, calibration_of
from rfms_can.identification.fit.summary import (
    compare_models,
    constant_figures,
    torque_figures,
)
from rfms_can.identification.fit.truth import truth_of

pytestmark = pytest.mark.system

PLANTS = [("puma560", "table41"), ("puma560", "rewired:2"), ("puma260", "rewired:3")]


class Found:
    def __init__(self, arm: str, plant: str) -> None:
        self.variant, data = ideal_experiments(arm, plant)
        self.result: Identification = identify(arm_by_name(arm), data)
        self.calibration: Calibration = calibration_of(self.result)
        self.truth = truth_of(self.variant)


@pytest.fixture(scope="module", params=PLANTS, ids=" ".join)
def found(request: pytest.FixtureRequest) -> Found:
    return Found(*request.param)


def test_slopes_within_1_percent_and_offsets_within_5(found: Found) -> None:
    for row in torque_figures(found.calibration, found.truth):
        figures = {figure.name: figure for figure in row}
        for side in ("positive", "negative"):
            assert abs(figures[f"slope_{side}"].error) < 0.01, figures
            offset = figures[f"offset_{side}"]
            assert abs(offset.error) < 0.05, figures


def test_gravity_within_2_percent_and_inertia_within_5(found: Found) -> None:
    for figure in constant_figures(found.calibration, found.truth):
        assert abs(figure.error) < (0.02 if figure.name[0] == "c" else 0.05), figure
    models = compare_models(found.result, found.calibration, found.truth)
    assert max(map(max, models.effective)) < 0.05
    assert max(models.gravity) < 0.02
    rms, off = models.coupling
    assert off < 0.05 * rms


def test_confidence_is_not_off_by_an_order(found: Found) -> None:
    """Nine in ten figures within five of their deviations."""
    rows = [*torque_figures(found.calibration, found.truth)]
    figures = [f for row in rows for f in row if not f.name.startswith("static")]
    figures += constant_figures(found.calibration, found.truth)
    near = [abs(f.value - f.truth) < 5.0 * f.deviation for f in figures]
    assert sum(near) > 0.9 * len(near)


def test_motions_no_fit_has_seen_are_explained(found: Found) -> None:
    measured, left = found.result.validation
    assert (left[:3] < 0.1 * measured[:3]).all()


def test_the_amplifier_with_a_current_of_its_own_is_named(found: Found) -> None:
    own = [j for j, w in enumerate(found.variant.board_errors, start=1) if w.current_offset]
    assert [f"joint {j} of" in note for j, note in zip(own, found.result.notes, strict=True)] == [
        True
    ] * len(own)


def test_a_load_that_was_not_there_is_refused_with_the_joint() -> None:
    """Sweeps "with the load" of an arm that carries none."""
    arm = arm_by_name("puma560")
    variant, data = ideal_experiments("puma560", "table41")
    experiment = next(e for e in experiments(arm) if e.name == "sweep-3-load")
    bare = ideal_data(replace(experiment, load=False), variant)._replace(load=True)
    with pytest.raises(IdentificationError, match=r"joint 3: .*known load"):
        identify(arm, {**data, "sweep-3-load": bare})
    experiment = next(e for e in experiments(arm) if e.name == "burst-1-load")
    bare = ideal_data(replace(experiment, load=False), variant)._replace(load=True)
    with pytest.raises(IdentificationError, match=r"joint 1: .*known load"):
        identify(arm, {**data, "burst-1-load": bare})


def test_missing_frames_and_missing_experiments_are_refused() -> None:
    arm = arm_by_name("puma560")
    _, data = ideal_experiments("puma560", "table41")
    table = data["burst-2"].table.copy()
    table[100, 1, 3] = MISSING
    torn = data["burst-2"]._replace(table=table)
    with pytest.raises(IdentificationError, match="1 cycles lack a MEASURE or DAC"):
        identify(arm, {**data, "burst-2": torn})
    without = {name: each for name, each in data.items() if name != "burst-1-load"}
    with pytest.raises(IdentificationError, match="joint 1: no motion with the known load"):
        identify(arm, without)
    without = {name: each for name, each in data.items() if "sweep-4" not in name}
    with pytest.raises(IdentificationError, match="joint 4"):
        identify(arm, without)


def test_nothing_is_read_from_the_model() -> None:
    """An arm whose data sheet says other masses, frictions and torques gives the same result."""
    _, data = ideal_experiments("puma560", "table41")
    arm = arm_by_name("puma560")
    links = tuple(replace(link, mass=2.0 * link.mass + 1.0) for link in arm.links)
    drives = tuple(replace(drive, rotor_inertia=1e-3) for drive in arm.drives)
    other = replace(arm, links=links, drives=drives, friction_sets={})
    ours, theirs = (calibration_of(identify(each, data)) for each in (arm, other))
    assert ours.joints == theirs.joints
    assert ours.constants == pytest.approx(theirs.constants, rel=1e-9)
    np.testing.assert_allclose(ours.parameters, theirs.parameters, rtol=1e-9, atol=1e-12)


def test_the_validation_is_of_an_experiment_that_exists() -> None:
    for name in ("puma260", "puma560"):
        assert VALIDATION in {experiment.name for experiment in experiments(arm_by_name(name))}
    assert JOINT_COUNT == 6
