"""The program API over a link that only remembers: what programs say, and what they may not."""

import math

import pytest
from support.link import FakeLink

from rfms_can.coordinator import Arm, Equation, Expression, Transform
from rfms_can.errors import EquationError, FaultError, MoveError, ProgramError, TransformError
from rfms_can.messages import (
    GripperRequest,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TransformMessage,
)


@pytest.fixture
def link() -> FakeLink:
    return FakeLink()


@pytest.fixture
def arm(link: FakeLink) -> Arm:
    return Arm(link)


# --- defining ----------------------------------------------------------------------------------


def test_a_program_in_the_manner_of_the_thesis(arm: Arm, link: FakeLink) -> None:
    tool = arm.transform("tool", Transform.translation(0.0, 0.0, 0.1))
    part = arm.transform("part", Transform.translation(0.3, 0.1, 0.0))
    above = arm.transform("above", Transform.translation(0.0, 0.0, -0.05))
    over = arm.position("over", arm.t6 @ tool == part @ above, tool=tool)
    at = arm.position("at", part == arm.t6 @ tool, config="left up noflip")
    slow = arm.mode("slow", segment_time=1.0, acceleration_time=0.2, interpolation="cartesian")
    assert [arm.move(over, slow), arm.move(at, slow)] == [1, 2]
    assert link.heard[3:] == [
        PositionMessage("over", ["t6", "tool"], ["part", "above"], "tool"),
        PositionMessage("at", ["part"], ["t6", "tool"], configuration="left up noflip"),
        ModeMessage("slow", "cartesian", 0.2, 1.0),
        MoveRequest("over", "slow"),
        MoveRequest("at", "slow"),
    ]


def test_transforms_travel_as_twelve_numbers(arm: Arm, link: FakeLink) -> None:
    value = Transform.translation(0.1, 0.2, 0.3) @ Transform.rotation((0.0, 0.0, 1.0), 0.5)
    name = arm.transform("part", value)
    (message,) = link.heard
    assert isinstance(message, TransformMessage)
    assert message.rows == tuple(value)
    assert name.names == ("part",)


def test_modes_move_in_joint_space_unless_told(arm: Arm, link: FakeLink) -> None:
    arm.mode("far", segment_time=2.0, acceleration_time=0.3)
    assert link.heard == [ModeMessage("far", "joint", 0.3, 2.0)]


# --- equations ---------------------------------------------------------------------------------


def test_expressions_compose_in_order_and_leave_their_parts_alone() -> None:
    a, b, c = Expression("a"), Expression("b"), Expression("c")
    assert ((a @ b) @ c).names == (a @ (b @ c)).names == ("a", "b", "c")
    assert a.names == ("a",)
    equation = a @ b == c
    assert isinstance(equation, Equation)
    assert (equation.left, equation.right) == (("a", "b"), ("c",))
    assert repr(equation) == "a @ b == c"


def test_an_equation_is_neither_true_nor_false() -> None:
    with pytest.raises(EquationError, match="t6 == part is a position equation"):
        bool(Expression("t6") == Expression("part"))


def test_expressions_make_nothing_with_other_things() -> None:
    with pytest.raises(EquationError):
        Expression("a") @ Transform.identity()  # type: ignore[operator]
    assert not isinstance(Expression("a") == "a", Equation)
    assert len({Expression("a"), Expression("a")}) == 2


# --- bad input ---------------------------------------------------------------------------------


def test_what_is_no_transform_is_refused_before_it_is_sent(arm: Arm, link: FakeLink) -> None:
    with pytest.raises(TransformError, match=r"transform 'part': a Transform is needed, not \[1"):
        arm.transform("part", [1, 2, 3])  # type: ignore[arg-type]
    assert link.heard == []


def test_what_is_no_equation_is_refused_before_it_is_sent(arm: Arm, link: FakeLink) -> None:
    with pytest.raises(EquationError, match="position 'at': give an equation"):
        arm.position("at", arm.t6)  # type: ignore[arg-type]
    assert link.heard == []


def test_a_tool_is_one_transform(arm: Arm, link: FakeLink) -> None:
    equation = arm.t6 @ Expression("tool") @ Expression("grip") == Expression("part")
    for tool in (Expression("tool") @ Expression("grip"), "tool"):
        with pytest.raises(EquationError, match=r"position 'at': tool .* must be one transform"):
            arm.position("at", equation, tool=tool)  # type: ignore[arg-type]
    assert link.heard == []


@pytest.mark.parametrize("seconds", [0.0, -1.0, 101.0, math.nan])
def test_times_out_of_bounds_are_refused_before_they_are_sent(
    arm: Arm, link: FakeLink, seconds: float
) -> None:
    with pytest.raises(ProgramError, match=r"mode 'odd': .*segment_time"):
        arm.mode("odd", segment_time=seconds, acceleration_time=0.1)
    assert link.heard == []


@pytest.mark.parametrize("name", ["", "x" * 65])
def test_names_out_of_bounds_are_refused_before_they_are_sent(
    arm: Arm, link: FakeLink, name: str
) -> None:
    with pytest.raises(TransformError, match=rf"transform '{name}': .*name"):
        arm.transform(name, Transform.identity())
    with pytest.raises(MoveError, match=rf"move to 'at' with '{name}': .*mode"):
        arm.move("at", name)
    assert link.heard == []


def test_an_equation_of_too_many_transforms_is_refused(arm: Arm, link: FakeLink) -> None:
    chain = arm.t6
    for _ in range(16):
        chain = chain @ Expression("link")
    with pytest.raises(EquationError, match=r"position 'far away': .*left"):
        arm.position("far away", chain == Expression("part"))
    assert link.heard == []


@pytest.mark.parametrize("force", [0.0, -0.5, 1.01, math.nan])
def test_gripper_forces_out_of_bounds_are_refused(arm: Arm, link: FakeLink, force: float) -> None:
    with pytest.raises(ProgramError, match=r"is outside 0\.\.1"):
        arm.gripper.close(force)
    assert link.heard == []


def test_what_the_server_refuses_reaches_the_program(arm: Arm, link: FakeLink) -> None:
    link.refusal = MoveError("to 'at' with 'slow': too_far")
    with pytest.raises(MoveError, match="too_far"):
        arm.move("at", "slow")


# --- waiting -----------------------------------------------------------------------------------


def test_a_move_is_asked_for_at_once_and_waited_for_by_number(arm: Arm, link: FakeLink) -> None:
    first, second = arm.move("a", "m"), arm.move("b", "m")
    assert link.now == 0
    arm.wait(first)
    assert link.now == 100
    arm.wait(first)
    assert link.now == 100  # it is over
    arm.wait(second)
    assert link.now == 200


@pytest.mark.parametrize("number", [-1, 0, 3, 999])
def test_a_move_that_was_never_asked_for_is_not_waited_for(arm: Arm, number: int) -> None:
    arm.move("a", "m"), arm.move("b", "m")
    with pytest.raises(ProgramError, match=f"move {number}: 2 moves have been asked for"):
        arm.wait(number)


def test_wait_without_a_number_is_for_rest(arm: Arm, link: FakeLink) -> None:
    link.rests_at = 37
    arm.wait()
    assert link.now == 37


@pytest.mark.parametrize(("seconds", "cycles"), [(0.0, 0), (0.004, 1), (0.1, 25), (1.0, 250)])
def test_sleep_lasts_cycles_of_the_arms_clock(
    arm: Arm, link: FakeLink, seconds: float, cycles: int
) -> None:
    link.now = 11
    arm.sleep(seconds)
    assert link.now == 11 + cycles


def test_the_gripper_returns_when_its_jaw_rests(arm: Arm, link: FakeLink) -> None:
    link.rests_at = 20
    arm.gripper.open(0.5)
    assert link.now == 20
    link.rests_at = 45
    arm.gripper.close()
    assert link.now == 45
    assert link.heard == [GripperRequest(True, 0.5), GripperRequest(False, 1.0)]


def test_stop_waits_until_the_arm_rests(arm: Arm, link: FakeLink) -> None:
    link.rests_at = 60
    arm.stop()
    assert link.heard == [StopRequest()]
    assert link.now == 60


def test_a_fault_ends_a_wait(arm: Arm, link: FakeLink) -> None:
    link.fault_at = 30
    with pytest.raises(FaultError, match="joint 3"):
        arm.wait(arm.move("a", "m"))


def test_the_arm_can_be_looked_at(arm: Arm) -> None:
    assert arm.joints == (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    assert arm.pose == Transform.translation(0.3, 0.2, 0.1)
