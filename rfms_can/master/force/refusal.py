"""Reasons to refuse a move: bias force, load, tare and guard, judged before it is accepted."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.arm import Arm, Load
from rfms_can.compliance import compliance_jacobian
from rfms_can.compliance.selection import DIRECTIONS, Selection
from rfms_can.master.force.bias import BIAS_FRACTION
from rfms_can.master.force.guards import DISTANCES, reached_force
from rfms_can.master.force.specification import Guard
from rfms_can.master.force.wrench import in_frame, weight
from rfms_can.master.force.wrench_estimate import WrenchEstimate
from rfms_can.messages import Vector6
from rfms_can.transform import Transform

Matrix = npt.NDArray[np.float64]


def bias_refusal(J: Matrix, bias: Vector6, torque_limits: Sequence[float]) -> str | None:
    """Which joint a bias force overloads, and the fraction of the bias that it could bear; or None.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        bias: N and N m, in that frame.
        torque_limits: of the joints, Nm.
    """
    joint, torque, limit = _critical_joint(J.T @ np.array(bias), torque_limits)
    if torque <= limit:
        return None
    words = ", ".join(
        f"{name} {value:g}" for name, value in zip(DIRECTIONS, bias, strict=True) if value
    )
    fraction = _floored(limit / torque)
    return (
        f"the bias {words} takes {torque:.1f} Nm of joint {joint}, which has {limit:.1f} Nm for "
        f"it: ask for {fraction:g} of it or less"
    )


def load_refusal(
    J: Matrix, load: Load | None, T6: Transform, torque_limits: Sequence[float]
) -> str | None:
    """Which joint a load overloads, and the mass that it could hold; or None.

    Args:
        J: (6, 6), Jacobian in the T6 frame.
        load: in the hand.
        T6: pose of the hand.
        torque_limits: of the joints, Nm.
    """
    if load is None:
        return None
    joint, torque, limit = _critical_joint(J.T @ np.array(weight(load, T6)), torque_limits)
    if torque <= limit:
        return None
    held = _floored(load.mass * limit / torque)
    return (
        f"the mass {load.mass:g} kg takes {torque:.1f} Nm of joint {joint}, which has "
        f"{limit:.1f} Nm for it: {held:g} kg or less can be held here"
    )


def tare_refusal(selection: Selection, estimate: WrenchEstimate) -> str | None:
    """Why the force loop may not be closed over a sensor whose bias is not known, or None.

    Args:
        selection: what is to comply.
        estimate: the wrench of the hand, by the sensor.
    """
    if estimate.tared or not selection.size:
        return None
    return (
        f"it complies in {selection.word} with the force loop closed over a sensor that was not "
        "tared, and its bias would send the arm off: tare first, at rest and touching nothing, "
        "or run with --force-loop open"
    )


def _floored(value: float) -> float:
    """The value to two digits, and not more than it is."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / digit) * digit


def _critical_joint(
    torques: npt.NDArray[np.float64], torque_limits: Sequence[float]
) -> tuple[int, float, float]:
    """The joint nearest to its limit: its number, its torque, and its limit for this, Nm."""
    limits = [BIAS_FRACTION * limit for limit in torque_limits]
    loads = [abs(torque) / limit for torque, limit in zip(torques.tolist(), limits, strict=True)]
    worst = max(range(len(loads)), key=loads.__getitem__)
    return worst + 1, abs(float(torques[worst])), limits[worst]


def guard_refusal(
    guard: Guard, estimate: WrenchEstimate, J: Matrix, frame: Transform, arm: Arm, rests: bool
) -> str | None:
    """Why a guard would stop its move before it has met anything, or would never; or None.

    Args:
        guard: of the move.
        estimate: the wrench of the hand, and how well it is known.
        J: (6, 6), Jacobian in the T6 frame.
        frame: the compliance frame in T6.
        arm: whose encoders and torques bound what can be known.
        rests: whether the arm rests where the move begins.
    """
    torque_limits = [drive.torque_limit for drive in arm.drives]
    largest = estimate.measurable_limit(J, frame, torque_limits).tolist()
    for name, bound, limit in zip(DIRECTIONS, guard.force, largest, strict=True):
        if bound >= limit:
            return (
                f"stop on force {name} {bound:g}: no more than {limit:.4g} can be measured there; "
                "give less"
            )
    counts = np.array([1.0 / abs(drive.counts_per_radian) for drive in arm.drives])
    resolution = (np.abs(compliance_jacobian(J, frame)) @ counts).tolist()
    for name, bound, least in zip(DISTANCES, guard.distance, resolution, strict=True):
        if 0.0 < bound <= least:
            return (
                f"stop on distance {name} {bound:g}: one count of each encoder is up to "
                f"{least:.2g} there; give more"
            )
    if estimate.sensed:
        reached = reached_force(guard, in_frame(estimate.wrench, frame)) if rests else None
        return reached and f"its stop condition holds already: {reached}"
    hidden = estimate.friction_uncertainty(J, frame).tolist()
    for name, bound, least in zip(DIRECTIONS, guard.force, hidden, strict=True):
        if 0.0 < bound < least:
            return (
                f"stop on force {name} {bound:g}: without a wrist sensor friction hides up to "
                f"{least:.3g} there; give more, or run with a sensor"
            )
    return None
