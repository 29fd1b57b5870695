"""Resolved motion rate control: joint rates from the hand's, by the inverse Jacobian.

Whitney, "Resolved motion rate control of manipulators and human prostheses", IEEE Trans.
Man-Machine Systems MMS-10 (1969), and 1972, as thesis section III.2 describes it (3.1 to 3.3): from
where the hand is to its goal v = delta x / T, a rotation about one axis at an even rate; the joints
run at J^-1 v, integrated at the sample rate. Segments meet without transitions: rates step.

*Open loop*, delta x is taken once a segment and every sample adds an error of the order of tau^2:
the hand drifts. *Closed loop*, it is updated each sample with the remaining time.
"""

from typing import Final

from planners.planner import NotPossibleError
from planners.task import Task
from rfms_can.kinematics import Joints, direct, inverse_jacobian
from rfms_can.master.trajectory.segment import whole_ticks
from rfms_can.transform import DriveTransform, Transform, Vector3, differential_transform
from rfms_can.wire.vocabulary import Mode

Twist = tuple[Vector3, Vector3]
"""Velocity of the tool's origin, m/s, and its angular velocity, rad/s, base axes."""


class WhitneyPlanner:
    """Resolved rates of a task's legs, one after the other."""

    def __init__(self, task: Task, period_s: float, *, closed: bool) -> None:
        if any(leg.mode is Mode.JOINT for leg in task.legs):
            raise NotPossibleError("resolves rates of the hand: it has no joint motion")
        if task.moves and not closed:
            raise NotPossibleError("aims at the goal once, at where it then is")
        self.leg = 0
        self.blending = False
        self._task: Final = task
        self._period: Final = period_s
        self._closed: Final = closed
        self._ticks: Final = [whole_ticks(leg.segment_time, period_s) for leg in task.legs]
        self._from_tool: Final = differential_transform(task.tool.inverse())
        self._q = task.start
        self._n = 0
        self._cycle = 0
        self._twist: Twist = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

    def step(self) -> Joints:
        """Rates from where the hand is, integrated for one period."""
        arrived = self.leg == len(self._ticks)
        if arrived and not self._task.moves:
            return self._q
        goal = self._task.legs[min(self.leg, len(self._ticks) - 1)].goal
        self._cycle += 1
        t6 = direct(self._task.arm, self._q)
        tool = t6 @ self._task.tool
        if self._closed or self._n == 0:
            # The time left, of which one period is run with these rates: the goal at its end.
            left = 1 if arrived else self._ticks[self.leg] - self._n
            self._twist = _twist(tool, goal(self._cycle * self._period), left * self._period)
        self._run(tool)
        self._n += 1
        if not arrived and self._n == self._ticks[self.leg]:
            self.leg, self._n = self.leg + 1, 0
        return self._q

    def _run(self, tool: Transform) -> None:
        """One period with the twist at hand: q += J^-1 v tau."""
        linear, angular = (_in_axes_of(tool, vector) for vector in self._twist)
        at_tool = (*linear, *angular)
        at_t6 = [sum(map(float.__mul__, row, at_tool)) for row in self._from_tool]
        rates = [
            sum(map(float.__mul__, row, at_t6)) for row in inverse_jacobian(self._task.arm, self._q)
        ]
        q1, q2, q3, q4, q5, q6 = (
            angle + rate * self._period for angle, rate in zip(self._q, rates, strict=True)
        )
        self._q = (q1, q2, q3, q4, q5, q6)


def open_loop(task: Task, period_s: float) -> WhitneyPlanner:
    """With delta x taken once a segment."""
    return WhitneyPlanner(task, period_s, closed=False)


def closed_loop(task: Task, period_s: float) -> WhitneyPlanner:
    """With delta x taken each sample."""
    return WhitneyPlanner(task, period_s, closed=True)


def _twist(now: Transform, goal: Transform, time: float) -> Twist:
    """The even rates that bring ``now`` to ``goal`` in ``time``, s (3.1, 3.2)."""
    turn = DriveTransform(goal @ now.inverse())
    rate = turn.psi / time
    x, y, z = turn.axis
    linear = ((goal.px - now.px) / time, (goal.py - now.py) / time, (goal.pz - now.pz) / time)
    return linear, (x * rate, y * rate, z * rate)


def _in_axes_of(frame: Transform, vector: Vector3) -> Vector3:
    """A vector of the base frame, seen in the axes of ``frame``."""
    x, y, z = vector
    return (
        frame.nx * x + frame.ny * y + frame.nz * z,
        frame.ox * x + frame.oy * y + frame.oz * z,
        frame.ax * x + frame.ay * y + frame.az * z,
    )
