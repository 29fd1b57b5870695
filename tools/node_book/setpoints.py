"""Vectors of the set-point of one joint: traces of what comes in, and what a joint makes of it."""

import math
from typing import Final, NamedTuple

from generated import table

from node_book.printed import as_float32, number
from rfms_can.kinematics import Configuration
from rfms_can.setpoint import JointSetpoint
from rfms_can.setpoint.blend import blend_parameter
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.setpoint.succession import FOLLOWS
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode, TrajectoryState

PERIOD_S: Final = as_float32(0.004)
"""As CONFIG brings it."""
T_ACC: Final = 0.02
"""Five periods: every row of a transition fits on the page."""
TICKS: Final = 5
S, J, C = TrajectoryState, Mode.JOINT, Mode.CARTESIAN
ORDERS: Final = ("value", "rate", "acceleration", "jerk")
_ANY: Final = Configuration(left=True, up=True, noflip=True)


class Row(NamedTuple):
    """What comes in in a cycle; None for ``state`` is a cycle without a usable set-point."""

    state: TrajectoryState | None
    mode: Mode = J
    r: float = 0.0
    p: float = 0.0
    q1: float = 0.0
    q2: float | None = None
    t_acc: float = T_ACC


def _transition(h_of_end: float, q1: float, mode: Mode = J) -> list[Row]:
    """BLEND rows of a joint segment of ``1 / h_of_end`` times t_acc, after its START."""
    rows = []
    for k in range(1, 2 * TICKS + 1):
        p = k / (2 * TICKS)
        rows.append(Row(S.BLEND, mode, 1.0 - h_of_end * blend_parameter(p), p, q1))
    return rows


def joint_segments() -> list[Row]:
    """From rest at 0.3 to 0.5, on the way over to 0.4 without a stop, and a missed cycle."""
    part, ticks = TICKS / 16, 16  # of a segment of 16 periods from -t_acc to the hand-over
    rows = [Row(S.IDLE, J, 0.0, 0.0, 0.3), Row(S.IDLE, J, 0.0, 0.0, 0.3, 0.5)]
    rows += [Row(S.START, J, 1.0, 0.0, 0.3, 0.5), *_transition(part, 0.5)]
    for k in range(TICKS + 1, ticks - TICKS - 1):
        rows.append(Row(S.LINEAR, J, 1.0 - k / ticks, 0.0, 0.5))
    rows.append(Row(None))
    left = ticks - TICKS
    rows.append(Row(S.PRE, J, 1.0 - left / ticks, 0.0, 0.5, 0.4))
    rows += [Row(S.START, J, 1.0, 0.0, 0.5, 0.4), *_transition(part, 0.4)]
    rows += [Row(S.LINEAR, J, 1.0 - k / ticks, 0.0, 0.4) for k in range(TICKS + 1, ticks + 1)]
    rows += [Row(S.IDLE, J, 0.0, 0.0, 0.4), Row(S.IDLE, J, 0.0, 0.0, 0.4)]
    return rows


def lines() -> list[Row]:
    """A straight line, whose solution moves; into a joint segment at a START between two cycles."""

    def solution(k: int) -> float:
        return 0.8 + 0.1 * (1.0 - math.cos(0.06 * k))

    rows = [Row(S.IDLE, C, 0.0, 0.0, solution(0), solution(0))]
    rows.append(Row(S.START, C, 1.0, 0.0, solution(0)))
    for k in range(1, 2 * TICKS + 1):
        p = k / (2 * TICKS)
        h = TICKS / 20 * blend_parameter(p)
        rows.append(Row(S.BLEND, C, 1.0 - h, p, solution(k)))
    for k in range(2 * TICKS + 1, 15):
        rows.append(Row(S.LINEAR, C, 1.0 - (k - TICKS) / 20, 0.0, solution(k)))
    rows.append(Row(S.PRE, C, 1.0 - 10 / 20, 0.0, solution(15), 0.9))
    rows.append(Row(S.PRE, C, 1.0 - 11 / 20, 0.0, solution(16), 0.9))
    rows.append(Row(S.START, J, 1.0, 0.04, solution(17), 0.9))
    for k in range(1, 2 * TICKS):
        p = k / (2 * TICKS) + 0.04
        rows.append(Row(S.BLEND, J, 1.0 - TICKS / 16 * blend_parameter(p), p, 0.9))
    return rows


def stopped() -> list[Row]:
    """On the way from 0.3 to 0.5 the arm is stopped halfway, rests, and goes to 0.2 from there."""
    part = TICKS / 16
    rows = [Row(S.IDLE, J, 0.0, 0.0, 0.3), Row(S.IDLE, J, 0.0, 0.0, 0.3, 0.5)]
    rows += [Row(S.START, J, 1.0, 0.0, 0.3, 0.5), *_transition(part, 0.5)]
    rows += [Row(S.LINEAR, J, r, 0.0, 0.5) for r in (0.64, 0.61, 0.6, 0.6)]
    rest = 0.5 - 0.2 * as_float32(0.6)
    rows += [Row(S.IDLE, J, 0.6, 0.0, rest), *[Row(S.IDLE, J, 0.6, 0.0, rest, 0.2)] * 2]
    return [*rows, Row(S.START, J, 1.0, 0.0, rest, 0.2), *_transition(part, 0.2)[:4]]


def departing(start: int) -> list[Row]:
    """A curve that is left at cycle ``start`` by a transition of 2.4 s, 300 periods for t_acc."""

    def solution(k: int) -> float:
        return 0.8 + 0.1 * (1.0 - math.cos(0.02 * k))

    rows = [Row(S.IDLE, C, 0.0, 0.0, solution(0), solution(0))]
    rows.append(Row(S.START, C, 1.0, 0.0, solution(1)))
    rows += [Row(S.BLEND, C, 1.0, k / 10, solution(1 + k)) for k in range(1, 11)]
    rows += [Row(S.LINEAR, C, 1.0, 0.0, solution(k)) for k in range(12, start - 2)]
    rows += [Row(S.PRE, C, 1.0, 0.0, solution(k), 1.1) for k in (start - 2, start - 1)]
    rows.append(Row(S.START, J, 1.0, 0.0, solution(start), 1.1, 1.2))
    return [*rows, *[Row(S.BLEND, J, 1.0, k / 600, 1.1, None, 1.2) for k in (1, 2, 3)]]


def received(row: Row, blend: Blend) -> CartesianSetpoint:
    """The set-point of a row; its poses stand for their solutions."""
    assert row.state is not None
    pose = Transform.identity()
    second = None if row.q2 is None else pose
    return CartesianSetpoint(
        *(row.state, row.mode, blend, as_float32(row.r), as_float32(row.p)),
        as_float32(row.t_acc),
        *(pose, _ANY, second, _ANY),
    )


def trace(rows: list[Row], blend: Blend, start: float) -> list[tuple[float, float, float]]:
    """Angle, rate and acceleration of each cycle."""
    joint = JointSetpoint(PERIOD_S, start)
    made = []
    for row in rows:
        if row.state is None:
            joint.miss()
        else:
            theta = joint.advance(received(row, blend), row.q1, row.q2 or 0.0)
            assert not math.isnan(theta), row
        made.append((joint.theta, joint.rate, joint.acceleration))
    return made


def _traced(rows: list[Row], start: float) -> str:
    continuous, thesis = (trace(rows, blend, start) for blend in (Blend.CONTINUOUS, Blend.THESIS))
    printed = []
    for cycle, (row, own, other) in enumerate(zip(rows, continuous, thesis, strict=True)):
        if row.state is None:
            told = ("missed", "", "", "", "", "")
        else:
            r, p = (number(as_float32(x), 9) for x in (row.r, row.p))
            q2 = "" if row.q2 is None else f"{row.q2:.10g}"
            told = (row.state.name, row.mode.name, r, p, f"{row.q1:.10g}", q2)
        angles = (f"{own[0]:.9f}", f"{own[1]:.6f}", f"{own[2]:.3f}", f"{other[0]:.9f}")
        printed.append((str(cycle), *told, *angles))
    columns = ("cycle", "state", "mode", "r", "p", "q1", "q2", "θ", "rate", "acceleration")
    return table((*columns, "θ, thesis"), printed)


def succession() -> str:
    """The states that each may follow."""
    columns = ("state", "may follow")
    rows = []
    for state in TrajectoryState:
        names = [before.name for before in TrajectoryState if before in FOLLOWS[state]]
        if state is S.LINEAR:
            names[0] += " (only if mode is CARTESIAN and p > 0)"
            assert FOLLOWS[state] >= {S.IDLE}
        rows.append((state.name, ", ".join(names)))
    return table(columns, rows)


def joint_trace() -> str:
    """The first trace."""
    return _traced(joint_segments(), 0.3)


def stopped_trace() -> str:
    """The third."""
    return _traced(stopped(), 0.3)


def departing_trace() -> str:
    """The last cycles of curves that are left slowly."""
    printed = []
    for start in (40, 101, 181):
        made = trace(departing(start), Blend.CONTINUOUS, 0.8)
        for cycle in range(start, start + 4):
            theta, rate, acceleration = made[cycle]
            numbers = (f"{theta:.9f}", f"{rate:.6f}", f"{acceleration:.3f}")
            printed.append((str(start), str(cycle), *numbers))
    return table(("START at", "cycle", "θ", "rate", "acceleration"), printed)


def line_trace() -> str:
    """The second."""
    return _traced(lines(), 0.8)


def weights() -> str:
    """Weights of the fits of ten samples."""
    from rfms_can.setpoint.history import SampleHistory  # noqa: PLC0415 (the one user here)

    rows = []
    for which, fit in (("newest", SampleHistory.at_newest), ("one ahead", SampleHistory.one_ahead)):
        for count in (2, 3, 8, 10):
            orders = 2 if count < 10 else 4
            for order, name in enumerate(ORDERS[:orders]):
                found = []
                for place in range(count):
                    history = SampleHistory()
                    for index in range(count):
                        history.push(float(index == place))
                    found.append(fit(history, 1.0, count)[order])
                said = ", ".join(f"{w:.6g}" if abs(w) > 1e-9 else "0" for w in found)
                rows.append((which, str(count), name, said))
    return table(("at", "samples", "of", "weights, oldest first, for a period of 1"), rows)
