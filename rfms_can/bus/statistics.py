"""Statistics of a bus: frames, load, response times, errors."""

import msgspec


class FrameStatistics(msgspec.Struct):
    """One identifier's traffic.

    Attributes:
        count: frames sent successfully.
        busy_ns: bus time they took, intermission included, ns.
        max_response_ns: longest time from hand-over to end of frame, ns.
    """

    count: int = 0
    busy_ns: int = 0
    max_response_ns: int = 0


class BusStatistics(msgspec.Struct):
    """A whole bus, since ``since_ns``.

    Attributes:
        since_ns: when counting began, ns.
        frames: per identifier.
        busy_ns: bus time of frames, error frames and intermissions, ns.
        error_frames: transmissions destroyed by an error flag.
        collisions: those among them in which two controllers sent one identifier at once.
    """

    since_ns: int = 0
    frames: dict[int, FrameStatistics] = msgspec.field(default_factory=dict)
    busy_ns: int = 0
    error_frames: int = 0
    collisions: int = 0

    def load(self, now_ns: int) -> float:
        """Fraction of the time since ``since_ns`` that the bus was busy, 0 to 1."""
        elapsed_ns = now_ns - self.since_ns
        return self.busy_ns / elapsed_ns if elapsed_ns > 0 else 0.0

    def count_frame(self, identifier: int, busy_ns: int, response_ns: int) -> None:
        """Count one frame sent successfully."""
        of_id = self.frames.get(identifier)
        if of_id is None:
            of_id = self.frames[identifier] = FrameStatistics()
        of_id.count += 1
        of_id.busy_ns += busy_ns
        self.busy_ns += busy_ns
        if response_ns > of_id.max_response_ns:  # noqa: PLR1730 (max() costs a call per frame)
            of_id.max_response_ns = response_ns
