"""What force control refuses, by name, with what would do; and what it needs a sensor for."""

import re

import numpy as np
import pytest
from support.fleet import PushedFleet

from rfms_can.arm.wrist import FORCE_RANGE
from rfms_can.compliance import SelectionError
from rfms_can.errors import MoveError, ProgramError
from rfms_can.kinematics import direct
from rfms_can.master.force.wrench_estimate import TARE_CYCLES
from rfms_can.master.report import status_of
from rfms_can.messages import PositionMessage, TareRequest, TransformMessage
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire
from rfms_can.wire.records import Force


@pytest.fixture
def fleet(wire: Wire) -> PushedFleet:
    """Without friction: what is pushed moves, and what is not does not."""
    fleet = PushedFleet(wire, friction="none")
    fleet.enable()
    return fleet


def test_a_bias_no_joint_has_is_refused_with_what_would_do(fleet: PushedFleet) -> None:
    reason = r"the bias fx 400 takes (\d+\.\d) Nm of joint (\d), which has .*: ask for (0\.\d+) of"
    with pytest.raises(MoveError, match=reason) as refused:
        fleet.move(comply={"fx": 400.0})
    found = re.search(reason, str(refused.value))
    assert found is not None
    part = float(found.group(3))
    with pytest.raises(MoveError, match=f"joint {found.group(2)}"):
        fleet.move(comply={"fx": 400.0 * part * 1.1})
    assert fleet.move(comply={"fx": 400.0 * part * 0.99}) == 1


def test_a_mass_the_joints_cannot_hold_is_refused_with_what_they_can(fleet: PushedFleet) -> None:
    reason = r"the mass 100 kg takes \d+\.\d Nm of joint (\d), which has .*: (\d+\.?\d*) kg or"
    with pytest.raises(MoveError, match=reason) as refused:
        fleet.move(mass=100.0)
    found = re.search(reason, str(refused.value))
    assert found is not None
    most = float(found.group(2))
    with pytest.raises(MoveError, match=f"joint {found.group(1)}"):
        fleet.move(mass=most + 0.2)
    assert fleet.move(mass=most - 0.1) == 1


def test_a_stop_condition_that_holds_already_is_refused_with_a_sensor(wire: Wire) -> None:
    fleet = PushedFleet(wire, friction="none", sensor="ideal")
    fleet.plant.physics.sample_force = lambda: [0.0, 0.0, 9.0, 0.0, 0.0, 0.0]  # type: ignore[method-assign]
    fleet.enable()
    fleet.run(3)
    with pytest.raises(MoveError, match="its stop condition holds already: fz 9 N reached 8 N"):
        fleet.move(stop_on_force={"fz": 8.0})
    sequence = fleet.move((0.05, 0, 0, 0, 0, 0), stop_on_force={"fz": 9.5})
    fleet.settle(sequence)
    assert status_of(fleet.master).guard is None


def test_a_loop_is_not_closed_over_a_sensor_that_was_not_tared(wire: Wire) -> None:
    fleet = PushedFleet(wire, friction="none", sensor="good", force_loop="closed")
    fleet.enable()
    reason = r"'there 1' .*complies in fx rz with the force loop closed .*not tared.*: tare first"
    with pytest.raises(MoveError, match=reason):
        fleet.move(comply={"fx": 0.0, "rz": 0.0})
    fleet.settle(fleet.move())  # nothing complies
    fleet.run(30)
    fleet.master.handle(TareRequest())
    with pytest.raises(MoveError, match="tare first"):
        fleet.move(comply={"fx": 0.0})  # it is not over yet
    fleet.run(TARE_CYCLES)
    fleet.settle(fleet.move(comply={"fx": 0.0}))
    assert fleet.master.fault is None


@pytest.mark.parametrize("settings", [{"force_loop": "open"}, {"law": "position"}])
def test_what_no_loop_is_closed_over_need_not_be_tared(
    wire: Wire, settings: dict[str, str]
) -> None:
    fleet = PushedFleet(wire, friction="none", sensor="good", **settings)
    fleet.enable()
    assert fleet.move(comply={"fx": 0.0}) == 1


def test_a_reading_that_is_lost_is_not_made_up(wire: Wire) -> None:
    fleet = PushedFleet(wire, friction="none", sensor="ideal")
    fleet.plant.physics.sample_force = lambda: [0.0, 0.0, 5.0, 0.0, 0.0, 0.0]  # type: ignore[method-assign]
    fleet.enable()
    fleet.move((0.1, 0, 0, 0, 0, 0), stop_on_force={"fz": 9.0})
    fleet.run(20)
    force = fleet.id(Force)
    fleet.pump.lose(lambda frame, to: frame.id == force and to is fleet.master)
    fleet.run(2)
    assert status_of(fleet.master).force[2] == pytest.approx(5.0, abs=1e-6)
    fleet.pump.heal()
    fleet.run(5)
    assert fleet.master.fault is None


def test_a_stop_force_below_what_friction_hides_is_refused_without_a_sensor(wire: Wire) -> None:
    fleet = PushedFleet(wire)  # Corke's friction
    fleet.enable()
    reason = r"stop on force fz 1: without a wrist sensor friction hides up to (\d+\.?\d*) there"
    with pytest.raises(MoveError, match=reason) as refused:
        fleet.move(stop_on_force={"fz": 1.0})
    found = re.search(reason, str(refused.value))
    assert found is not None
    assert fleet.move(stop_on_force={"fz": 1.01 * float(found.group(1))}) == 1


def test_a_stop_distance_no_encoder_can_tell_is_refused(fleet: PushedFleet) -> None:
    reason = r"stop on distance dx 1e-09: one count of each encoder is up to (\S+) there"
    with pytest.raises(MoveError, match=reason) as refused:
        fleet.move(stop_on_distance={"dx": 1e-9})
    found = re.search(reason, str(refused.value))
    assert found is not None
    least = float(found.group(1))
    assert 1e-5 < least < 1e-3
    assert fleet.move(stop_on_distance={"dx": 1.1 * least}) == 1


@pytest.mark.parametrize("sensor", ["none", "ideal"])
def test_a_stop_force_that_is_never_felt_is_refused(wire: Wire, sensor: str) -> None:
    """Beyond the range of the sensor, or of what the motors can make it guess."""
    fleet = PushedFleet(wire, friction="none", sensor=sensor)
    fleet.enable()
    fleet.run(3)
    reason = r"stop on force fz 1e\+06: no more than (\d+\.?\d*) can be measured there; give less"
    with pytest.raises(MoveError, match=reason) as refused:
        fleet.move(stop_on_force={"fz": 1e6})
    found = re.search(reason, str(refused.value))
    assert found is not None
    assert sensor == "none" or float(found.group(1)) == FORCE_RANGE
    assert fleet.move(stop_on_force={"fz": 0.99 * float(found.group(1))}) == 1


@pytest.mark.parametrize("word", ["", "fx fw", "fx fx"])
def test_words_that_name_no_directions_are_refused(fleet: PushedFleet, word: str) -> None:
    with pytest.raises(SelectionError, match="selection"):
        fleet.comply(word, *[0.0] * len(word.split()))
    assert status_of(fleet.master).comply == ""


@pytest.mark.parametrize("rows", [(0.0,) * 12, (1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, -1.0, 0)])
def test_a_compliance_frame_that_is_none_is_refused(
    fleet: PushedFleet, rows: tuple[float, ...]
) -> None:
    with pytest.raises(ProgramError, match=r"rigid|rotation|orthonormal"):
        fleet.master.handle(TransformMessage("task", Transform(*rows)))
    fleet.master.handle(TransformMessage("part", direct(fleet.master.arm, fleet.master.arm.park)))
    with pytest.raises(ProgramError, match="'task'"):
        fleet.master.handle(PositionMessage("there", ["t6"], ["part"], compliance="task"))


def test_a_tare_needs_a_sensor_and_an_arm_that_rests(fleet: PushedFleet, wire: Wire) -> None:
    with pytest.raises(ProgramError, match="tare: the arm has no wrist sensor; run it with --sens"):
        fleet.master.handle(TareRequest())
    sensed = PushedFleet(wire, friction="none", sensor="good", force_loop="open")
    sensed.enable()
    sensed.move((0.1, 0, 0, 0, 0, 0))
    sensed.run(10)
    with pytest.raises(ProgramError, match="tare: the arm moves; wait until it rests"):
        sensed.master.handle(TareRequest())
    sensed.settle(sensed.move(comply={"fy": 0.0}))
    sensed.run(30)
    with pytest.raises(ProgramError, match="tare: the arm complies in fy and may press on someth"):
        sensed.master.handle(TareRequest())
    sensed.settle(sensed.move())
    sensed.run(300)
    off = status_of(sensed.master).force
    sensed.master.handle(TareRequest())
    sensed.run(30)
    taken = status_of(sensed.master).force
    assert np.abs(taken[:3]).max() < 0.5 < np.abs(off[:3]).max()
