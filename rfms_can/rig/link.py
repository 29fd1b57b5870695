"""A program's link to a supervisor in its own process: time advances only while it waits."""

from collections.abc import Callable
from functools import partial

from rfms_can.errors import FaultError
from rfms_can.master.phases import Phase
from rfms_can.master.report import holds, status_of
from rfms_can.master.supervisor import Supervisor
from rfms_can.messages import Answer, AnyCondition, ArmRequest, Status
from rfms_can.rig.realtime import ThreadedPump

Pump = Callable[[Callable[[], bool]], None]
"""Runs the bus until a condition holds; evaluates it after every event."""


class DirectLink:
    """``coordinator.Link`` on a supervisor.

    Args:
        supervisor: the master.
        pump: runs the bus.
        on_cycle: called once for every closed cycle.
        interrupted: whether the program is to end; called after every event.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        pump: Pump,
        on_cycle: Callable[[], None],
        interrupted: Callable[[], bool] = lambda: False,
    ) -> None:
        self._supervisor = supervisor
        self._pump = pump
        self._on_cycle = on_cycle
        self._interrupted = interrupted
        self._closed = supervisor.closed

    def pass_time(
        self, condition: Callable[[], bool], ended: Callable[[], bool] = lambda: False
    ) -> None:
        """Let time advance until a condition holds, even if the run is halted.

        Args:
            condition: evaluated at the end of every cycle.
            ended: evaluated after every event.
        """
        supervisor = self._supervisor
        if condition():
            return

        def held() -> bool:
            if supervisor.closed == self._closed and supervisor.fault is None:
                return ended()  # conditions depend on closed cycles only
            if supervisor.closed != self._closed:
                self._closed = supervisor.closed
                self._on_cycle()
            return condition() or ended()

        self._pump(held)

    def run_until(self, condition: Callable[[], bool]) -> None:
        """Let time advance until a condition holds; a halted run raises ``FaultError``.

        Raises:
            FaultError: the run was halted.
            KeyboardInterrupt: the program was interrupted.
        """
        supervisor = self._supervisor
        self.pass_time(lambda: supervisor.fault is not None or condition(), self._interrupted)
        if supervisor.fault is not None:
            raise FaultError(supervisor.fault)
        if self._interrupted():
            raise KeyboardInterrupt

    def wait(self, *any_of: AnyCondition) -> None:
        """Let time advance until one of the conditions holds; see ``run_until``."""
        supervisor = self._supervisor
        self.run_until(lambda: any(holds(supervisor, condition) for condition in any_of))

    def request(self, message: ArmRequest) -> Answer:
        """Pass a message to the supervisor; in real time in the thread that runs it."""
        handle = partial(self._supervisor.handle, message)
        return self._pump.do(handle) if isinstance(self._pump, ThreadedPump) else handle()

    def status(self) -> Status:
        """The arm's state, as of the last closed cycle."""
        return status_of(self._supervisor)

    def time(self) -> float:
        """The arm's clock at the last closed cycle, s."""
        return self.status().time

    @property
    def running(self) -> bool:
        """Whether the arm is enabled."""
        return self._supervisor.phase is Phase.RUN
