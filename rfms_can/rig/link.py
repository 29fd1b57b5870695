"""A program's link to a supervisor in its own process: time goes on only while it waits."""

from collections.abc import Callable
from functools import partial
from typing import Final

from rfms_can.errors import FaultError
from rfms_can.kinematics import direct
from rfms_can.master.phases import Phase
from rfms_can.master.supervisor import Supervisor
from rfms_can.messages import GripperRequest, Message, MoveRequest
from rfms_can.rig.realtime import ThreadedPump
from rfms_can.transform import Transform

STILL_CYCLES: Final = 12
"""Cycles without a count from an encoder that mean its axis stands still."""

Pump = Callable[[Callable[[], bool]], None]
"""Runs the bus until a condition holds; asks it after every event."""


class DirectLink:
    """``coordinator.Link`` on a supervisor.

    Args:
        supervisor: the master.
        pump: runs the bus.
        on_cycle: called once for every closed cycle.
        interrupted: whether somebody wants the program to end; asked after every event.
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
        self._counts_per_rad = [abs(d.counts_per_radian) for d in supervisor.arm.drives]
        self._q = list(supervisor.arm_state.q)
        self._jaw_counts = 0
        self._still = self._jaw_still = 0

    def pass_time(
        self, condition: Callable[[], bool], ended: Callable[[], bool] = lambda: False
    ) -> None:
        """Let time go on until a condition holds, whatever happens to the run.

        Args:
            condition: asked at the end of every cycle.
            ended: asked after every event.
        """
        supervisor = self._supervisor
        if condition():
            return

        def held() -> bool:
            if supervisor.closed == self._closed and supervisor.fault is None:
                return ended()  # nothing a condition may ask about changes within a cycle
            if supervisor.closed != self._closed:
                self._closed = supervisor.closed
                self._watch_stillness()
                self._on_cycle()
            return condition() or ended()

        self._pump(held)

    def run_until(self, condition: Callable[[], bool]) -> None:
        """Let time go on until a condition holds; a halted run raises ``FaultError``.

        Raises:
            FaultError: the run was halted.
            KeyboardInterrupt: somebody wants the program to end.
        """
        supervisor = self._supervisor
        self.pass_time(lambda: supervisor.fault is not None or condition(), self._interrupted)
        if supervisor.fault is not None:
            raise FaultError(supervisor.fault)
        if self._interrupted():
            raise KeyboardInterrupt

    def request(self, message: Message) -> int:
        """Hand a message to the supervisor; in real time in the thread that runs it."""
        handle = partial(self._supervisor.handle, message)
        answer = self._pump.do(handle) if isinstance(self._pump, ThreadedPump) else handle()
        if isinstance(message, GripperRequest):
            self._jaw_still = 0
        elif isinstance(message, MoveRequest):
            self._still = 0
        return answer

    def _watch_stillness(self) -> None:
        """Count the cycles for which arm and jaw have not moved by more than a count."""
        state = self._supervisor.arm_state
        still = all(
            abs(q - before) * scale < 1.5
            for q, before, scale in zip(state.q, self._q, self._counts_per_rad, strict=True)
        )
        self._still = self._still + 1 if still else 0
        self._q[:] = state.q
        jaw_still = abs(state.jaw_counts - self._jaw_counts) <= 1
        self._jaw_still = self._jaw_still + 1 if jaw_still else 0
        self._jaw_counts = state.jaw_counts

    def is_over(self, sequence: int) -> bool:
        """Whether a move is complete."""
        return self._supervisor.motion.is_over(sequence)

    def at_rest(self) -> bool:
        """Whether no move is under way or waits, and the arm stands still."""
        return self._still >= STILL_CYCLES and self._supervisor.motion.at_rest

    def jaw_rests(self) -> bool:
        """Whether the jaw has not moved for a while."""
        return self._jaw_still >= STILL_CYCLES

    def cycle(self) -> int:
        """Control cycles since the arm was enabled."""
        return self._supervisor.statistics.cycles

    def period_s(self) -> float:
        """Control period, s."""
        return self._supervisor.settings.period_ns * 1e-9

    def joints(self) -> tuple[float, ...]:
        """Measured joint angles, rad (6)."""
        return tuple(self._supervisor.arm_state.q)

    def t6(self) -> Transform:
        """Measured T6."""
        return direct(self._supervisor.arm, self._supervisor.arm_state.q)

    @property
    def running(self) -> bool:
        """Whether the arm is enabled."""
        return self._supervisor.phase is Phase.RUN
