"""Whether what the joints will do is within what they may."""

from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

import numpy as np

from rfms_can.errors import JointLimitError
from rfms_can.kinematics import Geometry, nearest_singularity
from rfms_can.master.trajectory.braking import STOPPING_FRACTION
from rfms_can.master.trajectory.planning.curve import Floats
from rfms_can.master.trajectory.planning.preview import Phase

ROUNDING: Final = 1e-6
"""Part by which a limit may be passed: a mode that asks for the limit itself gets it."""

RANGE_ROUNDING: Final = 1e-4
"""Rad a joint may be past the end of its range: what joints estimate of a path that ends there may
be so much off. Joints take ten times that, and no pose that is solved is beyond the end."""

STOPS_PAST_END: Final = 0.02
"""Rad past it by which a controlled stop must end: a node takes 0.05 for SOFT_LIMIT, the commanded
trajectory 0.045, and what joints estimate of a path takes up to 6e-3 of the rest."""


class LimitedArm(Geometry, Protocol):
    """The geometry of an arm, and how fast its joints may run and accelerate."""

    @property
    def speed_limits(self) -> Sequence[float]:
        """rad/s, one per joint."""

    @property
    def acceleration_limits(self) -> Sequence[float]:
        """rad/s2, one per joint."""


class Excess(NamedTuple):
    """The limit that is broken worst.

    Attributes:
        what: joint, value, limit and place, in words.
        ratio: value to limit.
        slower: times the segment time it takes, if nothing else adds to it.
        blending: whether it is an acceleration in a transition, which a longer one lowers.
    """

    what: str
    ratio: float
    slower: float
    blending: bool


def peaks(phases: Sequence[Phase]) -> tuple[Floats, Floats]:
    """Largest speed and acceleration of each joint, rad/s and rad/s2; shapes (6,)."""
    _, speeds, accelerations = np.max(
        [np.abs(phase.motion).max(axis=1) for phase in phases], axis=0
    )
    return speeds, accelerations


def worst_excess(arm: LimitedArm, phases: Sequence[Phase]) -> Excess | None:
    """The broken speed or acceleration limit that takes the longest time to mend; None if none."""
    worst: Excess | None = None
    for phase in phases:
        sizes = np.abs(phase.motion[1:])
        values = sizes.max(axis=1)
        ratios = values / (arm.speed_limits, arm.acceleration_limits)
        for order, (verb, unit, limits) in enumerate(
            (
                ("run at", "rad/s", arm.speed_limits),
                ("accelerate at", "rad/s2", arm.acceleration_limits),
            )
        ):
            joint = int(ratios[order].argmax())
            ratio = float(ratios[order, joint])
            slower = ratio**0.5 if order and phase.even else ratio
            if ratio > 1.0 + ROUNDING and (worst is None or slower > worst.slower):
                sample = int(sizes[order, :, joint].argmax())
                what = (
                    f"joint {joint + 1} of {arm.name} would {verb} {values[order, joint]:.4g} "
                    f"{unit} {phase.where}, its limit is {limits[joint]:g} {unit}"
                    f"{_near_singular(arm, phase.motion[0, sample].tolist())}"
                )
                worst = Excess(what, ratio, slower, bool(order) and not phase.even)
        stop = _unstoppable(arm, phase)
        if stop is not None and (worst is None or stop.slower > worst.slower):
            worst = stop
    return worst


def _unstoppable(arm: LimitedArm, phase: Phase) -> Excess | None:
    """A joint that runs towards an end of its range faster than its node could stop it there."""
    angles, speeds, _ = phase.motion
    lower, upper = np.array(arm.joint_limits).T
    room = np.where(speeds > 0.0, upper - angles, angles - lower) + STOPS_PAST_END
    needs = speeds * speeds / (2.0 * STOPPING_FRACTION * np.array(arm.acceleration_limits))
    ratios = needs / np.maximum(room, ROUNDING)
    ratio = float(ratios.max())
    if ratio <= 1.0 + ROUNDING:
        return None
    sample, joint = (int(k) for k in np.unravel_index(ratios.argmax(), ratios.shape))
    what = (
        f"joint {joint + 1} of {arm.name} would run at {abs(speeds[sample, joint]):.4g} rad/s at "
        f"{angles[sample, joint]:.6g} rad {phase.where}, where its node, which stops at "
        f"{STOPPING_FRACTION:g} of its acceleration limit, would be {STOPS_PAST_END:g} rad past "
        f"the end of its range"
    )
    return Excess(what, ratio, ratio**0.5, False)


def _near_singular(arm: Geometry, q: Sequence[float]) -> str:
    """The singularity that makes joints fast at ``q``, rad, in words; nothing away from all."""
    near = nearest_singularity(arm, q)
    return f", next to {near.text}" if near.is_near else ""


def check_ranges(arm: LimitedArm, phases: Sequence[Phase], sequence: int) -> None:
    """Every set-point within the joints' ranges.

    Raises:
        JointLimitError: a transition swings past the end of one.
    """
    lower, upper = np.array(arm.joint_limits).T
    for phase in phases:
        angles = phase.motion[0]
        past = np.maximum(lower - angles, angles - upper)
        if past.max() > RANGE_ROUNDING:
            sample, joint = np.unravel_index(past.argmax(), past.shape)
            raise JointLimitError(
                f"move {sequence}: joint {joint + 1} of {arm.name} would reach "
                f"{angles[sample, joint]:.6g} rad {phase.where}, outside [{lower[joint]:.6g}, "
                f"{upper[joint]:.6g}] rad"
            )
