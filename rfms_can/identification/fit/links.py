"""Inertial parameters of all links at once, by the regressor of Newton-Euler (Pinocchio's).

The coupling inertias D_ij, which the thesis could not isolate, act in motions in which several
joints accelerate. The torques are linear in the links' parameters,

    tau = Y(q, qd, qdd) pi + Ia qdd + friction,

and the equations of all motions determine the base parameters, the combinations that torques depend
on. A weak prior, the size of such an arm's parameters, determines the others.
"""

from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.analysis.cycles import Floats
from rfms_can.arm import JOINT_COUNT, Arm
from rfms_can.arm.torque_law import TorqueLaw
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.identification.fit.trace import Trace

HALF: Final = 6
"""Samples to either side in the window of a derivative."""
DEGREE: Final = 3
BLOCK: Final = 8
"""Samples an equation averages over; motions are slower."""
MOVING: Final = 0.04
"""Joint speed over its limit below which the joint may stick: it then gets no equation."""
PARAMETERS: Final = 10
GAUGE_MASS: Final = 1.0
"""kg: prior mass of a link, where torques do not determine it."""
PRIOR: Final = np.array([1e-3, *(5.0,) * 3, *(2.0,) * 6])
"""Standard deviations of the prior: mass (kg), first moments (kg m), inertia (kg m2)."""
ARMATURE_PRIOR: Final = 5.0


class LinkFit(NamedTuple):
    """Inertial parameters that give the same torques as the true ones.

    Attributes:
        parameters: (6, 10), as ``ArmDynamics.parameters``.
        armature: kg m2 (6).
        residual: of each joint's torque, root mean square, Nm (6).
        equations: of each joint (6).
        determined: number of combinations determined by the data rather than by the prior.
        covariance: of parameters and armature (66, 66).
    """

    parameters: Floats
    armature: Floats
    residual: Floats
    equations: Floats
    determined: int
    covariance: Floats

    def drawn(self, draw: np.random.Generator) -> tuple[Floats, Floats]:
        """One random draw of parameters and armature from their distribution."""
        mean = np.concatenate((self.parameters.ravel(), self.armature))
        eigenvalues, vectors = np.linalg.eigh(self.covariance)
        deviations = np.sqrt(np.clip(eigenvalues, 0.0, None))
        drawn = mean + vectors @ (deviations * draw.standard_normal(len(mean)))
        links = drawn[: PARAMETERS * JOINT_COUNT].reshape(JOINT_COUNT, PARAMETERS)
        return links, drawn[PARAMETERS * JOINT_COUNT :]


class Samples(NamedTuple):
    """States and torques, each averaged over a block of samples.

    Attributes:
        regressor: of parameters and armature, (n, 6, 66).
        torque: of the motors, friction subtracted, Nm (n, 6).
        moving: which joints certainly move (n, 6).
    """

    regressor: Floats
    torque: Floats
    moving: npt.NDArray[np.bool_]


def smoothed(values: Floats, period_s: float, order: int) -> Floats:
    """Derivative of an order by a local polynomial (Savitzky and Golay), along the first axis.

    ``HALF`` rows are lost at either end.
    """
    steps = np.arange(-HALF, HALF + 1) * period_s
    powers = np.vander(steps, DEGREE + 1, increasing=True)
    kernel = np.linalg.pinv(powers)[order] * (1.0, 1.0, 2.0)[order]
    windows = np.lib.stride_tricks.sliding_window_view(values, 2 * HALF + 1, axis=0)
    result: Floats = windows @ kernel
    return result


def samples_of(trace: Trace, arm: Arm, laws: Sequence[TorqueLaw], model: ArmDynamics) -> Samples:
    """Equations of a trace, in all its marked motions."""
    q, qd, qdd = (smoothed(trace.q, trace.period_s, order) for order in (0, 1, 2))
    # A current is held for the period before its row: half of it belongs to the row before.
    middle = 0.5 * (trace.current[:-1] + trace.current[1:])
    current = smoothed(np.concatenate((middle, middle[-1:])), trace.period_s, 0)
    limits = np.array(arm.speed_limits)
    moving = np.abs(qd) > MOVING * limits
    torque = _driving(current, qd, laws)
    rows = [
        start
        for mark in trace.marks
        for start in range(mark.start, mark.stop - 2 * HALF - BLOCK, BLOCK)
        if moving[start : start + BLOCK].all(axis=0).any()
    ]
    regressors, torques, sure = [], [], []
    for start in rows:
        block = slice(start, start + BLOCK)
        states = zip(q[block], qd[block], qdd[block], strict=True)
        regressors.append(np.mean([_whole(model, *state) for state in states], axis=0))
        torques.append(torque[block].mean(axis=0))
        steady = moving[block].all(axis=0) & (np.ptp(np.sign(qd[block]), axis=0) == 0.0)
        sure.append(steady)
    width = (PARAMETERS + 1) * JOINT_COUNT
    return Samples(
        np.array(regressors, dtype=np.float64).reshape(-1, JOINT_COUNT, width),
        np.array(torques, dtype=np.float64).reshape(-1, JOINT_COUNT),
        np.array(sure, dtype=np.bool_).reshape(-1, JOINT_COUNT),
    )


def _driving(current: Floats, qd: Floats, laws: Sequence[TorqueLaw]) -> Floats:
    """Torque by the laws for current and speed, Nm (n, 6)."""
    columns = []
    for joint, law in enumerate(laws):
        own, speed = current[:, joint], qd[:, joint]
        positive = law.slope_positive * own + law.offset_positive
        negative = law.slope_negative * own + law.offset_negative
        columns.append(np.where(speed > 0.0, positive, negative) - law.viscous * speed)
    return np.column_stack(columns)


def _whole(model: ArmDynamics, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    return np.hstack((model.regressor(q, qd, qdd), np.diag(qdd)))


def fit_links(samples: Iterable[Samples]) -> LinkFit:
    """Fit of the parameters to all samples, each joint weighted by its residual."""
    parts = list(samples)
    chosen = [
        (
            np.concatenate([s.regressor[s.moving[:, joint], joint] for s in parts]),
            np.concatenate([s.torque[s.moving[:, joint], joint] for s in parts]),
        )
        for joint in range(JOINT_COUNT)
    ]
    prior = np.concatenate((np.tile(PRIOR, JOINT_COUNT), np.full(JOINT_COUNT, ARMATURE_PRIOR)))
    centre = np.zeros(len(prior))
    centre[0 : PARAMETERS * JOINT_COUNT : PARAMETERS] = GAUGE_MASS
    noise = np.array([0.05 * float(np.abs(torque).mean()) for _, torque in chosen])
    solution, normal = centre, np.zeros((len(prior), len(prior)))
    for _ in range(4):
        normal = np.diag(np.ones(len(prior)))
        right = np.zeros(len(prior))
        for (matrix, torque), spread in zip(chosen, noise, strict=True):
            scaled = matrix * prior / spread
            normal += scaled.T @ scaled
            right += scaled.T @ ((torque - matrix @ centre) / spread)
        solution = centre + prior * np.linalg.solve(normal, right)
        errors = [torque - matrix @ solution for matrix, torque in chosen]
        noise = np.array([float(np.sqrt(np.mean(error**2))) for error in errors])
    links, armature = solution[: PARAMETERS * JOINT_COUNT], solution[PARAMETERS * JOINT_COUNT :]
    return LinkFit(
        links.reshape(JOINT_COUNT, PARAMETERS),
        armature,
        noise,
        np.array([len(torque) for _, torque in chosen]),
        int((np.linalg.eigvalsh(normal) > 2.0).sum()),
        np.asarray(np.linalg.inv(normal) * np.outer(prior, prior), dtype=np.float64),
    )
