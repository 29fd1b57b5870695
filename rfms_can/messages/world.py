"""The world model's messages: transforms, positions, modes (thesis VI.3.1)."""

from typing import Annotated, Literal

import msgspec

from rfms_can.messages.base import (
    Deviation,
    Directions,
    Factor,
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
What = Literal["transform", "position", "mode"]
Predict = Literal["hold", "velocity"]
RestAfter = Annotated[float, msgspec.Meta(ge=0.2, le=5.0)]


class TransformMessage(Message, frozen=True, tag="TRANSFORM"):
    """Define a transform, or redefine it; with a stamp, an observation of it.

    A value or a function that is redefined acts in all moves that have not begun: those that use
    it are planned again. If one of them could not be made, the redefinition is refused.

    Attributes:
        name: its name in the world model.
        rows: its value; of a functional transform the constant left of its function.
        kind: ``value``: a move uses its value at the time it begins. ``reference``: read in every
            cycle, so that a redefinition changes the current motion. ``functional``: ``rows``
            times ``function`` of the motion parameters, as it is defined when a move begins. A
            transform keeps its kind until it is removed.
        function: of a functional transform.
        predict: of a reference: ``hold`` the last observation, or extrapolate by the ``velocity``
            of the last ones; as it was before if None, at first ``hold``.
        twist: observed velocity of its origin, m/s, and angular velocity, rad/s, both in the frame
            its value is given in. Estimated from the observations if None.
        stamp: the server's time at which it was observed, s; now if None.
        rest_after: of a reference: time in which its prediction comes to rest when observations
            stay out, s; as it was before if None, at first 0.2. Longer where the acceleration of
            the mode demands it.
    """

    name: Name
    rows: Rigid
    kind: Kind = "value"
    function: AnyFunction | None = None
    predict: Predict | None = None
    twist: Vector6 | None = None
    stamp: float | None = None
    rest_after: RestAfter | None = None


class PositionMessage(Message, frozen=True, tag="POSITION"):
    """Define a position, or redefine it, by an equation that contains T6 exactly once.

    A redefinition acts in all moves that have not begun, as that of a value transform does.

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


class JointPositionMessage(Message, frozen=True, tag="JOINT_POSITION"):
    """Define a position, or redefine it, by six joint angles; each must be in its joint's range.

    It stands in the same table as the positions of equations. Tool and compliance frame are T6.

    Attributes:
        name: its name in the world model.
        angles: of the joints 1 to 6, rad; which turn matters.
    """

    name: Name
    angles: Vector6


class ModeMessage(Message, frozen=True, tag="MODE"):
    """Define the motion parameters of a segment, or redefine them.

    A redefinition acts in all moves that have not begun, as that of a value transform does.

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
        lengthen_at_most: by which factor; a segment that needs more is refused.
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
    lengthen_at_most: Factor = 10.0
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


class RemoveRequest(Message, frozen=True, tag="REMOVE"):
    """Remove a name from the world model; refused while a position or a move uses it.

    Attributes:
        name: of a transform, a position or a mode.
        what: which of these; None if the name is that of one of them only.
    """

    name: Name
    what: What | None = None
