"""How far a transition stays from the position it cuts: on paper, as planned, and as run."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from pytest import approx
from support.planning import TOOL, How, PlannedRig, at_angles, at_pose
from support.trajectory import REST, TAU

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import direct
from rfms_can.master.trajectory.segment import Transition
from rfms_can.setpoint.blend import MatchingPolynomial, blend_parameter
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.vocabulary import Mode

START = direct(PUMA_260, REST) @ TOOL
CURVED = How(Mode.CARTESIAN, 0.2, 1.0, transition=Transition.CARTESIAN)
SHARE = 5 / 32
"""Of t_acc (v2 - v1): how far the corner is missed at p = 1/2."""


def moved(x: float, y: float, z: float) -> Transform:
    return Transform.translation(x, y, z) @ START


def test_half_way_through_a_transition_the_miss_is_five_32nds() -> None:
    """Old motion and new are there by 5/32 of what they make in t_acc, to and from the corner."""
    v1, v2, t_acc = 0.3, -0.1, 0.2
    left = MatchingPolynomial.matching((-v1 * t_acc, v1, 0.0, 0.0), t_acc)
    miss = left.at(0.5) + v2 * t_acc * blend_parameter(0.5)
    assert miss == approx(SHARE * t_acc * (v2 - v1), abs=1e-15)


@pytest.mark.parametrize("angle", [math.pi / 6, math.pi / 2, 2.6])
def test_at_a_corner_of_straight_lines_of_equal_speed_it_is_that_fraction(angle: float) -> None:
    rig = PlannedRig()
    rig.go(at_pose(moved(-0.05, 0.0, 0.0)), CURVED)
    on = moved(-0.05 - 0.05 * math.cos(angle), 0.05 * math.sin(angle), 0.0)
    plan = rig.go(at_pose(on), CURVED)
    change = 2.0 * 0.05 * math.sin(angle / 2.0)
    assert plan.via_deviation == approx(SHARE * 0.2 * change, rel=1e-6)
    assert plan.via_rotation == approx(0.0, abs=1e-7)


def test_straight_on_at_the_same_speed_it_passes_through() -> None:
    rig = PlannedRig()
    rig.go(at_pose(moved(-0.04, 0.0, 0.0)), CURVED)
    plan = rig.go(at_pose(moved(-0.08, 0.0, 0.0)), CURVED)
    assert plan.via_deviation == approx(0.0, abs=1e-9)


def test_where_the_tool_only_turns_it_is_the_rotation_that_is_missed() -> None:
    rig = PlannedRig()
    rig.go(at_pose(START @ Transform.rotation((0.0, 0.0, 1.0), 0.6)), CURVED)
    plan = rig.go(at_pose(START), CURVED)
    assert plan.via_deviation == approx(0.0, abs=1e-9)
    assert plan.via_rotation == approx(SHARE * 0.2 * (0.6 + 0.6), rel=1e-6)


def test_in_joint_mode_each_joint_misses_by_that_fraction() -> None:
    rig = PlannedRig()
    corner = (REST[0] + 0.3, *REST[1:])
    rig.go(at_angles(corner), How(Mode.JOINT, 0.2, 1.0))
    plan = rig.go(at_angles(REST), How(Mode.JOINT, 0.2, 1.0))
    turn = SHARE * 0.2 * (0.3 + 0.3)
    tool = direct(PUMA_260, corner) @ TOOL
    chord = 2.0 * math.hypot(tool.px, tool.py) * math.sin(turn / 2.0)
    assert plan.via_deviation == approx(chord, rel=1e-6)
    assert plan.via_rotation == approx(turn, rel=1e-6)


def test_there_is_none_where_the_arm_rests() -> None:
    rig = PlannedRig()
    plan = rig.go(at_pose(moved(0.05, 0.0, 0.0)), CURVED)
    assert plan.via_deviation is None and plan.via_rotation is None
    rig.finish()
    plan = rig.go(at_pose(moved(0.05, 0.05, 0.0)), CURVED)
    assert plan.via_deviation is None and plan.via_rotation is None


def off(q: Sequence[float], goal: Transform) -> DriveTransform:
    q1, q2, q3, q4, q5, q6 = q
    return DriveTransform(goal.inverse() @ direct(PUMA_260, (q1, q2, q3, q4, q5, q6)) @ TOOL)


@pytest.mark.parametrize(
    ("first", "second", "transition"),
    [(first, second, each) for first in Mode for second in Mode for each in Transition],
)
def test_the_run_comes_as_near_as_planned(
    first: Mode, second: Mode, transition: Transition
) -> None:
    """Samples of a run are a cycle apart, so that the nearest lies between two of them."""
    rig = PlannedRig()
    rig.run(12)
    corner = direct(PUMA_260, (0.4, 1.3, -2.8, 0.5, 1.2, 0.1)) @ TOOL
    rig.go(at_pose(corner), How(first, 0.2, 0.9, transition=transition))
    there = at_angles((0.0, 1.1, -2.6, 0.1, 0.8, -0.4))
    plan = rig.go(there, How(second, 0.2, 1.1, transition=transition))
    rig.finish()
    assert plan.via_deviation is not None and plan.via_rotation is not None
    missed = [off(q, corner) for q in rig.q]
    distances = [math.hypot(*each.p) for each in missed]
    nearest = int(np.argmin(distances))
    step = max(abs(a - b) for a, b in zip(distances[1:], distances, strict=False))
    assert plan.via_deviation == approx(distances[nearest], abs=step / 4.0)
    assert plan.via_deviation <= distances[nearest] + 2e-5
    assert plan.via_rotation == approx(missed[nearest].psi, abs=2.0 * TAU)
