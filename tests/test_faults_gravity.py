"""Gravity tells less of a wrong coarse position than friction holds, but of joint 2."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest

from rfms_can.arm import ARMS, Arm, arm_by_name, friction_set
from rfms_can.dynamics.model import FULL, make_dynamics
from rfms_can.faults.boards import COARSE_FRACTION
from rfms_can.wire.nodes import JOINTS

FRICTION: float = 1.5
"""Of Coulomb friction, that a plant may have over the published one."""


def gravity(arm: Arm, q: Sequence[float]) -> npt.NDArray[np.float64]:
    model = make_dynamics(arm, FULL)
    model.update(list(q))
    return np.array(model.g)


def residual(arm: Arm, joint: int) -> npt.NDArray[np.float64]:
    """By how much gravity of the parked arm is off where a joint is believed elsewhere, Nm (6)."""
    lower, upper = arm.joint_limits[joint - 1]
    believed = list(arm.park)
    believed[joint - 1] += COARSE_FRACTION * (upper - lower)
    return gravity(arm, believed) - gravity(arm, arm.park)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("joint", JOINTS)
def test_friction_holds_more_than_gravity_tells_but_of_joint_2(name: str, joint: int) -> None:
    arm = arm_by_name(name)
    held = [
        FRICTION * max(friction.coulomb_positive, friction.coulomb_negative)
        for friction in friction_set(arm, "corke")
    ]
    tells = bool((np.abs(residual(arm, joint)) > held).any())
    assert tells is (joint == 2)
