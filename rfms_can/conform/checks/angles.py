"""Checks 31 to 31d: the joint's angle of a pose, its turn, and who says it."""

from typing import Any, Final

from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import read
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS
from rfms_can.wire.records import JointAngles, JointError, Setpoint
from rfms_can.wire.vocabulary import Parameter

SLOW: Final = {
    Parameter.PERIOD: 1.0,
    Parameter.SPEED_LIMIT: 100.0,
    Parameter.OVERSPEED_LIMIT: 150.0,
    Parameter.TACHOMETER_LIMIT: 100.0,
    Parameter.TORQUE_LIMIT: 1e4,
    Parameter.CONTINUOUS_TORQUE: 1e4,
    Parameter.FOLLOWING_ERROR_LIMIT: 0.5,
    Parameter.CURRENT_TOLERANCE: 0.25,
    Parameter.RATE_PER_CODE: 0.01,
    Parameter.ACCELERATION_LIMIT: 1e4,
}
"""Cycles in which a joint goes from any pose to any other, and does not mind."""


def by_whom(t: Tester) -> None:
    """JOINT_SETPOINT counts where it has the joint's bit; else the pose is solved."""
    t.operational(SLOW, theta=0.3)
    own, others = 1 << t.index, 0x3F & ~(1 << t.index)
    angle = t.vectors.rest_angles[t.index]
    for bits, want in ((own, 0.25), (0x3F, 0.25), (others & ~8, angle), (0, angle)):
        t.sync()
        t.theta = want
        t.measure()
        frames = (t.setpoint_frame(), t.angles_frame(0.25, joints=bits))
        error: JointError = t.one(t.give(*frames), "ERROR", f"bits {bits:#x}")
        t.near(error.error, want - t.measured, 1e-6, f"error with bits {bits:#x}")
        t.errors()
    # outside the joint's range there is no set-point
    p = t.parameters
    ends = (p[Parameter.POSITION_MIN], p[Parameter.POSITION_MAX])
    for end, sign in zip(ends, (-1.0, 1.0), strict=True):
        t.theta = end
        for beyond, names in ((0.5e-5, ("ERROR",)), (2e-5, ())):
            t.sync()
            t.measure()
            frames = (t.setpoint_frame(), t.angles_frame(end + sign * beyond))
            t.only(t.give(*frames), names, f"{beyond} rad beyond the range")
            t.errors()
    t.operational({**SLOW, Parameter.KINEMATICS: 0.0}, theta=0.3)
    t.sync()
    t.measure()
    t.only(t.give(t.setpoint_frame(0)), (), "KINEMATICS 0: no angle without JOINT_SETPOINT")
    t.run(1)


def straight_wrist(t: Tester) -> None:
    """Where the wrist is straight joint 4 is where it was told, or was; joint 6 makes up for it."""
    for number, case in enumerate(read("straight")):
        for told in (True, False):
            # by JOINT_SETPOINT, bit of joint 4; else by the pose before
            t.operational(SLOW, theta=case["bent"]["angles"][t.index])
            t.run(2)
            if not told:
                _at(t, case["bent"], f"wrist {number}, bent", None, 0)
                _at(t, case, f"wrist {number}, joint 4 as it was", None, 0)
                continue
            _at(t, case, f"wrist {number}, joint 4 told", case["angles"][3], 8)
            # the bits of the others' angles say nothing of joint 4
            _at(t, case, f"wrist {number}, joint 4 as it was", 1.0, 0x37 & ~(1 << t.index))


def _at(t: Tester, pose: dict[str, Any], where: str, angle4: float | None, joints: int) -> None:
    """One cycle at a pose: the own joint's angle must be that of the pose."""
    want = pose["angles"][t.index]
    t.sync()
    t.theta = want
    t.measure()
    told = place(pose)
    if angle4 is None:
        answers = t.give(t.setpoint_frame(0, **told))
    else:
        angles = [0.7] * 6
        angles[3] = angle4
        frame = t.frame(JointAngles, 1, *angles, t.cycle & 0xFF, joints)
        answers = t.give(t.setpoint_frame(JOINT_SETPOINT_BELONGS, **told), frame)
    error: JointError = t.one(answers, "ERROR", where)
    t.near(error.error + t.measured, want, 1e-6, f"{where}: angle")
    t.errors()


def turns(t: Tester) -> None:
    """Turns go on from where a pose was solved last: that of the goal, not that of the joint."""
    poses = read("turns")[str(t.joint)]
    wide = {
        **SLOW,
        **{Parameter.POSITION_MIN: -20.0, Parameter.POSITION_MAX: 20.0},
        **{Parameter.COARSE_ZERO: -20.0, Parameter.COARSE_PER_CODE: 0.01},
    }
    first, goal = poses[0], poses[6]
    t.operational(wide, theta=first["angle"])
    for pose in (*poses, *reversed(poses)):
        _turned(t, pose, pose["angle"], "at rest")
    # more than half a turn to the goal, which the second pose reaches step by step
    for pose in poses[:7]:
        _turned(t, first, first["angle"], "before a motion in joint angles", pose)
    moving: dict[str, Any] = {"r": 1.0, "acceleration_time": 4.0}
    _turned(t, first, None, "START", goal, state=3, **moving)
    for state, p in ((4, 1.0), (4, 1.0), (1, 0.0), (1, 0.0)):
        _turned(t, goal, goal["angle"], "a motion in joint angles", state=state, blend_p=p)
    _turned(t, goal, goal["angle"], "where it ended")
    # a Cartesian motion: the pose is the hand's
    _turned(t, goal, None, "START", state=3, mode=1, **moving)
    for pose in poses[6:]:
        _turned(t, pose, pose["angle"], "a Cartesian motion", state=4, mode=1, blend_p=1.0)
    for pose in reversed(poses):
        _turned(t, pose, pose["angle"], "a Cartesian motion", state=1, mode=1)


def _turned(
    t: Tester,
    pose: dict[str, Any],
    want: float | None,
    where: str,
    second: dict[str, Any] | None = None,
    **changes: Any,
) -> None:
    """One cycle at a pose; the angle that the joint commands, if one is wanted."""
    t.sync()
    t.theta = pose["angle"] if want is None else want
    t.measure()
    frames = [t.setpoint_frame(0, poses=1 if second is None else 2, **place(pose), **changes)]
    if second is not None:
        told = (*second["o"], *second["a"], *second["p"], 0.0, 0.0, 0.2, 0, 0)
        ends = (second["configuration"], 1, t.cycle, 0, 2, 0)
        frames.append(t.frame(Setpoint, 2, *told, *ends))
    answers = t.give(*frames)
    error: JointError = t.one(answers, "ERROR", f"turns, {where}")
    if want is not None:
        t.near(error.error + t.measured, want, 1e-6, f"angle, {where}")
    t.errors()


def place(pose: dict[str, Any]) -> dict[str, Any]:
    """The fields of SETPOINT that say a pose."""
    fields = {f"{v}_{x}": n for v in "oap" for x, n in zip("xyz", pose[v], strict=True)}
    return {**fields, "configuration": pose["configuration"]}


def solved(t: Tester) -> None:
    """Poses of both arms in all configurations; where there is no angle there is no ERROR."""
    for arm, poses in t.vectors.inverse.items():
        changes = {
            **t.vectors.arms[arm][t.joint],
            **SLOW,
            Parameter.HOMING_SPEED: 0.1,
        }
        p = t.bench(changes)
        middle = 0.5 * (p[Parameter.POSITION_MIN] + p[Parameter.POSITION_MAX])
        t.operational({k: v for k, v in changes.items() if k not in _OF_THE_LINE}, theta=middle)
        before = t.measured
        t.run()
        step = 1 if t.line.virtual else 3
        for number, pose in enumerate(poses[::step]):
            before = _one_pose(t, f"{arm}, pose {number * step}", pose, before)


_OF_THE_LINE: Final = (Parameter.CLOCK, Parameter.BARRIER)
FAR: Final = 3.5
"""From one pose to the next, rad: twice this, back and forth, is a rate that steps."""
TURN: Final = 6.283185307179586


def _one_pose(t: Tester, where: str, pose: dict[str, Any], before: float) -> float:
    """One pose, and one at rest after it; the angle that the node commands then."""
    angle = pose["angles"][t.index]
    want = None if angle is None else _turn(t, angle, before)
    if want is None:
        t.run(4)  # the steps of a joint that misses a set-point go on as they were
    elif abs(want - before) > FAR:
        settle(t)
    t.sync()
    t.move_to(before if want is None else want)
    t.measure()
    first = t.setpoint_frame(0, **place(pose))
    answers = t.give(first)
    t.only(answers, () if want is None else ("ERROR",), f"{where}: {pose}")
    for error in answers.of("ERROR"):
        t.near(error.error + t.measured, want or 0.0, 1e-6, f"{where}: angle")
    t.errors()
    t.speed = 0.0
    t.run()
    return t.measured


def settle(t: Tester) -> None:
    """At rest, and a cycle without a set-point: after it a rate may step."""
    t.speed = 0.0
    t.run(3)
    t.sync()
    t.measure()
    t.errors()


def _turn(t: Tester, angle: float, before: float) -> float:
    """The turn of an angle in the joint's range that is nearest to where it was."""
    low, high = t.parameters[Parameter.POSITION_MIN], t.parameters[Parameter.POSITION_MAX]
    turns = [angle + TURN * k for k in range(-3, 4)]
    inside = [turn for turn in turns if low - 1e-5 <= turn <= high + 1e-5]
    return min(inside, key=lambda turn: abs(turn - before))
