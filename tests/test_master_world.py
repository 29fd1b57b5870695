"""The world model: position equations solved for T6, and what it refuses by name."""

import math
import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260
from rfms_can.errors import EquationError, MoveError, ProgramError, TransformError
from rfms_can.kinematics import Configuration
from rfms_can.master.motion import Motion
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import WorldModel
from rfms_can.messages import (
    Answer,
    GripperRequest,
    Message,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend, Mode

OWN = Configuration(True, False, True)
PERIOD_S = 0.004


@st.composite
def rigid(draw: Callable[[st.SearchStrategy[float]], float]) -> Transform:
    turn = [draw(st.floats(-math.pi, math.pi)) for _ in range(3)]
    place = [draw(st.floats(-1.0, 1.0)) for _ in range(3)]
    return (
        Transform.translation(*place)
        @ Transform.rotation((0.0, 0.0, 1.0), turn[0])
        @ Transform.rotation((0.0, 1.0, 0.0), turn[1])
        @ Transform.rotation((1.0, 0.0, 0.0), turn[2])
    )


SHIFT = Transform.translation(0.1, 0.2, 0.3)
TURN = Transform.rotation((0.0, 0.0, 1.0), 0.5)


@pytest.fixture
def world() -> WorldModel:
    world = WorldModel(OWN, PERIOD_S)
    world.define_transform(TransformMessage("shift", SHIFT))
    world.define_transform(TransformMessage("turn", TURN))
    return world


def position(left: str, right: str, **more: str) -> PositionMessage:
    """A position equation as one would write it: ``position("t6 turn", "shift")``."""
    return PositionMessage("place", left.split(), right.split(), **more)


# --- solving -----------------------------------------------------------------------------------


@given(rigid(), rigid(), rigid(), rigid())
def test_t6_solves_the_equation_wherever_it_stands(
    a: Transform, b: Transform, c: Transform, d: Transform
) -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name, value in zip("abcd", (a, b, c, d), strict=True):
        world.define_transform(TransformMessage(name, value))
    for k, (left, right) in enumerate((("a t6 b", "c d"), ("c d", "a t6 b"))):
        message = PositionMessage(f"p{k}", left.split(), right.split())
        t6 = world.define_position(message).goal.pose(Moment(0))
        assert a @ t6 @ b == pytest.approx(c @ d, abs=1e-12)


@given(rigid(), rigid(), rigid())
def test_the_tool_rides_at_the_right_of_t6(tool: Transform, grip: Transform, at: Transform) -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name, value in (("tool", tool), ("grip", grip), ("at", at)):
        world.define_transform(TransformMessage(name, value))
    every: tuple[tuple[str | None, Transform], ...] = (("tool", tool), (None, tool @ grip))
    for by, rides in every:
        message = PositionMessage(f"by {by}", ["t6", "tool", "grip"], ["at"], by)
        goal = world.define_position(message).goal
        assert goal.right(Moment(0)) @ rides == pytest.approx(Transform.identity(), abs=1e-12)
        assert goal.left(Moment(0)) @ goal.right(Moment(0)) == pytest.approx(
            goal.pose(Moment(0)), abs=1e-12
        )
        assert goal.pose(Moment(0)) @ tool @ grip == pytest.approx(at, abs=1e-12)


def test_a_position_takes_the_arms_configuration_unless_it_names_one(world: WorldModel) -> None:
    assert world.define_position(position("t6", "shift")).configuration == OWN
    named = PositionMessage("other", ["t6"], ["shift"], configuration="right up flip")
    assert world.define_position(named).configuration == Configuration(False, True, False)


def test_a_position_is_solved_with_the_transforms_as_they_are_when_it_is_bound(
    world: WorldModel,
) -> None:
    before = world.define_position(position("t6", "shift"))
    world.define_transform(TransformMessage("shift", TURN))
    assert world.position("place").goal.pose(Moment(0)) == TURN
    assert before.goal.pose(Moment(0)) == SHIFT


# --- refusing ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("left", "right", "reason"),
    [
        ("shift", "turn", "position 'place': t6 stands 0 times; it must stand once"),
        ("t6", "t6", "position 'place': t6 stands 2 times; it must stand once"),
        ("t6 turn t6", "shift", "position 'place': t6 stands 2 times; it must stand once"),
        ("t6 tool", "shift", "transform 'tool' is not defined; there are: shift, turn"),
        ("t6", "shift part", "transform 'part' is not defined; there are: shift, turn"),
    ],
)
def test_equations_that_do_not_say_where_t6_is(
    world: WorldModel, left: str, right: str, reason: str
) -> None:
    with pytest.raises(EquationError, match=re.escape(reason)):
        world.define_position(position(left, right))
    with pytest.raises(ProgramError, match="there are: none"):
        world.position("place")


@pytest.mark.parametrize("tool", ["shift", "nothing"])
def test_a_tool_that_is_not_on_the_hand(world: WorldModel, tool: str) -> None:
    with pytest.raises(EquationError, match=f"tool '{tool}' must stand right after t6"):
        world.define_position(position("t6 turn shift", "shift", tool=tool))


def test_an_empty_world_says_so() -> None:
    with pytest.raises(EquationError, match="'part' is not defined; there are: none"):
        WorldModel(OWN, PERIOD_S).define_position(position("t6", "part"))


def test_positions_and_modes_may_be_redefined_as_transforms_may(world: WorldModel) -> None:
    world.define_position(position("t6", "shift"))
    world.define_position(position("t6", "turn"))
    world.define_mode(ModeMessage("slow", "joint", 0.2, 2.0))
    world.define_mode(ModeMessage("slow", "cartesian", 0.1, 1.0))
    assert world.position("place").goal.pose(Moment(0)) == pytest.approx(TURN)
    assert world.mode("slow").mode is Mode.CARTESIAN


def test_the_arm_itself_cannot_be_defined(world: WorldModel) -> None:
    with pytest.raises(TransformError, match="'t6' is the arm itself"):
        world.define_transform(TransformMessage("t6", SHIFT))


@pytest.mark.parametrize(
    "broken",
    [
        SHIFT._replace(nx=1.001),
        SHIFT._replace(ox=0.01),
        SHIFT._replace(az=-1.0),
        SHIFT._replace(py=math.nan),
        SHIFT._replace(pz=math.inf),
        Transform(*(0.0,) * 12),
    ],
)
def test_what_is_no_rotation_is_no_transform(world: WorldModel, broken: Transform) -> None:
    with pytest.raises(TransformError, match="transform 'shift' is not a rotation: off by"):
        world.define_transform(TransformMessage("shift", broken))
    assert world.define_position(position("t6", "shift")).goal.pose(Moment(0)) == SHIFT


def test_unknown_names_list_what_there_is(world: WorldModel) -> None:
    world.define_position(position("t6", "shift"))
    world.define_mode(ModeMessage("slow", "joint", 0.2, 2.0))
    world.define_mode(ModeMessage("straight", "cartesian", 0.2, 2.0))
    with pytest.raises(ProgramError, match="position 'palce' is not defined; there are: place"):
        world.position("palce")
    with pytest.raises(ProgramError, match="mode 'fast' is not defined; there are: slow, straight"):
        world.mode("fast")


def test_a_configuration_that_does_not_exist(world: WorldModel) -> None:
    with pytest.raises(EquationError, match="position 'place': "):
        world.define_position(position("t6", "shift", configuration="left up sideways"))


# --- requests ----------------------------------------------------------------------------------


@pytest.fixture
def motion() -> Motion:
    motion = Motion(PUMA_260, PERIOD_S, Blend.CONTINUOUS, lambda *_: None)
    motion.enable(PUMA_260.park)
    return motion


def define(motion: Motion) -> None:
    """A place next to park, a slow mode, and one far too fast."""
    park = motion.generator.tick().T6_1
    for message in (
        TransformMessage("near", park @ Transform.translation(0.0, 0.0, 0.02)),
        TransformMessage("far", park._replace(px=1.5)),
        PositionMessage("near", ["t6"], ["near"]),
        PositionMessage("far", ["t6"], ["far"]),
        ModeMessage("slow", "cartesian", 0.1, 1.0),
        ModeMessage("free", "joint", 0.1, 1.0),
        ModeMessage("rushed", "cartesian", 0.1, 0.1),
    ):
        assert motion.handle(message) == Answer()


def ask(motion: Motion, mode: str) -> int:
    """Ask for a move to the near place; its number."""
    return motion.handle(MoveRequest("near", mode)).sequence


def test_moves_are_numbered_from_one(motion: Motion) -> None:
    define(motion)
    assert [ask(motion, "slow") for _ in range(3)] == [1, 2, 3]


def test_a_refused_move_names_place_and_mode_and_uses_no_number(motion: Motion) -> None:
    define(motion)
    for place, mode, reason in (
        ("far", "free", r"to 'far' with 'free': move 1: the goal: puma260: too_far: "),
        ("near", "rushed", r"to 'near' with 'rushed': move 1: segment time 0.1 s is under"),
    ):
        with pytest.raises(MoveError, match=reason):
            motion.handle(MoveRequest(place, mode))
    assert ask(motion, "slow") == 1


def test_move_to_nowhere_lists_the_places(motion: Motion) -> None:
    define(motion)
    with pytest.raises(ProgramError, match="position 'home' is not defined; there are: near, far"):
        motion.handle(MoveRequest("home", "slow"))


def test_the_shadow_follows_every_setpoint_to_the_goal(motion: Motion) -> None:
    define(motion)
    sequence = ask(motion, "slow")
    moved = 0
    while not motion.is_over(sequence):
        motion.next_setpoint()
        moved += motion.following.moves
    assert moved * PERIOD_S == pytest.approx(1.2, abs=0.1)
    assert motion.at_rest
    for _ in range(3):  # set-points the rate is made of besides the last
        motion.next_setpoint()
    assert not motion.following.moves


def test_stop_ends_at_rest_and_new_moves_go_on_from_there(motion: Motion) -> None:
    define(motion)
    ask(motion, "slow")
    dropped = ask(motion, "free")
    for _ in range(100):
        motion.next_setpoint()
    motion.handle(StopRequest())
    assert not motion.is_over(dropped)
    for _ in range(150):
        motion.next_setpoint()
    assert motion.at_rest
    assert motion.stopped_short is None
    assert motion.is_over(dropped)  # nobody waits for it for ever
    again = ask(motion, "slow")
    assert again == dropped + 1
    assert not motion.is_over(again)


def test_requests_that_are_not_motions_are_refused(motion: Motion) -> None:
    with pytest.raises(ProgramError, match="GripperRequest is not a request for motion"):
        motion.handle(GripperRequest(True))
    with pytest.raises(ProgramError, match="Message is not a request for motion"):
        motion.handle(Message())
