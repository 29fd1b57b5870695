"""What numbers a transform may be made of.

A float on a link may be NaN or 1e308: finite numbers are bounded too, because the product of two
such transforms is infinite, and would only be noticed in the middle of a motion.
"""

import math
from collections.abc import Sequence
from typing import Final

from rfms_can.errors import KinematicsError, TransformError
from rfms_can.transform import RIGID_TOLERANCE, Transform

MAX_LENGTH: Final = 1e3
"""Largest coordinate of an origin, m (and of a rotation vector, rad): no arm reaches further."""

MAX_NUMBER: Final = 1e6
"""Largest rate, frequency or parameter."""

MAX_SPEED: Final = 100.0
"""Largest component of a twist, m/s and rad/s: what an arm could follow, many times over."""

OLDEST_S: Final = 1.0
"""Age at which an observation says nothing any more about where its object is, s."""

REST_AFTER_S: Final = 0.2
"""Time in which the prediction of an object that is not observed any more comes to rest, s, unless
the reference states another one: as short as the fades that smooth the noise."""


def check_numbers(name: str, what: str, numbers: Sequence[float], bound: float) -> None:
    """Raise ``TransformError`` unless all are finite and within +-``bound``."""
    for number in numbers:
        if not -bound <= number <= bound:  # also NaN
            raise TransformError(
                f"transform {name!r}: {what} has {number:g}, outside +-{bound:g}; "
                f"give metres, radians and seconds"
            )


def check_rigid(name: str, transform: Transform) -> None:
    """Raise ``TransformError`` unless it is a rotation, and its origin within bounds."""
    if not transform.is_rigid():
        raise TransformError(
            f"transform {name!r} is not a rotation: off by {transform.rigidity_error():.3g}, "
            f"{RIGID_TOLERANCE:g} may be; build it with Transform.rotation and @"
            f"{_or_squared_up(transform)}"
        )
    check_numbers(name, "its origin", (transform.px, transform.py, transform.pz), MAX_LENGTH)


def _or_squared_up(transform: Transform) -> str:
    """A further way out, where there is one: rounded digits."""
    try:
        _, correction = Transform.nearest_rotation(transform)
    except KinematicsError:
        return ""
    return (
        f", or take Transform.nearest_rotation(...).transform, which changes its elements by "
        f"{correction:.2g} at most"
    )


def check_stamp(name: str, stamp: float, now: float, period_s: float) -> None:
    """Raise ``TransformError`` unless an observation is of the present or the near past, s."""
    slack = 1e-6 * period_s
    if not math.isfinite(stamp):
        raise TransformError(
            f"transform {name!r}: its stamp {stamp} is not a time; give the server's time, s"
        )
    if stamp > now + period_s + slack:
        raise TransformError(
            f"transform {name!r}: its stamp {stamp:.6g} s is {stamp - now:.3g} s in the future, "
            f"{period_s:g} s may be; give the server's time of the observation, as in a status"
        )
    if stamp < now - OLDEST_S - slack:
        raise TransformError(
            f"transform {name!r}: its stamp {stamp:.6g} s is {now - stamp:.3g} s old, "
            f"{OLDEST_S:g} s may be; observe it again"
        )
