"""The conversation between a coordinator and the server: who speaks, what is answered, when.

A coordinator numbers its requests from 1; the server processes each once, and answers a repeated
one with what it answered before. ``PROTOCOL`` of the link: docs/link.md.
"""

from typing import Annotated, Literal

import msgspec

from rfms_can.messages.base import Message, Name, Rigid, Vector6
from rfms_can.messages.numbers import ServerNumbers
from rfms_can.messages.requests import (
    ComplyRequest,
    FeedRequest,
    GripperRequest,
    LockRequest,
    MoveRequest,
    PauseRequest,
    ResumeRequest,
    StopRequest,
    TareRequest,
)
from rfms_can.messages.world import ModeMessage, PositionMessage, TransformMessage


class Condition(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag=True):
    """Base of what can be waited for."""


class MoveOver(Condition, frozen=True, tag="MOVE_OVER"):
    """A move is complete: at rest at its goal, handed over to the next, or dropped by a stop."""

    sequence: int


class AtRest(Condition, frozen=True, tag="AT_REST"):
    """No move is under way or waits, and the arm stands still."""


class JawAtRest(Condition, frozen=True, tag="JAW_AT_REST"):
    """The gripper's jaw has come to rest after its last command."""


class CycleReached(Condition, frozen=True, tag="CYCLE"):
    """So many control cycles have been closed since the arm was enabled."""

    cycle: int


AnyCondition = MoveOver | AtRest | JawAtRest | CycleReached


class LeaseRequest(Message, frozen=True, tag="LEASE"):
    """Take, keep or give back the control of the arm; one coordinator has it at a time.

    Attributes:
        action: what to do with it.
        name: who asks, for those who are refused.
        duration_s: how long it lasts without being renewed, s.
    """

    action: Literal["acquire", "renew", "release"]
    name: Name = "coordinator"
    duration_s: Annotated[float, msgspec.Meta(ge=0.1, le=10.0)] = 1.0


QueryKind = Literal["status", "world", "server"]


class Query(Message, frozen=True, tag="QUERY"):
    """Ask for the status, the names in the world model, the server's numbers; needs no lease."""

    what: QueryKind = "status"


class WaitRequest(Message, frozen=True, tag="WAIT"):
    """Be answered when one of some conditions holds; a later one takes the place of an earlier.

    In virtual time and lockstep time goes on only while the holder of the lease waits.
    """

    any_of: Annotated[list[AnyCondition], msgspec.Meta(min_length=1, max_length=64)]


ArmRequest = (
    TransformMessage
    | PositionMessage
    | ModeMessage
    | MoveRequest
    | StopRequest
    | PauseRequest
    | ResumeRequest
    | FeedRequest
    | GripperRequest
    | ComplyRequest
    | LockRequest
    | TareRequest
)
"""What the supervisor handles; all of it needs the lease."""

AnyRequest = ArmRequest | LeaseRequest | Query | WaitRequest


class Envelope(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A request on the link.

    Attributes:
        session: who speaks: a random word of the coordinator's own, kept for its whole session.
        serial: 1, 2, 3 ...
        message: what is asked.
    """

    session: Annotated[str, msgspec.Meta(min_length=16, max_length=64)]
    serial: Annotated[int, msgspec.Meta(ge=1)]
    message: AnyRequest


class EmergencyStop(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="EMERGENCY"):
    """Stop now, whoever holds the lease; on a queue of its own. Not a safety function."""

    name: Name
    reason: Annotated[str, msgspec.Meta(max_length=200)] = ""


class WorldNames(msgspec.Struct, frozen=True):
    """What the world model has: transforms by kind, positions, modes."""

    transforms: dict[str, str]
    positions: list[str]
    modes: list[str]


class Answer(msgspec.Struct, frozen=True, omit_defaults=True):
    """What became of a request that was taken.

    Attributes:
        sequence: of a move its number, from 1.
        segment_time: of a move its t_seg, s: as the mode gave it, lengthened or from its speeds.
        via_deviation, via_rotation: how near the tool comes to the goal before this one where
            the move takes over without rest, m and rad; None where the arm rests between.
        held: of a wait the indices of the conditions that hold.
        world: of a query for it.
        server: of a query for its numbers.
    """

    sequence: int = 0
    segment_time: float | None = None
    via_deviation: float | None = None
    via_rotation: float | None = None
    held: list[int] = []
    world: WorldNames | None = None
    server: ServerNumbers | None = None


class Refusal(msgspec.Struct, frozen=True):
    """Why a request was not taken; nothing has changed.

    Attributes:
        error: name of the error's class in :mod:`rfms_can.errors`.
        reason: one line: the value, the bound, what to do.
    """

    error: str
    reason: str


class Status(msgspec.Struct, frozen=True):
    """The arm's state at the end of a control cycle, broadcast every cycle.

    Attributes:
        cycle: cycles closed since the arm was enabled.
        time: the server's time, s: of the SYNC at which the joints were sampled, 0 at the first
            after enabling.
        period: control period, s.
        clock: ``virtual``, ``lockstep`` or ``realtime``.
        phase: of the master, e.g. ``RUN``.
        stage: of the trajectory generator, e.g. ``BLEND``.
        joints: measured joint angles, rad.
        t6: measured T6.
        errors: joint errors, rad.
        sequence: number of the move under way; 0 before the first.
        completed: number of the last move that is complete.
        waiting: moves in the queue.
        at_rest: whether no move is under way or waits, and the arm stands still.
        jaw_at_rest: whether the jaw stands still.
        jaw: its opening, m: on a part the part's width.
        feed: part of the modes' speed it runs at now, 0 when paused.
        comply: directions the program has asked to comply in.
        complying: directions the arm complies in.
        complied: how far the compliance frame has been let go, m and rad along its axes.
        force: what the hand does to the world, N and N m, in the compliance frame.
        force_loop: ``none`` without a wrist sensor, ``open`` or ``closed`` over it.
        guard: why the last guarded move was stopped, or None.
        lease: who holds it, or None.
        refused: requests refused so far.
        fault: the latched fault, or None.
    """

    cycle: int
    time: float
    period: float
    clock: str
    phase: str
    stage: str
    joints: Vector6
    t6: Rigid
    errors: Vector6
    sequence: int
    completed: int
    waiting: int
    at_rest: bool
    jaw_at_rest: bool
    jaw: float
    feed: float
    comply: str
    complying: str
    complied: Vector6
    force: Vector6
    force_loop: str
    guard: str | None
    lease: str | None
    refused: int
    fault: str | None


class Reply(msgspec.Struct, frozen=True):
    """The answer to one request: an answer or a refusal, and the arm's state then."""

    serial: int
    status: Status
    answer: Answer | None = None
    refusal: Refusal | None = None
