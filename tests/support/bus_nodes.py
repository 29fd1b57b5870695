"""Little nodes for the bus tests: one that talks by the clock, one that answers, one that logs."""

from collections.abc import Mapping, Sequence

from rfms_can.node.protocol import NOTHING
from rfms_can.wire.frame import Frame


class Listener:
    """Notes (time, frame) of everything it accepts."""

    def __init__(self, name: str, accepts: frozenset[int]) -> None:
        self.name = name
        self.accepts = accepts
        self.heard: list[tuple[int, Frame]] = []

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        self.heard.append((now_ns, frame))
        return NOTHING

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        return NOTHING

    def next_deadline_ns(self) -> int | None:
        return None

    @property
    def payloads(self) -> list[bytes]:
        return [frame.data for _, frame in self.heard]


class Talker(Listener):
    """Sends the same frames every period, ``rounds`` times."""

    def __init__(
        self,
        name: str,
        frames: Sequence[Frame],
        period_ns: int = 1_000_000,
        rounds: int = 1,
        *,
        accepts: frozenset[int] = frozenset(),
        first_ns: int = 0,
    ) -> None:
        super().__init__(name, accepts)
        self.frames = frames
        self.period_ns = period_ns
        self.rounds = rounds
        self.next_ns = first_ns

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        self.rounds -= 1
        self.next_ns += self.period_ns
        return self.frames

    def next_deadline_ns(self) -> int | None:
        return self.next_ns if self.rounds > 0 else None


class Responder(Listener):
    """Answers frames by identifier."""

    def __init__(self, name: str, answers: Mapping[int, Sequence[Frame]]) -> None:
        super().__init__(name, frozenset(answers))
        self.answers = answers

    def on_frame(self, frame: Frame, now_ns: int) -> Sequence[Frame]:
        super().on_frame(frame, now_ns)
        return self.answers[frame.id]
