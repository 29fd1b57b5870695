"""What a program needs of the server: requests in, answers and state out, time in between."""

from typing import Protocol

from rfms_can.messages import Answer, AnyCondition, ArmRequest, Status


class Link(Protocol):
    """A way to the server: in the same process, or over a network."""

    def request(self, message: ArmRequest) -> Answer:
        """Hand a message over.

        Raises:
            ProgramError: the server refuses it; nothing has changed.
            FaultError: the run was halted.
        """

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time go on until one of some conditions holds.

        Raises:
            FaultError: the run was halted.
        """

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""
