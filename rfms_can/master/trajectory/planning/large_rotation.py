"""Rotations over 0.8 pi: one straight path, moved in two parts.

The drive transform of each part turns by less, about the same axis; the inner hand-over is a
Cartesian transition between equal rates on one line, which is that even motion exactly.
"""

from typing import Final

from rfms_can.master.trajectory.goal import Goal, Moment
from rfms_can.master.trajectory.segment import Move, Transition
from rfms_can.transform import DriveTransform, Transform


class PartGoal:
    """A goal on the straight path to another one: where a part of the way ends.

    D(r) of the whole path is a translation and a rotation. The one stands left of the part's own
    drive and the other right of it, so that the tool's origin still runs straight.

    Attributes:
        whole: the goal of the whole path.
    """

    __slots__ = (
        *("_begins", "_ends", "_pose", "_shift", "_start_s", "_turn"),
        *("constant", "cycle_s", "whole"),
    )

    def __init__(
        self, whole: Goal, drive: DriveTransform, begins: float, ends: float, start_s: float
    ) -> None:
        """Part of the path from ``drive`` to ``whole``, h from ``begins`` to ``ends``.

        ``start_s`` is when it begins, s: the motion parameters ``whole`` is told are those of the
        whole path.
        """
        self.whole: Final = whole
        self.constant: Final = whole.constant
        self.cycle_s: Final = whole.cycle_s
        self._begins: Final = begins
        self._ends: Final = ends
        self._start_s: Final = start_s
        x, y, z = (component * (1.0 - ends) for component in drive.p)
        self._shift: Final = Transform.translation(x, y, z)
        self._turn: Final = Transform.rotation(drive.axis, drive.psi * (1.0 - ends))
        self._pose: Transform | None = None

    def left(self, moment: Moment) -> Transform:
        """L of the whole path, moved to where the part ends."""
        return self.whole.left(self._of_whole(moment)) @ self._shift

    def right(self, moment: Moment) -> Transform:
        """R of the whole path, turned as it is where the part ends."""
        return self._turn @ self.whole.right(self._of_whole(moment))

    def pose(self, moment: Moment) -> Transform:
        """T6 where the part ends."""
        if self._pose is not None:
            return self._pose
        pose = self.left(moment) @ self.right(moment)
        if self.constant:
            self._pose = pose
        return pose

    def _of_whole(self, moment: Moment) -> Moment:
        tick, h, t = moment
        return Moment(tick, self._begins + (self._ends - self._begins) * h, t + self._start_s)


def in_parts(move: Move, drive: DriveTransform, period_s: float) -> tuple[Move, Move]:
    """``move``, whose path from where it starts is ``drive``, in two parts of equal rate.

    Its segment time must hold each part's transitions: 4 t_acc + 4 tau, or what a corner's needs.
    """
    first = move.segment_ticks // 2
    share = first / move.segment_ticks
    goal = move.target
    via = PartGoal(goal, drive, 0.0, share, 0.0)
    rest = goal if goal.constant else PartGoal(goal, drive, share, 1.0, first * period_s)
    return (
        move._replace(target=via, segment_ticks=first, last=False, goal_angles=None),
        move._replace(
            target=rest,
            segment_ticks=move.segment_ticks - first,
            acceleration_ticks=move.rest_ticks,
            transition=Transition.CARTESIAN,
            start_angles=None,
        ),
    )
