"""Constants of the simplified dynamics (Eq. 4.16, 4.30) from calibrated torques, all at once.

Gravity from the windows of all sweeps without load; effective inertias from bursts, one fit for
each pose of each joint and one over the poses. Everywhere more equations than unknowns.
"""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.terms import GRAVITY, INERTIA, gravity_row, inertia_row, value
from rfms_can.identification.fit.least_squares import Fit, matrix_of, solve
from rfms_can.identification.fit.momentum import Motion, inertia_of
from rfms_can.identification.fit.windows import Window

LOADED: Final = (1, 2, 3, 4)
"""Joint indices with gravity torque."""


class PoseInertia(NamedTuple):
    """Ia_i + D_ii of a joint at one pose.

    Attributes:
        joint: index 0 to 5.
        pose: where, rad (6).
        inertia, deviation: kg m2.
    """

    joint: int
    pose: Floats
    inertia: float
    deviation: float


def gravity_fit(windows: Sequence[Window], laws: Sequence[TorqueLaw]) -> Fit:
    """Eq. 4.9 over all windows without load."""
    rows, rights = [], []
    for window in windows:
        if window.load or window.joint not in LOADED:
            continue
        rows.append(gravity_row(window.joint + 1, window.q.tolist()))
        rights.append(laws[window.joint].torque(window.current, window.speed))
    return solve(GRAVITY, matrix_of(GRAVITY, rows), np.array(rights), "gravity")


def net_torque(motion: Motion, law: TorqueLaw, gravity: Mapping[str, float]) -> Floats:
    """tau_i - D_i along a motion, Nm, friction subtracted.

    A sample's current was held for the period before it: speed and angle are those of its middle.
    """
    qd = motion.qd.copy()
    qd[1:] = 0.5 * (motion.qd[1:] + motion.qd[:-1])
    speeds = np.where(motion.direction * qd > 0.0, qd, motion.direction * 1e-9)
    torque = np.array(
        [law.torque(c, v) for c, v in zip(motion.current.tolist(), speeds.tolist(), strict=True)]
    )
    held = [value(gravity_row(motion.joint + 1, q), gravity) for q in motion.poses.tolist()]
    before = np.array([held[0], *held[:-1]])
    net: Floats = torque - 0.5 * (np.array(held) + before)
    return net


def pose_inertias(
    motions: Sequence[Motion],
    laws: Sequence[TorqueLaw],
    gravity: Mapping[str, float],
    period_s: float,
) -> list[PoseInertia]:
    """Inertia at each pose of a burst; motions of one action are consecutive."""
    found = []
    for _, group in groupby(motions, key=lambda motion: (motion.joint, motion.action)):
        own = list(group)
        joint = own[0].joint
        torques = [net_torque(motion, laws[joint], gravity) for motion in own]
        fit = inertia_of(own, torques, period_s)
        found.append(
            PoseInertia(joint, own[0].pose, fit.values["inertia"], fit.deviations["inertia"])
        )
    return found


def inertia_fits(measured: Sequence[PoseInertia]) -> Fit:
    """Eq. 4.11 over all poses: one fit a joint, merged."""
    values: dict[str, float] = {}
    deviations: dict[str, float] = {}
    worst, squares = 0.0, 0.0
    for joint in range(1, 7):
        names = tuple(name for name in INERTIA if name[1] == str(joint))
        own = [pose for pose in measured if pose.joint == joint - 1]
        rows = [inertia_row(joint, pose.pose.tolist()) for pose in own]
        right = np.array([pose.inertia for pose in own])
        fit = solve(names, matrix_of(names, rows), right, f"inertias of joint {joint}")
        values |= fit.values
        spread = max(*(pose.deviation for pose in own), fit.residual)
        for name in names:
            deviations[name] = max(fit.deviations[name], spread)
        worst = max(worst, fit.condition)
        squares += len(own) * fit.residual**2
    count = len(measured)
    return Fit(values, deviations, float(np.sqrt(squares / count)), count, worst)
