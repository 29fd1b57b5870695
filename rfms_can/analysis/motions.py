"""The motions of a run, from rest to rest, and the three that thesis Figures 3.3 to 3.5 show."""

from typing import Final, NamedTuple

import numpy as np

from rfms_can.analysis.recording import Recording, RecordingError
from rfms_can.wire.vocabulary import Mode, TrajectoryState

SAME_PLACE: Final = 1e-3
"""Largest difference of two poses that count as one place, rad at any joint."""


class MoveSpan(NamedTuple):
    """One move of a motion.

    Attributes:
        sequence: its number.
        mode: its interpolation.
        acceleration_time: its t_acc, s.
        start: first row of the log that belongs to it: its START.
    """

    sequence: int
    mode: Mode
    acceleration_time: float
    start: int


class Motion(NamedTuple):
    """Moves that run into one another, from rest to rest.

    Attributes:
        start: first row of the log in motion: the START of the first move.
        stop: row of the log after the last one in motion.
        moves: in order.
        places: commanded joint angles at rest before and after, rad (2, 6).
    """

    start: int
    stop: int
    moves: tuple[MoveSpan, ...]
    places: tuple[tuple[float, ...], tuple[float, ...]]

    @property
    def mode(self) -> Mode | None:
        """The mode of all its moves, or None where they differ."""
        modes = {move.mode for move in self.moves}
        return modes.pop() if len(modes) == 1 else None

    @property
    def acceleration_time(self) -> float:
        """Longest t_acc of its moves, s."""
        return max(move.acceleration_time for move in self.moves)

    def has_path_of(self, other: "Motion") -> bool:
        """Whether both start and end at the same places, with the same number of moves."""
        return len(self.moves) == len(other.moves) and bool(
            np.allclose(self.places, other.places, rtol=0.0, atol=SAME_PLACE)
        )


def motions(recording: Recording) -> list[Motion]:
    """All motions of a run that start and end at rest, by the states and numbers of SETPOINT."""
    log = recording.log
    moving = (log.state > TrajectoryState.IDLE) & (log.cycle < len(recording.commanded))
    edges = np.flatnonzero(np.diff(moving.astype(np.int8), prepend=0, append=0))
    return [
        _motion(recording, int(start), int(stop))
        for start, stop in edges.reshape(-1, 2)
        if start > 0 and stop < len(moving)
    ]


def _motion(recording: Recording, start: int, stop: int) -> Motion:
    log = recording.log
    _, firsts = np.unique(log.sequence[start:stop], return_index=True)
    moves = tuple(
        MoveSpan(
            int(log.sequence[row]), Mode(log.mode[row]), float(log.acceleration_time[row]), int(row)
        )
        for row in firsts + start
    )
    before, after = (recording.commanded[log.cycle[row]] for row in (start - 1, stop - 1))
    return Motion(start, stop, moves, (tuple(before), tuple(after)))


class ThesisMotions(NamedTuple):
    """One way, made three times: what Figures 3.3, 3.4 and 3.5 compare."""

    joint: Motion
    longer: Motion
    cartesian: Motion


def thesis_motions(recording: Recording) -> ThesisMotions:
    """The first way made in joint mode, again with a longer t_acc, and in Cartesian mode.

    Raises:
        RecordingError: the run has no such three motions.
    """
    found = motions(recording)
    by_joint = [motion for motion in found if motion.mode is Mode.JOINT]
    for first in by_joint:
        same = [motion for motion in found if motion.has_path_of(first)]
        longer = [
            motion
            for motion in same
            if motion.mode is Mode.JOINT and motion.acceleration_time > first.acceleration_time
        ]
        cartesian = [motion for motion in same if motion.mode is Mode.CARTESIAN]
        if longer and cartesian:
            return ThesisMotions(first, longer[0], cartesian[0])
    raise RecordingError(
        f"{recording.directory}: of its {len(found)} motions no three go one way in joint mode, in "
        f"joint mode with a longer acceleration time, and in Cartesian mode: record "
        f"examples/figures.py"
    )
