"""What a torque is made of: the terms add up to it, whatever drives the joint, and cost nothing."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.joint_bench import JointBench
from support.programs.there_and_back import program

from rfms_can.arm import PUMA_560
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.servo import Servo, ServoTerms
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings, SettingsError
from rfms_can.rig.torque_terms import TERMS, joint_key
from rfms_can.wire.contract import BIAS_BELONGS, Wire
from rfms_can.wire.records import Bias, Rows
from rfms_can.wire.vocabulary import Command, Law, NodeState, Parameter

PARAMETERS = {**all_parameters(PUMA_560, "corke", 0.004)[3], Parameter.DITHER_FRACTION: 0.5}

six = st.tuples(*[st.floats(-1.0, 1.0)] * 6)


@given(
    st.lists(st.tuples(six, six, st.integers(0, 63), st.floats(-30.0, 30.0)), min_size=1),
    *(six, six, six),
    st.floats(-20.0, 20.0),
    st.sampled_from(Law),
)
def test_the_terms_of_a_servo_torque_add_up_to_it(
    sets: list[tuple[tuple[float, ...], tuple[float, ...], int, float]],
    e: tuple[float, ...],
    v: tuple[float, ...],
    a: tuple[float, ...],
    bias: float,
    law: Law,
) -> None:
    """Any rows after any others: complying and rigid, clamped, in the middle of a transfer."""
    servo, plain = Servo(PARAMETERS, 3), Servo(PARAMETERS, 3)
    servo.recording = True
    rows = RowSets(3)
    for number, (c, mc, selection, gravity) in enumerate(sets):
        set_number = number % 200
        told = (gravity, set_number, law, 12.0, selection, number % 200)
        rows.receive(Rows._make((*c, *mc, *told, 0)))
        waiting = rows.waiting(set_number)
        assert waiting is not None
        rows.activate(waiting)
        for cycle in range(12):
            torques = []
            for one in (servo, plain):
                if selection:
                    intended = one.state.intended_speed
                    friction = one.friction.complying(v[2], 0.0, intended, cycle)
                else:
                    friction = one.friction.rigid(v[2])
                torques.append(one.torque(e, v, a, rows, gravity, friction, bias))
            assert servo.terms.torque == pytest.approx(torques[0] + bias, abs=1e-9)
            assert torques[0] == torques[1], "recording must not change the torque"
    assert plain.terms == ServoTerms()


@given(*[st.floats(-2.0, 2.0)] * 5)
def test_the_terms_of_a_joint_alone_add_up(
    error: float, rate: float, gravity: float, friction: float, inertia: float
) -> None:
    servo = Servo(PARAMETERS, 3)
    servo.recording = True
    torque = servo.alone(error, rate, gravity, friction, inertia)
    assert servo.terms.torque == pytest.approx(torque, abs=1e-9)
    assert (servo.terms.gravity, servo.terms.friction) == (gravity, friction)
    torque = servo.damped(rate, gravity)
    assert servo.terms.torque == torque
    assert servo.terms == ServoTerms(derivative=servo.terms.derivative, gravity=gravity)


def test_every_torque_of_a_joint_is_recorded_whatever_drives_it(wire: Wire) -> None:
    bench = JointBench(wire)
    told: list[tuple[int, ServoTerms]] = []
    bench.node.record_terms(lambda cycle, terms: told.append((cycle, terms)))
    bench.configure()
    bench.home()
    bench.rows(1, gravity=0.7)
    bench.start()
    bench.run(5)
    bench.sync()
    bench.setpoint(extras=BIAS_BELONGS)
    bench.measure()
    bench.other_errors()
    bench.say(Bias, None, *(0.2,) * 6, bench.cycle & 0xFF)
    assert told[-1][1].bias == pytest.approx(0.2)
    bench.command(Command.QUICKSTOP)
    bench.sync(NodeState.QUICKSTOP)
    bench.measure()
    bench.miss_syncs(6)
    bench.measure()
    dacs = bench.dacs()
    assert len(told) == len(dacs)
    scale = bench.parameters[Parameter.TORQUE_PER_CODE]
    fine = bench.parameters[Parameter.TORQUE_PER_FORCE_CODE]
    for (_, terms), dac in zip(told, dacs, strict=True):
        torque = dac.current_dac * scale + dac.force_dac * fine
        assert terms.torque == pytest.approx(torque, abs=0.51 * (abs(scale) + abs(fine)))
    assert told[-1][1].gravity == pytest.approx(0.7)
    count = len(told)
    bench.node.record_terms(None)
    bench.measure()
    assert len(told) == count
    assert len(bench.dacs()) == count + 1


# --- a recorded run -----------------------------------------------------------------------------


@pytest.mark.system
def test_a_run_records_the_terms_of_all_joints(recorded_with_terms: Path) -> None:
    cycles = json.loads((recorded_with_terms / "summary.json").read_text())["cycles"]
    with np.load(recorded_with_terms / TERMS, allow_pickle=False) as file:
        assert tuple(file["terms"]) == ServoTerms._fields
        for joint in range(1, 7):
            rows = file[joint_key(joint)]
            assert rows[:, 0].tolist() == list(range(len(rows)))
            assert len(rows) == cycles


@pytest.mark.parametrize("bus", ["sim", "hub:none"])
def test_terms_need_a_directory_and_the_simulated_bus(bus: str, tmp_path: Path) -> None:
    record = None if bus == "sim" else tmp_path / "run"
    with pytest.raises(SettingsError, match="--terms needs --record DIRECTORY and bus 'sim'"):
        execute(program, RunSettings(bus=bus), record=record, terms=True)
    assert not (tmp_path / "run").exists()
