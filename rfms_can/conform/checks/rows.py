"""Check 52i: rows that cannot be do not act, and for three SYNCs no longer."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from rfms_can.conform.checks.cycles import BARE
from rfms_can.conform.checks.emergencies import emergency, noted
from rfms_can.conform.checks.ladder import bare
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import float32
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import FaultCode, Law, NodeState, Parameter

S, F, P = NodeState, FaultCode, Parameter

IDENTITY: Final = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
INERTIA: Final = (0.1, 0.02, -0.01, 0.0, 0.0, 0.0)
MOST: Final = 0.8
"""10 KP / wn^2 of the bench."""


class Told(NamedTuple):
    """A set of rows, own elements first.

    Attributes:
        law_row, inertia, gravity, law, selection: as ROWS has them.
        value, bound: of EMCY where the set cannot be; None where it can.
    """

    law_row: Sequence[float] = IDENTITY
    inertia: Sequence[float] = (0.0,) * 6
    gravity: float = 0.0
    law: Law = Law.PID
    selection: int = 0
    value: float | None = None
    bound: float = 0.0


def _with(row: Sequence[float], element: int, value: float) -> list[float]:
    return [value if k == element else float(x) for k, x in enumerate(row)]


def _sets() -> Iterator[Told]:
    """At each bound, and beyond it; the set before has no gravity."""
    yield Told(gravity=2.5)
    yield Told(gravity=-2.5)
    yield Told(gravity=2.501, value=2.501, bound=2.5)
    yield Told(gravity=-2.501, value=-2.501, bound=2.5)
    yield Told(gravity=10.01, value=10.01, bound=10.0)
    yield Told(gravity=-10.01, value=-10.01, bound=10.0)
    yield Told(inertia=_with(INERTIA, 0, 0.799))
    yield Told(inertia=_with(INERTIA, 0, 0.801), value=0.801, bound=MOST)
    yield Told(inertia=_with(INERTIA, 0, -0.001), value=-0.001, bound=MOST)
    yield Told(inertia=_with(INERTIA, 0, 0.801), selection=4, value=0.801, bound=MOST)
    yield Told(_with(IDENTITY, 1, 0.4), selection=4)
    for element, due in ((0, 1.0), (1, 0.0), (5, 0.0)):
        for off in (0.9e-3, -0.9e-3):
            yield Told(_with(IDENTITY, element, due + off))
        for off in (1.1e-3, -1.1e-3, 0.5, -2.0):
            yield Told(_with(IDENTITY, element, due + off), value=due + off, bound=due)
    yield Told(_with(_with(IDENTITY, 1, 0.3), 2, -0.4), value=-0.4, bound=0.0)
    yield Told(INERTIA, INERTIA, law=Law.WEIGHTED)
    yield Told(_with(INERTIA, 1, 0.4), INERTIA, law=Law.WEIGHTED, selection=4)
    for element in (0, 1):
        due = INERTIA[element]
        yield Told(_with(INERTIA, element, due + 0.9e-4), INERTIA, law=Law.WEIGHTED)
        wrong = _with(INERTIA, element, due + 1.1e-4)
        yield Told(wrong, INERTIA, law=Law.WEIGHTED, value=due + 1.1e-4, bound=due)


def implausible(t: Tester) -> None:
    """Sets at each bound act; beyond it the one in force stays, and the third stops the joint."""
    for told in _sets():
        _one_set(t, told)
    _begins_again(t)
    # before any set gravity may be what the torque limit is; without gains no inertia is too large
    _first_set(t, {}, gravity=10.0)
    _first_set(t, {P.KP: 0.0}, inertia=3.0)
    _first_set(t, {P.NATURAL_FREQUENCY: 0.0}, inertia=3.0)


def _send(t: Tester, number: int, told: Told) -> None:
    row, inertia = t.own_first(told.law_row), t.own_first(told.inertia)
    rest = (told.gravity, number, told.law, 0.0, told.selection, 0)
    t.rows(number, (*row, *inertia, *rest))


def _one_set(t: Tester, told: Told) -> None:
    t.operational({**BARE, P.KD: 0.5})
    _send(t, 1, Told())
    t.run(2)
    _send(t, 2, told)
    why = f"{told}"
    if told.value is None:
        t.only(bare(t.run()), ("ERROR", "DAC"), why)
        noted(t, S.OPERATIONAL)
        return
    for _ in range(2):
        answers = bare(t.run())
        t.only(answers, ("ERROR", "DAC"), why)
        t.equal([d.current_dac for d in answers.of("DAC")], [0], f"DAC by the set before, {why}")
    noted(t, S.OPERATIONAL, F.ROWS_IMPLAUSIBLE)
    answers = bare(t.sync())
    t.only(answers, ("EMCY",), why)
    emergency(
        *(t, answers, F.ROWS_IMPLAUSIBLE),
        culprit=MASTER,
        frame=t.codec(Rows, t.joint).id,
        value=float32(told.value),
        bound=told.bound,
        tolerance=1e-5,
    )
    noted(t, S.QUICKSTOP, F.ROWS_IMPLAUSIBLE)


def _begins_again(t: Tester) -> None:
    """A SYNC whose set is in force ends the row of either fault; neither counts for the other."""
    t.operational(BARE)
    _send(t, 1, Told())
    t.run(2)
    _send(t, 2, Told(gravity=9.0))
    for names in ((2, 2, 1), (9, 9, 1), (2, 9, 2, 9, 1), (2, 2)):
        for number in names:
            t.row_set = number
            t.only(bare(t.run()), ("ERROR", "DAC"), f"SYNC names set {number} of {names}")
    noted(t, S.OPERATIONAL, F.ROWS_MISSING, F.ROWS_IMPLAUSIBLE)


def _first_set(
    t: Tester, changes: dict[Parameter, float], gravity: float = 0.0, inertia: float = 0.0
) -> None:
    t.operational({**BARE, **changes})
    _send(t, 1, Told(inertia=_with(INERTIA, 0, inertia), gravity=gravity))
    t.only(bare(t.run()), ("ERROR", "DAC"), f"gravity {gravity}, inertia {inertia}, {changes}")
    noted(t, S.OPERATIONAL)
