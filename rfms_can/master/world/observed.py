"""Where an object is that was observed a while ago: held, or carried on with its velocity."""

import math
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from rfms_can.master.world import gate
from rfms_can.master.world.functions import screw
from rfms_can.master.world.line_fit import FEWEST, fit_line
from rfms_can.master.world.numbers import OLDEST_S
from rfms_can.transform import DriveTransform, Transform, Vector3

WINDOW_S: Final = 0.3
"""A velocity is estimated from observations of so long, s: with 0.5 mm of noise at 25 Hz to 2 mm/s.
Of a camera that is slower from the newest five, up to a second old."""

OVERDUE: Final = 2.0
"""Usual intervals after the last observation at which it is the last of the object for now."""

FIRST_INTERVAL_S: Final = 0.1
"""Usual interval, s, while there are not yet two observations."""

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


Rows = npt.NDArray[np.float64]


class _Seen(NamedTuple):
    """An observation, its time, and its pose as numbers to fit: x, y, z, m; a quaternion w to z."""

    observation: Observation
    time: float
    row: tuple[float, ...]

    @classmethod
    def of(cls, observation: Observation) -> "_Seen":
        pose = observation.pose
        row = (pose.px, pose.py, pose.pz, *_quaternion(pose))
        return cls(observation, observation.time, row)


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
    """

    __slots__ = ("_agreed", "_apart", "_defined", "_moving", "_noise", "_seen", "_suspects")

    def __init__(self, apart_s: float) -> None:
        self._apart: Final = apart_s
        self._seen: list[_Seen] = []
        self._suspects: list[gate.Sighting] = []
        self._moving: Prediction | None = None
        self._noise = (0.0, 0.0)
        self._defined = self._agreed = False

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._seen)

    @property
    def newest(self) -> Observation:
        """The newest by its time."""
        return self._seen[-1].observation

    @property
    def interval(self) -> float:
        """The usual time from one to the next, s."""
        seen = self._seen
        if len(seen) < 2:
            return FIRST_INTERVAL_S
        return (seen[-1].time - seen[0].time) / (len(seen) - 1)

    def is_stream_at(self, time: float) -> bool:
        """Whether so many have come of late that one of another place may be a mistake, s."""
        seen = self._seen
        return len(seen) >= FEWEST and time - seen[-FEWEST].time <= WINDOW_S

    def add(self, observation: Observation, *, gated: bool) -> bool:
        """Take one more; those that come late find their place by their stamp.

        The first is the definition of the object, which the next one replaces.

        Args:
            observation: what was seen.
            gated: whether it has to be near the prediction, unless others confirm it.

        Returns:
            Whether it counts.
        """
        if not self._seen:
            self._keep([observation])
            self._defined = True
            return True
        elapsed = observation.time - self._seen[-1].time
        if self._defined:
            self._agreed = self._inside(observation, max(0.0, elapsed))
            self._keep([observation])
            self._defined = False
            return True
        if elapsed > max(WINDOW_S, FEWEST * self.interval):  # too long ago to say how fast it is
            inside = not gated or self._inside(observation, elapsed)
            if inside:
                self._keep([observation])
            return inside or self._confirmed(observation)
        if gated and not self._inside(observation, max(0.0, elapsed)):
            if len(self._seen) > 1 or self._agreed:
                return self._confirmed(observation)
            self._keep([observation])  # of two that differ the newer one
            return True
        self._insert(observation)
        return True

    def _inside(self, observation: Observation, elapsed: float) -> bool:
        predicted, known = self.moving().at(observation.time), len(self._seen) >= FEWEST
        return gate.inside(observation.pose, predicted, elapsed, self._noise, speed_known=known)

    def _confirmed(self, observation: Observation) -> bool:
        """Keep one that is outside of the gate in mind; whether it makes a jump with others."""
        suspects = self._suspects
        suspects.append(gate.Sighting(observation.pose, observation.time))
        suspects.sort(key=lambda suspect: suspect.time)
        oldest = suspects[-1].time - max(WINDOW_S, FEWEST * self.interval)
        suspects[:] = [one for one in suspects if one.time >= oldest]
        agreeing = gate.agreeing(suspects, self._noise)
        if agreeing:
            self._keep([Observation(*suspects[index]) for index in agreeing])
        return bool(agreeing)

    def _keep(self, observations: list[Observation]) -> None:
        """Begin again with these."""
        self._seen = [_Seen.of(one) for one in observations]
        self._suspects.clear()
        self._moving = None

    def _insert(self, observation: Observation) -> None:
        seen, time = self._seen, observation.time
        if time - seen[-1].time < self._apart:  # late, or the same again
            seen[:] = [one for one in seen if abs(one.time - time) >= self._apart]
        seen.append(_Seen.of(observation))
        if len(seen) > 1 and time < seen[-2].time:
            seen.sort(key=lambda one: one.time)
        newest = seen[-1].time
        while seen[0].time < newest - (WINDOW_S if len(seen) > FEWEST else OLDEST_S):
            del seen[0]
        self._suspects.clear()
        self._moving = None

    def held(self) -> Prediction:
        """As the newest."""
        newest = self._seen[-1].observation
        return Prediction(newest.pose, newest.time)

    def moving(self) -> Prediction:
        """The line through all, or the newest with its twist; two alone rest."""
        if self._moving is None:
            self._moving = self._predicted()
        return self._moving

    def _predicted(self) -> Prediction:
        pose, time, twist = self._seen[-1].observation
        fitted = self.held()
        self._noise = (0.0, 0.0)
        if len(self._seen) > 2:
            times = np.array([one.time - time for one in self._seen])
            value, slope, self._noise = fit_line(times, self._rows())
            x, y, z, *turn = value.tolist()
            vx, vy, vz, wx, wy, wz = slope.tolist()
            turned = screw(REST, (turn[0], turn[1], turn[2])) @ pose if any(turn) else pose
            moved = turned._replace(px=pose.px + x, py=pose.py + y, pz=pose.pz + z)
            fitted = Prediction(moved, time, (vx, vy, vz), (wx, wy, wz))
        return fitted if twist is None else Prediction(pose, time, *twist)

    def _rows(self) -> Rows:
        """Where it was, from the newest: the origin, m, and a rotation vector, rad (n, 6)."""
        rows = np.array([one.row for one in self._seen])
        turns = _turns(rows[:, 3:], self._seen[-1].row[3:])
        return np.hstack((rows[:, :3] - rows[-1, :3], turns))


def rotation_vector(transform: Transform) -> Vector3:
    """Axis times angle of its rotation, rad."""
    drive = DriveTransform(transform)
    (x, y, z), psi = drive.axis, drive.psi
    return (x * psi, y * psi, z * psi)


def _quaternion(pose: Transform) -> tuple[float, float, float, float]:
    """Of its rotation: w, x, y, z."""
    drive = DriveTransform(pose)
    sine = math.sin(0.5 * drive.psi)
    x, y, z = drive.axis
    return (math.cos(0.5 * drive.psi), sine * x, sine * y, sine * z)


def _turns(quaternions: Rows, origin: tuple[float, ...]) -> Rows:
    """Rotation vectors, rad (n, 3), from one orientation to others (n, 4)."""
    w, x, y, z = origin
    q0, q1, q2, q3 = quaternions.T
    scalar = q0 * w + q1 * x + q2 * y + q3 * z
    vector = np.stack(
        (
            w * q1 - x * q0 - z * q2 + y * q3,
            w * q2 - y * q0 - x * q3 + z * q1,
            w * q3 - z * q0 - y * q1 + x * q2,
        ),
        axis=1,
    )
    sine = np.sqrt(np.einsum("ij,ij->i", vector, vector))
    angle = 2.0 * np.arctan2(sine, np.abs(scalar))
    factor = np.where(sine > 0.0, angle / np.maximum(sine, 1e-300), 2.0)
    return np.asarray(vector * (np.copysign(1.0, scalar) * factor)[:, None])
