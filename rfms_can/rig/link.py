"""A program's link to a master in its own process: time advances only while it waits."""

from collections.abc import Callable
from functools import partial
from typing import TypeVar

from rfms_can.errors import FaultError, ProgramError
from rfms_can.master.node import MasterNode
from rfms_can.master.phases import Phase
from rfms_can.master.report import holds, status_of
from rfms_can.messages import (
    Answer,
    AnyCondition,
    ArmRequest,
    GrantRequest,
    MoveOutcome,
    ResetRequest,
    Status,
)
from rfms_can.rig.realtime import ThreadedPump

Result = TypeVar("Result")
Pump = Callable[[Callable[[], bool]], None]
"""Runs the bus until a condition holds; evaluates it after every event."""


class DirectLink:
    """``coordinator.Link`` on a master.

    Args:
        master: the master.
        pump: runs the bus.
        on_cycle: called once for every closed cycle.
        interrupted: whether the program is to end; called after every event.
    """

    def __init__(
        self,
        master: MasterNode,
        pump: Pump,
        on_cycle: Callable[[], None],
        interrupted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._master = master
        self._pump = pump
        self._on_cycle = on_cycle
        self._interrupted = interrupted
        self._closed = master.closed

    def pass_time(
        self, condition: Callable[[], bool], ended: Callable[[], bool] = lambda: False
    ) -> None:
        """Let time advance until a condition holds, even if the run is halted.

        Args:
            condition: evaluated at the end of every cycle.
            ended: evaluated after every event.
        """
        cycle, machine = self._master.cycle, self._master.machine  # asked after every event
        if condition():
            return

        def held() -> bool:
            if cycle.closed == self._closed and machine.fault is None:
                return ended()  # conditions depend on closed cycles only
            if cycle.closed != self._closed:
                self._closed = cycle.closed
                self._on_cycle()
            return condition() or ended()

        self._pump(held)

    def run_until(self, condition: Callable[[], bool]) -> None:
        """Let time advance until a condition holds; a halted run raises ``FaultError``.

        Raises:
            FaultError: the run was halted.
            KeyboardInterrupt: the program was interrupted.
        """
        master = self._master
        self.pass_time(lambda: master.fault is not None or condition(), self._interrupted)
        if master.fault is not None:
            raise FaultError(master.fault)
        if self._interrupted():
            raise KeyboardInterrupt

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time advance until one of the conditions holds; see ``run_until``."""
        master = self._master
        self.run_until(lambda: any(holds(master, condition) for condition in any_of))

    def request(self, message: ArmRequest) -> Answer:
        """Pass a message to the master; in real time in the thread that runs it.

        Raises:
            FaultError: the run was halted, and it is no reset.
            ProgramError: the master refuses it.
        """
        return self._done(partial(self._handle, message))

    def _done(self, action: Callable[[], Result]) -> Result:
        """The result of an action on the master, in the thread that runs it."""
        return self._pump.do(action) if isinstance(self._pump, ThreadedPump) else action()

    def _handle(self, message: ArmRequest) -> Answer:
        if self._master.fault is not None and not isinstance(message, ResetRequest):
            raise FaultError(self._master.fault)
        if isinstance(message, GrantRequest):
            raise ProgramError(
                f"grant to sensor {message.sensor!r}: the arm of this program is in its own "
                f"process, and sensors connect to a server: use rfms serve and connect(), or "
                f"observe in the program"
            )
        return self._master.handle(message)

    def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        """How moves ended; see ``coordinator.Link.outcomes``."""
        outcomes = self._master.motion.generator.outcomes
        return self._done(partial(outcomes.of, first, last))

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""
        return status_of(self._master)

    def time(self) -> float:
        """The arm's clock at the last closed cycle, s."""
        return self.status().time

    @property
    def running(self) -> bool:
        """Whether the arm is enabled."""
        return self._master.phase is Phase.RUN
