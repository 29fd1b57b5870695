"""Ruckig, today's pick for a planner that runs in the cycle: jerk-limited, from state to state.

Berscheid and Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states",
RSS 2021; the library ``ruckig`` (extra ``bench``), in joint angles, as it is used most.

The published library goes to one target state; paths with waypoints are in its paid version or a
service over the network, neither of which is used here. So each leg is a motion of its own, to its
goal at a velocity: the mean of the joints' mean speeds on the two legs that meet there, zero at the
last. It is told to take the same times as the thesis' motion, and the arm's limits.
Its lines are straight neither in space nor in joint angles. A moving goal is a target with the
goal's joint velocity and acceleration: where the goal's velocity brings it by the end of the leg,
and after that each cycle where it is.
"""

from typing import Any, Final

from planners.planner import NotPossibleError
from planners.task import Task
from rfms_can.kinematics import InverseKinematics, Joints
from rfms_can.transform import Transform

RISE_TIME: Final = 0.1
"""Seconds from no acceleration to its limit: the jerk limit is that limit over this."""


HORIZON: Final = 0.05
"""How far ahead, s, a goal that moves is aimed at once it is reached. A state that is not reached
in time costs a loop back to it: aimed at the next cycle's, it would never be tracked."""


def library() -> Any:
    """The module ``ruckig``.

    Raises:
        NotPossibleError: it is not installed; the message says how to.
    """
    try:
        import ruckig  # noqa: PLC0415
    except ImportError as error:
        raise NotPossibleError("needs ruckig: pip install 'rfms_can[bench]'") from error
    return ruckig


class RuckigPlanner:
    """Six joints in step, one target state a leg."""

    def __init__(self, task: Task, period_s: float) -> None:
        ruckig = library()
        self.leg = 0
        self.blending = False
        self._task: Final = task
        self._period: Final = period_s
        self._finished: Final = ruckig.Result.Finished
        self._fine: Final = (ruckig.Result.Working, ruckig.Result.Finished)
        self._solve: Final = InverseKinematics(task.arm).solve
        self._from_tool: Final = task.tool.inverse()
        self._otg: Final = ruckig.Ruckig(6, period_s)
        self._output: Final = ruckig.OutputParameter(6)
        state = self._input = ruckig.InputParameter(6)
        state.current_position = list(task.start)
        state.max_velocity = list(task.arm.speed_limits)
        state.max_acceleration = list(task.arm.acceleration_limits)
        state.max_jerk = jerk_limits(task)
        self._durations: Final = _durations(task)
        self._goals: Final = self._solved_goals()
        self._aimed: Transform | None = None
        self._cycle = 0
        self._due = self._durations[0]
        self._aim(0)

    def step(self) -> Joints:
        """One ``Ruckig.update``; where the target is new, it plans."""
        self._cycle += 1
        last = len(self._goals) - 1
        if self._task.moves:
            self._follow(min(self.leg, last))
        result = self._otg.update(self._input, self._output)
        if result not in self._fine:
            raise NotPossibleError(f"ruckig: {result}")
        self._output.pass_to_input(self._input)
        q1, q2, q3, q4, q5, q6 = self._output.new_position
        arrived = result == self._finished
        if self._task.moves:
            arrived = (self._cycle + 0.5) * self._period > self._due
        if arrived and self.leg <= last:
            self.leg += 1
            if self.leg <= last:
                self._aim(self.leg)
        return (q1, q2, q3, q4, q5, q6)

    def _solved_goals(self) -> list[Joints]:
        goals, q = [], self._task.start
        for leg in self._task.legs:
            q = self._solve(leg.target @ self._from_tool, self._task.configuration, q)
            goals.append(q)
        return goals

    def _aim(self, leg: int) -> None:
        """The target of ``leg``: its goal's angles, and the velocity to pass them with."""
        state = self._input
        state.target_position = list(self._goals[leg])
        state.target_velocity = [0.0] * 6
        state.minimum_duration = self._durations[leg]
        if leg + 1 < len(self._goals):
            before = self._goals[leg - 1] if leg else self._task.start
            here, after = self._goals[leg], self._goals[leg + 1]
            time, next_time = (self._task.legs[k].segment_time for k in (leg, leg + 1))
            state.target_velocity = [
                0.5 * ((b - a) / time + (c - b) / next_time)
                for a, b, c in zip(before, here, after, strict=True)
            ]

    def _follow(self, leg: int) -> None:
        """The target that a moving goal is when the leg is over, or at the end of this cycle."""
        tau, state = self._period, self._input
        now = (self._cycle - 1) * tau
        due = self._due if now + 0.5 * tau < self._due else now + HORIZON
        goal, near = self._task.legs[leg].goal, self._goals[leg]
        place = goal(due)
        if place == self._aimed:
            return  # as foreseen: what was planned holds
        self._aimed = place
        before, here, after = (
            self._solve(goal(due + step) @ self._from_tool, self._task.configuration, near)
            for step in (-tau, 0.0, tau)
        )
        self._goals[leg] = here
        state.target_position = list(here)
        state.target_velocity = [(b - a) / (2.0 * tau) for a, b in zip(before, after, strict=True)]
        state.target_acceleration = [
            (a - 2.0 * q + b) / (tau * tau) for a, q, b in zip(before, here, after, strict=True)
        ]
        state.minimum_duration = due - now


def jerk_limits(task: Task) -> list[float]:
    """Of each joint, rad/s3."""
    return [limit / RISE_TIME for limit in task.arm.acceleration_limits]


def _durations(task: Task) -> list[float]:
    """Of each leg, s: t_seg, and the t_acc before the first and after the last."""
    times = [leg.segment_time for leg in task.legs]
    times[0] += task.legs[0].acceleration_time
    times[-1] += task.legs[-1].acceleration_time
    return times
