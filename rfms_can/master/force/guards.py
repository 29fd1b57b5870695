"""Guarded moves: stop on force and stop on distance (stpsel and dissel of the thesis' MODE).

A move is stopped where a force that it meets, or the displacement since the move took over,
reaches what the mode says, in either direction. It then counts as over. The displacement is that of
what was in the compliance frame when the move took over, along and about the frame's axes then: a
frame that stands in the world does not move itself.
"""

from collections.abc import Sequence

from rfms_can.compliance.selection import DIRECTIONS
from rfms_can.master.force.specification import NO_FORCE, Guard
from rfms_can.transform import Transform, motion_of

DISTANCES = ("dx", "dy", "dz", "rx", "ry", "rz")
"""Words of distances along and about the axes of the compliance frame."""


class Guards:
    """Watches one move.

    Attributes:
        tripped: why the last guarded move was stopped, or None.
    """

    __slots__ = ("_frame", "_guard", "_origin", "tripped")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Nothing is guarded."""
        self._guard: Guard | None = None
        self._frame = self._origin = Transform.identity()
        self.tripped: str | None = None

    def begin(self, guard: Guard, T6: Transform, frame: Transform) -> None:
        """A move takes over, with the arm at ``T6``: its compliance frame is ``frame`` in T6."""
        self._guard = guard if guard.active else None
        self._frame, self._origin = frame, (T6 @ frame).inverse()
        if guard.active:
            self.tripped = None

    def end(self) -> None:
        """The move is over: what is met from now on stops nothing."""
        self._guard = None

    def watch(self, sequence: int, force: Sequence[float], T6: Transform) -> str | None:
        """One cycle; why the move is to be stopped, or None.

        Args:
            sequence: of the move.
            force: measured in the compliance frame, N and N m.
            T6: where the arm is.
        """
        guard = self._guard
        if guard is None:
            return None
        reason = reached_force(guard, force)
        if reason is None and guard.distance != NO_FORCE:
            gone = motion_of(self._origin @ T6 @ self._frame)
            reason = _reached(guard.distance, gone, DISTANCES, _UNITS)
        if reason is not None:
            self._guard = None
            self.tripped = f"move {sequence}: {reason}"
        return reason


_FORCES = ("N", "N", "N", "N m", "N m", "N m")
_UNITS = ("m", "m", "m", "rad", "rad", "rad")


def reached_force(guard: Guard, force: Sequence[float]) -> str | None:
    """Which force has been reached, in words, or None."""
    return _reached(guard.force, force, DIRECTIONS, _FORCES)


def _reached(
    bounds: Sequence[float],
    values: Sequence[float],
    names: Sequence[str],
    units: Sequence[str],
) -> str | None:
    for bound, value, name, unit in zip(bounds, values, names, units, strict=True):
        if bound and abs(value) >= bound:
            return f"{name} {value:.3g} {unit} reached {bound:g} {unit}"
    return None
