"""The master verifies: what it commanded against MEASURE, and MEASURE against ERROR.

A node that computes another set-point, or sends an old torque, tells an error that looks well while
its joint goes elsewhere. So the master looks for itself, once a cycle, at each joint's

    following error  =  commanded angle + displacement (COMPLY) - measured angle,

and asks two things of it:

- it is the error that the node tells in ERROR. Both are made of the same float32 set-point and the
  same encoder counts, so they agree to the rounding of float32, whatever the law, the load or the
  contact, and whether the arm complies or not;
- it is within a bound: each joint's own error where the arm is rigid; where it complies what the
  rows in force make of the six errors (C_theta e of Eq. 5.10), which is what the law still holds.
  Laws that hold joints, or give a stiffness, do not part the directions that are held: a peg that
  jams leaves any error. What a law lets go is bounded by the displacement of COMPLY.

Either must be wrong for ``CYCLES`` cycles in a row: a node bridges two samples of an encoder that
jumped. What was not heard in a cycle is not judged in it.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.master.fault import Fault
from rfms_can.messages.culprit import Culprit
from rfms_can.wire.nodes import JOINTS, MASTER, NODE_NAMES
from rfms_can.wire.vocabulary import Parameter

Matrix = npt.NDArray[np.float64]

CYCLES: Final = 3
"""Cycles in a row: one more than a node predicts over a jump of its encoder."""
AGREEMENT: Final = 5e-5
"""Largest difference of ERROR and following error, rad: a quarter of the coarsest encoder's count,
fifty times what a node's arithmetic may be off. Ours are 3e-8 rad off, beside a singularity. A
joint in motion follows with 2e-4 rad of error, so that one that always tells 0 is found out."""
DOUBT_CYCLES: Final = 1.0
"""What may be added after a cycle without ERROR, until the arm is at rest, in cycles at the speed
limit: a joint without a set-point extrapolates the past that its next transition departs from."""
TORQUE_FRACTION: Final = 0.5
"""Following error over the error at which the proportional torque alone is the torque limit. Load,
friction, bias and contact together may take half of a joint's torque; what is off by more than they
explain does not follow."""
LEAST: Final = 0.03
"""Least bound of the following error, rad. Half of the torque of a PUMA 560's joints 1 and 2 is at
0.02 rad; experiments of identification, which run fast without a model, leave 0.013 there."""
MOST: Final = 0.1
"""Largest bound of the following error, rad: half of FOLLOWING_ERROR_LIMIT."""
COMPLYING_FACTOR: Final = 2.0
"""The bound of what is held while something complies, over that of a rigid joint: the servos see to
all six errors at once, and the peg beside its hole leaves 0.6 of a rigid joint's."""
MODELLED_FREQUENCY: Final = 30.0
"""Natural frequency, rad/s, from which LEAST and MOST hold without a model; a softer servo leaves
an error that is larger by the square, since gravity and inertia are errors then."""

_ALL: Final = (1 << len(JOINTS)) - 1
_NONE: Final = (0.0,) * len(JOINTS)


def following_bounds(
    parameters: Mapping[int, Mapping[Parameter, float]], *, modelled: bool, largest: float = 0.0
) -> tuple[float, ...]:
    """Bounds of the following error, rad (6).

    Args:
        parameters: configuration of joint nodes 1 to 6.
        modelled: whether the servos compensate gravity and inertia.
        largest: the bound of all joints instead, rad; 0 for the bounds by their stiffness.
    """
    if largest:
        return (largest,) * len(JOINTS)
    bounds = []
    for joint in JOINTS:
        p = parameters[joint]
        softness = 1.0
        if not modelled and p[Parameter.NATURAL_FREQUENCY]:
            softness = max(1.0, (MODELLED_FREQUENCY / p[Parameter.NATURAL_FREQUENCY]) ** 2)
        most = MOST * softness
        bound = most
        if p[Parameter.KP]:
            bound = TORQUE_FRACTION * p[Parameter.TORQUE_LIMIT] / p[Parameter.KP]
        bounds.append(min(most, max(LEAST * softness, bound)))
    return tuple(bounds)


class _Seen(NamedTuple):
    """A cycle as it was seen: angles and errors in rad (6)."""

    goals: Sequence[float]
    measured: Sequence[float]
    told: Sequence[float]
    cycle: int
    altered: int


class Verification:
    """Of six joints.

    Args:
        parameters: configuration of joint nodes 1 to 6.
        modelled: whether the servos compensate gravity and inertia.
        parts_directions: whether the law's rows part what is held from what complies.
        largest: see ``following_bounds``.

    Attributes:
        bounds: of the following error, rad (6).
    """

    __slots__ = (
        "_altered",
        "_doubt",
        "_doubted",
        "_parts_directions",
        "_strayed",
        "_untrue",
        "_watching",
        "bounds",
    )

    def __init__(
        self,
        parameters: Mapping[int, Mapping[Parameter, float]],
        *,
        modelled: bool = True,
        parts_directions: bool = True,
        largest: float = 0.0,
    ) -> None:
        self._parts_directions: Final = parts_directions
        self.bounds: Final = following_bounds(parameters, modelled=modelled, largest=largest)
        self._doubt: Final = tuple(
            DOUBT_CYCLES
            * parameters[joint][Parameter.SPEED_LIMIT]
            * parameters[joint][Parameter.PERIOD]
            for joint in JOINTS
        )
        self.reset()

    def reset(self) -> None:
        """The arm is enabled: nothing is known against any joint."""
        self._strayed = [0] * len(JOINTS)  # cycles in a row beyond the bound
        self._untrue = [0] * len(JOINTS)  # cycles in a row in which ERROR told another error
        self._doubted = 0  # bits of joints that have missed a cycle since the arm rested last
        self._altered = 0  # set-points gone out altered, by the last cycle that was right
        self._watching = False  # whether any count is not zero, or any joint is doubted

    def check(
        self,
        commanded: Sequence[float],
        displacement: Sequence[float] | None,
        measured: Sequence[float],
        told: Sequence[float],
        heard: int = _ALL,
        held: Matrix | None = None,
        *,
        cycle: int = 0,
        altered: int = 0,
    ) -> Fault | None:
        """Take a cycle of an enabled arm.

        Args:
            commanded: angles of the set-point that went out with SYNC, rad (6).
            displacement: what went out with it in COMPLY, rad (6), or None.
            measured: encoder angles sampled at that SYNC, rad (6).
            told: ERROR of the cycle, rad (6).
            heard: bits of the joints whose MEASURE and ERROR are of this cycle; bit 0 is joint 1.
            held: (6, 6), rows of the law in force, where the arm complies; None where it is rigid.
            cycle: its number.
            altered: set-points, so far, that have gone out otherwise than the master made them.

        Returns:
            Who is to blame that a joint must not go on, and why; None if all may.
        """
        goals = commanded
        if displacement is not None:
            goals = [goal + shift for goal, shift in zip(commanded, displacement, strict=True)]
        seen = _Seen(goals, measured, told, cycle, altered)
        if self._watching or heard != _ALL:
            return self._judge(seen, heard, held)
        if held is None:
            for goal, angle, error, bound in zip(goals, measured, told, self.bounds, strict=True):
                off = goal - angle
                if off > bound or off < -bound or not -AGREEMENT <= off - error <= AGREEMENT:
                    return self._judge(seen, heard, held)
            self._altered = altered
            return None
        errors = [goal - angle for goal, angle in zip(goals, measured, strict=True)]
        for off, error, real, bound in zip(
            errors, told, self._held(held, errors), self.bounds, strict=True
        ):
            if not (-AGREEMENT <= off - error <= AGREEMENT and -bound <= real <= bound):
                return self._judge(seen, heard, held)
        self._altered = altered
        return None

    def _held(self, held: Matrix, errors: Sequence[float]) -> Sequence[float]:
        """What a complying arm is held to of six errors, rad, by the bounds of a rigid one."""
        if not self._parts_directions:
            return _NONE
        real: list[float] = (held @ errors).tolist()
        return [part / COMPLYING_FACTOR for part in real]

    def rested(self) -> None:
        """The arm is commanded to rest: from here on no joint's past matters."""
        if self._doubted:
            self._doubted = 0

    def _judge(self, seen: "_Seen", heard: int, held: Matrix | None) -> Fault | None:
        """Count what is wrong, joint by joint."""
        goals, measured, told = seen.goals, seen.measured, seen.told
        errors = [goal - angle for goal, angle in zip(goals, measured, strict=True)]
        real = errors if held is None else self._held(held, errors)
        self._doubted |= _ALL & ~heard
        for k, bound in enumerate(self.bounds):
            if heard >> k & 1:
                wide = AGREEMENT + (self._doubt[k] if self._doubted >> k & 1 else 0.0)
                true = abs(errors[k] - told[k]) <= wide
                self._untrue[k] = 0 if true else self._untrue[k] + 1
                self._strayed[k] = 0 if abs(real[k]) <= bound else self._strayed[k] + 1
        self._watching = bool(self._doubted) or any(self._untrue) or any(self._strayed)
        if max(self._untrue) >= CYCLES:
            return self._untruth(seen)
        if max(self._strayed) >= CYCLES:
            return self._straying(seen, real, held is not None)
        if not self._watching:
            self._altered = seen.altered
        return None

    def _untruth(self, seen: "_Seen") -> Fault:
        """ERROR of a joint is not what its encoder says: its node is wrong, or the set-point.

        What several joints tell at once, or what comes with a set-point that has gone out altered,
        has the set-point as its cause: each computes its own error.
        """
        goals, measured, told = seen.goals, seen.measured, seen.told
        k = self._untrue.index(max(self._untrue))
        joint, error = k + 1, goals[k] - measured[k]
        wide = AGREEMENT + (self._doubt[k] if self._doubted >> k & 1 else 0.0)
        off = (
            f"ERROR_{joint} tells {told[k]:.6f} rad, but MEASURE_{joint} is {measured[k]:.6f} rad "
            f"where {goals[k]:.6f} rad was commanded, which is {error:.6f} rad (bound {wide:g} "
            f"rad, {CYCLES} cycles)"
        )
        number = f"(cycle {seen.cycle})"
        others = sum(map(bool, self._untrue)) - 1
        numbers = (seen.cycle, told[k] - error, wide)
        if others or seen.altered != self._altered:
            went = "went out altered" if seen.altered != self._altered else "is another one"
            who = f"joint {joint}" + (f" and {others} more" if others else "")
            return Fault(
                f"master: SETPOINT_1 {went} for {who}: {off} {number}",
                Culprit(NODE_NAMES[MASTER], "SETPOINT_1", *numbers),
            )
        return Fault(
            f"joint {joint}: {off}: its node computes another set-point {number}",
            Culprit(NODE_NAMES[joint], f"ERROR_{joint}", *numbers),
        )

    def _straying(self, seen: "_Seen", real: Sequence[float], complies: bool) -> Fault:
        """A joint is not where it was commanded to be: where the arm complies, by the held part."""
        goals, measured = seen.goals, seen.measured
        strayed = [k for k, cycles in enumerate(self._strayed) if cycles >= CYCLES]
        off = [abs(goal - angle) for goal, angle in zip(goals, measured, strict=True)]
        among = range(len(JOINTS)) if complies else strayed  # rows mix the errors of the joints
        k = max(among, key=lambda i: off[i] / self.bounds[i])
        shown = max(strayed, key=lambda i: abs(real[i])) if complies else k
        factor = COMPLYING_FACTOR if complies else 1.0
        joint, value, bound = k + 1, factor * real[shown], factor * self.bounds[shown]
        return Fault(
            f"joint {joint} does not follow: MEASURE_{joint} is {measured[k]:.6f} rad where "
            f"{goals[k]:.6f} rad was commanded ({'held part' if complies else 'rigid'} off by "
            f"{value:.4f} rad, bound {bound:g} rad, {CYCLES} cycles): is it blocked, overloaded, "
            f"or not driven as its node tells? (cycle {seen.cycle})",
            Culprit(NODE_NAMES[joint], f"MEASURE_{joint}", seen.cycle, value, bound),
        )
