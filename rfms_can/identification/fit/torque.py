"""Torque against current of each joint, per direction (Eq. 4.13, Table 4.1), and its friction.

Joint i moves alone at constant speed v:

    A_d I + B_d - f v = D_i(theta_i) + (torque of the known load)        d: the direction

With the other joints at rest gravity is a sine of theta_i whatever the arm: two unknowns a pose.
The load's torque, known from its mass and the kinematics, sets the scale. Joint 1 turns about the
vertical and no weight loads it: its known load is the *inertia* of the same mass, in motions with
and without it, integrated twice.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import hypot
from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import Arm, known_load, load_alone
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.identification.fit.least_squares import Fit, IdentificationError, solve
from rfms_can.identification.fit.momentum import Motion, inertia_of
from rfms_can.identification.fit.windows import Window

LAW: Final = ("slope_positive", "offset_positive", "slope_negative", "offset_negative", "viscous")


UNSEEN: Final = 0.3
"""Largest residual over the known load's torque; beyond it the load was not in the hand."""
_NO_LOAD: Final = (
    "the currents do not show the known load: it was not in the hand when it should have been"
)


@dataclass(frozen=True)
class KnownLoad:
    """Torque and inertia of the known load at each joint, by the arm's kinematics."""

    model: ArmDynamics

    @classmethod
    def of(cls, arm: Arm) -> "KnownLoad":
        """The known load of ``rfms identify``."""
        return cls(ArmDynamics(load_alone(arm, known_load(arm))))

    def weight(self, q: Sequence[float] | Floats, joint: int) -> float:
        """Torque that holds it, Nm, at joint index ``joint``."""
        return float(self.model.gravity(q)[joint])

    def inertia(self, q: Sequence[float] | Floats, joint: int) -> float:
        """Its inertia about that joint, kg m2."""
        return float(self.model.inertia_matrix(q)[joint, joint])


class TorqueFit(NamedTuple):
    """One joint's law.

    Attributes:
        law: found.
        fit: of the equations it was found with.
        points: of Fig. 4.2: current, torque required for gravity, load and inertia (viscous
            friction added, Nm), direction (n, 3).
    """

    law: TorqueLaw
    fit: Fit
    points: Floats


def fit_weight_loaded_joint(windows: list[Window], known: KnownLoad, what: str) -> TorqueFit:
    """The law of a joint (2 to 6) loaded by the known load's weight."""
    poses = sorted({window.pose for window in windows})
    names = [*LAW, "inertia", *(f"{side} {pose}" for pose in poses for side in ("cos", "sin"))]
    rows, rights = [], []
    for window in windows:
        row = np.zeros(len(names))
        row[: len(LAW)] = _law_row(window.current, window.speed)
        row[5] = -window.acceleration
        place = 6 + 2 * poses.index(window.pose)
        angle = window.q[window.joint]
        row[place : place + 2] = -np.cos(angle), -np.sin(angle)
        rows.append(row)
        rights.append(known.weight(window.q, window.joint) if window.load else 0.0)
    matrix, right = np.array(rows).reshape(-1, len(names)), np.array(rights)
    fit = solve(names, matrix, right, what)
    if fit.residual > UNSEEN * float(np.sqrt(np.mean(right**2))):
        raise IdentificationError(f"{what}: {_NO_LOAD}")
    solution = np.array([fit.values[name] for name in names])
    required = right - matrix[:, 4:] @ solution[4:]
    points = [
        (w.current, torque, np.sign(w.speed)) for w, torque in zip(windows, required, strict=True)
    ]
    return TorqueFit(law_of(fit), fit, np.array(points))


def fit_vertical_joint(
    windows: list[Window], motions: list[Motion], period_s: float, known: KnownLoad, what: str
) -> TorqueFit:
    """The law of joint 1: friction from sweeps, the scale from the known load's inertia.

    In codes first: the current for friction, per direction, and inertia over slope without and
    with the load. The load's own inertia over the difference of the two is the slope.
    """
    drag = _drag(windows, what)
    slopes, spreads = {}, {}
    for direction, name in ((1.0, "positive"), (-1.0, "negative")):
        over: dict[bool, Fit] = {}
        for load in (False, True):
            own = [m for m in motions if m.direction == direction and m.load is load]
            currents = [motion.current - _dragged(drag, motion, name) for motion in own]
            over[load] = inertia_of(own, currents, period_s)
        gain = over[True].values["inertia"] - over[False].values["inertia"]
        if gain < UNSEEN * over[False].values["inertia"] / 4.0:
            raise IdentificationError(f"{what}: {_NO_LOAD}")
        loads = [known.inertia(m.pose, m.joint) for m in motions if m.load]
        slopes[name] = float(np.mean(loads)) / gain
        spread = hypot(*(fit.deviations["inertia"] for fit in over.values())) / gain
        spreads[name] = float(spread)
    values, deviations = {}, {}
    for name, slope in slopes.items():
        values[f"slope_{name}"], deviations[f"slope_{name}"] = slope, slope * spreads[name]
        offset = -slope * drag.values[f"offset_{name}"]
        values[f"offset_{name}"] = offset
        own_spread = slope * drag.deviations[f"offset_{name}"]
        deviations[f"offset_{name}"] = float(hypot(own_spread, offset * spreads[name]))
    viscous = [slope * drag.values[f"viscous_{name}"] for name, slope in slopes.items()]
    values["viscous"] = float(np.mean(viscous))
    deviations["viscous"] = float(
        hypot(*(slopes[name] * drag.deviations[f"viscous_{name}"] for name in slopes)) / 2.0
    )
    mean = float(np.mean(list(slopes.values())))
    fit = Fit(values, deviations, mean * drag.residual, drag.equations, drag.condition)
    law = law_of(fit)
    inertia = {load: mean * own.values["inertia"] for load, own in over.items()}
    return TorqueFit(law, fit, np.array(list(_turned_points(windows, motions, law, inertia))))


BLOCK: Final = 8
"""Samples a point of joint 1's figure is averaged over."""


def _turned_points(
    windows: list[Window], motions: list[Motion], law: TorqueLaw, inertia: dict[bool, float]
) -> Iterable[tuple[float, float, float]]:
    """Required torque: only friction at constant speed, inertia times acceleration in a burst."""
    for window in windows:
        yield window.current, law.viscous * window.speed, float(np.sign(window.speed))
    for motion in motions:
        for start in range(0, len(motion.q) - BLOCK, BLOCK):
            rows = slice(start + 1, start + BLOCK + 1)
            seconds = motion.time[start + BLOCK] - motion.time[start]
            acceleration = (motion.qd[start + BLOCK] - motion.qd[start]) / seconds
            torque = inertia[motion.load] * acceleration + law.viscous * motion.qd[rows].mean()
            yield float(motion.current[rows].mean()), float(torque), motion.direction


def _drag(windows: list[Window], what: str) -> Fit:
    """Current, in codes, at constant speed: offset and viscous term per direction."""
    names = ("offset_positive", "offset_negative", "viscous_positive", "viscous_negative")
    rows = [
        (1.0, 0.0, w.speed, 0.0) if w.speed > 0.0 else (0.0, 1.0, 0.0, w.speed) for w in windows
    ]
    return solve(names, np.array(rows).reshape(-1, 4), np.array([w.current for w in windows]), what)


def _dragged(drag: Fit, motion: Motion, name: str) -> Floats:
    """Current for friction along a motion, codes; at the middle of each period."""
    speed = motion.qd.copy()
    speed[1:] = 0.5 * (motion.qd[1:] + motion.qd[:-1])
    drawn: Floats = drag.values[f"offset_{name}"] + drag.values[f"viscous_{name}"] * speed
    return drawn


def _law_row(current: float, speed: float) -> tuple[float, float, float, float, float]:
    if speed > 0.0:
        return (current, 1.0, 0.0, 0.0, -speed)
    return (0.0, 0.0, current, 1.0, -speed)


def law_of(fit: Fit) -> TorqueLaw:
    """The law among the unknowns of a fit."""
    return TorqueLaw(*(fit.values[name] for name in LAW))
