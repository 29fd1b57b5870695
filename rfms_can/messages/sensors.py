"""Sensors of their own on the link: what they may observe, and whether they are there (VI.2)."""

from typing import Annotated, Literal

import msgspec

from rfms_can.messages.base import Message, Name

MAX_REFERENCES = 32
"""References of one sensor."""
MAX_SENSORS = 16
"""Sensors with a grant."""


class GrantRequest(Message, frozen=True, tag="GRANT"):
    """Let a sensor observe references and nothing else, until the lease ends or it is revoked.

    Attributes:
        sensor: the name it connects with.
        references: what it may observe, in the place of what it might before; none: nothing.
    """

    sensor: Name
    references: Annotated[list[Name], msgspec.Meta(max_length=MAX_REFERENCES)]


class SensorRequest(Message, frozen=True, tag="SENSOR"):
    """Be a sensor from now on, say that it is still there, or be none; needs a grant, no lease.

    A session that is a sensor may send TRANSFORM of the references granted to it, QUERY, WAIT and
    SENSOR. In virtual time and lockstep time advances only while it waits.

    Attributes:
        action: begin, go on or end.
        name: of the sensor; one session at a time has it.
        duration_s: after so long without a message of it, its references are not observed, s.
    """

    action: Literal["attach", "renew", "detach"]
    name: Name
    duration_s: Annotated[float, msgspec.Meta(ge=0.1, le=10.0)] = 0.5
