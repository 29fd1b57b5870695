"""Predictions of stability and instability come true on the plant's MuJoCo arm.

The whole nonlinear arm, its own (corrected) inertia, torques one period late and held; only
friction, boards and torque limits are left out.
"""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from rfms_can.analysis.stability import Analyst, ControlLaw, Study, Verdict
from rfms_can.arm import PUMA_560, friction_set
from rfms_can.compliance import Selection
from rfms_can.plant.arm_model import ArmModel
from rfms_can.transform import Transform

Array = NDArray[np.float64]
Pose = tuple[float, ...]

TOOL = Transform.translation(0.0, 0.0, 0.1)
ROTATIONS, PEG = Selection.parse("rx ry rz"), Selection.parse("fx fy rx ry")
MIXED = (10.0, 10.0, 10.0, 40.0, 40.0, 40.0)
PERIOD_S, STEPS = 0.004, 8
SMALL, LARGE = 1e-9, 1e-4
"""Size of the disturbance, and where the linear range ends, rad."""

POSES: tuple[Pose, ...] = (
    (0.3, 0.4, -2.0, 0.2, 0.9, 0.1),
    (0.0, 1.0, -0.6, 0.5, 1.0, 0.0),
    (-0.5, 0.8, -2.2, 0.4, -0.8, 0.3),
)


def disturbed(analyst: Analyst, q: Pose, cycles: int) -> Array:
    """Angles less ``q`` at each SYNC, from a small disturbance of every joint; (n, 6), rad."""
    loop = analyst.loop(q)
    plant = ArmModel(PUMA_560, friction_set(PUMA_560, "none"), PERIOD_S / STEPS)
    goal = np.array(q)
    plant.reset((goal + SMALL * np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])).tolist())
    torque, seen = np.zeros(6), []
    for _ in range(cycles):
        error, rate = goal - plant.q, -np.array(plant.qd)
        seen.append(-error)
        if np.abs(error).max() > LARGE:
            break
        following = loop.stiffness @ error + loop.damping @ rate
        for _ in range(STEPS):  # gravity is compensated exactly: it is not what is asked about
            plant.step((torque + plant.holding_torque()).tolist())
        torque = following
    return np.array(seen)


@pytest.mark.parametrize("q", POSES)
def test_what_is_called_unstable_grows_as_fast_as_said(q: Pose) -> None:
    study = Study(PUMA_560, ROTATIONS, TOOL, ControlLaw.HYBRID, natural=MIXED, compliant_rate=5.0)
    analyst = Analyst(study)
    analysis = analyst.analyse(q)
    assert analysis.verdict is Verdict.UNSTABLE
    seen = disturbed(analyst, q, 3000)
    assert np.abs(seen[-1]).max() > LARGE
    sizes = np.linalg.norm(seen, axis=1)
    later = sizes > 0.1 * sizes[-1]  # the fastest growing motion has the others behind it
    growth = math.log(sizes[-1] / sizes[later][0]) / (PERIOD_S * (int(later.sum()) - 1))
    predicted = math.log(float(np.abs(analysis.sampled).max())) / PERIOD_S
    assert growth == pytest.approx(predicted, rel=0.1)


@pytest.mark.parametrize("q", POSES)
@pytest.mark.parametrize("selection", [ROTATIONS, PEG])
def test_what_is_called_stable_comes_to_rest(q: Pose, selection: Selection) -> None:
    """The same poses and frame under the law weighted by inertia."""
    study = Study(PUMA_560, selection, TOOL, ControlLaw.WEIGHTED, compliant_rate=5.0)
    analyst = Analyst(study)
    analysis = analyst.analyse(q)
    assert analysis.verdict is Verdict.STABLE
    assert analysis.sampled_stable
    seen = disturbed(analyst, q, 500)
    assert len(seen) == 500
    held, _ = analyst.loop(q).bases
    assert np.abs(seen[-1] @ held).max() < 1e-3 * SMALL
    assert np.abs(seen[-1] - seen[-2]).max() < 1e-4 * SMALL
