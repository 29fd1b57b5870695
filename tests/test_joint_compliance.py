"""Rows the master sends are found again in the DAC frames: C_theta, M C_theta, gravity, bias."""

import random
from collections.abc import Sequence
from operator import mul

import pytest
from support.joint_bench import ANY_SPEED, JointBench

from rfms_can.arm import ARMS, Arm
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.wire.contract import BIAS_BELONGS, COMPLY_BELONGS, NO_SET, Wire
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Bias, Comply, Dac, JointError, Rows
from rfms_can.wire.vocabulary import Command, FaultCode, Law, NodeState, Parameter

MEMORYLESS = {
    Parameter.KI: 0.0,
    Parameter.COULOMB_POSITIVE: 0.0,
    Parameter.COULOMB_NEGATIVE: 0.0,
    Parameter.VISCOUS: 0.0,
}
"""A servo whose torque follows from this cycle's frames alone."""

ZERO = (0.0,) * 6


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    return float(sum(map(mul, a, b)))


class Injector:
    """An enabled joint whose rows, errors and bias the test chooses; and what must come of them."""

    def __init__(self, wire: Wire, joint: int, arm: Arm, seed: int = 0) -> None:
        self.bench = JointBench(wire, joint, arm, {**MEMORYLESS, **ANY_SPEED}).enable()
        self.bench.run(6)  # until rate and acceleration of the set-point are those of rest
        self.random = random.Random(seed)
        self.scale = self.bench.parameters[Parameter.TORQUE_PER_CODE]
        self.limit = self.bench.parameters[Parameter.TORQUE_LIMIT]

    def some(self, size: float) -> tuple[float, ...]:
        """Six numbers between -size and size."""
        return tuple(self.random.uniform(-size, size) for _ in range(6))

    def with_own_inertia(self, row: Sequence[float]) -> tuple[float, ...]:
        """A row of the inertia matrix whose own element can be: up to ten times the nominal."""
        p, i = self.bench.parameters, self.bench.index
        nominal = p[Parameter.KP] / p[Parameter.NATURAL_FREQUENCY] ** 2
        return (*row[:i], self.random.uniform(0.0, 10.0 * nominal), *row[i + 1 :])

    def cycle(
        self, e: Sequence[float], v: Sequence[float], a: Sequence[float], own: float = 0.0
    ) -> tuple[Dac, JointError]:
        """One cycle with these errors of the others, and an own one; DAC and ERROR of it."""
        bench = self.bench
        bench.sync()
        bench.setpoint()
        answers = bench.measure(bench.q[bench.index] - own)
        answers += bench.other_errors(e, v, a)
        (dac,), (error,) = bench.dacs(answers), bench.errors(answers)
        return dac, error

    def expect(self, dac: Dac, torque: float) -> None:
        """The code is that of a torque (Nm), to half a code and float32."""
        assert abs(torque) < self.limit, "choose smaller errors"
        assert dac.current_dac * self.scale == pytest.approx(
            torque, abs=0.501 * abs(self.scale), rel=1e-4
        )

    def whole(
        self, e: Sequence[float], v: Sequence[float], a: Sequence[float], error: JointError
    ) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
        """All six errors, rates and accelerations, the own ones as the node told them."""
        i = self.bench.index

        def among(values: Sequence[float], mine: float) -> tuple[float, ...]:
            return (*values[:i], mine, *values[i + 1 :])

        return (
            among(e, error.error),
            among(v, error.error_rate),
            among(a, error.acceleration),
        )

    def law(
        self,
        e: Sequence[float],
        v: Sequence[float],
        a: Sequence[float],
        c: Sequence[float],
        mc: Sequence[float],
        law: Law,
    ) -> float:
        """Eq. 5.11 as corrected, or the inertia-weighted law; Nm."""
        p = self.bench.parameters
        if law is Law.WEIGHTED:
            wn, zeta = p[Parameter.NATURAL_FREQUENCY], p[Parameter.DAMPING_RATIO]
            return dot(c, a) + wn * wn * dot(mc, e) + 2.0 * zeta * wn * dot(mc, v)
        return dot(mc, a) + p[Parameter.KP] * dot(c, e) + p[Parameter.KD] * dot(c, v)


@pytest.fixture(params=[(arm, joint) for arm in ARMS for joint in JOINTS], ids=str)
def injector(request: pytest.FixtureRequest, wire: Wire) -> Injector:
    arm, joint = request.param
    return Injector(wire, joint, ARMS[arm], seed=joint)


@pytest.mark.parametrize("law", Law)
def test_mixed_rows_act_in_the_cycle_that_names_them(injector: Injector, law: Law) -> None:
    bench = injector.bench
    size = 0.002 if law is Law.PID else 0.0005
    for number in range(10, 20):
        c, mc = injector.some(0.8 if law is Law.PID else 0.02), injector.some(0.02)
        if law is Law.PID:
            mc = injector.with_own_inertia(mc)
        else:
            c = injector.with_own_inertia(c)
        gravity = injector.random.uniform(-0.1, 0.1) * injector.limit
        told = {"gravity": gravity, "selection": 1}
        bench.rows(number, compliance=c, weighted=mc, law=law, **told)  # type: ignore[arg-type]
        e, v, a = injector.some(size), injector.some(0.01), injector.some(3.0)
        dac, error = injector.cycle(e, v, a, own=injector.random.uniform(-size, size))
        torque = injector.law(*injector.whole(e, v, a, error), c, mc, law)
        injector.expect(dac, torque + gravity)


def test_a_row_without_the_own_joint_makes_it_follow_the_others(wire: Wire) -> None:
    injector = Injector(wire, 3, ARMS["puma560"])
    row = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    injector.bench.rows(5, compliance=row, selection=1)
    gain = injector.bench.parameters[Parameter.KP]
    for other in (0.01, -0.02):
        dac, _ = injector.cycle((0.0, other, 0.0, 0.0, 0.0, 0.0), ZERO, ZERO, own=0.03)
        injector.expect(dac, gain * other)


def test_identity_rows_leave_the_joint_to_itself(injector: Injector) -> None:
    injector.bench.rows(5)
    dac, error = injector.cycle(injector.some(0.5), injector.some(5.0), injector.some(9.0), 0.003)
    p = injector.bench.parameters
    injector.expect(dac, p[Parameter.KP] * error.error + p[Parameter.KD] * error.error_rate)


def test_a_fully_compliant_joint_bears_its_weight_and_no_more(injector: Injector) -> None:
    gravity = 0.2 * injector.limit
    injector.bench.rows(5, compliance=ZERO, gravity=gravity, selection=1)
    dac, error = injector.cycle(injector.some(0.5), injector.some(5.0), ZERO, own=0.01)
    assert error.error != 0.0
    injector.expect(dac, gravity)


# --- swapping ----------------------------------------------------------------------------------


def _gravity_in_dac(injector: Injector, row_set: int) -> float:
    """What the active set says of gravity, read from the DAC; Nm."""
    bench = injector.bench
    bench.sync(row_set=row_set)
    bench.setpoint()
    (dac,) = bench.dacs(bench.measure() + bench.other_errors())
    return dac.current_dac * injector.scale


@pytest.fixture
def second(wire: Wire) -> Injector:
    return Injector(wire, 2, ARMS["puma260"])


def test_rows_that_have_come_wait_for_the_sync_that_names_them(second: Injector) -> None:
    second.bench.rows(1, gravity=1.0)
    assert _gravity_in_dac(second, 1) == pytest.approx(1.0, abs=0.01)
    second.bench.rows(2, gravity=2.0)
    assert _gravity_in_dac(second, 1) == pytest.approx(1.0, abs=0.01)
    assert _gravity_in_dac(second, 2) == pytest.approx(2.0, abs=0.01)


def test_rows_that_come_within_a_cycle_do_not_act_in_it(second: Injector) -> None:
    bench = second.bench
    bench.rows(1, gravity=1.0)
    bench.sync()
    bench.rows(2, gravity=2.0)
    bench.setpoint()
    (dac,) = bench.dacs(bench.measure() + bench.other_errors())
    assert dac.current_dac * second.scale == pytest.approx(1.0, abs=0.01)
    assert _gravity_in_dac(second, 2) == pytest.approx(2.0, abs=0.01)


def test_a_set_that_has_not_come_leaves_the_old_one_and_is_counted(second: Injector) -> None:
    second.bench.rows(1, gravity=1.0)
    assert _gravity_in_dac(second, 1) == pytest.approx(1.0, abs=0.01)
    second.bench.rows(3, gravity=3.0)
    assert _gravity_in_dac(second, 2) == pytest.approx(1.0, abs=0.01)  # set 2 was lost
    assert second.bench.node.faults[FaultCode.ROWS_MISSING] == 1
    assert _gravity_in_dac(second, 3) == pytest.approx(3.0, abs=0.01)
    assert second.bench.state is NodeState.OPERATIONAL


def test_rows_of_other_joints_are_not_ours(second: Injector) -> None:
    bench = second.bench
    bench.rows(1, gravity=1.0)
    for joint in JOINTS:
        if joint != bench.number:
            bench.say(Rows, joint, *ZERO, *ZERO, 5.0, 2, Law.PID, 0.0, 0, 0)
    assert _gravity_in_dac(second, 1) == pytest.approx(1.0, abs=0.01)
    assert _gravity_in_dac(second, 2) == pytest.approx(1.0, abs=0.01)


def test_a_half_arrived_row_set_never_acts() -> None:
    rows = RowSets(4)
    before = (rows.law_row, rows.inertia_row, rows.gravity, rows.law, rows.number)
    rows.receive(Rows(*(1.0,) * 12, 9.0, 7, Law.WEIGHTED, 8.0, 3, 1))
    assert rows.waiting(6) is None
    assert (rows.law_row, rows.inertia_row, rows.gravity, rows.law, rows.number) == before
    waiting = rows.waiting(7)
    assert waiting is not None
    rows.activate(waiting)
    assert (rows.gravity, rows.law, rows.number) == (9.0, Law.WEIGHTED, 7)


def test_no_set_is_named_while_the_master_has_sent_none() -> None:
    rows = RowSets(4)
    assert rows.number == NO_SET
    assert rows.waiting(1) is None


def test_set_numbers_wrap(second: Injector) -> None:
    for k in range(250, 262):
        gravity = (k - 250) / 10.0
        second.bench.rows(k & 0xFF, gravity=gravity)
        assert _gravity_in_dac(second, k & 0xFF) == pytest.approx(gravity, abs=0.01)


def test_after_reset_the_sets_of_a_new_master_count_from_anew(second: Injector) -> None:
    bench = second.bench
    bench.rows(1, gravity=1.0)
    _gravity_in_dac(second, 1)
    bench.command(Command.STOP)
    bench.command(Command.RESET)
    bench.rows(1, gravity=2.0)
    bench.command(Command.HOME)
    bench.sync(NodeState.HOMING)
    (dac,) = bench.dacs(bench.measure() + bench.reference())
    second.expect(dac, 2.0)


# --- bias --------------------------------------------------------------------------------------


def test_bias_goes_out_on_the_force_dac_in_the_cycle_of_its_set_point(second: Injector) -> None:
    bench = second.bench
    fine = bench.parameters[Parameter.TORQUE_PER_FORCE_CODE]
    bench.rows(1)
    bench.sync()
    bench.setpoint(extras=BIAS_BELONGS)
    waiting = bench.measure() + bench.other_errors()
    assert not bench.errors(waiting) and not bench.dacs(waiting)  # it waits for BIAS
    answers = bench.say(Bias, None, 0.1, 0.7, 0.3, 0.0, 0.0, 0.0, bench.cycle & 0xFF)
    (dac,) = bench.dacs(answers)
    assert dac.force_dac * fine == pytest.approx(0.7, abs=0.51 * abs(fine))
    assert dac.current_dac * second.scale == pytest.approx(0.0, abs=0.01)
    (dac,) = bench.dacs(bench.run())
    assert dac.force_dac == 0  # none belongs to this one


def test_bias_of_another_cycle_is_stale(second: Injector) -> None:
    bench = second.bench
    bench.rows(1)
    bench.sync()
    bench.setpoint(extras=BIAS_BELONGS)
    bench.measure()
    late = bench.say(Bias, None, *(0.7,) * 6, bench.cycle - 1 & 0xFF)
    assert not bench.errors(late)
    assert second.bench.node.ignored["stale BIAS"] == 1


def test_the_bias_and_the_servo_together_keep_the_torque_limit(second: Injector) -> None:
    bench = second.bench
    limit = bench.parameters[Parameter.TORQUE_LIMIT]
    fine = bench.parameters[Parameter.TORQUE_PER_FORCE_CODE]
    bench.rows(1, gravity=0.95 * limit)
    bench.sync()
    bench.setpoint(extras=BIAS_BELONGS)
    answers = bench.measure() + bench.other_errors()
    answers += bench.say(Bias, None, *(0.2 * limit,) * 6, bench.cycle & 0xFF)
    (dac,) = bench.dacs(answers)
    total = dac.current_dac * second.scale + dac.force_dac * fine
    assert total == pytest.approx(limit, abs=abs(second.scale))


# --- COMPLY ------------------------------------------------------------------------------------


def test_comply_displaces_the_set_point_and_not_its_acceleration(second: Injector) -> None:
    bench = second.bench
    bench.rows(1, selection=1)
    for cycle in range(3):
        bench.sync()
        bench.setpoint(extras=COMPLY_BELONGS)
        waiting = bench.measure()
        assert not bench.errors(waiting)
        by = 1e-3 * (cycle + 1)
        (error,) = bench.errors(
            bench.say(Comply, None, 0.5, by, 0.5, 0.5, 0.5, 0.5, bench.cycle & 0xFF)
        )
        bench.other_errors()
        assert error.error == pytest.approx(by, abs=1e-4)
        assert error.error_rate == pytest.approx(0.0, abs=1e-6)  # nor its rate, while it complies
        assert error.acceleration == pytest.approx(0.0, abs=1e-6)


def test_a_rigid_joint_is_told_how_fast_the_displacement_fades(second: Injector) -> None:
    bench = second.bench
    bench.rows(1)
    rates = []
    for by in (1e-3, 0.9e-3, 0.8e-3):
        bench.sync()
        bench.setpoint(extras=COMPLY_BELONGS)
        bench.measure()
        answers = bench.say(Comply, None, *(by,) * 6, bench.cycle & 0xFF)
        rates.append(bench.errors(answers)[0].error_rate)
        bench.other_errors()
    assert rates[1:] == pytest.approx([-0.1e-3 / 0.004] * 2, rel=1e-3)


def test_bias_does_not_outlive_the_run_it_was_for(second: Injector) -> None:
    bench = second.bench
    bench.sync()
    bench.setpoint(extras=BIAS_BELONGS)
    bench.measure()
    bench.other_errors()
    bench.say(Bias, None, *(0.7,) * 6, bench.cycle & 0xFF)
    bench.command(Command.STOP)
    bench.start()
    assert _gravity_in_dac(second, bench.row_set) == pytest.approx(0.0, abs=0.01)
