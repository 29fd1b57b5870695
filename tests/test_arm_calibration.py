"""The calibration file, and what a master makes of it."""

import math
from pathlib import Path

import numpy as np
import pytest
from support.identification import exact_calibration

from rfms_can.arm import PUMA_260, PUMA_560, Load
from rfms_can.arm.calibration import Calibration, as_toml, load_calibration, save_calibration
from rfms_can.arm.torque_law import joint_current
from rfms_can.dynamics.fitted import random_poses
from rfms_can.dynamics.model import KINDS, make_dynamics
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import ArmError
from rfms_can.kinematics import jacobian
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.plant.variant import make_variant
from rfms_can.rig.settings import RunSettings
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.vocabulary import Parameter

TABLE = make_variant("table41", PUMA_560, "thesis")
FOUND = exact_calibration(TABLE, ('a "note", with\na line',))
FRICTION = (Parameter.COULOMB_POSITIVE, Parameter.COULOMB_NEGATIVE, Parameter.VISCOUS)


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "new" / "arm.toml"
    save_calibration(path, FOUND)
    assert load_calibration(path) == FOUND


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("slope_positive = 0", "slope_positive = -0", "slope_positive"),
        ("viscous", "viscus", "viscus"),
        ("[constants]", "[constants", "calibration .*arm.toml"),
        ("c21 = ", 'c21 = "', "calibration .*arm.toml"),
    ],
)
def test_a_file_that_is_none_is_refused_with_the_place(
    tmp_path: Path, before: str, after: str, message: str
) -> None:
    path = tmp_path / "arm.toml"
    text = as_toml(FOUND)
    assert before in text
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(ArmError, match=message):
        load_calibration(path)


def test_no_file_and_another_arms_file(tmp_path: Path) -> None:
    with pytest.raises(ArmError, match="No such file"):
        RunSettings(arm="puma560", calibration=str(tmp_path / "none.toml"))
    path = tmp_path / "arm.toml"
    save_calibration(path, FOUND)
    assert RunSettings(arm="puma560", calibration=str(path)).master().calibration == FOUND
    with pytest.raises(ArmError, match="is of arm puma560, not of puma260"):
        RunSettings(arm="puma260", calibration=str(path))
    with pytest.raises(ArmError, match="no dynamics 'half'; there are: full, simplified, none"):
        RunSettings(dynamics="half")


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_nodes_give_the_current_the_law_asks_for(joint: int, speed: float) -> None:
    """Exact for a joint without load; half the difference of the slopes with one."""
    p = all_parameters(PUMA_560, "corke", 0.004, FOUND)[joint]
    law, drive = TABLE.laws[joint - 1], PUMA_560.drives[joint - 1]
    coulomb = p[Parameter.COULOMB_POSITIVE] if speed > 0 else -p[Parameter.COULOMB_NEGATIVE]
    for load in (0.0, 0.3 * drive.torque_limit):
        wanted = load + coulomb + p[Parameter.VISCOUS] * speed
        code = joint_current(drive.gear_ratio, wanted / p[Parameter.TORQUE_PER_CODE])
        unequal = abs(law.slope_positive - law.slope_negative) / law.slope_positive
        bound = 1e-6 * drive.torque_limit + 0.51 * load * unequal
        bound += 0.025 * law.viscous * abs(speed)
        assert law.torque(code, speed) == pytest.approx(load, abs=bound)


def test_without_compensation_nodes_know_no_friction_and_gains_stay() -> None:
    usual = all_parameters(PUMA_560, "corke", 0.004)
    bare = all_parameters(PUMA_560, "corke", 0.004, compensated=False)
    found = all_parameters(PUMA_560, "corke", 0.004, FOUND)
    for joint in JOINTS:
        assert [bare[joint][p] for p in FRICTION] == [0.0] * 3
        changed = {p for p in usual[joint] if usual[joint][p] != found[joint][p]}
        assert changed <= {*FRICTION, Parameter.TORQUE_PER_CODE}
        assert math.copysign(1, usual[joint][Parameter.TORQUE_PER_CODE]) == math.copysign(
            1, found[joint][Parameter.TORQUE_PER_CODE]
        )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("calibration", [None, FOUND])
def test_models_of_a_kind(kind: str, calibration: Calibration | None) -> None:
    full, model = ArmDynamics(TABLE.rigid), make_dynamics(PUMA_560, kind, calibration)
    known = 0.0 if kind == "none" else 1.0
    for q in random_poses(PUMA_560, 20, 1):
        model.update(q)
        full.update(q)
        np.testing.assert_allclose(model.J, jacobian(PUMA_560, q), atol=1e-12)
        np.testing.assert_allclose(model.g, known * full.g, atol=1e-6)
        bound = 0.02 if kind == "simplified" or calibration is None else 1e-9
        np.testing.assert_allclose(np.diag(model.M), known * np.diag(full.M), rtol=bound)


@pytest.mark.parametrize("kind", KINDS)
def test_a_load_is_added_and_taken_away(kind: str) -> None:
    model, load = make_dynamics(PUMA_260, kind), Load(0.5, (0.0, 0.0, 0.1))
    q = PUMA_260.park
    model.update(q)
    bare_M, bare_g = model.M.copy(), model.g.copy()
    model.carry(load)
    model.update(q)
    J = np.array(jacobian(PUMA_260, q))
    point = J[:3] - np.cross((0.0, 0.0, 0.1), J[3:], axisb=0, axisc=0)
    np.testing.assert_allclose(model.M - bare_M, 0.5 * point.T @ point, atol=1e-12)
    assert model.g[1] > bare_g[1]
    model.carry(Load(0.0, (0.0, 0.0, 0.0)))
    model.update(q)
    np.testing.assert_array_equal(model.M, bare_M)


def test_a_calibration_of_another_arm_makes_no_model() -> None:
    with pytest.raises(ArmError, match="puma560, not of puma260"):
        make_dynamics(PUMA_260, "full", FOUND)
