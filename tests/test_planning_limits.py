"""Speed and acceleration limits before a move is accepted, held against the run itself."""

import re
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx
from support.planning import TOOL, How, Place, PlannedRig, at_angles, at_goal, at_pose
from support.programs.random_moves import angles_near
from support.trajectory import REST, WeavingGoal

from rfms_can.arm import PUMA_260
from rfms_can.errors import JointLimitError, KinematicsError, MoveError, UnreachableError
from rfms_can.kinematics import Configuration, Joints, direct
from rfms_can.master.trajectory.planning import Plan
from rfms_can.master.trajectory.segment import Transition
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

ESTIMATED = 1.05
"""How much a run may pass limits and what was planned: joints estimate from few samples how they
leave a segment whose straight part is short."""
AGREE = 0.03
"""How near a run must come to the peaks that were planned where it is not."""
SPEEDS = np.array(PUMA_260.speed_limits)
ACCELERATIONS = np.array(PUMA_260.acceleration_limits)


class Leg(NamedTuple):
    """A move of a program: to joint angles, and how."""

    q: Joints
    how: How


def timed(acceleration_time: float, segment_time: float, lengthen: bool) -> How:
    return How(Mode.JOINT, acceleration_time, segment_time, lengthen=lengthen)


def straight(
    acceleration_time: float, speed: float, turn: float | None, curved: bool, lengthen: bool
) -> How:
    transition = Transition.CARTESIAN if curved else Transition.JOINT
    mode = How(Mode.CARTESIAN, acceleration_time, lengthen=lengthen, transition=transition)
    return mode._replace(speed=speed, angular_speed=turn, joint_speed=turn and 0.5)


def hows(lengthen: st.SearchStrategy[bool]) -> st.SearchStrategy[How]:
    """All kinds of modes; most ask for more than the arm can do."""
    blend = st.sampled_from((0.05, 0.1, 0.2))
    return st.one_of(
        st.builds(timed, blend, st.sampled_from((0.15, 0.3, 0.6, 1.0)), lengthen),
        st.builds(
            straight,
            *(blend, st.sampled_from((0.1, 0.3, 0.8)), st.sampled_from((None, 0.5, 2.0))),
            *(st.booleans(), lengthen),
        ),
    )


def programs(lengthen: st.SearchStrategy[bool]) -> st.SearchStrategy[list[Leg]]:
    centre = (0.2, 1.2, -2.6, 0.3, 1.0, -0.2)
    angles = angles_near(centre, (0.6, 0.3, 0.3, 0.8, 0.5, 0.8))
    return st.lists(st.builds(Leg, angles, hows(lengthen)), min_size=1, max_size=4)


def planned(rig: PlannedRig, first: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Largest speeds and accelerations of the plans from number ``first`` on."""
    plans = rig.plans[first:]
    return (
        np.max([plan.peak_speeds for plan in plans], axis=0),
        np.max([plan.peak_accelerations for plan in plans], axis=0),
    )


@settings(max_examples=30)
@given(programs(st.booleans()))
def test_accepted_moves_keep_the_limits_when_they_are_run(program: list[Leg]) -> None:
    rig = PlannedRig()
    rig.run(12)
    for leg in program:
        try:
            rig.go(at_angles(leg.q), leg.how)
        except (KinematicsError, MoveError):
            continue
    if not rig.plans:
        return
    rig.finish(20000)
    speeds, accelerations = rig.peaks()
    assert np.all(speeds <= ESTIMATED * SPEEDS)
    assert np.all(accelerations <= ESTIMATED * ACCELERATIONS)
    most_speeds, most_accelerations = planned(rig)
    assert np.all(speeds <= ESTIMATED * most_speeds + 1e-6)
    assert np.all(accelerations <= ESTIMATED * most_accelerations + 1e-3)


@settings(max_examples=30)
@given(programs(st.just(False)))
def test_a_refused_move_is_accepted_with_the_time_it_is_told(program: list[Leg]) -> None:
    rig = PlannedRig()
    rig.run(12)
    for leg in program:
        place, how = at_angles(leg.q), leg.how
        try:
            rig.go(place, how)
        except KinematicsError:
            continue
        except MoveError as refusal:
            better = with_the_time_told(how, str(refusal))
            if better is not None:
                rig.go(place, better)


def with_the_time_told(how: How, message: str) -> How | None:
    """The mode that a refusal asks for; None if it asks for something else."""
    if match := re.search(r"at least (\S+) s instead", message):
        return how._replace(segment_time=float(match[1]))
    if match := re.search(
        r"accelerate in (\S+) s instead of \S+ s(?:, with .* of (\S+) s)?", message
    ):
        how = how._replace(acceleration_time=float(match[1]))
        return how if match[2] is None else how._replace(segment_time=float(match[2]))
    if match := re.search(r"tau\): accelerate within|cannot leave", message):
        return None
    assert "wait until" in message or "place the path elsewhere" in message or "twice" in message
    return None


AHEAD: Joints = (0.4, 1.3, -2.8, 0.5, 1.2, 0.1)
ASIDE: Joints = (0.0, 1.1, -2.6, 0.1, 0.8, -0.4)


@pytest.mark.parametrize(
    ("mode", "transition"),
    [(Mode.JOINT, Transition.JOINT), *((Mode.CARTESIAN, each) for each in Transition)],
)
def test_planned_peaks_are_those_of_the_run(mode: Mode, transition: Transition) -> None:
    rig = PlannedRig()
    rig.run(12)
    how = How(mode, segment_time=0.9, transition=transition)
    rig.go(at_angles(AHEAD), how)
    rig.go(at_angles(ASIDE), how)
    rig.finish()
    first = next(k for k, setpoint in enumerate(rig.setpoints) if setpoint.sequence == 2)
    speeds, accelerations = rig.peaks(first - 1)
    most_speeds, most_accelerations = planned(rig, 1)
    assert speeds == approx(most_speeds, rel=AGREE)
    assert accelerations == approx(most_accelerations, rel=AGREE)


@pytest.mark.parametrize("transition", Transition)
@pytest.mark.parametrize("width", [0.0, 0.003])
def test_planned_peaks_of_goals_that_weave_are_those_of_the_run(
    transition: Transition, width: float
) -> None:
    rig = PlannedRig()
    rig.run(12)
    goal = WeavingGoal(direct(PUMA_260, AHEAD) @ TOOL, width, 0.01)
    rig.go(at_goal(goal), How(Mode.CARTESIAN, segment_time=1.5, transition=transition))
    rig.run(300 + 2 * 40)
    speeds, accelerations = rig.peaks()
    most_speeds, most_accelerations = planned(rig)
    assert speeds == approx(most_speeds, rel=AGREE)
    assert accelerations == approx(most_accelerations, rel=AGREE)


def test_a_joint_at_its_speed_limit_is_not_too_fast() -> None:
    rig = PlannedRig()
    far = (1.6, *REST[1:])
    plan = rig.go(at_angles(far), How(joint_speed=1.0))
    assert plan.segment_time == approx(0.7)
    assert plan.peak_speeds[0] == approx(2.0)


def refusal(rig: PlannedRig, place: Place, how: How) -> str:
    with pytest.raises(MoveError) as refused:
        rig.go(place, how)
    return str(refused.value)


def test_a_move_too_fast_is_told_joint_number_limit_and_time() -> None:
    rig = PlannedRig()
    place = at_angles((-1.0, *REST[1:]))
    assert refusal(rig, place, How(segment_time=0.5)) == (
        "move 1: joint 1 of puma260 would run at 2.4 rad/s on departure, its limit is 2 rad/s: "
        "give the segment at least 0.6 s instead of 0.5 s"
    )
    assert rig.generator.waiting == 0
    assert rig.go(place, How(segment_time=0.5, lengthen=True)).segment_time == approx(0.6)


def test_a_transition_too_short_is_told_joint_number_limit_and_time() -> None:
    """From rest the acceleration is 15/16 of the speed over t_acc."""
    rig = PlannedRig()
    place = at_angles((-0.8, *REST[1:]))
    message = refusal(rig, place, How(acceleration_time=0.1, segment_time=0.75))
    assert "joint 1 of puma260 would accelerate at 12.5 rad/s2 on departure" in message
    assert "its limit is 10 rad/s2: give the segment at least 0.94 s instead of 0.75 s" in message


def test_a_turn_back_in_motion_is_told_the_acceleration_time() -> None:
    """However slow the way back, the way there is promised: only its end can be gentler."""
    rig = PlannedRig()
    rig.go(at_angles((-0.8, *REST[1:])), How(acceleration_time=0.2, segment_time=0.75))
    back = at_angles(REST)
    how = How(acceleration_time=0.05, segment_time=1.0)
    message = refusal(rig, back, how)
    assert "in the transition from move 1" in message and "no segment time helps" in message
    better = with_the_time_told(how, message)
    assert better is not None and 0.05 < better.acceleration_time <= 0.25
    rig.go(back, better)


def test_where_the_segment_before_has_no_room_it_says_wait() -> None:
    rig = PlannedRig()
    rig.go(at_angles((-0.8, *REST[1:])), How(acceleration_time=0.25, segment_time=0.75))
    message = refusal(rig, at_angles((-2.4, *REST[1:])), How(acceleration_time=0.02, speed=9.0))
    assert "give the segment at least" in message or "wait until move 1 is complete" in message


def test_goals_and_paths_out_of_reach_name_move_and_place() -> None:
    rig = PlannedRig()
    far = at_pose(Transform.translation(0.9, 0.0, 0.0))
    with pytest.raises(UnreachableError, match="move 1: the goal: puma260: too_far"):
        rig.go(far, How(segment_time=1.0))
    beyond = at_angles((2.4, *REST[1:]))
    rig.plan(beyond, How(segment_time=3.0))
    with pytest.raises((KinematicsError, MoveError), match=r"move 1: .*path"):
        rig.go(beyond, How(Mode.CARTESIAN, segment_time=3.0))
    right = Configuration.parse("right up noflip")
    with pytest.raises(JointLimitError, match=r"move 1: the goal: puma260: joint 1 would"):
        rig.go(at_angles((1.4, *REST[1:])), How(segment_time=3.0, configuration=right))
    with pytest.raises(MoveError, match="cannot change the configuration"):
        rig.go(at_angles(AHEAD), How(Mode.CARTESIAN, segment_time=3.0, configuration=right))
    assert rig.plans == []


def test_a_transition_that_swings_past_a_joints_range_is_refused() -> None:
    """Both positions are inside the range, and so is the corner; the way around it is not."""
    rig = PlannedRig((2.3, *REST[1:]))
    rig.go(at_angles((2.5, *REST[1:])), How(acceleration_time=0.1, segment_time=0.5))
    rig.go(at_angles((2.529, *REST[1:])), How(acceleration_time=0.2, segment_time=2.0))
    rig.finish()
    assert max(q[0] for q in rig.q) < PUMA_260.joint_limits[0][1]


def test_a_path_through_the_wrist_singularity_is_refused_by_name() -> None:
    """theta5 passes zero where theta4 and theta6 have to change places at once."""
    rig = PlannedRig((0.2, 1.2, -2.7, 0.3, 0.4, -0.2))
    start = direct(PUMA_260, (0.2, 1.2, -2.7, 0.3, 0.4, -0.2)) @ TOOL
    through = start @ Transform.rotation((0.1, -1.0, 0.0), -0.9)
    with pytest.raises((MoveError, KinematicsError)) as refused:
        rig.go(at_pose(through), How(Mode.CARTESIAN, segment_time=5.0))
    assert "joint" in str(refused.value)


def test_a_move_asked_for_in_motion_follows_what_was_planned_before_it() -> None:
    """Requests one at a time, under way, are planned like those of a queue."""
    plans: list[list[Plan]] = []
    for wait in (0, 60):
        rig = PlannedRig()
        rig.run(12)
        for q in (AHEAD, ASIDE, REST):
            rig.go(at_angles(q), How(Mode.CARTESIAN, segment_time=0.9))
            rig.run(wait)
        plans.append(rig.plans)
    for queued, asked in zip(*plans, strict=True):
        assert asked.peak_accelerations == approx(queued.peak_accelerations, rel=1e-9)
    for queued, asked in zip(plans[0][1:], plans[1][1:], strict=True):
        assert asked.via_deviation == approx(queued.via_deviation, rel=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_node_could_stop_before_its_guard_all_the_way_to_the_end_of_a_range(sign: float) -> None:
    """Joint 1 comes to the end of its range at 1.9 rad/s with all its acceleration. Its node stops
    at half of that, and would be in front of a SOFT_LIMIT in the middle of the transition."""
    end = sign * float(PUMA_260.joint_limits[0][1])
    rig = PlannedRig((end - sign * 1.5, *REST[1:]))
    how = How(acceleration_time=0.19, segment_time=1.5 / 1.9)
    place = at_angles((end, *REST[1:]))
    words = (
        "joint 1 of puma260 would run at .* coming to rest, where its node, which stops at 0.5 of "
        "its acceleration limit, would be 0.02 rad past the end of its range"
    )
    with pytest.raises(MoveError, match=words) as refused:
        rig.plan(place, how)
    rig.go(place, how._replace(segment_time=refused.value.remedy["segment_time"]))
    rig.finish()
    q = np.array(rig.q)[:, 0]
    v = np.gradient(q, rig.period_s)
    stops = sign * (q + v * np.abs(v) / PUMA_260.acceleration_limits[0])
    assert 0.0 < stops.max() - abs(end) < 0.03
