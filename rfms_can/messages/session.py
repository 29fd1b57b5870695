"""The session of a coordinator with the server: requests, answers, waits, the lease.

A coordinator numbers its requests from 1; the server processes each once, and answers a repeated
request with the stored answer. ``PROTOCOL`` of the link: docs/link.md.
"""

from typing import Annotated, Final, Literal

import msgspec

from rfms_can.messages.base import Message, Name, Rigid, Vector6
from rfms_can.messages.culprit import Culprit
from rfms_can.messages.numbers import ServerNumbers
from rfms_can.messages.outcomes import MoveOutcome, OutcomeQuery
from rfms_can.messages.requests import (
    ComplyRequest,
    FeedRequest,
    GripperRequest,
    LockRequest,
    MoveRequest,
    PauseRequest,
    ResetRequest,
    ResumeRequest,
    StopRequest,
    TareRequest,
)
from rfms_can.messages.sensors import GrantRequest, SensorRequest
from rfms_can.messages.world import (
    JointPositionMessage,
    Kind,
    ModeMessage,
    PositionMessage,
    RemoveRequest,
    TransformMessage,
    What,
)

NAMES_LISTED: Final = 1000
"""Names of each kind in the answer to one query of the world model."""


class Condition(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag=True):
    """Base of the conditions of a wait."""


class MoveOver(Condition, frozen=True, tag="MOVE_OVER"):
    """A move is over, in whatever way: OUTCOME says how. One stopped is over at rest."""

    sequence: int


class AtRest(Condition, frozen=True, tag="AT_REST"):
    """No move is active or queued, and the arm is at rest."""


class JawAtRest(Condition, frozen=True, tag="JAW_AT_REST"):
    """The gripper's jaw has come to rest after its last command."""


class CycleReached(Condition, frozen=True, tag="CYCLE"):
    """``cycle`` control cycles have been closed since the arm was enabled."""

    cycle: int


class Enabled(Condition, frozen=True, tag="ENABLED"):
    """The arm is enabled and takes requests, as it is again after a RESET."""


AnyCondition = MoveOver | AtRest | JawAtRest | CycleReached | Enabled


class LeaseRequest(Message, frozen=True, tag="LEASE"):
    """Acquire, renew or release the control of the arm; one coordinator has it at a time.

    Attributes:
        action: on the lease.
        name: of the coordinator, shown to others that are refused.
        duration_s: time after which it lapses unless renewed, s.
    """

    action: Literal["acquire", "renew", "release"]
    name: Name = "coordinator"
    duration_s: Annotated[float, msgspec.Meta(ge=0.1, le=10.0)] = 1.0


QueryKind = Literal["status", "world", "server"]


class Query(Message, frozen=True, tag="QUERY"):
    """Query status, names in the world model, or the server's numbers; needs no lease.

    Attributes:
        what: is queried.
        start: of the world model, the number of the first name of each kind, from 0.
    """

    what: QueryKind = "status"
    start: Annotated[int, msgspec.Meta(ge=0, le=1_000_000)] = 0


class WaitRequest(Message, frozen=True, tag="WAIT"):
    """Wait until one of the conditions holds; a later wait replaces an earlier one.

    In virtual time and lockstep time advances only while the holder of the lease waits.
    """

    any_of: Annotated[list[AnyCondition], msgspec.Meta(min_length=1, max_length=64)]


ArmRequest = (
    TransformMessage
    | PositionMessage
    | JointPositionMessage
    | ModeMessage
    | RemoveRequest
    | MoveRequest
    | StopRequest
    | PauseRequest
    | ResumeRequest
    | FeedRequest
    | GripperRequest
    | ComplyRequest
    | LockRequest
    | TareRequest
    | ResetRequest
    | GrantRequest
)
"""Requests of the program that controls the arm; all of them need the lease."""

AnyRequest = ArmRequest | LeaseRequest | SensorRequest | Query | OutcomeQuery | WaitRequest


class Envelope(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A request on the link.

    Attributes:
        session: random identifier of the coordinator, constant for its whole session.
        serial: 1, 2, 3 ...
        message: the request.
    """

    session: Annotated[str, msgspec.Meta(min_length=16, max_length=64)]
    serial: Annotated[int, msgspec.Meta(ge=1)]
    message: AnyRequest


class EmergencyStop(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="EMERGENCY"):
    """Stop immediately, with or without the lease; on a queue of its own. Not a safety function."""

    name: Name
    reason: Annotated[str, msgspec.Meta(max_length=200)] = ""


class EmergencyLift(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="LIFT"):
    """Lift the emergency stop; the arm stays halted until a RESET. From a person, not a program.

    Attributes:
        name: of the person.
    """

    name: Name


class WorldNames(msgspec.Struct, frozen=True):
    """Contents of the world model, in the order of their definition: a page of 1000 names each.

    Attributes:
        transforms: by name, their kinds.
        positions, modes: names.
        sizes: how many there are of each, by ``transform``, ``position`` and ``mode``.
    """

    transforms: dict[str, Kind]
    positions: list[str]
    modes: list[str]
    sizes: dict[What, int]


class PlannedMove(msgspec.Struct, frozen=True, omit_defaults=True):
    """An accepted move that was planned again, because of a redefinition.

    Attributes:
        sequence: its number.
        segment_time, via_deviation, via_rotation: as in an answer.
    """

    sequence: int
    segment_time: float
    via_deviation: float | None = None
    via_rotation: float | None = None


class Answer(msgspec.Struct, frozen=True, omit_defaults=True):
    """The answer to an accepted request.

    Attributes:
        sequence: number of a move, from 1.
        segment_time: t_seg of a move, s: as the mode gave it, lengthened or from its speeds.
        via_deviation, via_rotation: smallest distance of the tool from the goal before this one if
            the move begins without rest, m and rad; None if the arm rests between.
        replanned: for a redefinition, the accepted moves that it changed.
        held: for a wait, the indices of the conditions that hold.
        world: for a query of the world model.
        server: for a query of the server's numbers.
        outcomes: for a query of outcomes, one for each move asked about.
    """

    sequence: int = 0
    segment_time: float | None = None
    via_deviation: float | None = None
    via_rotation: float | None = None
    replanned: list[PlannedMove] = []
    held: list[int] = []
    world: WorldNames | None = None
    server: ServerNumbers | None = None
    outcomes: list[MoveOutcome] = []


class Refusal(msgspec.Struct, frozen=True):
    """Why a request was refused; nothing has changed.

    Attributes:
        error: name of the error's class in :mod:`rfms_can.errors`.
        reason: one line: the value, the bound, the way out.
        remedy: of a move, settings of its mode with which it is accepted: that was tried. A
            segment time takes the place of speeds; ``wait`` is a move to wait for first.
    """

    error: str
    reason: str
    remedy: dict[str, float | str | None] = {}


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
        sequence: number of the current move; 0 before the first.
        completed: the highest number such that all moves up to it are over, in whatever way.
        waiting: moves in the queue.
        at_rest: whether no move is active or queued, and the arm is at rest.
        jaw_at_rest: whether the jaw is at rest.
        jaw: its opening, m: the width of a gripped workpiece.
        feed: current fraction of the modes' speed, 0 when paused.
        comply: compliant directions requested by the program.
        complying: directions the arm complies in now.
        complied: compliant displacement of the compliance frame, m and rad along its axes.
        force: wrench of the hand on the environment, N and N m, in the compliance frame.
        force_loop: ``none`` without a wrist sensor, ``open`` or ``closed`` over it.
        guard: why the last guarded move was stopped, or None.
        lease: name of its holder, or None.
        refused: requests refused so far.
        fault: the latched fault, or None.
        culprit: who is to blame for it, and by what; None without one.
        emergency: whether an emergency stop is in force, which only a person lifts.
        issued: statuses the server has made before; of two the higher one is the newer.
        sensors: by name ``granted``, ``live`` or ``silent``: those that may observe references in
            sessions of their own.
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
    emergency: bool = False
    issued: int = 0
    sensors: dict[str, str] = {}
    culprit: Culprit | None = None


class Reply(msgspec.Struct, frozen=True):
    """The reply to one request: an answer or a refusal, and the arm's state at that time."""

    serial: int
    status: Status
    answer: Answer | None = None
    refusal: Refusal | None = None
