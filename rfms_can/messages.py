"""What a coordinator says to the server: typed, bounded messages (thesis VI.3.1).

The same messages will travel over a link; in one process they are handed over as they are.
"""

from typing import Annotated

import msgspec

Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Rigid = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
Seconds = Annotated[float, msgspec.Meta(gt=0.0, le=100.0)]

T6: str = "t6"
"""The name every position equation uses for the arm itself."""


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag=True):
    """Base of all messages."""


class TransformMessage(Message, frozen=True, tag="TRANSFORM"):
    """Define a transform.

    Attributes:
        name: its name in the world model.
        rows: 12 numbers, the first three rows of the matrix, row-major; metres.
    """

    name: Name
    rows: Rigid


class PositionMessage(Message, frozen=True, tag="POSITION"):
    """Define a position by an equation of transforms with T6 in it exactly once.

    Attributes:
        name: its name in the world model.
        left, right: names of the transforms on either side, in order; ``"t6"`` is the arm.
        tool: the transform right of T6 whose frame moves along straight lines.
        configuration: e.g. ``"left up noflip"``.
    """

    name: Name
    left: Annotated[list[Name], msgspec.Meta(max_length=16)]
    right: Annotated[list[Name], msgspec.Meta(max_length=16)]
    tool: Name | None = None
    configuration: str | None = None


class ModeMessage(Message, frozen=True, tag="MODE"):
    """Define how a segment is moved.

    Attributes:
        name: its name in the world model.
        interpolation: ``"joint"`` or ``"cartesian"``.
        segment_time, acceleration_time: t_seg and t_acc, s.
    """

    name: Name
    interpolation: str
    segment_time: Seconds
    acceleration_time: Seconds


class MoveRequest(Message, frozen=True, tag="MOVE"):
    """Move to a position with a mode; moves are made in the order they are asked for."""

    position: Name
    mode: Name


class StopRequest(Message, frozen=True, tag="STOP"):
    """Bring the arm to rest on its path and forget the queued moves."""


class GripperRequest(Message, frozen=True, tag="GRIPPER"):
    """Open or close the gripper with a part (0 to 1) of its force."""

    opens: bool
    part: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)] = 1.0
