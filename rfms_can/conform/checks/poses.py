"""Checks 31e to 31h: angles at the ends of reach and range, wrists almost straight, far turns."""

from collections.abc import Callable
from functools import partial
from typing import Any, Final

from rfms_can.conform.checks.angles import SLOW, TURN, place, settle
from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import read
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import JointAngles, Setpoint
from rfms_can.wire.vocabulary import Command, Mode, Parameter, TrajectoryState

P = Parameter

WIDE: Final = {
    **{**SLOW, P.POSITION_MIN: -20.0, P.POSITION_MAX: 20.0},
    **{P.COARSE_ZERO: -20.0, P.COARSE_PER_CODE: 0.01},
}
"""And a range of many turns."""
MakeFrames = Callable[[], list[Frame]]
"""Makes the frames of a set-point once SYNC has numbered its cycle."""
TOLERANCE: Final = 1e-6
"""Of an angle, rad."""


def shapes(t: Tester) -> None:
    """Arms of other shapes, half a micrometre on either side of the ends of their reach."""
    for number, shape in enumerate(read("shapes")):
        geometry = {Parameter[name]: value for name, value in shape["geometry"].items()}
        t.operational({**WIDE, **geometry})
        before = 0.0
        for n, pose in enumerate(shape["poses"]):
            where = f"arm {number}, pose {n}"
            angle = pose["angles"][t.index]
            if angle is None:
                t.run(3)  # the steps of a joint that misses a set-point go on as they were
            else:
                settle(t)
            before = _solved(t, where, pose, angle, before)


def wrists(t: Tester) -> None:
    """Wrists almost straight: what a pose leaves of joint 4 is held in the next."""
    t.operational(WIDE)
    before = 0.0
    for n, step in enumerate(read("wrists")):
        _bring[step["how"]](t)
        where = f"wrist {n}, {step['how']}"
        before = _solved(t, where, step, step["angles"][t.index], before)


def _nothing(_t: Tester) -> None:
    """The node goes on."""


def _restarted(t: Tester) -> None:
    t.command(Command.STOP)
    t.start()


def _reset(t: Tester) -> None:
    at = t.theta
    t.to_preop()
    t.home(at)
    t.start()


def _configured(t: Tester) -> None:
    t.operational({**WIDE, P.KP: 60.0}, theta=t.theta)


_bring: Final = {
    "alone": _nothing,
    "out of reach": _nothing,
    "refused": _nothing,
    "told": _nothing,
    "restarted": _restarted,
    "reset": _reset,
    "configured": _configured,
}
"""What comes before a pose, by how it is told."""


def ends(t: Tester) -> None:
    """Half of the margin beyond the range a pose has an angle; beyond the margin it has none."""
    t.operational(SLOW)
    before = 0.0
    for n, pose in enumerate(read("ends")[str(t.joint)]):
        where = f"{('lower', 'upper')[n // 2]} end of the range"
        before = _solved(t, where, pose, pose["angle"], before)


def _solved(t: Tester, where: str, pose: dict[str, Any], angle: float | None, at: float) -> float:
    """One cycle at a pose, whose angle must be this one or none; where the joint is then."""
    if angle is None:
        _refused(t, at, f"{where}: {pose}", lambda: _frames(t, pose))
        return at
    want = _nearest(t, angle, at)
    _commands(t, want, where, lambda: _frames(t, pose))
    return want


def _refused(t: Tester, at: float, where: str, frames: MakeFrames = list) -> None:
    """A cycle without an angle."""
    t.only(_cycle(t, at, frames), (), where)


def _commands(t: Tester, angle: float, where: str, frames: MakeFrames) -> None:
    """A cycle whose angle must be this one; the joint is there."""
    answers = t.only(_cycle(t, angle, frames), ("ERROR", "DAC"), where)
    for error in answers.of("ERROR"):
        t.near(error.error + t.measured, angle, TOLERANCE, f"{where}: angle")


def _frames(t: Tester, step: dict[str, Any]) -> list[Frame]:
    """The set-point of a pose: at rest, or after rest where no transition can go on."""
    second, joint_4 = step.get("second"), step.get("joint_4")
    state = TrajectoryState.BLEND if step.get("how") == "refused" else TrajectoryState.IDLE
    told: dict[str, Any] = {"state": state, "poses": 1 if second is None else 2, **place(step)}
    extras = 0 if joint_4 is None else JOINT_SETPOINT_BELONGS
    frames = [t.setpoint_frame(extras, **told)]
    if second is not None:
        frames.append(_second(t, second))
    if joint_4 is not None:
        angles = [0.7] * 6
        angles[3] = joint_4
        frames.append(t.frame(JointAngles, 1, *angles, t.cycle & 0xFF, 8))
    return frames


def _second(t: Tester, pose: dict[str, Any]) -> Frame:
    """SETPOINT_2 with a pose."""
    told = (*pose["o"], *pose["a"], *pose["p"], 0.0, 0.0, 0.2, TrajectoryState.IDLE, Mode.JOINT)
    return t.frame(Setpoint, 2, *told, pose["configuration"], 1, t.cycle, 0, 2, 0)


def _cycle(t: Tester, measured: float, frames: MakeFrames) -> Answers:
    """A cycle with the joint there, and the frames of its set-point, made after SYNC."""
    t.theta = measured
    answers = t.sync() + t.measure()
    told = frames()
    answers += t.give(*told) if told else Answers()
    answers += t.errors()
    return Answers(h for h in answers if h.name != "HEARTBEAT")


def _nearest(t: Tester, angle: float, at: float) -> float:
    """The turn nearest to an angle, in the range with its margin."""
    low, high = t.parameters[P.POSITION_MIN] - 1e-5, t.parameters[P.POSITION_MAX] + 1e-5
    inside = [x for k in range(-8, 9) if low <= (x := angle + TURN * k) <= high]
    return min(inside, key=lambda turn: abs(turn - at))


AWAY: Final = 3.0
"""Where a joint jumps from, and to the other side, rad."""
TURNS: Final = {**WIDE, P.POSITION_MIN: -7.0, P.POSITION_MAX: 7.0}
"""A range of more than two turns."""


def far_turns(t: Tester) -> None:
    """A history that is carried on beyond the range by turns: the pose's nearest turn inside it."""
    pose, angle = t.vectors.rest_pose._asdict(), t.vectors.rest_angles[t.index]
    for sign in (1.0, -1.0):
        t.operational(TURNS, theta=-sign * AWAY)
        for state, angles in (
            (TrajectoryState.IDLE, (-sign * AWAY, None)),
            (TrajectoryState.START, (-sign * AWAY, -sign * AWAY)),
            (TrajectoryState.BLEND, (-sign * AWAY, None)),
            (TrajectoryState.LINEAR, (-sign * AWAY, None)),
            (TrajectoryState.LINEAR, (sign * AWAY, None)),
        ):
            _told(t, state, *angles)
        for _ in range(2):
            _refused(t, sign * AWAY, "a set-point that is lost")
        inside = [x for k in range(-3, 4) if abs(x := angle + TURN * k) <= TURNS[P.POSITION_MAX]]
        want = max(inside, key=lambda turn: sign * turn)
        for where in ("a pose after two that were lost", "the pose again"):
            _commands(
                t,
                want,
                where,
                lambda: [t.setpoint_frame(0, state=TrajectoryState.LINEAR, **place(pose))],
            )


def second_turns(t: Tester) -> None:
    """A second pose that comes on the way to a far goal: on the goal's turn, not on the joint's."""
    poses = read("turns")[str(t.joint)]
    first, goal, last = poses[0], poses[10], poses[9]
    t.operational(WIDE, theta=first["angle"])
    moving: dict[str, Any] = {"acceleration_time": 4.0, "r": 1.0}
    at = first["angle"]
    told: list[tuple[dict[str, Any], dict[str, Any] | None, float, dict[str, Any]]] = [
        *((first, pose, at, {"state": TrajectoryState.IDLE}) for pose in poses),
        (first, goal, at, {"state": TrajectoryState.START, **moving}),
        (goal, None, at, {"state": TrajectoryState.BLEND, "blend_p": 1.0, "r": 1.0}),
        (goal, last, at, {"state": TrajectoryState.LINEAR, "r": 1.0}),
        (first, last, at, {"state": TrajectoryState.START, **moving}),
        (last, None, last["angle"], {"state": TrajectoryState.BLEND, "blend_p": 1.0, "r": 0.0}),
    ]
    for pose, second, want, values in told:
        where = f"{values['state'].name}, its goal more than half a turn away"
        frames = partial(_moving, t, pose, second, values)
        if values["state"] is TrajectoryState.START:  # as the history of the goal has it
            t.only(_cycle(t, want, frames), ("ERROR", "DAC"), where)
        else:
            _commands(t, want, where, frames)


def _moving(
    t: Tester, pose: dict[str, Any], second: dict[str, Any] | None, values: dict[str, Any]
) -> list[Frame]:
    """A set-point of a motion in joint angles, no angle told."""
    frames = [t.setpoint_frame(0, poses=1 if second is None else 2, **place(pose), **values)]
    return frames if second is None else [*frames, _second(t, second)]


def _told(t: Tester, state: TrajectoryState, first: float, second: float | None) -> None:
    """A cycle of a motion in joint angles that are told."""
    poses = 1 if second is None else 2
    p = 1.0 if state is TrajectoryState.BLEND else 0.0

    def frames() -> list[Frame]:
        one = t.setpoint_frame(state=state, blend_p=p, poses=poses)
        found = [one, t.angles_frame(first)]
        if second is not None:
            values = t.codec(Setpoint, 1).unpack(one.data)
            assert values is not None
            found += [t.frame(Setpoint, 2, *values), t.angles_frame(second, 2)]
        return found

    _commands(t, first, f"{state.name}, told", frames)
