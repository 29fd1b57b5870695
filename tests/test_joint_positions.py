"""Positions in joint coordinates: the arm ends at the angles asked for, on the turns asked for."""

import itertools
import math
import re
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx
from random_programs.draw import JOINT_COORDINATES, Move, draw
from random_programs.draw import Program as Random
from random_programs.joints import NodeJoints
from random_programs.trial import Trial
from support.motion import PERIOD_S, Program
from support.trajectory import REST

from rfms_can.arm import ARMS, PUMA_260, PUMA_560, Arm
from rfms_can.errors import JointPositionError, MoveError, ProgramError, TransformError
from rfms_can.kinematics import Configuration, Joints, configuration_of, direct
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import JointPosition
from rfms_can.messages import JointPositionMessage, ModeMessage, StopRequest, TransformMessage
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire

REACHED = 1e-6
"""Rad the commanded trajectory may be off the angles asked for; it ends on their turns."""
HEARD = 4e-6
"""Rad a node may be off: it solves T6 of float32 where the wrist is bent by 0.05 or more."""
TOLD = 5e-7
"""Rad where it is told its angles: float32 of them."""
STRAIGHT = 1e-5
"""Rad of theta5 within which a wrist is taken as straight."""


def at(q: Sequence[float], **joints: float) -> Joints:
    """``q``, with joints by name (``j1`` to ``j6``) elsewhere, rad."""
    q1, q2, q3, q4, q5, q6 = (joints.get(f"j{k}", angle) for k, angle in enumerate(q, 1))
    return (q1, q2, q3, q4, q5, q6)


def by(q: Joints, **joints: float) -> Joints:
    """``q``, with joints by name moved by so much, rad."""
    return at(q, **{name: q[int(name[1]) - 1] + angle for name, angle in joints.items()})


class Run(Program):
    """A program whose set-points six joints hear as their nodes do."""

    def __init__(self, wire: Wire, start: Sequence[float] = REST, arm: Arm = PUMA_260) -> None:
        super().__init__(arm, start)
        q1, q2, q3, q4, q5, q6 = start
        self._nodes = NodeJoints(wire, arm, (q1, q2, q3, q4, q5, q6), PERIOD_S)
        self._cycle = itertools.count()
        self._names = itertools.count()
        self.heard: list[float] = []
        self.modes = {
            "joint": self.mode_of("joint", "joint", joint_speed=0.8),
            "line": self.mode_of("line", "cartesian", speed=0.1),
            "curve": self.mode_of("curve", "cartesian", speed=0.1, transition="cartesian"),
        }

    def mode_of(self, name: str, interpolation: str, **more: object) -> str:
        settings: dict[str, object] = {"lengthen": True, "lengthen_at_most": 1e3, **more}
        message = ModeMessage(name, interpolation, 0.2, **settings)  # type: ignore[arg-type]
        self.motion.handle(message)
        return name

    def equation(self, name: str, angles: Joints) -> None:
        """A position by the equation of the T6 that joint angles have."""
        self.motion.handle(TransformMessage(name, direct(PUMA_260, angles)))
        self.position(name, name)

    def go(self, angles: Joints, mode: str = "joint", cycles: int | None = None) -> None:
        """Ask for a move to joint angles; run to its end, or so many cycles."""
        name = f"angles {next(self._names)}"
        self.joint_position(name, angles)
        self.move(name, mode)
        self.listen(cycles)

    def listen(self, cycles: int | None = None) -> None:
        """Run so many cycles, or until the arm rests."""
        for _ in itertools.count() if cycles is None else range(cycles):
            if cycles is None and self.motion.at_rest:
                break
            self.run(1)
            told, behind = self.motion.commanded.told, self.motion.displaced(None)
            self.heard = self._nodes.take(self.setpoints[-1], told, behind, next(self._cycle))

    def has_reached(self, angles: Joints) -> None:
        """Assert that the arm rests there: as commanded, and as the nodes have it."""
        commanded = self.motion.commanded
        assert commanded.theta == approx(angles, abs=REACHED, rel=0.0)
        bound = HEARD if commanded.told is None else REACHED + TOLD
        assert self.heard == approx(angles, abs=bound, rel=0.0)


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


# --- defined again, and removed ------------------------------------------------------------------


def test_a_position_that_is_defined_again_acts_in_moves_that_wait(wire: Wire) -> None:
    run = Run(wire)
    first, second = by(REST, j1=0.3), at(REST, j6=math.radians(200.0))
    run.joint_position("a", first)
    run.joint_position("b", at(REST, j6=math.radians(-160.0)))
    run.move("a", "joint")
    run.move("b", "joint")
    run.listen(5)
    assert [each.sequence for each in run.joint_position("b", second).replanned] == [2]
    assert run.joint_position("b", second).replanned == []
    assert run.joint_position("a", at(REST, j1=-0.1)).replanned == []  # it has begun
    run.listen()
    run.has_reached(second)


def test_an_equation_takes_the_name_of_joint_angles_and_the_other_way_round(wire: Wire) -> None:
    run = Run(wire)
    there = at(REST, j6=math.radians(200.0))
    run.joint_position("a", by(REST, j1=0.3))
    run.joint_position("b", there)
    run.transform("up", 0.0, 0.0, 0.02)
    run.move("a", "joint")
    run.move("b", "joint")
    run.listen(5)
    assert [each.sequence for each in run.position("b", "up").replanned] == [2]
    with pytest.raises(TransformError, match="is used by position 'b'"):
        run.remove("up")
    assert [each.sequence for each in run.joint_position("b", there).replanned] == [2]
    run.remove("up")
    run.listen()
    run.has_reached(there)


def test_a_redefinition_that_cannot_be_made_changes_nothing(wire: Wire) -> None:
    run = Run(wire)
    there = by(REST, j1=0.1)
    run.joint_position("a", by(REST, j1=0.05))
    run.joint_position("b", there)
    run.move("a", "line")
    run.move("b", "line")
    run.listen(5)
    words = "position 'b' stays as it was, .*move 2, to 'b' with 'line': the straight line would"
    with pytest.raises(MoveError, match=words):
        run.joint_position("b", at(there, j6=there[5] + math.radians(-360.0) + 3.0))
    with pytest.raises(JointPositionError):
        run.joint_position("b", at(there, j1=9.0))
    run.listen()
    run.has_reached(there)


def test_a_refused_change_from_equation_to_angles_leaves_what_uses_what(wire: Wire) -> None:
    run = Run(wire)
    run.joint_position("a", by(REST, j1=0.05))
    run.equation("b", by(REST, j1=0.1))
    run.move("a", "line")
    run.move("b", "line")
    run.listen(5)
    with pytest.raises(MoveError, match="position 'b' stays as it was"):
        run.joint_position("b", by(REST, j1=0.1, j6=2.0 * math.pi - 3.0))
    with pytest.raises(TransformError, match="transform 'b' is used by position 'b'"):
        run.remove("b", "transform")
    run.listen()
    run.has_reached(by(REST, j1=0.1))
    run.remove("b", "position")
    run.remove("b")
    assert run.motion.world.names().sizes == {"transform": 0, "position": 1, "mode": 3}


def test_a_position_is_removed_when_no_move_needs_it(wire: Wire) -> None:
    run = Run(wire)
    run.joint_position("a", by(REST, j1=0.3))
    run.joint_position("b", REST)
    run.move("a", "joint")
    with pytest.raises(ProgramError, match="position 'a': move 1 is to be made with it"):
        run.remove("a")
    run.remove("b")
    with pytest.raises(ProgramError, match="position 'b' is not defined; there are: a"):
        run.move("b", "joint")
    run.listen()
    run.remove("a")
    assert run.motion.world.names().positions == []


# --- what is not a position ----------------------------------------------------------------------


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
@pytest.mark.parametrize("joint", range(1, 7))
@pytest.mark.parametrize("end", [0, 1])
def test_an_angle_outside_its_range_is_refused_by_its_number(
    arm: Arm, joint: int, end: int
) -> None:
    bound = arm.joint_limits[joint - 1][end]
    beyond = bound + (2.0 * end - 1.0) * 1e-6
    run = Program(arm)
    run.joint_position("at", at(arm.park, **{f"j{joint}": bound}))
    lower, upper = (f"{angle:.6g}" for angle in arm.joint_limits[joint - 1])
    words = (
        f"position 'past': joint {joint} of {arm.name} at {beyond:.6g} rad "
        f"({math.degrees(beyond):.6g} deg) is outside its range [{lower}, {upper}] rad (["
    )
    with pytest.raises(JointPositionError, match=re.escape(words)) as refused:
        run.joint_position("past", at(arm.park, **{f"j{joint}": beyond}))
    assert str(refused.value).endswith("deg): give an angle inside it")
    assert "\n" not in str(refused.value)
    assert run.motion.world.names().positions == ["at"]


@pytest.mark.parametrize("angle", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_no_angle(angle: float) -> None:
    run = Program()
    with pytest.raises(JointPositionError, match=f"joint 5 of puma260 at {angle} rad"):
        run.joint_position("p", at(PUMA_260.park, j5=angle))
    assert run.motion.at_rest and run.motion.world.names().positions == []


def test_the_end_of_a_range_by_other_arithmetic_is_the_end() -> None:
    upper = PUMA_560.joint_limits[0][1]
    position = JointPosition(
        JointPositionMessage("p", at(PUMA_560.park, j1=upper + 5e-10)), PUMA_560
    )
    assert position.goal.angles == at(PUMA_560.park, j1=upper)


def test_frames_of_joint_angles_are_those_of_T6() -> None:
    position = JointPosition(JointPositionMessage("p", REST), PUMA_260)
    here = Moment(3)
    assert position.goal.pose(here) == direct(PUMA_260, REST)
    assert position.configuration == Configuration.parse("left down noflip")
    for frame in (position.tool(here), position.compliance_frame(here, direct(PUMA_260, REST))):
        assert frame == Transform.identity()
    assert (position.levers(here), position.uses("p"), position.references) == ({}, False, ())


def test_poses_of_a_run_are_the_asked_for_pose(wire: Wire) -> None:
    """T6 at the end is that of the angles, whatever turns led there."""
    run = Run(wire)
    there = at(REST, j4=math.radians(200.0), j6=math.radians(-200.0))
    run.go(there)
    assert np.array(run.setpoints[-1].T6_1) == approx(np.array(direct(PUMA_260, there)), abs=1e-12)


# --- random programs -----------------------------------------------------------------------------


def test_random_programs_ask_for_a_share_of_their_joint_moves_by_angles() -> None:
    programs = [draw(PUMA_260, seed) for seed in range(300)]
    assert programs[:20] == [draw(PUMA_260, seed) for seed in range(20)]
    moves = [move for program in programs for move in program.moves]
    by_angles = [move for move in moves if move.angles is not None]
    resting = [m for m in moves if m.mode["interpolation"] == "joint" and m.function is None]
    assert all(move in resting for move in by_angles)
    assert len(by_angles) / len(resting) == approx(JOINT_COORDINATES, abs=0.05)
    for move in by_angles:
        assert move.angles is not None and direct(PUMA_260, move.angles) == move.target


@pytest.mark.parametrize("seed", range(0, 40, 4))
def test_random_programs_end_at_the_angles_they_ask_for(seed: int) -> None:
    program = draw(PUMA_560, seed)
    *_, last = program.moves
    there = last.angles or at(PUMA_560.park, j6=math.radians(200.0))
    moves = [*program.moves[:-1], last._replace(function=None, angles=there)]
    assert Trial(PUMA_560, program._replace(moves=moves), seed).run().broken == ""


def test_a_trial_tells_of_a_turn_that_was_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "rfms_can.master.trajectory.planning.base_path.joint_coordinates", lambda _: None
    )
    mode = {"interpolation": "joint", "acceleration_time": 0.2, "joint_speed": 0.5}
    there = at(REST, j6=math.radians(200.0))
    move = Move("near", direct(PUMA_260, there), "", None, mode, True, 0, None, there)
    broken = Trial(PUMA_260, Random(REST, [move]), 0).run().broken
    assert broken.startswith("joint 6 rests at -2.7925") and "3.4906" in broken
