"""What a refusal offers: tried as a program would ask for it, and so accepted and made."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from support.planning import TOOL, How, Place, PlannedRig, at_angles, at_goal, at_pose
from support.trajectory import LEFT_DOWN, REST, WeavingGoal

from rfms_can.arm import PUMA_260
from rfms_can.errors import KinematicsError, MoveError
from rfms_can.kinematics import Joints, direct
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.planning.times import LONGEST_S
from rfms_can.master.trajectory.segment import Transition
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Mode

START = direct(PUMA_260, REST) @ TOOL
JOINT, STRAIGHT = Mode.JOINT, Mode.CARTESIAN
Refusal = MoveError | KinematicsError


def turned(angle: float, x: float, y: float, z: float) -> Transform:
    length = math.hypot(x, y, z)
    return START @ Transform.rotation((x / length, y / length, z / length), angle)


def refused(rig: PlannedRig, place: Place, how: How) -> Refusal:
    with pytest.raises((MoveError, KinematicsError)) as error:
        rig.go(place, how)
    assert isinstance(error.value, Refusal)
    return error.value


def changed(how: How, remedy: Mapping[str, Any]) -> How:
    """The mode as a program makes it of the settings that a refusal names."""
    settings = {name: value for name, value in remedy.items() if name != "wait"}
    if "interpolation" in settings:
        settings["mode"] = Mode[settings.pop("interpolation").upper()]
    if "transition" in settings:
        settings["transition"] = Transition[settings["transition"].upper()]
    if "config" in settings:
        settings["configuration"] = settings.pop("config")
    if "segment_time" in settings:
        how = how._replace(speed=None, angular_speed=None, joint_speed=None)
    return how._replace(**settings)


def taken(rig: PlannedRig, place: Place, how: How, error: Refusal) -> How:
    """Take what a refusal offers: it is accepted."""
    assert error.remedy
    better = changed(how, error.remedy)
    if "wait" in error.remedy:
        rig.finish(20000)
    rig.go(place, better)
    return better


# --- A segment time that the transitions do not fit in ------------------------------------------


def test_the_time_that_transitions_need_is_offered_and_so_is_a_shorter_transition() -> None:
    rig = PlannedRig()
    place, how = at_pose(turned(2.9, -0.3, 0.0, 1.0)), How(STRAIGHT, 0.2, 0.7)
    error = refused(rig, place, how)
    assert str(error).endswith("two parts: lengthen the segment, or accelerate in 0.17 s")
    assert error.remedy == {"segment_time": 0.82}
    assert len(rig.plan(place, how._replace(acceleration_time=0.17)).moves) == 2
    assert len(rig.plan(place, how._replace(segment_time=0.82)).moves) == 2


def test_a_time_that_the_path_does_not_allow_is_not_offered() -> None:
    """The straight line leads out of reach, however long it takes."""
    place, how = at_pose(turned(2.9, 0.0, 1.0, 0.0)), How(STRAIGHT, 0.2, 0.7)
    error = refused(PlannedRig(), place, how)
    message = str(error)
    assert "is under four times" in message and "with segment_time=0.82, the path" in message
    assert message.endswith("place position or path elsewhere")
    assert error.remedy == {}
    assert "the path" in str(refused(PlannedRig(), place, how._replace(segment_time=10.0)))


def test_a_time_that_is_still_too_short_for_the_joints_is_followed_up() -> None:
    rig = PlannedRig()
    place, how = at_angles((-0.8, *REST[1:])), How(JOINT, 0.02, 0.04)
    error = refused(rig, place, how)
    assert "is under twice" in str(error) and "; with segment_time=0.05, joint 1 " in str(error)
    assert "instead of 0.05 s" in str(error)
    assert error.remedy["segment_time"] > 1.0
    taken(rig, place, how, error)
    rig.finish()


def test_what_no_mode_can_have_is_not_offered() -> None:
    rig = PlannedRig()
    how = How(JOINT, 60.0, 50.0)
    error = refused(rig, at_pose(START), how)
    assert error.remedy == {"acceleration_time": 24.995}
    assert 2.0 * how.acceleration_time > LONGEST_S
    taken(rig, at_pose(START), how, error)


# --- Goals that move with time -------------------------------------------------------------------


class TurningGoal:
    """A target that turns with t, about the tool's z."""

    constant = False
    cycle_s = 3.0  # tanh is at its end then

    def __init__(self, target: Transform, rate: float) -> None:
        self._target, self._rate = target, rate

    def left(self, moment: Moment) -> Transform:
        return self._target @ Transform.rotation((0.0, 0.0, 1.0), self._rate * math.tanh(moment.t))

    def right(self, moment: Moment) -> Transform:
        return TOOL.inverse()

    def pose(self, moment: Moment) -> Transform:
        return self.left(moment) @ self.right(moment)


@pytest.mark.parametrize("psi", np.linspace(2.2, 2.8, 13))
@pytest.mark.parametrize("rate", [-0.3, 0.3])
def test_generator_and_planner_agree_in_how_far_a_goal_has_turned(psi: float, rate: float) -> None:
    rig = PlannedRig()
    goal = TurningGoal(turned(float(psi), 0.0, 0.0, 1.0), rate)
    plan = rig.go(at_goal(goal), How(STRAIGHT, 0.4, 4.0))
    begins = psi + rate * math.tanh(-0.4)
    assert len(plan.moves) == (1 if begins <= 0.8 * math.pi else 2)


# --- At random -----------------------------------------------------------------------------------


def random_mode(rng: np.random.Generator) -> How:
    straight, lengthen = bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    curved = straight and rng.random() < 0.5
    how = How(
        STRAIGHT if straight else JOINT,
        float(rng.uniform(0.02, 0.4)),
        lengthen=lengthen,
        lengthen_at_most=float(rng.uniform(1.0, 4.0)),
        transition=Transition.CARTESIAN if curved else Transition.JOINT,
        deviation=float(rng.uniform(1e-4, 0.01)) if rng.random() < 0.4 else None,
        configuration=LEFT_DOWN if rng.random() < 0.2 else None,
    )
    if rng.random() < 0.6:
        return how._replace(segment_time=float(rng.uniform(0.05, 1.0)))
    return how._replace(speed=float(rng.uniform(0.05, 0.8)), angular_speed=2.0)


def random_place(rng: np.random.Generator, q: Joints) -> Place:
    size = rng.choice([0.1, 0.5, 1.5])
    low, high = np.array(PUMA_260.joint_limits).T
    there = np.clip(np.add(q, rng.uniform(-size, size, 6)), low, high)
    pose = direct(PUMA_260, tuple(there)) @ TOOL
    if rng.random() < 0.8:
        return at_pose(pose)
    if rng.random() < 0.5:
        return at_goal(TurningGoal(pose, float(rng.uniform(-0.3, 0.3))))
    return at_goal(WeavingGoal(pose, float(rng.uniform(0.0, 0.005))))


def offers_taken(seed: int) -> list[str]:
    """Names of the settings that refusals of a random program made it change."""
    rng = np.random.default_rng(seed)
    rig = PlannedRig()
    names: list[str] = []
    for _ in range(4):
        place, how = random_place(rng, REST), random_mode(rng)
        try:
            rig.go(place, how)
        except (MoveError, KinematicsError) as error:
            if error.remedy:
                taken(rig, place, how, error)
                names += error.remedy
        rig.run(int(rng.integers(0, 60)))
    return names


def test_whatever_is_offered_is_accepted() -> None:
    names = [name for seed in range(60) for name in offers_taken(seed)]
    assert {"segment_time", "acceleration_time", "lengthen_at_most", "interpolation"} < set(names)
    assert {"transition", "wait", "deviation"} < set(names)


@pytest.mark.parametrize("seed", [1, 17, 51, 70, 71, 194])
def test_a_corner_asked_for_late_is_offered_what_it_is_not_too_late_for(seed: int) -> None:
    """In what is left of the segment before, its transition must be short, and so the way slow."""
    rng = np.random.default_rng(seed)
    rig = PlannedRig()
    first = How(JOINT, 0.1, 0.4, lengthen=True)
    rig.go(random_place(rng, REST), first)
    ticks = rig.plans[0].moves[0].segment_ticks
    rig.run(int(ticks * rng.uniform(0.85, 1.0)))
    assert rig.generator.entry.left < 60
    how = random_mode(rng)._replace(deviation=float(rng.uniform(0.02, 0.08)))
    place = random_place(rng, REST)
    error = refused(rig, place, how)
    taken(rig, place, how, error)
    rig.finish(20000)
    assert rig.generator.completed == 2
