"""Checks 30b and 30c: which set-point may follow which, and a hand-over after one that was lost."""

from typing import Any, Final

from rfms_can.conform.talk import Answers
from rfms_can.conform.tester import Tester
from rfms_can.wire.contract import JOINT_SETPOINT_BELONGS
from rfms_can.wire.records import JointError, Setpoint
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

T, M = TrajectoryState, Mode

FOLLOWS: Final = {
    T.IDLE: (T.IDLE, T.LINEAR, T.BLEND),
    T.LINEAR: (T.LINEAR, T.PRE, T.START, T.BLEND),
    T.PRE: (T.LINEAR, T.PRE, T.BLEND),
    T.START: (T.IDLE, T.LINEAR, T.PRE),
    T.BLEND: (T.START, T.BLEND),
}
"""The states that a set-point of each state may follow; LINEAR follows IDLE as well if it is
CARTESIAN and p > 0."""
WAY: Final = (T.START, T.BLEND, T.LINEAR, T.PRE)
"""From rest to each state."""
STEPS: Final = 20
"""Cycles of a transition."""


def succession(t: Tester) -> None:
    """Every state after every other: taken as the table says, else as one that is lost."""
    for last in T:
        for state in T:
            for mode in M:
                for p in (0.0, 0.5):
                    t.operational()
                    t.run(1)
                    for before in WAY[: WAY.index(last) + 1] if last in WAY else ():
                        _cycle(t, before, M.JOINT, 1.0, 0.0)
                    taken = last in FOLLOWS[state]
                    if (last, state) == (T.IDLE, T.LINEAR):
                        taken = mode is M.CARTESIAN and p > 0.0
                    answers = _cycle(t, state, mode, 1.0, p)
                    told = f"{state.name}, {mode.name}, p {p} after {last.name}"
                    t.only(answers, ("ERROR", "DAC") if taken else (), told)
    t.operational()
    t.run(1)
    answers = _cycle(t, T.START, M.JOINT, 1.0, 0.0, (0.0, None))
    t.only(answers, (), "START of a joint segment without a second pose")


def _cycle(
    t: Tester,
    state: TrajectoryState,
    mode: Mode,
    r: float,
    p: float,
    angles: tuple[float, float | None] = (0.0, 0.0),
    blend: Blend = Blend.CONTINUOUS,
) -> Answers:
    """A cycle with a set-point of its own; START of a Cartesian segment has no second pose."""
    answers = t.sync() + t.measure()
    angle, second = angles
    if state is T.START and mode is M.CARTESIAN:
        second = None
    told: Any = {"state": state, "mode": mode, "r": r, "blend_p": p, "acceleration_time": 0.04}
    poses = 1 if second is None else 2
    first = t.setpoint_frame(JOINT_SETPOINT_BELONGS, poses=poses, blend=blend, **told)
    frames = [first, t.angles_frame(angle)]
    if second is not None:
        values = t.codec(Setpoint, 1).unpack(first.data)
        assert values is not None
        frames += [t.frame(Setpoint, 2, *values), t.angles_frame(second, 2)]
    answers += t.give(*frames) + t.errors()
    return Answers(h for h in answers if h.name != "HEARTBEAT")


def lost_before_start(t: Tester) -> None:
    """With r going on evenly, a hand-over is the same where the set-point before it is lost."""
    for blend in Blend:
        whole = _errors(t, blend, lost=0)
        for lost in (1, 2):
            for number, (got, want) in enumerate(
                zip(_errors(t, blend, lost=lost), whole, strict=True)
            ):
                where = f"{blend.name}, {lost} lost before START, cycle {number} of it: error"
                t.near(got, want, 1e-6, where)


def _errors(t: Tester, blend: Blend, lost: int) -> list[float]:
    """From 0 towards 0.05 rad, and on to 0.02 rad: the errors from the second START on."""
    t.operational()
    t.run(12)
    _cycle(t, T.START, M.JOINT, 1.0, 0.0, (0.0, 0.05), blend)
    for k in range(1, STEPS + 1):
        _cycle(t, T.BLEND, M.JOINT, 1.0 - 0.01 * k, k / STEPS, (0.05, None), blend)
    for k in range(12):
        _cycle(t, T.LINEAR, M.JOINT, 0.79 - 0.01 * k, 0.0, (0.05, None), blend)
    for k in range(12):
        if k < 12 - lost:
            _cycle(t, T.PRE, M.JOINT, 0.67 - 0.01 * k, 0.0, (0.05, 0.02), blend)
            continue
        t.sync()
        t.measure()
        t.errors()
    answers = _cycle(t, T.START, M.JOINT, 1.0, 0.0, (0.03, 0.02), blend)
    for k in range(1, STEPS + 1):
        answers += _cycle(t, T.BLEND, M.JOINT, 1.0 - 0.01 * k, k / STEPS, (0.02, None), blend)
    told: list[JointError] = answers.of("ERROR")
    t.equal(len(told), STEPS + 1, "ERRORs of a transition")
    return [error.error for error in told]
