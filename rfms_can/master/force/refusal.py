"""Why the force that a move asks for cannot be had, or what shall stop it would not."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rfms_can.compliance.selection import DIRECTIONS
from rfms_can.master.force.bias import BIAS_PART
from rfms_can.master.force.felt import Felt
from rfms_can.master.force.guards import reached_force
from rfms_can.master.force.specification import Guard
from rfms_can.master.force.wrench import in_frame
from rfms_can.messages import Vector6
from rfms_can.transform import Transform, differential_transform

Matrix = npt.NDArray[np.float64]


def too_strong(J: Matrix, bias: Vector6, torque_limits: Sequence[float]) -> str | None:
    """Which joint a bias force takes too much of, and what part of the bias would do; or None.

    Args:
        J: (6, 6), Jacobian of the compliance frame.
        bias: N and N m, in that frame.
        torque_limits: of the joints, Nm.
    """
    for joint, torque in enumerate((J.T @ np.array(bias)).tolist(), start=1):
        limit = BIAS_PART * torque_limits[joint - 1]
        if abs(torque) > limit:
            words = ", ".join(
                f"{name} {value:g}" for name, value in zip(DIRECTIONS, bias, strict=True) if value
            )
            part = math.floor(100.0 * limit / abs(torque)) / 100.0  # none too much
            return (
                f"the bias {words} takes {abs(torque):.1f} Nm of joint {joint}, which has "
                f"{limit:.1f} Nm for it: ask for {part:g} of it or less"
            )
    return None


def trips_at_once(guard: Guard, felt: Felt, J: Matrix, frame: Transform, rests: bool) -> str | None:
    """Why a guard would stop its move before it has met anything, or None.

    Args:
        guard: of the move.
        felt: what the hand feels, or how little it can know of it.
        J: (6, 6), Jacobian in the T6 frame.
        frame: the compliance frame in T6.
        rests: whether the arm rests where the move begins.
    """
    if felt.sensed:
        reached = reached_force(guard, in_frame(felt.wrench, frame)) if rests else None
        return reached and f"its stop condition holds already: {reached}"
    to_frame = np.abs(np.array(differential_transform(frame.inverse())).T)
    unsure = to_frame @ felt.uncertainty(J)
    for name, bound, least in zip(DIRECTIONS, guard.force, unsure.tolist(), strict=True):
        if 0.0 < bound < least:
            return (
                f"stop on force {name} {bound:g}: without a wrist sensor friction hides up to "
                f"{least:.3g} there; give more, or run with a sensor"
            )
    return None
