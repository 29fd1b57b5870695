"""Positions in joint coordinates: defined again, removed, refused; and in random programs."""

import math
import re

import numpy as np
import pytest
from pytest import approx
from random_programs.draw import JOINT_COORDINATES, Move, draw
from random_programs.draw import Program as Random
from random_programs.trial import Trial
from support.joint_run import Run, at, by
from support.motion import Program
from support.trajectory import REST

from rfms_can.arm import ARMS, PUMA_260, PUMA_560, Arm
from rfms_can.errors import JointPositionError, MoveError, ProgramError, TransformError
from rfms_can.kinematics import Configuration, direct
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import JointPosition
from rfms_can.messages import JointPositionMessage
from rfms_can.transform import Transform
from rfms_can.wire.contract import Wire

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
