"""Where an object is that was observed a while ago: held, or carried on with its velocity."""

from collections.abc import Sequence
from typing import Final, NamedTuple

from rfms_can.master.world.functions import screw
from rfms_can.transform import DriveTransform, Transform, Vector3

FITTED: Final = 5
"""Observations a velocity is estimated from, at most: the newest."""

REST: Final = (0.0, 0.0, 0.0)


class Observation(NamedTuple):
    """What was seen, and when.

    Attributes:
        pose: of the object.
        time: the server's time then, s.
        twist: velocity of its origin, m/s, and its angular velocity, rad/s, in the frame ``pose``
            is given in; None if nothing was said of it.
    """

    pose: Transform
    time: float
    twist: tuple[Vector3, Vector3] | None = None


class Prediction(NamedTuple):
    """A motion at constant velocity.

    Attributes:
        pose: at ``time``.
        time: s.
        velocity: of the origin, m/s.
        turning: angular velocity, rad/s. Both in the frame ``pose`` is given in.
    """

    pose: Transform
    time: float
    velocity: Vector3 = REST
    turning: Vector3 = REST

    @property
    def rests(self) -> bool:
        """Whether it is where it was, always."""
        return self.velocity == REST and self.turning == REST

    def at(self, time: float) -> Transform:
        """The pose at a time, s."""
        if self.rests:
            return self.pose
        elapsed = time - self.time
        turned, pose = self.pose, self.pose
        if self.turning != REST:
            x, y, z = self.turning
            turned = screw(REST, (x * elapsed, y * elapsed, z * elapsed)) @ pose
        vx, vy, vz = self.velocity
        return turned._replace(
            px=pose.px + vx * elapsed, py=pose.py + vy * elapsed, pz=pose.pz + vz * elapsed
        )


class Observations:
    """The newest observations of one object, by their stamps.

    Args:
        apart_s: observations nearer to one another in time than this are the same one seen again;
            the one that came last counts. A velocity between them would be noise.
        window_s: observations older than the newest by more say nothing of how fast it moves.
    """

    __slots__ = ("_apart", "_seen", "_window")

    def __init__(self, apart_s: float, window_s: float) -> None:
        self._apart: Final = apart_s
        self._window: Final = window_s
        self._seen: list[Observation] = []

    def add(self, observation: Observation) -> None:
        """Take one more; those that come late find their place by their stamp."""
        seen = [o for o in self._seen if abs(o.time - observation.time) >= self._apart]
        seen.append(observation)
        seen.sort(key=lambda o: o.time)
        oldest = seen[-1].time - self._window
        self._seen = [o for o in seen[-FITTED:] if o.time >= oldest]

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._seen)

    @property
    def newest(self) -> Observation:
        """The newest by its time."""
        return self._seen[-1]

    def held(self) -> Prediction:
        """As the newest."""
        newest = self._seen[-1]
        return Prediction(newest.pose, newest.time)

    def moving(self) -> Prediction:
        """The newest with its twist, or the line of least squares through all; one alone rests."""
        newest = self._seen[-1]
        if newest.twist is not None:
            return Prediction(newest.pose, newest.time, *newest.twist)
        if len(self._seen) == 1:
            return self.held()
        pose, time, _ = newest
        inverse = pose.inverse()
        times = [o.time - time for o in self._seen]
        places = [
            (o.pose.px - pose.px, o.pose.py - pose.py, o.pose.pz - pose.pz) for o in self._seen
        ]
        turns = [rotation_vector(o.pose @ inverse) for o in self._seen]
        offset, velocity = _line(times, places)
        turn, turning = _line(times, turns)
        turned = screw(REST, turn) @ pose if turn != REST else pose
        x, y, z = offset
        fitted = turned._replace(px=pose.px + x, py=pose.py + y, pz=pose.pz + z)
        return Prediction(fitted, time, velocity, turning)


def rotation_vector(transform: Transform) -> Vector3:
    """Axis times angle of its rotation, rad."""
    drive = DriveTransform(transform)
    (x, y, z), psi = drive.axis, drive.psi
    return (x * psi, y * psi, z * psi)


def _line(times: Sequence[float], points: Sequence[Vector3]) -> tuple[Vector3, Vector3]:
    """Value at time 0 and slope of the least-squares line, per component."""
    count = len(times)
    middle = sum(times) / count
    spread = sum((t - middle) ** 2 for t in times)
    value, slope = [], []
    for component in zip(*points, strict=True):
        mean = sum(component) / count
        rise = sum((t - middle) * x for t, x in zip(times, component, strict=True)) / spread
        value.append(mean - middle * rise)
        slope.append(rise)
    return (value[0], value[1], value[2]), (slope[0], slope[1], slope[2])
