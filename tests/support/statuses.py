"""A status for tests that need one."""

import msgspec

from rfms_can.messages import Status
from rfms_can.transform import Transform

NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

AT_REST = Status(
    cycle=0,
    time=0.0,
    period=0.004,
    clock="virtual",
    phase="RUN",
    stage="IDLE",
    joints=NOTHING,
    t6=Transform.identity(),
    errors=NOTHING,
    sequence=0,
    completed=0,
    waiting=0,
    at_rest=True,
    jaw_at_rest=True,
    jaw=0.08,
    feed=1.0,
    comply="",
    complying="",
    complied=NOTHING,
    force=NOTHING,
    force_loop="none",
    guard=None,
    lease=None,
    refused=0,
    fault=None,
)


def status(**fields: object) -> Status:
    """The status of an arm at rest, but for some fields."""
    return msgspec.structs.replace(AT_REST, **fields)
