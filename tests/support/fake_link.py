"""A link to no server, which remembers what a program says."""

from rfms_can.errors import FaultError
from rfms_can.messages import (
    Answer,
    AnyCondition,
    CycleReached,
    Message,
    MoveOver,
    MoveRequest,
    Status,
)
from rfms_can.transform import Transform
from support.statuses import status


class FakeLink:
    """Takes every message, and lets a cycle pass whenever a condition does not hold.

    Attributes:
        heard: messages, in order.
        now: cycles that have passed.
        over: last move that is complete.
        rests_at: cycle at which arm and jaw come to rest.
        refusal: raised by the next request, if any.
    """

    def __init__(self) -> None:
        self.heard: list[Message] = []
        self.now = 0
        self.over = 0
        self.rests_at = 0
        self.refusal: Exception | None = None
        self.fault_at: int | None = None
        self._moves = 0

    def request(self, message: Message) -> Answer:
        if self.refusal is not None:
            raise self.refusal
        self.heard.append(message)
        if isinstance(message, MoveRequest):
            self._moves += 1
            return Answer(self._moves)
        return Answer()

    def wait(self, *any_of: AnyCondition) -> None:
        while not any(self._holds(condition) for condition in any_of):
            self.now += 1
            if self.now == self.fault_at:
                raise FaultError("joint 3: OVER_TORQUE (9)")
            if self.now % 100 == 0:
                self.over += 1

    def _holds(self, condition: AnyCondition) -> bool:
        match condition:
            case MoveOver(sequence):
                return self.over >= sequence
            case CycleReached(cycle):
                return self.now >= cycle
            case _:
                return self.now >= self.rests_at

    def status(self) -> Status:
        return status(
            cycle=self.now,
            joints=(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
            t6=Transform.translation(0.3, 0.2, 0.1),
        )

    def time(self) -> float:
        return 0.004 * self.now
