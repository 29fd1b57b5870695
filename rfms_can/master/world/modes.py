"""Modes: how a segment is moved (thesis VI.3.1)."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from rfms_can.compliance.selection import DIRECTIONS, Selection, SelectionError, parse_bias
from rfms_can.errors import KinematicsError, ModeError
from rfms_can.kinematics import Configuration
from rfms_can.master.force.guards import DISTANCES
from rfms_can.master.force.specification import NO_GUARD, Guard
from rfms_can.master.trajectory.segment import Transition
from rfms_can.messages import FARTHEST_CORNER, ModeMessage, Vector3, Vector6
from rfms_can.wire.vocabulary import Mode

FARTHEST_CENTRE: Final = 2.0
"""Of what the hand holds: how far its centre of mass may be from T6 along each axis, m."""
FARTHEST_STOP: Final = (3.0, 3.0, 3.0, math.pi, math.pi, math.pi)
"""Distances a guard may have at most, m and rad: nothing an arm holds goes farther, and a turn by
more looks like one by less."""


ROTATION_LEVER: Final = 0.2
"""Where a mode has a speed of the tool and none of its rotation: distance from the tool's origin at
which a rotation moves a point at that speed, m; half the reach of the smallest arm."""


class Limits(NamedTuple):
    """What the correction of a reference may add to the motion of the tool.

    Attributes:
        acceleration: of its origin, m/s2.
        angular_acceleration: rad/s2.
    """

    acceleration: float
    angular_acceleration: float


@dataclass(frozen=True, slots=True)
class MotionMode:
    """How a segment is moved.

    Attributes:
        name: as defined.
        mode: straight in joint angles or in space.
        acceleration_time: t_acc, s.
        segment_time: t_seg, s, or None: it follows from the speeds.
        speed, angular_speed: of the tool, m/s and rad/s; None where they do not matter. With a
            speed alone the rotation has one too: ``speed / ROTATION_LEVER``.
        joint_speed: fraction of the joints' speed limits, or None.
        lengthen: whether a segment that breaks a limit is lengthened, or refused.
        lengthen_at_most: by which factor.
        transition: how the segment is entered.
        limits: what the correction of a reference may add.
        configuration: instead of the position's, or None.
        comply: what complies and with what bias, or None: what the program has requested.
        guard: what stops the move.
        mass: of what the hand holds, kg, or None: what it held before.
        mass_centre: its centre of mass in T6, m, or None: the origin of the tool's frame.
        deviation: largest distance of the tool from the position it passes on entering the segment,
            m, or None: that of the acceleration time.
    """

    name: str
    mode: Mode
    acceleration_time: float
    segment_time: float | None
    speed: float | None
    angular_speed: float | None
    joint_speed: float | None
    lengthen: bool
    lengthen_at_most: float
    transition: Transition
    limits: Limits
    configuration: Configuration | None
    comply: tuple[Selection, Vector6] | None = None
    guard: Guard = NO_GUARD
    mass: float | None = None
    mass_centre: Vector3 | None = None
    deviation: float | None = None

    @classmethod
    def from_message(cls, message: ModeMessage) -> "MotionMode":
        """The mode a message defines.

        Raises:
            ModeError: it contradicts itself, or has a number that is not finite.
        """
        _check(message)
        try:
            words = message.configuration
            configuration = None if words is None else Configuration.parse(words)
        except KinematicsError as error:
            raise ModeError(f"mode {message.name!r}: {error}") from error
        return cls(
            message.name,
            Mode[message.interpolation.upper()],
            message.acceleration_time,
            message.segment_time,
            message.speed,
            _angular_speed(message),
            message.joint_speed,
            message.lengthen,
            message.lengthen_at_most,
            Transition[message.transition.upper()],
            Limits(message.acceleration, message.angular_acceleration),
            configuration,
            _compliance(message),
            _guard(message),
            message.mass,
            message.mass_centre,
            message.deviation,
        )


def _angular_speed(message: ModeMessage) -> float | None:
    """As given, or with the tool's speed where nothing else bounds how fast it turns, rad/s."""
    unbounded = message.angular_speed is None and message.joint_speed is None
    if message.speed is not None and unbounded:
        return message.speed / ROTATION_LEVER
    return message.angular_speed


def _check(message: ModeMessage) -> None:
    """Times or speeds, and a deviation that a transition can have."""
    name = f"mode {message.name!r}"
    speeds = {
        "speed": message.speed,
        "angular_speed": message.angular_speed,
        "joint_speed": message.joint_speed,
    }
    given = [speed for speed, value in speeds.items() if value is not None]
    numbers = {
        **{speed: speeds[speed] for speed in given},
        "acceleration_time": message.acceleration_time,
        "acceleration": message.acceleration,
        "angular_acceleration": message.angular_acceleration,
    }
    if message.segment_time is not None:
        numbers["segment_time"] = message.segment_time
    for what, number in numbers.items():
        if number is None or not 0.0 < number < math.inf:  # also NaN
            raise ModeError(f"{name}: {what} {number} must be a number more than zero")
    _check_load(message)
    if message.segment_time is None and not given:
        raise ModeError(
            f"{name}: give a segment time or a speed (speed, angular_speed, joint_speed)"
        )
    if message.segment_time is not None and given:
        raise ModeError(
            f"{name}: a segment time of {message.segment_time:g} s and {' and '.join(given)} "
            f"contradict one another; give the time, or speeds"
        )
    if message.deviation is not None and not 0.0 < message.deviation <= FARTHEST_CORNER:  # or NaN
        raise ModeError(
            f"{name}: deviation {message.deviation} m must be more than 0 and at most "
            f"{FARTHEST_CORNER:g} m; to pass through the position itself, wait for the move to it"
        )


def _check_load(message: ModeMessage) -> None:
    """The mass in the hand, and where it is."""
    name = f"mode {message.name!r}"
    if message.mass is not None and not 0.0 <= message.mass < math.inf:  # also NaN
        raise ModeError(f"{name}: mass {message.mass} must be a number, zero or more")
    if message.mass_centre is not None and message.mass is None:
        raise ModeError(f"{name}: a mass_centre {message.mass_centre} without a mass: give both")
    for number in message.mass_centre or ():
        if not abs(number) <= FARTHEST_CENTRE:  # also NaN
            raise ModeError(
                f"{name}: mass centre {message.mass_centre}: {number} m is not within "
                f"{FARTHEST_CENTRE:g} m of the hand (T6)"
            )


def _compliance(message: ModeMessage) -> tuple[Selection, Vector6] | None:
    """What a mode complies in, and the bias along each direction."""
    if message.comply is None:
        return None
    try:
        selection, bias = parse_bias(" ".join(message.comply), list(message.comply.values()))
    except SelectionError as error:
        raise ModeError(f"mode {message.name!r}: {error}") from error
    return selection, bias


def _guard(message: ModeMessage) -> Guard:
    """What stops a move with this mode."""
    name, force, distance = message.name, message.stop_on_force, message.stop_on_distance
    if force is None and distance is None:
        return NO_GUARD
    return Guard(
        _bounds(name, "stop on force", force or {}, DIRECTIONS, (math.inf,) * 6),
        _bounds(name, "stop on distance", distance or {}, DISTANCES, FARTHEST_STOP),
    )


def _bounds(
    name: str, what: str, values: dict[str, float], words: tuple[str, ...], most: Vector6
) -> Vector6:
    for word, value in values.items():
        if word not in words:
            raise ModeError(
                f"mode {name!r}: {what}: {word!r} is not a direction: there are {', '.join(words)}"
            )
        if not 0.0 < value < math.inf:  # also NaN
            raise ModeError(f"mode {name!r}: {what}: {word} {value} must be more than zero")
        farthest = most[words.index(word)]
        if value > farthest:
            raise ModeError(
                f"mode {name!r}: {what}: {word} {value:g}: it would never stop there, "
                f"{farthest:.3g} is the most"
            )
    x, y, z, rx, ry, rz = (values.get(word, 0.0) for word in words)
    return (x, y, z, rx, ry, rz)
