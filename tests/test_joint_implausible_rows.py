"""ROWS_IMPLAUSIBLE: rows that no arm has never act; the joint goes on with those in force."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.joint_bench import JointBench

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.detectors.following import Excess
from rfms_can.joint_nodes.detectors.plausible_rows import RowsWatch
from rfms_can.joint_nodes.ladder import Reaction
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.contract import Wire
from rfms_can.wire.nodes import MASTER
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import FaultCode, Law, NodeState, Parameter

PARAMETERS = all_parameters(PUMA_260, "corke", 0.004)[2]
LIMIT = PARAMETERS[Parameter.TORQUE_LIMIT]
NOMINAL = PARAMETERS[Parameter.KP] / PARAMETERS[Parameter.NATURAL_FREQUENCY] ** 2
UNIT = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
INERTIA = (0.1, NOMINAL, -0.2, 0.0, 0.01, 0.0)

six = st.tuples(*[st.floats(-2.0, 2.0)] * 6)


def rows(
    law_row: tuple[float, ...] = UNIT,
    inertia: tuple[float, ...] = INERTIA,
    *,
    gravity: float = 0.0,
    law: Law = Law.PID,
    selection: int = 0,
    number: int = 1,
) -> Rows:
    return Rows._make((*law_row, *inertia, gravity, number, law, 0.0, selection, 0, 0))


def after(gravity: float, number: int) -> RowSets:
    """Rows in force: of set ``number``, with a gravity, Nm."""
    active = RowSets(2)
    active.activate(rows(gravity=gravity, number=number))
    return active


def judged(told: Rows, active: RowSets | None = None) -> Excess | None:
    return RowsWatch(PARAMETERS, 2).excess(told, active or RowSets(2))


# --- one set --------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_gravity_is_no_more_than_the_joint_can_carry(sign: float) -> None:
    assert judged(rows(gravity=sign * LIMIT)) is None
    beyond = sign * LIMIT * 1.0001
    assert judged(rows(gravity=beyond)) == Excess(beyond, LIMIT)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_gravity_steps_by_no_more_than_a_quarter_of_it(sign: float) -> None:
    step = 0.25 * LIMIT
    active = after(sign * 0.5 * LIMIT, 7)
    for to in (0.25001, 0.74999):
        assert judged(rows(gravity=sign * to * LIMIT), active) is None
    for to in (0.2499, 0.7501):
        excess = judged(rows(gravity=sign * to * LIMIT), active)
        assert excess == pytest.approx((sign * (to - 0.5) * LIMIT, step))


def test_the_first_set_may_begin_with_any_gravity() -> None:
    assert judged(rows(gravity=LIMIT), after(-LIMIT, 0)) is None


def test_the_own_inertia_is_that_of_the_gains_to_a_factor_of_ten() -> None:
    for own in (0.0, NOMINAL, 9.999 * NOMINAL):
        assert judged(rows(inertia=(5.0, own, 5.0, 5.0, 5.0, 5.0))) is None
    for own in (-1e-6, 10.001 * NOMINAL):
        excess = judged(rows(inertia=(5.0, own, 5.0, 5.0, 5.0, 5.0)))
        assert excess == pytest.approx((own, 10.0 * NOMINAL))


def test_without_a_natural_frequency_no_inertia_is_too_large() -> None:
    watch = RowsWatch({**PARAMETERS, Parameter.NATURAL_FREQUENCY: 0.0}, 2)
    told = rows(inertia=(0.0, 1e6, 0.0, 0.0, 0.0, 0.0))
    assert watch.excess(told, RowSets(2)) is None


@given(six)
def test_the_row_of_a_rigid_pid_is_its_own_error_to_a_thousandth(off: tuple[float, ...]) -> None:
    """The element that is farthest off is told, with what it should be."""
    law_row = tuple(due + 1e-3 * by for due, by in zip(UNIT, off, strict=True))
    excess = judged(rows(law_row))
    distances = [abs(value - due) for value, due in zip(law_row, UNIT, strict=True)]
    farthest = max(range(6), key=distances.__getitem__)
    if distances[farthest] <= 1e-3:
        assert excess is None
    else:
        assert excess == Excess(law_row[farthest], UNIT[farthest])


@given(six)
def test_the_row_of_a_rigid_weighted_law_is_that_of_the_inertia(off: tuple[float, ...]) -> None:
    margin = 1e-3 * NOMINAL
    law_row = tuple(due + margin * by for due, by in zip(INERTIA, off, strict=True))
    excess = judged(rows(law_row, law=Law.WEIGHTED))
    distances = [abs(value - due) for value, due in zip(law_row, INERTIA, strict=True)]
    farthest = max(range(6), key=distances.__getitem__)
    if distances[farthest] <= margin:
        assert excess is None
    else:
        assert excess == Excess(law_row[farthest], INERTIA[farthest])


@given(six, st.sampled_from(Law), st.integers(1, 63))
def test_the_row_of_a_joint_that_complies_may_be_any(
    law_row: tuple[float, ...], law: Law, selection: int
) -> None:
    assert judged(rows(law_row, law=law, selection=selection)) is None


def test_the_first_that_fails_is_told() -> None:
    told = rows((9.0,) * 6, (0.0, -1.0, 0.0, 0.0, 0.0, 0.0), gravity=2.0 * LIMIT)
    assert judged(told, after(LIMIT, 1)) == Excess(2.0 * LIMIT, LIMIT)
    told = rows((9.0,) * 6, (0.0, -1.0, 0.0, 0.0, 0.0, 0.0))
    assert judged(told, after(LIMIT, 1)) == Excess(-LIMIT, 0.25 * LIMIT)
    excess = judged(told)
    assert excess is not None and excess.value == -1.0


# --- the joint ------------------------------------------------------------------------------------


@pytest.fixture
def bench(wire: Wire) -> JointBench:
    bench = JointBench(wire).enable()
    bench.rows(1, gravity=1.0)
    bench.run(5)
    return bench


def gravity_of(bench: JointBench) -> float:
    """What the rows in force say, read in the DAC of a good cycle; Nm."""
    (dac,) = bench.dacs(bench.run())
    return dac.current_dac * bench.parameters[Parameter.TORQUE_PER_CODE]


def test_rows_that_cannot_be_leave_those_in_force_and_count_once(bench: JointBench) -> None:
    bench.rows(2, gravity=1.0 + 0.3 * LIMIT)
    assert gravity_of(bench) == pytest.approx(1.0, abs=0.05)
    assert bench.node.faults == {FaultCode.ROWS_IMPLAUSIBLE: 1}
    assert bench.node.rows.number == 1
    bench.rows(3, gravity=2.0)
    assert gravity_of(bench) == pytest.approx(2.0, abs=0.05)
    for number in (4, 5):
        bench.rows(number, compliance=(0.0, 1.01, 0.0, 0.0, 0.0, 0.0), gravity=2.0)
        bench.run()
    assert bench.node.ladder.misses[FaultCode.ROWS_IMPLAUSIBLE] == 2
    bench.run(row_set=3)  # that in force, named again
    assert bench.node.ladder.misses[FaultCode.ROWS_IMPLAUSIBLE] == 0
    assert (bench.state, bench.emergencies()) == (NodeState.OPERATIONAL, [])


@pytest.mark.parametrize("comes_again", [True, False])
def test_three_syncs_that_name_such_rows_stop_the_joint(
    bench: JointBench, comes_again: bool
) -> None:
    wrong = (0.0, 0.5, 0.0, 0.0, 0.0, 0.0)
    for number in (2, 3, 4) if comes_again else (2, 2, 2):
        assert bench.state is NodeState.OPERATIONAL
        if comes_again or number != bench.row_set:
            bench.rows(number, compliance=wrong, gravity=1.0)
        bench.run(row_set=number)
    (emergency,) = bench.emergencies()
    assert emergency.fault == FaultCode.ROWS_IMPLAUSIBLE
    assert (emergency.culprit, emergency.frame) == (MASTER, bench.wire.id(Rows, bench.number))
    assert (emergency.value, emergency.bound) == (0.5, 1.0)
    assert (bench.state, bench.node.reaction) == (NodeState.QUICKSTOP, Reaction.STOP)
    assert bench.node.rows.gravity == 1.0
    assert not bench.node.faults[FaultCode.ROWS_MISSING]


def test_rows_that_are_missing_and_rows_that_cannot_be_are_counted_apart(
    bench: JointBench,
) -> None:
    for _ in range(2):
        bench.rows(2, gravity=LIMIT)
        bench.run(row_set=2)
        bench.run(row_set=9)
    assert bench.state is NodeState.OPERATIONAL
    assert bench.node.faults == {FaultCode.ROWS_IMPLAUSIBLE: 2, FaultCode.ROWS_MISSING: 2}
    bench.rows(3, gravity=1.0)
    bench.run()
    assert bench.node.ladder.misses[FaultCode.ROWS_IMPLAUSIBLE] == 0
    assert bench.node.ladder.misses[FaultCode.ROWS_MISSING] == 0


def test_rows_in_preop_are_not_counted(wire: Wire) -> None:
    """A joint that does not drive judges them all the same: they do not act."""
    bench = JointBench(wire)
    bench.configure()
    for number in range(1, 6):
        bench.rows(number, gravity=1.1 * LIMIT)
        bench.sync(NodeState.READY)
    assert not bench.node.faults
    assert bench.node.rows.gravity == 0.0
