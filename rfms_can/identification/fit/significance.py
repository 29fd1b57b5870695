"""Error and computation time of simpler models of the dynamics: thesis IV.3 and IV.4.

Torques along a gross and a fine motion by Newton-Euler with velocity terms, and by models with
fewer terms. The cost is the time of one update in this process.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.simplified import SimplifiedDynamics

SAMPLES: Final = 200
UPDATES: Final = 2000
GROSS: Final = 0.9
"""Fraction of a joint's speed limit that a gross motion reaches."""
FINE_RAD: Final = 0.02
STEP: Final = 1e-5


class Path(NamedTuple):
    """A motion: angles, speeds and accelerations, rad (n, 6 each)."""

    q: Floats
    qd: Floats
    qdd: Floats


class Significance(NamedTuple):
    """Torque error of a model.

    Attributes:
        model: its name.
        microseconds: of one update.
        gross, fine: largest error along a motion, of any joint, over the largest torque of that
            joint.
    """

    model: str
    microseconds: float
    gross: float
    fine: float


def gross_motion(arm: Arm) -> Path:
    """All joints together, through much of their range, at nearly their speed limits."""
    here = np.array(arm.park)
    there = here + np.array([1.5, -0.7, 1.6, 1.2, 2.2, -1.5])
    distance = there - here
    seconds = 1.875 * float(np.max(np.abs(distance) / (GROSS * np.array(arm.speed_limits))))
    return _quintic(here, distance, seconds)


def fine_motion(arm: Arm) -> Path:
    """A short motion at the acceleration limit of the first joint: high torque, low speed."""
    here = np.array(arm.park)
    distance = FINE_RAD * np.array([1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    seconds = (5.7735 * FINE_RAD / (0.9 * arm.acceleration_limits[0])) ** 0.5
    return _quintic(here, distance, seconds)


def _quintic(here: Floats, distance: Floats, seconds: float) -> Path:
    """From rest to rest."""
    u = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    ds = 30.0 * u**2 * (1.0 - u) ** 2 / seconds
    dds = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / seconds**2
    return Path(here + s * distance, ds * distance, dds * distance)


Torque = Callable[[Floats, Floats, Floats], Floats]


class _Model(NamedTuple):
    """A model: its name, its torque, and one update of it."""

    name: str
    torque: Torque
    update: Callable[[Sequence[float]], object]


def significance(arm: Arm, constants: Mapping[str, float]) -> list[Significance]:
    """The table: models in the order of decreasing complexity."""
    paths = gross_motion(arm), fine_motion(arm)
    exact = [_along(ArmDynamics(arm).torque, path) for path in paths]
    rows = []
    for name, torque, update in _models(arm, constants):
        left = [
            float(np.max(np.abs(_along(torque, path) - whole).max(axis=0) / _most(whole, arm)))
            for path, whole in zip(paths, exact, strict=True)
        ]
        rows.append(Significance(name, _cost(update, arm), left[0], left[1]))
    return rows


def _models(arm: Arm, constants: Mapping[str, float]) -> tuple[_Model, ...]:
    full, simple = ArmDynamics(arm), SimplifiedDynamics(arm, constants)

    def without_velocity(q: Floats, _qd: Floats, qdd: Floats) -> Floats:
        full.update(q)
        torque: Floats = full.M @ qdd + full.g
        return torque

    def simplified(q: Floats, _qd: Floats, qdd: Floats) -> Floats:
        simple.update(q.tolist())
        torque: Floats = simple.M @ qdd + simple.g
        return torque

    def with_velocity(q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return simplified(q, qd, qdd) + velocity_torque(simple, q, qd)

    def gravity(q: Floats, _qd: Floats, _qdd: Floats) -> Floats:
        simple.update(q.tolist())
        return simple.g.copy()

    return (
        _Model("Newton-Euler, whole", full.torque, lambda q: full.torque(q, _ONES, _ONES)),
        _Model("M and g, no velocity terms", without_velocity, full.update),
        _Model(
            "simplified, with its velocity terms",
            with_velocity,
            lambda q: with_velocity(np.array(q), _ONES, _ONES),
        ),
        _Model("simplified: 4.9, 4.11, 4.12", simplified, simple.update),
        _Model("gravity alone: 4.9", gravity, simple.update),
    )


_ONES: Final = np.ones(JOINT_COUNT)


def _most(whole: Floats, arm: Arm) -> Floats:
    """The largest torque of each joint, at least a thousandth of its drive's limit."""
    least = [1e-3 * drive.torque_limit for drive in arm.drives]
    most: Floats = np.maximum(np.abs(whole).max(axis=0), least)
    return most


def _along(torque: Torque, path: Path) -> Floats:
    return np.array([torque(*state) for state in zip(*path, strict=True)])


def _cost(update: Callable[[Sequence[float]], object], arm: Arm) -> float:
    q = list(arm.park)
    began = time.perf_counter()
    for _ in range(UPDATES):
        update(q)
    return 1e6 * (time.perf_counter() - began) / UPDATES


def velocity_torque(simple: SimplifiedDynamics, q: Floats, qd: Floats) -> Floats:
    """Centripetal and Coriolis torques that belong to the simplified inertia, Nm (6).

    ``M' qd - grad(qd M qd) / 2`` by differences: M depends on theta2, theta3 and theta5.
    """
    torque = np.zeros(JOINT_COUNT)
    for k in (1, 2, 4):
        aside = q.copy()
        aside[k] += STEP
        simple.update(aside.tolist())
        ahead = simple.M.copy()
        aside[k] -= 2.0 * STEP
        simple.update(aside.tolist())
        slope = (ahead - simple.M) / (2.0 * STEP)
        torque += qd[k] * (slope @ qd)
        torque[k] -= 0.5 * float(qd @ slope @ qd)
    return torque
