"""Positions in joint coordinates: the arm ends at the angles asked for, on the turns asked for."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.joint_run import STRAIGHT, Run, at, by
from support.trajectory import REST

from rfms_can.arm import ARMS, PUMA_260, Arm
from rfms_can.errors import MoveError
from rfms_can.kinematics import Joints, configuration_of
from rfms_can.messages import StopRequest
from rfms_can.wire.contract import Wire

# --- anywhere ------------------------------------------------------------------------------------


def angles_of(arm: Arm) -> st.SearchStrategy[Joints]:
    """Anywhere in the ranges, at their ends, and with a straight wrist."""
    joints = [
        st.floats(lower, upper) | st.sampled_from((lower, upper))
        for lower, upper in arm.joint_limits
    ]
    joints[4] = joints[4] | st.sampled_from((0.0, 2e-5, -1e-4, 1e-3, -0.04))
    return st.tuples(*joints).map(lambda q: at(q, j5=0.0 if abs(q[4]) < STRAIGHT else q[4]))


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
@settings(max_examples=25)
@given(data=st.data())
def test_a_joint_move_ends_at_the_angles_asked_for_from_anywhere(
    wire: Wire, arm: Arm, data: st.DataObject
) -> None:
    angles = angles_of(arm)
    run = Run(wire, data.draw(angles), arm)
    for _ in range(2):
        there = data.draw(angles)
        run.go(there)
        run.has_reached(there)


@settings(max_examples=25)
@given(
    st.lists(st.tuples(angles_of(PUMA_260), st.integers(0, 250)), min_size=2, max_size=3),
    angles_of(PUMA_260),
)
def test_moves_that_pass_positions_without_rest_end_at_the_last(
    wire: Wire, legs: list[tuple[Joints, int]], start: Joints
) -> None:
    run = Run(wire, start)
    made = start
    for there, cycles in legs:
        try:
            run.go(there, "joint", cycles)
        except MoveError:  # too late, or too fast past the position before
            continue
        made = there
    run.listen()
    if run.heard:
        run.has_reached(made)


small = st.floats(-0.3, 0.3)
turns = st.sampled_from((-math.tau, 0.0, 0.0, math.tau))


@settings(max_examples=40)
@given(st.tuples(*[small] * 6), turns, turns, st.sampled_from(["line", "curve"]))
def test_a_straight_line_ends_at_the_angles_asked_for_or_is_refused(
    wire: Wire, offsets: Joints, turn_4: float, turn_6: float, mode: str
) -> None:
    """Half a turn around zero, joints 4 and 6 of a PUMA 260 have room for turns either way."""
    start = at(REST, j4=math.copysign(2.9, -turn_4), j6=math.copysign(2.9, -turn_6))
    near = by(start, **{f"j{k}": offset for k, offset in enumerate(offsets, 1)})
    there = by(near, j4=turn_4, j6=turn_6)
    run = Run(wire, start)
    if there != near:
        joint = 4 if turn_4 else 6
        with pytest.raises(MoveError, match=rf"would end with joint {joint} at .* stays on the tu"):
            run.go(there, mode)
        assert run.motion.at_rest
        run.go(there)
    else:
        run.go(there, mode)
    run.has_reached(there)


# --- turns ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", ["j4", "j6"])
def test_two_hundred_degrees_are_not_minus_a_hundred_and_sixty(wire: Wire, joint: str) -> None:
    run = Run(wire)
    for degrees in (200.0, -160.0, 200.0, 240.0, -240.0, 120.0, -200.0):
        there = at(REST, **{joint: math.radians(degrees)})
        run.go(there)
        run.has_reached(there)


def test_a_turn_is_more_than_an_equation_can_say(wire: Wire) -> None:
    """The same T6 by its equation is reached on the turn that is nearest."""
    there = at(REST, j6=math.radians(200.0))
    run = Run(wire)
    run.equation("by T6", there)
    run.move("by T6", "joint")
    run.listen()
    run.has_reached(at(REST, j6=math.radians(-160.0)))
    run.go(there)
    run.has_reached(there)
    run.move("by T6", "joint")
    run.listen()
    run.has_reached(there)


def test_a_straight_line_refuses_another_turn_in_one_line(wire: Wire) -> None:
    run = Run(wire, at(REST, j6=math.radians(-150.0)))
    run.joint_position("p", at(REST, j6=math.radians(200.0)))
    with pytest.raises(MoveError) as refused:
        run.move("p", "line")
    assert str(refused.value) == (
        "to 'p' with 'line': move 1: the straight line would end with joint 6 at -2.79253 rad "
        "(-160 deg), and 3.49066 rad (200 deg) is asked for: a line stays on the turns it begins "
        "on: move in joint mode"
    )
    assert run.motion.at_rest
    run.move("p", "joint")
    run.listen()
    run.has_reached(at(REST, j6=math.radians(200.0)))


def test_a_line_that_turns_by_more_than_its_parts_may_ends_on_its_turn(wire: Wire) -> None:
    """More than 0.8 pi is moved in two parts; this rotation passes half a turn of joint 6."""
    run = Run(wire, at(REST, j6=0.9))
    for there in (at(REST, j6=3.6), at(REST, j6=0.9)):
        run.go(there, "line")
        run.has_reached(there)


# --- straight wrists -----------------------------------------------------------------------------

FLAT: Joints = at(REST, j5=0.0)


@pytest.mark.parametrize("theta4", [0.0, 1.3, -2.9, math.radians(200.0), math.radians(-310.0)])
def test_a_straight_wrist_has_the_theta4_asked_for(wire: Wire, theta4: float) -> None:
    there = at(FLAT, j4=theta4)
    run = Run(wire)
    for q in (there, FLAT, there):
        run.go(q)
        run.has_reached(q)


def test_a_wrist_that_is_nearly_straight_is_taken_as_straight(wire: Wire) -> None:
    run = Run(wire)
    run.go(at(FLAT, j4=1.0, j5=0.9 * STRAIGHT))
    run.has_reached(at(FLAT, j4=1.0))
    run.go(at(FLAT, j4=1.0, j5=1.1 * STRAIGHT))
    run.has_reached(at(FLAT, j4=1.0, j5=1.1 * STRAIGHT))


def test_a_line_to_a_straight_wrist_needs_the_theta4_of_its_path(wire: Wire) -> None:
    run = Run(wire)
    run.joint_position("p", at(FLAT, j4=1.0))
    words = r"joint 4 at 0\.65 rad .* 1 rad .* the path tells theta4 .* wrist: move in joint mode$"
    with pytest.raises(MoveError, match=words):
        run.move("p", "line")
    run.go(FLAT, "line")  # joint 5 alone: theta4 stays
    run.has_reached(FLAT)


def test_a_straight_wrist_is_of_the_flip_the_arm_has(wire: Wire) -> None:
    """So a line from there may go on; ``configuration_of`` takes noflip where theta5 is zero."""
    flipped = at(REST, j5=-1.0)
    assert not configuration_of(PUMA_260, flipped).noflip
    run = Run(wire, flipped)
    run.go(FLAT)
    run.go(flipped, "line")
    run.has_reached(flipped)
    run.go(FLAT)
    with pytest.raises(MoveError, match="cannot change the configuration"):
        run.go(REST, "line")
    run.mode_of("noflip", "joint", joint_speed=0.8, configuration="left down noflip")
    run.go(FLAT, "noflip")
    run.go(REST, "line")
    run.has_reached(REST)


# --- together with everything else ---------------------------------------------------------------


def test_a_mode_of_another_configuration_is_refused_with_a_way_out(wire: Wire) -> None:
    run = Run(wire)
    run.mode_of("right", "joint", joint_speed=0.8, configuration="right up noflip")
    run.mode_of("same", "joint", joint_speed=0.8, configuration="left down noflip")
    run.joint_position("p", by(REST, j1=0.2))
    words = (
        "its mode asks for the configuration 'right up noflip', and the joint angles of the "
        "position are 'left down noflip': leave the configuration to the position"
    )
    with pytest.raises(MoveError, match=words):
        run.move("p", "right")
    run.move("p", "same")
    run.listen()
    run.has_reached(by(REST, j1=0.2))


def test_lines_and_equations_go_on_from_where_the_angles_are(wire: Wire) -> None:
    """Turned by more than half a turn, a Cartesian segment and an equation stay on that turn."""
    turned = at(REST, j4=math.radians(190.0), j6=math.radians(220.0))
    run = Run(wire)
    run.go(turned)
    for mode in ("line", "curve"):
        run.go(by(turned, j1=0.1, j5=0.05), mode)
        run.go(turned, mode)
        run.has_reached(turned)
    there = by(turned, j2=0.05, j5=0.05)
    run.equation("by T6", there)
    for mode in ("joint", "line", "curve"):
        run.move("by T6", mode)
        run.listen()
        run.has_reached(there)
        run.go(turned, mode)
        run.has_reached(turned)


def test_cartesian_transitions_lead_from_and_into_moves_to_joint_angles(wire: Wire) -> None:
    turned = at(REST, j4=math.radians(200.0))
    run = Run(wire, by(turned, j4=-0.4))
    run.mode_of("bent", "joint", joint_speed=0.3, transition="cartesian")
    slow = run.mode_of("slow", "cartesian", speed=0.05, transition="cartesian")
    run.go(by(turned, j1=0.2), "joint", 2)
    run.go(by(turned, j1=0.25, j2=0.1), slow, 2)
    run.go(by(turned, j1=0.1, j2=0.1, j6=0.3), "bent", 2)
    run.listen()
    assert run.motion.generator.completed == 3
    run.has_reached(by(turned, j1=0.1, j2=0.1, j6=0.3))


def test_a_move_that_was_stopped_is_made_when_it_is_asked_for_again(wire: Wire) -> None:
    there = at(REST, j6=math.radians(230.0))
    run = Run(wire)
    run.go(there, "joint", 60)
    run.motion.handle(StopRequest())
    run.listen()
    assert run.motion.commanded.theta[5] < there[5] - 0.1
    run.move("angles 0", "joint")
    run.listen()
    run.has_reached(there)
