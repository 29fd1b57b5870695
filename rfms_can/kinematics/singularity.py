"""Where the arm loses a degree of freedom: elbow, shoulder and wrist."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.errors import SingularityError
from rfms_can.kinematics.geometry import Geometry


class SingularityMargins(NamedTuple):
    """Distances of a pose from the singularities: zero is singular, the sign is the configuration.

    det J = a2 L * elbow * shoulder * wrist, L = hypot(a3, d4).

    Attributes:
        elbow: sine of the bend between upper arm and forearm; C3 where a3 = 0.
        shoulder: V114, metres: distance of the wrist centre from the joint-1 axis, in the
            forearm's plane.
        wrist: S5.
    """

    elbow: float
    shoulder: float
    wrist: float


REGULAR_BOUNDS: Final = SingularityMargins(elbow=1e-6, shoulder=1e-6, wrist=1e-6)
"""Smallest margins (sine, metres, sine) at which J is inverted, accurate to ten digits there."""

NEAR: Final = 0.1
"""Margin (sine, part of a2) under which a singularity is to blame for how fast a joint turns."""

_REMEDIES: Final = {
    "elbow": "bend joint 3 away from the stretched or folded arm",
    "shoulder": "move the wrist centre away from the joint-1 axis",
    "wrist": "turn joint 5, which has joints 4 and 6 in line",
}


def singularity_margins(arm: Geometry, q: Sequence[float]) -> SingularityMargins:
    """The three numbers that vanish where the Jacobian cannot be inverted."""
    _, q2, q3, _, q5, _ = q
    a3, d4 = arm.a3, arm.d4
    s23, c23 = math.sin(q2 + q3), math.cos(q2 + q3)
    return SingularityMargins(
        elbow=(d4 * math.cos(q3) + a3 * math.sin(q3)) / math.hypot(a3, d4),
        shoulder=arm.a2 * math.cos(q2) + a3 * c23 - d4 * s23,
        wrist=math.sin(q5),
    )


class Nearness(NamedTuple):
    """The singularity a pose is nearest to.

    Attributes:
        name: elbow, shoulder or wrist.
        margin: sine, or distance as a part of a2; its sign is the configuration.
    """

    name: str
    margin: float

    @property
    def is_near(self) -> bool:
        """Whether it is so near that joints turn fast because of it."""
        return abs(self.margin) < NEAR

    @property
    def text(self) -> str:
        """In words."""
        return _IN_WORDS[self.name].format(abs(self.margin))


_IN_WORDS: Final = {
    "elbow": "the elbow singularity (stretched or folded arm, sine of the bend {:.2g})",
    "shoulder": "the shoulder singularity (wrist centre {:.2g} a2 from the joint-1 axis)",
    "wrist": "the wrist singularity (|sin theta5| = {:.2g})",
}


def nearest_singularity(arm: Geometry, q: Sequence[float]) -> Nearness:
    """Which singularity the joint angles ``q``, rad, are nearest to."""
    elbow, shoulder, wrist = singularity_margins(arm, q)
    margins = {"elbow": elbow, "shoulder": shoulder / abs(arm.a2), "wrist": wrist}
    return Nearness(*min(margins.items(), key=lambda item: abs(item[1])))


def require_regular(arm: Geometry, q: Sequence[float]) -> None:
    """Refuse a pose whose Jacobian cannot be inverted.

    Raises:
        SingularityError: names the singularity, its number and the bound of ``REGULAR_BOUNDS``.
    """
    margins = singularity_margins(arm, q)
    for name, margin, bound in zip(margins._fields, margins, REGULAR_BOUNDS, strict=True):
        if not abs(margin) >= bound:
            unit = " m" if name == "shoulder" else ""
            raise SingularityError(
                f"{arm.name}: {name} singularity: margin {margin:.3g}{unit} is within "
                f"{bound:g}{unit} of zero: {_REMEDIES[name]}"
            )
