"""Paul's Cartesian path control: a drive transform each sample, quartic transitions.

Paul, "Manipulator Cartesian path control", IEEE Trans. SMC-9 (1979), and *Robot Manipulators* (MIT
Press, 1981), chapter 5; described in thesis section III.2. The formulas are recalled, not
checked against the paper. In short, of a leg from B to C:

* T6 tool = P D(h), where P is B seen from the goal's frame, so that it travels with it. D moves
  along a line and turns twice: by theta about an axis in the x-y plane at psi, which brings the
  approach vector home, and by phi about that vector. Each is linear in h = t / T.
* A transition of all six of these, or of six joint angles, is the quartic of zero acceleration at
  both ends that leaves A, t_acc before B, at the rate -dB / t_acc: the rate of an even motion on to
  B. psi runs evenly between its two values.
* Where the modes differ, the motion that is left is first taken for one of the new mode from A to
  B. Its rate is then nearly, and not quite, the one it had.
* A joint motion runs between angles solved at the transition: it does not follow a moving goal.

That a leg towards a moving goal starts at the rate of rest takes P where the goal *will be* at
t = 0. Of the two rotations one has no direction where it is zero; the other's psi is taken then
(ours: the sources do not say).
"""

from typing import Final

from planners.clock import Clock
from planners.double_turn import DoubleTurn
from planners.planner import NotPossibleError
from planners.task import Task
from rfms_can.kinematics import InverseKinematics, Joints, direct
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode


def quartic(ahead: float, behind: float, p: float) -> float:
    """Transition polynomial at p = (t + t_acc) / (2 t_acc), 0 to 1, of a coordinate zero at B.

    Args:
        ahead: dC t_acc / T, what the new motion covers in t_acc.
        behind: dB, where the old motion is at A.
        p: 0 to 1.
    """
    return (((ahead + behind) * (2.0 - p) * p * p) - 2.0 * behind) * p + behind


class PaulPlanner:
    """Cartesian and joint legs of a task with transitions in the mode of the leg entered."""

    def __init__(self, task: Task, period_s: float) -> None:
        if any(leg.moves and leg.mode is Mode.JOINT for leg in task.legs):
            raise NotPossibleError("a joint motion does not follow its goal")
        self.leg = 0
        self.blending = False
        self._task: Final = task
        self._period: Final = period_s
        self._clock: Final = Clock(task.legs, period_s)
        self._solve: Final = InverseKinematics(task.arm).solve
        self._from_tool: Final = task.tool.inverse()
        self._configuration: Final = task.configuration
        self._q = task.start
        self._cycle = 0
        self._start = Transform.identity()  # P in the goal's frame
        self._ahead = self._behind = DoubleTurn.still()
        self._theta_B = self._theta_BC = self._theta_BA = task.start

    def step(self) -> Joints:
        """A drive transform and an inverse solution, or angles on a joint line."""
        self._cycle += 1
        clock, legs = self._clock, self._task.legs
        number, n, enters = clock.advance()
        leg = legs[min(number, len(legs) - 1)]
        if enters:
            self._enter(number)
        ticks, acceleration = clock.segment[number], clock.acceleration[number]
        p = (n + acceleration) / (2 * acceleration)
        share, scale = n / ticks, acceleration / ticks
        self.blending = clock.blending
        self.leg = len(legs) if clock.over else min(number, len(legs) - 1)
        if leg.mode is Mode.CARTESIAN:
            drive = self._ahead.at(share) if p >= 1.0 else self._blended(scale, p)
            place = leg.goal(self._cycle * self._period) @ self._start @ drive.transform()
            self._q = self._inverse(place)
        else:
            self._q = self._joint_line(share, scale, p)
        return self._q

    def _inverse(self, place: Transform) -> Joints:
        return self._solve(place @ self._from_tool, self._configuration, self._q)

    def _blended(self, scale: float, p: float) -> DoubleTurn:
        """The drive's six parameters in a transition."""
        ahead, behind = self._ahead, self._behind
        x, y, z, theta, phi = (
            quartic(scale * b, a, p) for a, b in zip(behind.even, ahead.even, strict=True)
        )
        return DoubleTurn(x, y, z, theta, phi, behind.psi + p * (ahead.psi - behind.psi))

    def _joint_line(self, share: float, scale: float, p: float) -> Joints:
        """B + h dC, or in a transition the quartic."""
        if p >= 1.0:
            steps = [share * change for change in self._theta_BC]
        else:
            pairs = zip(self._theta_BC, self._theta_BA, strict=True)
            steps = [quartic(scale * ahead, behind, p) for ahead, behind in pairs]
        q1, q2, q3, q4, q5, q6 = (b + step for b, step in zip(self._theta_B, steps, strict=True))
        return (q1, q2, q3, q4, q5, q6)

    def _enter(self, number: int) -> None:
        """At A: what leads on from B, and what led to it."""
        task = self._task
        now = self._cycle * self._period
        at_B = now + self._clock.acceleration[number] * self._period
        rests = number == len(task.legs)
        leg = task.legs[number - 1 if rests else number]
        A = self._at_A(number, now)
        if leg.mode is Mode.JOINT:
            self._enter_joint(A, task.before(number, at_B), leg.target)
            return
        goal = leg.goal(at_B)
        self._start = goal.inverse() @ task.before(number, at_B)
        self._ahead = DoubleTurn.of(self._start.inverse())
        behind = DoubleTurn.of((leg.goal(now) @ self._start).inverse() @ A)
        self._ahead, self._behind = DoubleTurn.in_one_sense(self._ahead, behind)

    def _at_A(self, number: int, now: float) -> Transform:
        """The tool where the leg before has brought it now."""
        if number == 0:
            return self._task.before(0, now)
        clock, before = self._clock, number - 1
        share = 1.0 - clock.acceleration[number] / clock.segment[before]
        leg = self._task.legs[before]
        if leg.mode is Mode.CARTESIAN:
            return leg.goal(now) @ self._start @ self._ahead.at(share).transform()
        return direct(self._task.arm, self._joint_line(share, 0.0, 1.0)) @ self._task.tool

    def _enter_joint(self, A: Transform, B: Transform, C: Transform) -> None:
        """Angles at A, B and C, A's solved on the turns of the last set-point."""
        self._q = theta_A = self._inverse(A)
        theta_B = self._inverse(B)
        theta_C = self._solve(C @ self._from_tool, self._configuration, theta_B)
        self._theta_B = theta_B
        self._theta_BC = _difference(theta_C, theta_B)
        self._theta_BA = _difference(theta_A, theta_B)


def _difference(a: Joints, b: Joints) -> Joints:
    q1, q2, q3, q4, q5, q6 = (x - y for x, y in zip(a, b, strict=True))
    return (q1, q2, q3, q4, q5, q6)
