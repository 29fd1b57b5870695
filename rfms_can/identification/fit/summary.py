"""Identified and true values as plain numbers, for tables and JSON."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from rfms_can.arm.calibration import Calibration
from rfms_can.dynamics.fitted import random_poses
from rfms_can.dynamics.model import DynamicsModel
from rfms_can.dynamics.rigid_body import ArmDynamics
from rfms_can.dynamics.simplified import SimplifiedDynamics
from rfms_can.dynamics.terms import CONSTANTS, GRAVITY
from rfms_can.identification.compensation_comparison import Tracking
from rfms_can.identification.fit.result import Identification
from rfms_can.identification.fit.torque import LAW
from rfms_can.identification.fit.truth import VERDICTS, identities, thesis_constants

POSES = 200
SEED = 7


class Figure(NamedTuple):
    """One figure.

    Attributes:
        name: of the parameter.
        value, deviation: identified.
        truth: of the plant.
        error: difference over the size of such parameters.
    """

    name: str
    value: float
    deviation: float
    truth: float
    error: float


def torque_figures(found: Calibration, truth: Calibration) -> list[list[Figure]]:
    """Eq. 4.13 of each joint (6)."""
    table = []
    for ours, theirs in zip(found.joints, truth.joints, strict=True):
        row = []
        for name in (*LAW, "static_positive", "static_negative"):
            value, true = getattr(ours, name), getattr(theirs, name)
            row.append(Figure(name, value, ours.deviations[name], true, (value - true) / true))
        table.append(row)
    return table


def constant_figures(found: Calibration, truth: Calibration) -> list[Figure]:
    """Eq. 4.9, 4.11, 4.12; errors relative to the largest of their kind: c, b of a joint."""
    figures = []
    for name in CONSTANTS:
        kind = GRAVITY if name in GRAVITY else [k for k in CONSTANTS if k[:2] == name[:2]]
        size = max(abs(truth.constants[other]) for other in kind)
        value, true = found.constants[name], truth.constants[name]
        figures.append(Figure(name, value, found.deviations[name], true, (value - true) / size))
    return figures


class Models(NamedTuple):
    """Accuracy of both models over random poses.

    Attributes:
        effective: largest relative error of Ia_i + D_ii: simplified and full (2, 6).
        coupling: rms of all D_ij, and rms error of the full model's, kg m2.
        gravity: largest error of D_i, simplified and full, relative to the largest (2).
    """

    effective: list[list[float]]
    coupling: tuple[float, float]
    gravity: list[float]


def compare_models(found: Identification, calibration: Calibration, truth: Calibration) -> Models:
    """Both models against the plant's own."""
    arm = found.arm
    true = ArmDynamics(arm, np.array(truth.parameters), truth.armature)
    full = ArmDynamics(arm, np.array(calibration.parameters), calibration.armature)
    simple = SimplifiedDynamics(arm, calibration.constants)
    effective: list[list[Any]] = [[], []]
    gravity: list[list[Any]] = [[], []]
    coupling, off, held = [], [], []
    aside = ~np.eye(len(arm.drives), dtype=bool)
    for q in random_poses(arm, POSES, SEED):
        true.update(q)
        ours: tuple[DynamicsModel, DynamicsModel] = (simple, full)
        for k, model in enumerate(ours):
            model.update(q)
            effective[k].append(np.abs(np.diag(model.M) / np.diag(true.M) - 1.0))
            gravity[k].append(np.abs(model.g - true.g).max())
        held.append(np.abs(true.g).max())
        coupling.append(true.M[aside])
        off.append(full.M[aside] - true.M[aside])
    return Models(
        [np.max(errors, axis=0).tolist() for errors in effective],
        (float(np.sqrt(np.mean(np.square(coupling)))), float(np.sqrt(np.mean(np.square(off))))),
        [float(np.max(errors) / np.max(held)) for errors in gravity],
    )


def summary(
    found: Identification,
    calibration: Calibration,
    truth: Calibration,
    tracking: Sequence[Tracking] | None,
) -> dict[str, Any]:
    """For JSON."""
    models = compare_models(found, calibration, truth)
    thesis = thesis_constants()
    return {
        "arm": found.arm.name,
        "torque": [
            {figure.name: figure._asdict() for figure in row}
            for row in torque_figures(calibration, truth)
        ],
        "converters": [fit.values for fit in found.converters],
        "constants": {
            figure.name: {
                **figure._asdict(),
                "thesis": thesis.get(figure.name),
                "verdict": VERDICTS[figure.name].word if figure.name in VERDICTS else None,
            }
            for figure in constant_figures(calibration, truth)
        },
        "models": models._asdict(),
        "validation": found.validation.tolist(),
        "identities": [each._asdict() for each in identities(found.arm, found.constants)],
        "notes": found.notes,
        "tracking": None
        if tracking is None
        else {run.name: {"rms": run.rms, "largest": run.largest} for run in tracking},
    }
