"""What a coordinator asks of the arm."""

from typing import Annotated

import msgspec

from rfms_can.messages.base import Message, Name, Part, Word


class MoveRequest(Message, frozen=True, tag="REQUEST"):
    """Move to a position with a mode; moves are made in the order they are asked for."""

    position: Name
    mode: Name


class StopRequest(Message, frozen=True, tag="STOP"):
    """Bring the arm to rest on its path and forget the queued moves."""


class PauseRequest(Message, frozen=True, tag="PAUSE"):
    """Come to rest on the path, keep the queued moves."""


class ResumeRequest(Message, frozen=True, tag="RESUME"):
    """Go on after a pause."""


class FeedRequest(Message, frozen=True, tag="FEED"):
    """Run all segments slower; the path stays.

    Attributes:
        rate: part of the speed the modes ask for, 0.05 to 1.
    """

    rate: Annotated[float, msgspec.Meta(ge=0.05, le=1.0)]


class GripperRequest(Message, frozen=True, tag="GRIPPER"):
    """Open or close the gripper with a part (0 to 1) of its force."""

    opens: bool
    part: Part = 1.0


class ComplyRequest(Message, frozen=True, tag="COMPLY"):
    """Comply in some directions of the compliance frame from the next move on.

    Attributes:
        word: directions, of ``fx fy fz rx ry rz``, e.g. ``"fx fy rx ry"``.
        values: bias force or moment along each, N or N m.
    """

    word: Word
    values: Annotated[list[float], msgspec.Meta(max_length=6)]


class TareRequest(Message, frozen=True, tag="TARE"):
    """Take what the wrist sensor reads next, touching nothing, for its bias."""


class LockRequest(Message, frozen=True, tag="LOCK"):
    """Comply no more in some directions."""

    word: Word
