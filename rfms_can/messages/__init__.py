"""Messages between a coordinator and the server: typed, with bounds (thesis VI.3).

The same messages are sent over the link, or passed as objects within one process.
"""

from rfms_can.messages.base import MAX_BYTES, T6, Message, Rigid, Vector3, Vector6
from rfms_can.messages.functions import AnyFunction, Circular, Linear, Table, TableRow, Weave
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
from rfms_can.messages.sensors import GrantRequest, SensorRequest
from rfms_can.messages.session import (
    Answer,
    AnyCondition,
    AnyRequest,
    ArmRequest,
    AtRest,
    CycleReached,
    EmergencyStop,
    Envelope,
    JawAtRest,
    LeaseRequest,
    MoveOver,
    Query,
    Refusal,
    Reply,
    Status,
    WaitRequest,
    WorldNames,
)
from rfms_can.messages.world import ModeMessage, PositionMessage, TransformMessage

__all__ = [
    "MAX_BYTES",
    "T6",
    "Answer",
    "AnyCondition",
    "AnyFunction",
    "AnyRequest",
    "ArmRequest",
    "AtRest",
    "Circular",
    "ComplyRequest",
    "CycleReached",
    "EmergencyStop",
    "Envelope",
    "FeedRequest",
    "GrantRequest",
    "GripperRequest",
    "JawAtRest",
    "LeaseRequest",
    "Linear",
    "LockRequest",
    "Message",
    "ModeMessage",
    "MoveOver",
    "MoveRequest",
    "PauseRequest",
    "PositionMessage",
    "Query",
    "Refusal",
    "Reply",
    "ResumeRequest",
    "Rigid",
    "SensorRequest",
    "ServerNumbers",
    "Status",
    "StopRequest",
    "Table",
    "TableRow",
    "TareRequest",
    "TransformMessage",
    "Vector3",
    "Vector6",
    "WaitRequest",
    "Weave",
    "WorldNames",
]
