"""The table of control laws: complete, and what its entries say holds of the rows they make."""

import numpy as np
import pytest

from rfms_can.arm import PUMA_560
from rfms_can.compliance import (
    LAWS,
    ControlLaw,
    Selection,
    Servos,
    compliance_jacobian,
    free_damping,
    matched_stiffness,
)
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.errors import TableError
from rfms_can.tables import complete
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Law

PEG = Selection.parse("fx fy rx ry")
SERVOS = Servos((400.0, 500.0, 300.0, 20.0, 20.0, 10.0), 20.0, PUMA_560.a2)
HERE, THERE = (0.1, -0.6, 0.4, 0.3, 0.9, 0.2), (0.2, -0.5, 0.5, 0.2, 1.0, 0.1)


def at(q: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    dynamics = ArmDynamics(PUMA_560)
    dynamics.update(q)
    J = compliance_jacobian(dynamics.J, Transform.translation(0.0, 0.0, 0.2))
    return J.copy(), dynamics.M.copy()


@pytest.mark.parametrize("left_out", list(ControlLaw))
def test_a_law_without_an_entry_does_not_import(left_out: ControlLaw) -> None:
    table = {law: definition for law, definition in LAWS.items() if law is not left_out}
    with pytest.raises(TableError, match=rf"ControlLaw\.{left_out.name}"):
        complete(table, ControlLaw)


@pytest.mark.parametrize("law", list(ControlLaw))
def test_a_law_that_complies_lets_as_many_directions_go_as_are_selected(law: ControlLaw) -> None:
    J, M = at(HERE)
    rows = LAWS[law].begin(J, M, PEG, SERVOS)(J, M)
    rank = np.linalg.matrix_rank(rows.errors, tol=1e-8)
    assert rank == (6 - PEG.size if LAWS[law].complies else 6)


@pytest.mark.parametrize("law", [law for law in ControlLaw if LAWS[law].damped])
def test_damping_touches_no_direction_that_is_held(law: ControlLaw) -> None:
    """M (I - C) is zero on the range of C, a projector."""
    J, M = at(HERE)
    rows = LAWS[law].begin(J, M, PEG, SERVOS)(J, M)
    np.testing.assert_allclose(free_damping(rows, M) @ rows.errors, 0.0, atol=1e-8)


@pytest.mark.parametrize("law", list(ControlLaw))
def test_rows_of_the_weighted_torque_need_a_model(law: ControlLaw) -> None:
    definition = LAWS[law]
    assert definition.needs_model == (definition.wire is Law.WEIGHTED)


def test_a_stiffness_is_matched_where_compliance_begins_and_kept() -> None:
    J, M = at(HERE)
    rows_at = LAWS[ControlLaw.STIFFNESS].begin(J, M, PEG, SERVOS)
    K = matched_stiffness(J, PEG, M, SERVOS.natural_frequency)
    J_there, M_there = at(THERE)
    expected = J_there.T @ np.diag(K) @ J_there / np.array(SERVOS.Kp)[:, np.newaxis]
    np.testing.assert_allclose(rows_at(J_there, M_there).errors, expected, rtol=1e-12)


def test_free_joints_are_matched_where_compliance_begins_and_kept() -> None:
    J, M = at(HERE)
    rows_at = LAWS[ControlLaw.FREE_JOINT].begin(J, M, PEG, SERVOS)
    free = [n for n, row in enumerate(rows_at(J, M).errors) if not row.any()]
    assert len(free) == PEG.size
    there = rows_at(*at(THERE)).errors
    assert [n for n, row in enumerate(there) if not row.any()] == free


def test_only_a_law_between_poses_corrects_the_error() -> None:
    """(5.7): of second order, so half the errors leave a quarter of it."""
    correcting = [law for law in ControlLaw if LAWS[law].correction is not None]
    assert correcting == [ControlLaw.RAIBERT_CRAIG]
    correction = LAWS[ControlLaw.RAIBERT_CRAIG].correction
    assert correction is not None
    J, M = at(HERE)
    C = LAWS[ControlLaw.RAIBERT_CRAIG].begin(J, M, PEG, SERVOS)(J, M).errors
    frame = Transform.translation(0.0, 0.0, 0.2)
    errors = np.array([0.01, -0.02, 0.01, 0.02, 0.01, -0.01])
    whole, half = (
        np.linalg.norm(correction(PUMA_560, HERE, (size * errors).tolist(), frame, J, C))
        for size in (1.0, 0.5)
    )
    assert half == pytest.approx(0.25 * whole, rel=0.05)
