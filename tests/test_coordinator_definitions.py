"""What programs define beyond values and times, and what is told to them before it is sent."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.link import FakeLink

from rfms_can.coordinator import (
    Arm,
    Circular,
    Expression,
    Linear,
    MovePlan,
    SelectionError,
    Table,
    TableRow,
    Transform,
    Weave,
)
from rfms_can.errors import (
    EquationError,
    JointPositionError,
    ModeError,
    ProgramError,
    TransformError,
)
from rfms_can.messages import (
    Answer,
    ComplyRequest,
    FeedRequest,
    GripperRequest,
    JointPositionMessage,
    LockRequest,
    Message,
    ModeMessage,
    PauseRequest,
    PositionMessage,
    ResumeRequest,
    TransformMessage,
)

HERE = Transform.identity()
THERE = Transform.translation(0.1, 0.2, 0.3)
TWIST = (0.1, 0.0, 0.0, 0.0, 0.0, 0.5)


@pytest.fixture
def link() -> FakeLink:
    return FakeLink()


@pytest.fixture
def arm(link: FakeLink) -> Arm:
    return Arm(link)


# --- transforms of three kinds -----------------------------------------------------------------


def test_a_transform_of_each_kind(arm: Arm, link: FakeLink) -> None:
    weave = Weave((0.0, 0.002, 0.0), 5.0)
    made = (
        arm.transform("table", THERE),
        arm.reference("part", THERE),
        arm.reference("belt", THERE, predict="velocity", rest_after=0.5),
        arm.functional("weave", weave),
        arm.functional("seam", weave, base=THERE),
    )
    assert [expression.names for expression in made] == [
        ("table",),
        ("part",),
        ("belt",),
        ("weave",),
        ("seam",),
    ]
    assert link.heard == [
        TransformMessage("table", THERE),
        TransformMessage("part", THERE, "reference", predict="hold", rest_after=0.2),
        TransformMessage("belt", THERE, "reference", predict="velocity", rest_after=0.5),
        TransformMessage("weave", HERE, "functional", weave),
        TransformMessage("seam", THERE, "functional", weave),
    ]


@pytest.mark.parametrize(
    "function",
    [
        Linear(along=(0.0, 0.0, 0.1), turn=(0.0, 0.1, 0.0), parameter="t"),
        Circular(0.05, 2.0 * math.pi, turns=True),
        Weave((0.002, 0.0, 0.0), 3.0),
        Table([TableRow(0.0, (0.0,) * 6), TableRow(1.0, TWIST)], interpolation="linear"),
    ],
)
def test_functions_arrive_as_they_were_given(arm: Arm, link: FakeLink, function: Any) -> None:
    arm.functional("f", function)
    (message,) = link.heard
    assert isinstance(message, TransformMessage)
    assert message.function == function


@pytest.mark.parametrize(
    ("function", "complaint"),
    [
        (lambda h: h, r"transform 'f': <function .* is not a Linear, .* cannot be Python code"),
        (Weave((0.0, 0.0), 1.0), r"transform 'f': .*amplitude"),  # type: ignore[arg-type]
        (Linear(parameter="x"), r"transform 'f': .*parameter"),  # type: ignore[arg-type]
        (Table([TableRow(0.0, TWIST)]), r"transform 'f': .*function.rows .*length >= 2"),
    ],
)
def test_what_the_server_cannot_compute_is_refused(
    arm: Arm, link: FakeLink, function: Any, complaint: str
) -> None:
    with pytest.raises(TransformError, match=complaint):
        arm.functional("f", function)
    assert link.heard == []


def test_an_observation_keeps_how_its_reference_is_predicted(arm: Arm, link: FakeLink) -> None:
    part = arm.reference("part", HERE)
    arm.reference("belt", HERE, predict="velocity")
    arm.observe(part, THERE)
    arm.observe("belt", THERE, at=1.25, twist=TWIST)
    arm.observe("belt", THERE, twist=list(TWIST))
    assert link.heard[2:] == [
        TransformMessage("part", THERE, "reference", predict="hold"),
        TransformMessage("belt", THERE, "reference", None, "velocity", TWIST, 1.25),
        TransformMessage("belt", THERE, "reference", None, "velocity", TWIST),
    ]


@pytest.mark.parametrize("what", ["table", "nobody", Expression("part", "table")])
def test_only_references_are_observed(arm: Arm, link: FakeLink, what: str | Expression) -> None:
    arm.transform("table", HERE)
    arm.reference("part", HERE)
    with pytest.raises(TransformError, match=rf"transform '{what}' is not a reference .*: part;"):
        arm.observe(what, THERE)
    assert len(link.heard) == 2


@pytest.mark.parametrize("twist", [(1.0, 2.0), 6 * ("fast",)])
def test_a_twist_is_six_numbers(arm: Arm, link: FakeLink, twist: Any) -> None:
    arm.reference("part", HERE)
    with pytest.raises(TransformError, match=r"transform 'part': .*twist"):
        arm.observe("part", THERE, twist=twist)
    assert len(link.heard) == 1


# --- positions ---------------------------------------------------------------------------------


def test_the_thesis_equation_with_its_frames(arm: Arm, link: FakeLink) -> None:
    z, e, b1, tl = (arm.transform(name, HERE) for name in ("z", "e", "b1", "tl"))
    arm.position("hole", z @ arm.t6 @ e == b1 @ tl, tool=e, compliance=tl, config="left up noflip")
    assert link.heard[-1] == PositionMessage(
        "hole", ["z", "t6", "e"], ["b1", "tl"], "e", "tl", "left up noflip"
    )


@pytest.mark.parametrize("times", [0, 2])
def test_the_arm_stands_in_an_equation_once(arm: Arm, link: FakeLink, times: int) -> None:
    left = Expression(*["t6"] * times, "tool")
    with pytest.raises(EquationError, match=rf"position 'at': t6 occurs {times} times in .*tool"):
        arm.position("at", left == Expression("part"))
    assert link.heard == []


ANGLES = (0.1, 1.4, -3.3, 0.1, -1.25, 3.5)


def test_joint_angles_of_any_sequence(arm: Arm, link: FakeLink) -> None:
    given: list[Any] = [ANGLES, list(ANGLES), np.array(ANGLES)]
    names = [arm.joint_position(f"p{k}", angles) for k, angles in enumerate(given)]
    assert names == ["p0", "p1", "p2"]
    assert link.heard == [JointPositionMessage(name, ANGLES) for name in names]


@pytest.mark.parametrize(
    ("angles", "complaint"),
    [
        (ANGLES[:5], r"angles .*length 6.*5; give six joint angles in rad, as in arm\.joints"),
        ((*ANGLES, 0.0), r"angles .*length 6.*7; give six joint angles in rad"),
        ((*ANGLES[:5], math.nan), "joint 6 at nan rad: give a finite angle inside its range"),
        ((-math.inf, *ANGLES[1:]), "joint 1 at -inf rad: give a finite angle"),
        ((*ANGLES[:5], "200 deg"), r"angles\[5\] '200 deg': expected `float`, got `str`; give six"),
        ("0 1 2 3 4 5", "angles '0 1 2 3 4 5': expected `array`, got `str`; give six"),
        (None, "angles None: expected `array`, got `null`; give six"),
        (1.0, r"angles 1\.0: expected `array`, got `float`; give six"),
        (THERE, r"angles .*length 6.*12; give six joint angles"),
        ({1: 0.1}, "angles .*expected `array`, got `object`; give six"),
    ],
)
def test_what_are_not_six_angles_is_refused_in_one_line(
    arm: Arm, link: FakeLink, angles: Any, complaint: str
) -> None:
    with pytest.raises(JointPositionError, match=f"position 'p': {complaint}") as refused:
        arm.joint_position("p", angles)
    assert "\n" not in str(refused.value)
    assert link.heard == []


# --- modes -------------------------------------------------------------------------------------


def test_a_mode_with_everything(arm: Arm, link: FakeLink) -> None:
    arm.mode(
        "weld",
        acceleration_time=0.1,
        speed=0.02,
        angular_speed=0.5,
        joint_speed=0.8,
        interpolation="cartesian",
        transition="cartesian",
        lengthen=True,
        acceleration=2.0,
        angular_acceleration=7.0,
        config="right up flip",
        deviation=0.002,
    )
    assert link.heard == [
        ModeMessage(
            "weld",
            "cartesian",
            0.1,
            None,
            0.02,
            0.5,
            0.8,
            True,
            10.0,
            "cartesian",
            2.0,
            7.0,
            "right up flip",
            deviation=0.002,
        )
    ]


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({}, "acceleration_time"),
        ({"acceleration_time": 0.1, "sped": 0.2}, "sped"),
        ({"acceleration_time": 0.1, "segment_time": "long"}, "segment_time"),
        ({"acceleration_time": 0.1, "interpolation": "round"}, "interpolation"),
        ({"acceleration_time": 0.1, "joint_speed": 1.1}, "joint_speed"),
        ({"acceleration_time": 0.1, "lengthen": "yes"}, "lengthen"),
        ({"acceleration_time": 0.1, "deviation": "2 mm"}, "deviation '2 mm'"),
        ({"acceleration_time": 0.1, "deviation": 0}, "deviation 0 m must be more than 0 and at"),
        ({"acceleration_time": 0.1, "deviation": -2e-3}, "deviation -0.002 m must be more than 0"),
        ({"acceleration_time": 0.1, "deviation": 2}, "at most 1 m; to pass through the position"),
        ({"acceleration_time": 0.1, "deviation": math.nan}, "deviation nan m must be more than 0"),
    ],
)
def test_a_mode_says_which_setting_is_wrong(
    arm: Arm, link: FakeLink, settings: Any, complaint: str
) -> None:
    with pytest.raises(ModeError, match=f"mode 'odd': .*{complaint}"):
        arm.mode("odd", **settings)
    assert link.heard == []


# --- motion ------------------------------------------------------------------------------------


def test_words_of_motion(arm: Arm, link: FakeLink) -> None:
    arm.pause()
    arm.resume()
    arm.feed(0.5)
    arm.comply("fx fy rx ry", 0.0, 0.0, 0.0, 0.0)
    arm.comply("fz", -5.0)
    arm.lock("fz fx")
    arm.release()
    expected: list[Message] = [
        PauseRequest(),
        ResumeRequest(),
        FeedRequest(0.5),
        ComplyRequest("fx fy rx ry", [0.0, 0.0, 0.0, 0.0]),
        ComplyRequest("fz", [-5.0]),
        LockRequest("fz fx"),
        GripperRequest(True, 1.0),
    ]
    assert link.heard == expected


@pytest.mark.parametrize("rate", [0.0, 0.049, 1.01, math.nan])
def test_a_feed_rate_out_of_bounds_is_refused(arm: Arm, link: FakeLink, rate: float) -> None:
    with pytest.raises(ProgramError, match=f"feed rate {rate}"):
        arm.feed(rate)
    assert link.heard == []


@pytest.mark.parametrize(
    ("word", "values", "complaint"),
    [
        ("fx fq", (0.0, 0.0), "'fq' is not a direction"),
        ("fx fy fx", (0.0, 0.0, 0.0), "fx twice"),
        ("", (), "names no direction"),
        ("fx fy", (0.0,), "1 values for 2 directions"),
        ("fx", (0.0, 1.0), "2 values for 1 directions"),
        ("fx rz", (0.0, math.inf), "the bias of rz is inf"),
    ],
)
def test_a_word_to_comply_names_what_is_wrong(
    arm: Arm, link: FakeLink, word: str, values: tuple[float, ...], complaint: str
) -> None:
    with pytest.raises(SelectionError, match=complaint):
        arm.comply(word, *values)
    assert link.heard == []


@pytest.mark.parametrize(("word", "complaint"), [("rw", "'rw' is no"), ("rx rx", "rx twice")])
def test_a_word_to_lock_names_what_is_wrong(
    arm: Arm, link: FakeLink, word: str, complaint: str
) -> None:
    with pytest.raises(SelectionError, match=complaint):
        arm.lock(word)
    assert link.heard == []


# --- moves and their plans ---------------------------------------------------------------------


def planned(link: FakeLink, *answers: Answer) -> None:
    """Let the link answer moves with these."""
    left = list(answers)
    link.request = lambda message: left.pop(0)  # type: ignore[method-assign]


def test_the_plan_of_a_move_is_what_the_server_answered(arm: Arm, link: FakeLink) -> None:
    planned(link, Answer(7, 1.5), Answer(8, 0.8, 0.002, 0.1))
    assert [arm.move("a", "m"), arm.move("b", "m")] == [7, 8]
    assert arm.plan(7) == MovePlan(7, 1.5, None, None)
    assert arm.plan(8) == MovePlan(8, 0.8, 0.002, 0.1)
    for number in (6, 9):
        with pytest.raises(ProgramError, match=f"plan of move {number}: 2 moves have been asked"):
            arm.plan(number)


def test_numbers_of_another_program_are_not_waited_for(arm: Arm, link: FakeLink) -> None:
    planned(link, Answer(7), Answer(8))
    arm.move("a", "m"), arm.move("b", "m")
    with pytest.raises(ProgramError, match="wait for move 6: 2 moves have been asked for"):
        arm.wait(6)


def test_plans_of_long_ago_are_forgotten(arm: Arm) -> None:
    for _ in range(300):
        arm.move("a", "m")
    assert arm.plan(45).sequence == 45
    with pytest.raises(ProgramError, match="plan of move 44: it was too long ago"):
        arm.plan(44)


@pytest.mark.parametrize("seconds", [-0.1, math.nan, math.inf])
def test_sleep_takes_times(arm: Arm, seconds: float) -> None:
    with pytest.raises(ProgramError, match=f"sleep of {seconds} s"):
        arm.sleep(seconds)


def test_time_is_the_servers(arm: Arm, link: FakeLink) -> None:
    link.now = 250
    assert arm.time == 1.0
    assert arm.status.cycle == 250


@pytest.mark.parametrize(
    "equation",
    [
        lambda t6: t6 @ Transform.identity(),
        lambda t6: Transform.identity() @ t6,
        lambda t6: t6 == Transform.identity(),
        lambda t6: Transform.identity() == t6,
        lambda t6: t6 @ "tool",
        lambda t6: "tool" @ t6,
        lambda t6: t6 @ None,
        lambda t6: t6 @ np.eye(4),
        lambda t6: np.eye(4) @ t6,
    ],
)
def test_a_value_in_an_equation_is_refused_with_a_way_out(
    arm: Arm, equation: Callable[[Any], Any]
) -> None:
    with pytest.raises(EquationError, match=r"named transforms.*arm\.transform\(") as refused:
        arm.position("at", equation(arm.t6))
    assert "\n" not in str(refused.value)
