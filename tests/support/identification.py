"""Data of experiments without a bus: an arm that follows perfectly, and currents by its true law.

What an analysis is tested with where the servo, the bus and the physics engine do not matter: the
joints go from rest to rest along quintics, a joint at rest draws what it stopped with, converters
round and are noisy.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from rfms_can.arm import JOINT_COUNT, Arm, arm_by_name, known_load, load_alone
from rfms_can.arm.calibration import Calibration, JointCalibration
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.fitted import fitted_constants
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.identification.experiments.actions import (
    BURST,
    CREEP,
    SWEEP,
    TOUR,
    Action,
    Burst,
    Creep,
    Mark,
    Sweep,
    burst_times,
    with_joint,
)
from rfms_can.identification.experiments.data import Data
from rfms_can.identification.experiments.plan import Experiment, experiments
from rfms_can.identification.experiments.tap import Integers
from rfms_can.plant.variant import Variant, make_variant

Floats = NDArray[np.float64]

PERIOD_S = 0.004
REST_S = 0.6
ACCELERATION_S = 0.2


@dataclass
class Way:
    """Set-points and marks of an experiment."""

    q: list[Floats] = field(default_factory=list)
    marks: list[Mark] = field(default_factory=list)

    def rest(self, pose: Sequence[float], seconds: float) -> None:
        self.q += [np.array(pose)] * round(seconds / PERIOD_S)

    def go(self, kind: str, joint: int, action: int, to: Sequence[float], seconds: float) -> None:
        here, start = self.q[-1], len(self.q)
        rise = min(ACCELERATION_S, 0.45 * seconds) if kind in (SWEEP, CREEP) else 0.0
        for k in range(1, round(seconds / PERIOD_S) + 1):
            part = _trapezoid(k * PERIOD_S, seconds, rise) if rise else _quintic(k, seconds)
            self.q.append(here + part * (np.array(to) - here))
        self.marks.append(Mark(kind, joint, action, start, len(self.q)))


def _quintic(k: int, seconds: float) -> float:
    u = min(k * PERIOD_S / seconds, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def _trapezoid(t: float, seconds: float, rise: float) -> float:
    """Constant speed after a smooth start, and before a smooth end."""

    def way(s: float) -> float:
        """Of a speed that rises as 3 u^2 - 2 u^3 to 1."""
        u = min(s / rise, 1.0)
        return rise * (u**3 - 0.5 * u**4) + max(s - rise, 0.0)

    whole = seconds - rise
    return (way(t) if t < seconds / 2.0 else whole - way(max(seconds - t, 0.0))) / whole


def _act(way: Way, index: int, action: Action, arm: Arm) -> None:
    if isinstance(action, Sweep):
        kind = CREEP if isinstance(action, Creep) else SWEEP
        low, high = (with_joint(action.pose, action.joint, a) for a in (action.lower, action.upper))
        seconds = (action.upper - action.lower) / action.speed
        way.rest(low, REST_S)
        way.go(kind, action.joint, index, high, seconds)
        way.go(kind, action.joint, index, low, seconds)
    elif isinstance(action, Burst):
        there = with_joint(
            action.pose, action.joint, action.pose[action.joint - 1] + action.displacement
        )
        _, seconds = burst_times(abs(action.displacement), arm, action.joint)
        way.rest(action.pose, REST_S)
        for end in (there, action.pose) * action.times:
            way.go(BURST, action.joint, index, end, 1.3 * seconds)
            way.rest(end, 0.1)
    else:
        way.rest(action.places[0], REST_S)
        for place in action.places[1:]:
            far = np.abs(np.array(place) - way.q[-1]) / np.array(arm.speed_limits)
            way.go(TOUR, 0, index, place, 2.2 * float(far.max()))


def ideal_data(experiment: Experiment, variant: Variant, seed: int = 1) -> Data:
    """The data of an experiment on a plant."""
    arm, way = variant.rigid, Way()
    for index, action in enumerate(experiment.actions):
        _act(way, index, action, arm)
    way.rest(way.q[-1].tolist(), REST_S)
    q = np.array(way.q)
    qd = np.gradient(q, PERIOD_S, axis=0)
    current = _currents(variant, q, experiment.load)
    table = _table(variant, q, qd, current, np.random.default_rng(seed))
    return Data(table, (7, -3, 0, 11, 5, 2), tuple(way.marks), PERIOD_S, experiment.load)


def _currents(variant: Variant, q: Floats, load: bool) -> Floats:
    """Currents, codes towards positive angles, of the period before each row."""
    model = ArmDynamics(variant.rigid)
    more = ArmDynamics(load_alone(variant.arm, known_load(variant.arm))) if load else None
    current = np.zeros_like(q)
    laws = variant.laws
    for k in range(1, len(q) - 1):
        middle = 0.5 * (q[k] + q[k - 1])
        qd = (q[k] - q[k - 1]) / PERIOD_S
        before = (q[k - 1] - q[k - 2]) / PERIOD_S if k > 1 else qd
        after = (q[k + 1] - q[k]) / PERIOD_S
        qdd = (after - before) / (2.0 * PERIOD_S)
        torque = model.torque(middle, qd, qdd)
        if more is not None:
            torque = torque + more.torque(middle, qd, qdd)
        current[k] = current[k - 1]
        for joint, law in enumerate(laws):
            speed = qd[joint]
            if speed:
                slope = law.slope_positive if speed > 0.0 else law.slope_negative
                offset = law.offset_positive if speed > 0.0 else law.offset_negative
                current[k, joint] = (torque[joint] + law.viscous * speed - offset) / slope
    current[-1] = current[-2]
    return current


def _table(
    variant: Variant, q: Floats, qd: Floats, current: Floats, noise: np.random.Generator
) -> Integers:
    arm = variant.arm
    signs = np.sign([drive.gear_ratio for drive in arm.drives])
    per_rad = np.array([drive.counts_per_radian for drive in arm.drives])
    speeds = np.array([arm.board_scale(joint).speed_per_adc_code for joint in range(JOINT_COUNT)])
    dac = np.rint(signs * current)
    own = np.array([errors.current_offset for errors in variant.board_errors])
    slope = np.array([errors.adc_slope for errors in variant.board_errors])
    offset = np.array([errors.adc_offset for errors in variant.board_errors])
    adc = slope * (dac + own) + offset + noise.normal(0.0, 2.0, dac.shape)
    tachometer = qd / speeds + noise.normal(0.0, 1.5, qd.shape)
    early = np.concatenate((dac[2:], dac[-1:], dac[-1:]))  # a code acts two cycles later
    counts = q * per_rad + (7, -3, 0, 11, 5, 2)
    fields = (counts, adc, tachometer, early)
    table: Integers = np.rint(np.stack(fields, axis=1)).astype(np.int32)
    return table


@cache
def ideal_experiments(arm: str, plant: str) -> tuple[Variant, dict[str, Data]]:
    """A plant and the data of all experiments on it."""
    data = arm_by_name(arm)
    variant = make_variant(plant, data, "corke")
    found = {
        experiment.name: ideal_data(experiment, variant, seed)
        for seed, experiment in enumerate(experiments(data))
    }
    return variant, found


def exact_calibration(variant: Variant, notes: tuple[str, ...] = ()) -> Calibration:
    """What a perfect experiment would find out about a plant."""
    return calibration_of(variant.rigid, variant.laws, notes)


def calibration_of(
    arm: Arm, laws: tuple[TorqueLaw, ...], notes: tuple[str, ...] = ()
) -> Calibration:
    full = ArmDynamics(arm)
    constants = fitted_constants(full)
    first, second, third, fourth, fifth, sixth = (_joint(law) for law in laws)
    a, b, c, d, e, f = (drive.armature for drive in arm.drives)
    values = {
        "arm": arm.name,
        "joint": [first, second, third, fourth, fifth, sixth],
        "constants": constants,
        "deviations": dict.fromkeys(constants, 0.0),
        "links": {"parameters": full.parameters.tolist(), "armature": [a, b, c, d, e, f]},
        "notes": list(notes),
    }
    return msgspec.convert(msgspec.to_builtins(values), type=Calibration)


def _joint(law: TorqueLaw) -> JointCalibration:
    return JointCalibration(
        law.slope_positive,
        law.offset_positive,
        law.slope_negative,
        law.offset_negative,
        law.viscous,
        -law.offset_positive,
        law.offset_negative,
        0.92,
        -11.0,
        {"slope_positive": 1e-5},
    )
