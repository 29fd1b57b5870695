"""The world model's messages: transforms, positions, modes (thesis VI.3.1)."""

from typing import Annotated, Literal

import msgspec

from rfms_can.messages.base import (
    Deviation,
    Directions,
    Fraction,
    Mass,
    Message,
    Name,
    Positive,
    Rigid,
    Seconds,
    Vector3,
    Vector6,
)
from rfms_can.messages.functions import AnyFunction

Kind = Literal["value", "reference", "functional"]


class TransformMessage(Message, frozen=True, tag="TRANSFORM"):
    """Define a transform, or redefine it; with a stamp, an observation of it.

    Attributes:
        name: its name in the world model.
        rows: its value; of a functional transform the constant left of its function.
        kind: ``value``: positions use its value at the time they are defined. ``reference``: read
            in every cycle, so that a redefinition changes the current motion.
            ``functional``: ``rows`` times ``function`` of the motion parameters. A transform
            keeps its kind.
        function: of a functional transform.
        predict: of a reference: ``hold`` until the next observation, or extrapolate by the
            ``velocity`` of the last ones.
        twist: observed velocity of its origin, m/s, and angular velocity, rad/s, both in the frame
            its value is given in. Estimated from the observations if None.
        stamp: the server's time at which it was observed, s; now if None.
    """

    name: Name
    rows: Rigid
    kind: Kind = "value"
    function: AnyFunction | None = None
    predict: Literal["hold", "velocity"] = "hold"
    twist: Vector6 | None = None
    stamp: float | None = None


class PositionMessage(Message, frozen=True, tag="POSITION"):
    """Define a position by an equation of transforms that contains T6 exactly once.

    Attributes:
        name: its name in the world model.
        left, right: names of the transforms on either side, in order; ``"t6"`` is the arm.
        tool: the transform right of T6 whose frame moves along straight lines; all transforms
            right of T6 if None.
        compliance: the transform in whose frame the arm complies; the tool's if None.
        configuration: e.g. ``"left up noflip"``; the arm's own when enabled if None.
    """

    name: Name
    left: Annotated[list[Name], msgspec.Meta(max_length=16)]
    right: Annotated[list[Name], msgspec.Meta(max_length=16)]
    tool: Name | None = None
    compliance: Name | None = None
    configuration: str | None = None


class ModeMessage(Message, frozen=True, tag="MODE"):
    """Define the motion parameters of a segment.

    The time of a segment is given, or follows from the speeds: the longest of the resulting
    times.

    Attributes:
        name: its name in the world model.
        interpolation: ``"joint"`` or ``"cartesian"``.
        acceleration_time: t_acc, s.
        segment_time: t_seg, s, from goal to goal.
        speed, angular_speed: of the tool from goal to goal, m/s and rad/s; with a speed alone, and
            no joint speed, the tool turns at speed / 0.2 m at most.
        joint_speed: fraction of the joints' speed limits.
        lengthen: whether a segment that exceeds a speed or acceleration limit is lengthened;
            refused otherwise.
        transition: ``"joint"``, or ``"cartesian"``, planned in space.
        acceleration, angular_acceleration: what a correction of a reference transform may add
            to the motion of the tool, m/s2 and rad/s2.
        configuration: instead of the position's.
        comply: directions that comply (``fx`` ... ``rz``) and the bias force or moment along each,
            N or N m; None: those of the ``COMPLY`` requests.
        stop_on_force: directions (``fx`` ... ``rz``) and the force or moment, N or N m, at which
            the move is stopped.
        stop_on_distance: directions (``dx`` ``dy`` ``dz`` ``rx`` ``ry`` ``rz``) of the compliance
            frame and the displacement, m or rad, at which the move is stopped.
        mass: payload from this move on, kg; None: unchanged.
        mass_centre: its centre of mass in T6, m; None: the origin of the tool's frame.
        deviation: largest distance of the tool from the position it passes where the segment is
            entered without rest, m: the acceleration time of that transition is chosen to keep it.
    """

    name: Name
    interpolation: Literal["joint", "cartesian"]
    acceleration_time: Seconds
    segment_time: Seconds | None = None
    speed: Positive | None = None
    angular_speed: Positive | None = None
    joint_speed: Fraction | None = None
    lengthen: bool = False
    transition: Literal["joint", "cartesian"] = "joint"
    acceleration: Positive = 1.0
    angular_acceleration: Positive = 5.0
    configuration: str | None = None
    comply: Directions | None = None
    stop_on_force: Directions | None = None
    stop_on_distance: Directions | None = None
    mass: Mass | None = None
    mass_centre: Vector3 | None = None
    deviation: Deviation | None = None
