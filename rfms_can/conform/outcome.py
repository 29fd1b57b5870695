"""What comes of a check."""

from enum import Enum
from typing import NamedTuple

from rfms_can.errors import RfmsError


class CheckFailed(RfmsError):  # noqa: N818 (a verdict, no error of ours)
    """The node did not answer as required.

    Attributes:
        sent: the frames before, in words.
        got: what came of them.
        want: what was required.
    """

    def __init__(self, sent: str, got: str, want: str) -> None:
        super().__init__(f"sent {sent}; got {got}; want {want}")
        self.sent, self.got, self.want = sent, got, want


class NodeSilent(CheckFailed):
    """The node does not answer at all: no further check would say more."""


class CheckSkipped(RfmsError):  # noqa: N818 (a verdict, no error of ours)
    """This line cannot do what the check needs."""


class Verdict(Enum):
    """How a check ended."""

    PASSED = "passed"
    FAILED = "failed"
    PENDING = "pending"
    """Listed; what it asks is not part of the contract yet."""
    SKIPPED = "skipped"
    """Not for this bus, or not asked for."""


class Outcome(NamedTuple):
    """One check, run.

    Attributes:
        id, title: of the check.
        kind: its class, ``bus``, ``sensor`` or ``axis``.
        required: whether the node must pass.
        verdict: how it ended.
        sent, got, want: frames sent, what came, what was required.
        seconds: wall-clock time.
    """

    id: str
    title: str
    kind: str
    required: bool
    verdict: Verdict
    sent: str = ""
    got: str = ""
    want: str = ""
    seconds: float = 0.0
