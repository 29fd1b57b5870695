"""Which observations are of the object: a validation gate around its prediction, and jumps of it.

An observation outside of the gate changes nothing; it may be of another object, or of none. When
enough of them in succession agree with one another, and none was inside, the object has jumped, and
they are what is known of it (Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking
and Navigation, 2001: gating, and M-of-N confirmation).
"""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.transform import Transform

CONFIRMED: Final = 4
"""Observations outside of the gate that make a jump, at least ..."""

CONFIRMED_S: Final = 0.02
"""... and the time they span, s: a reflection lasts for some pictures of a fast camera."""

SIGMAS: Final = 6.0
"""Half the width of the gate, in standard deviations of an observation."""


class Bound(NamedTuple):
    """How far an observation may be from where its object is predicted.

    Attributes:
        least: m or rad: what an object may move by itself, or a camera be off at times.
        acceleration: m/s2 or rad/s2: what makes the prediction wrong since the last observation.
        speed: m/s or rad/s of an object that has jumped, at most.
    """

    least: float
    acceleration: float
    speed: float

    def after(self, elapsed: float, noise: float) -> float:
        """Half the width of the gate, ``elapsed`` s after the last observation inside of it."""
        return self.least + SIGMAS * noise + 0.5 * self.acceleration * elapsed**2

    def apart(self, elapsed: float, noise: float) -> float:
        """How far two observations of an object that has jumped may be from one another."""
        return self.least + SIGMAS * noise + self.speed * elapsed


PLACE: Final = Bound(5e-3, 10.0, 2.0)
"""Of an origin: 5 mm, and an object that is not struck accelerates by g at most."""

TURN: Final = Bound(0.05, 50.0, 10.0)
"""Of an orientation: the same at 0.1 to 0.2 m from the origin."""


class Sighting(NamedTuple):
    """An observation outside of the gate."""

    pose: Transform
    time: float


def inside(
    seen: Transform,
    predicted: Transform,
    elapsed: float,
    noise: tuple[float, float],
    *,
    speed_known: bool,
) -> bool:
    """Whether an observation may be of the object.

    Args:
        seen: its pose.
        predicted: the object's at the same time.
        elapsed: since the last observation inside, s.
        noise: of one observation, m and rad.
        speed_known: whether the prediction says how fast the object moves.
    """
    place, turn = PLACE.after(elapsed, noise[0]), TURN.after(elapsed, noise[1])
    if not speed_known:
        place = max(place, PLACE.apart(elapsed, noise[0]))
        turn = max(turn, TURN.apart(elapsed, noise[1]))
    return distance(seen, predicted) <= place and angle_between(seen, predicted) <= turn


def agreeing(suspects: Sequence[Sighting], noise: tuple[float, float]) -> list[int]:
    """Which of the suspects are of one object with the newest, the last of them; [] if too few."""
    newest = suspects[-1]
    place, turn = noise
    indices = []
    for index, (pose, time) in enumerate(suspects):
        elapsed = abs(newest.time - time)
        near = distance(pose, newest.pose) <= PLACE.apart(elapsed, place)
        if near and angle_between(pose, newest.pose) <= TURN.apart(elapsed, turn):
            indices.append(index)
    spanned = newest.time - suspects[indices[0]].time
    return indices if len(indices) >= CONFIRMED and spanned >= CONFIRMED_S else []


def distance(one: Transform, other: Transform) -> float:
    """Of two origins, m."""
    return math.dist((one.px, one.py, one.pz), (other.px, other.py, other.pz))


def angle_between(one: Transform, other: Transform) -> float:
    """Of two orientations, rad: from |A - B|^2 = 8 sin^2(angle / 2), exact for small ones too."""
    nx, ox, ax, _, ny, oy, ay, _, nz, oz, az, _ = one
    mx, px, bx, _, my, py, by, _, mz, pz, bz, _ = other
    square = (nx - mx) ** 2 + (ny - my) ** 2 + (nz - mz) ** 2
    square += (ox - px) ** 2 + (oy - py) ** 2 + (oz - pz) ** 2
    square += (ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2
    return 2.0 * math.asin(min(1.0, math.sqrt(square / 8.0)))
