"""Requests of a coordinator to the arm."""

from typing import Annotated

import msgspec

from rfms_can.messages.base import Fraction, Message, Name, Word


class MoveRequest(Message, frozen=True, tag="REQUEST"):
    """Move to a position with a mode; moves are executed in the order of their requests."""

    position: Name
    mode: Name


class StopRequest(Message, frozen=True, tag="STOP"):
    """Bring the arm to rest on its path and drop the queued moves."""


class ResetRequest(Message, frozen=True, tag="RESET"):
    """Leave a fault: reset the nodes, home what has lost its reference, enable; see ENABLED."""


class PauseRequest(Message, frozen=True, tag="PAUSE"):
    """Bring the arm to rest on its path and keep the queued moves."""


class ResumeRequest(Message, frozen=True, tag="RESUME"):
    """Continue after a pause."""


class FeedRequest(Message, frozen=True, tag="FEED"):
    """Run all segments slower on the same path.

    Attributes:
        rate: fraction of the modes' speed, 0.05 to 1.
    """

    rate: Annotated[float, msgspec.Meta(ge=0.05, le=1.0)]


class GripperRequest(Message, frozen=True, tag="GRIPPER"):
    """Open or close the gripper with a fraction (0 to 1) of its force."""

    opens: bool
    part: Fraction = 1.0


class ComplyRequest(Message, frozen=True, tag="COMPLY"):
    """Comply in some directions of the compliance frame from the next move on.

    Attributes:
        word: directions, of ``fx fy fz rx ry rz``, e.g. ``"fx fy rx ry"``.
        values: bias force or moment along each, N or N m.
    """

    word: Word
    values: Annotated[list[float], msgspec.Meta(max_length=6)]


class TareRequest(Message, frozen=True, tag="TARE"):
    """Measure the bias of the wrist sensor from its next samples, without contact."""


class LockRequest(Message, frozen=True, tag="LOCK"):
    """Stop complying in some directions."""

    word: Word
