"""Tasks as data: what they are made of, how they are changed, what they refuse, and cleaning up."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from support.link import FakeLink
from support.tasks import PEG, AsyncFakeLink, hole_at, run_async

from rfms_can.coordinator import (
    Arm,
    AsyncArm,
    EquationError,
    Expression,
    FaultError,
    ModeError,
    MoveError,
    Outcome,
    ProgramError,
    RfmsError,
    SelectionError,
    StoppedError,
    Transform,
    TransformError,
)
from rfms_can.messages import (
    Message,
    ModeMessage,
    MoveRequest,
    PositionMessage,
    RemoveRequest,
    StopRequest,
    TransformMessage,
)
from rfms_can.task import (
    Comply,
    DefineMode,
    DefineTransform,
    Frame,
    Grip,
    Lock,
    Move,
    Sleep,
    Tare,
    Task,
    approach,
    depart,
    follow,
    grip,
    guarded_approach,
    insert,
    release,
)

TIP = Frame("tip", Transform.translation(0.0, 0.0, 0.16))
PART = Frame("part", Transform.translation(0.3, 0.1, 0.0))
TASK = approach(TIP, PART)
SQUASHED = Transform(*(2.0, *Transform.identity()[1:]))


class Refusing(FakeLink):
    """Refuses the n-th message of a kind, and tells how often it was stopped."""

    def __init__(self, kind: type[Message], number: int, error: Exception) -> None:
        super().__init__()
        self._kind, self._left, self._error = kind, number, error

    def request(self, message: Message) -> Any:
        if isinstance(message, self._kind):
            self._left -= 1
            if self._left == 0:
                raise self._error
        return super().request(message)

    def count(self, kind: type[Message]) -> int:
        return sum(isinstance(message, kind) for message in self.heard)


# --- data ----------------------------------------------------------------------------------------


def test_a_task_names_what_it_relates() -> None:
    assert [step.name for step in TASK.steps if not isinstance(step, Move)] == [  # type: ignore[attr-defined]
        "tip",
        "part",
        "approach part: back",
        "approach part: over",
        "approach part: at",
        "approach part: far",
        "approach part: near",
    ]
    assert TASK.steps[-2:] == (
        Move("approach part: over", "approach part: far", wait=False),
        Move("approach part: at", "approach part: near"),
    )


def test_frames_compose_with_one_another_and_with_those_of_the_program() -> None:
    fixture, lid = Expression("fixture", "lid"), Frame("corner", Transform.translation(0.1, 0, 0))
    product = fixture @ lid @ PART
    assert isinstance(product, Frame)
    assert product.names == ("fixture", "lid", "corner", "part")
    assert [part.ours for part in product.parts] == [False, False, True, True]
    assert product.values == {**lid.values, **PART.values}
    assert (PART @ fixture).names == ("part", "fixture", "lid")
    assert PART.names == ("part",)


def test_tasks_in_a_row_share_what_is_the_same() -> None:
    both = approach(TIP, PART, wait=False) + grip(0.5) + depart(TIP, PART)
    transforms = [step.name for step in both.steps if isinstance(step, DefineTransform)]
    assert transforms == ["tip", "part", "approach part: back", "depart part: back"]
    first = next(i for i, step in enumerate(both.steps) if isinstance(step, Move))
    assert all(isinstance(step, Move | Grip) for step in both.steps[first:])
    assert both.name == TASK.name


def test_a_task_is_a_value() -> None:
    assert approach(TIP, PART) == TASK
    assert approach(TIP, PART, speed=0.2) != TASK
    assert TASK.named("other") != TASK
    assert TASK.named("other").steps == TASK.steps


# --- changes -------------------------------------------------------------------------------------


def test_a_mode_is_changed_and_the_task_it_was_of_is_not() -> None:
    slower = TASK.change("near", speed=0.01)
    assert slower.mode("near").settings["speed"] == 0.01
    assert TASK.mode("near").settings["speed"] == 0.1
    assert [a for a, b in zip(TASK.steps, slower.steps, strict=True) if a != b] == [
        TASK.mode("near")
    ]


def test_a_time_takes_the_place_of_speeds_and_the_reverse() -> None:
    timed = TASK.change("far", segment_time=1.5)
    assert timed.mode("far").settings == {
        "acceleration_time": 0.25,
        "lengthen": True,
        "segment_time": 1.5,
    }
    again = timed.change("far", joint_speed=0.3, angular_speed=1.0, lengthen=None)
    assert again.mode("far").settings == {
        "acceleration_time": 0.25,
        "joint_speed": 0.3,
        "angular_speed": 1.0,
    }


def test_a_transform_a_position_and_a_step_are_changed() -> None:
    nearer = TASK.change("back", value=Transform.translation(0.0, 0.0, -0.01))
    assert nearer.transform("back").value.pz == -0.01
    assert TASK.change("over", config="left up flip").position("over").config == "left up flip"
    slept = TASK.replace(TASK.steps[-1], Sleep(0.1), TASK.steps[-1])
    assert slept.steps[-2:] == (Sleep(0.1), TASK.steps[-1])
    assert TASK.replace(TASK.steps[-1]).steps == TASK.steps[:-1]


def test_a_frame_that_is_changed_changes_the_depth_of_an_insertion() -> None:
    task = insert(PEG, hole_at(0.02), 0.04, chamfer=0.006, guided=0.028)
    moved = task.change("hole", value=hole_at(0.04).values["hole"])
    assert moved.run(Arm(FakeLink())).depth == pytest.approx(0.04)
    with pytest.raises(ProgramError, match=r"insert hole: 20\.0 of 40 mm deep"):
        task.run(Arm(FakeLink()))


# --- running -------------------------------------------------------------------------------------


def test_a_configuration_is_that_of_every_position() -> None:
    config = "left up flip"
    for task in (approach(TIP, PART, config=config), depart(TIP, PART, config=config)):
        link = FakeLink()
        task.run(Arm(link))
        asked = [m.configuration for m in link.heard if isinstance(m, PositionMessage)]
        assert {*asked} == {config}


def test_a_report_has_outcomes_and_distances() -> None:
    link = FakeLink()
    link.ended = {2: (Outcome.GUARDED, "fz 11 N reached 10 N")}
    report = guarded_approach(TIP, PART, force={"fz": 10.0}).run(Arm(link))
    assert [(one.sequence, one.how) for one in report.outcomes] == [
        (1, Outcome.MADE),
        (2, Outcome.GUARDED),
    ]
    assert (report.travelled, report.depth) == (0.0, None)


def test_an_insertion_that_its_guard_ends_says_how_deep_and_why() -> None:
    link = FakeLink()
    link.ended = {2: (Outcome.GUARDED, "fz 151 N reached 150 N")}
    task = insert(PEG, hole_at(0.01), 0.04, chamfer=0.006, guided=0.028, force={"fz": 150.0})
    told = r"^insert hole: 10\.0 of 40 mm deep: fz 151 N reached 150 N$"
    with pytest.raises(ProgramError, match=told):
        task.run(Arm(link))
    assert sum(isinstance(message, MoveRequest) for message in link.heard) == 2


def test_a_task_that_is_kept_leaves_its_names_and_runs_again() -> None:
    link = FakeLink()
    arm = Arm(link)
    TASK.run(arm, keep=True)
    before = [*link.heard]
    TASK.run(arm, keep=True)
    assert link.heard == before * 2
    assert not any(isinstance(message, RemoveRequest) for message in before)


@pytest.mark.parametrize("keep", [False, True])
@pytest.mark.parametrize(
    ("number", "stops"),
    [(1, 0), (2, 1)],
)
def test_a_move_refused_stops_what_the_task_has_begun_and_takes_its_names_away(
    keep: bool, number: int, stops: int
) -> None:
    link = Refusing(MoveRequest, number, MoveError("reach is 0.4064 m"))
    with pytest.raises(MoveError, match="reach is"):
        TASK.run(Arm(link), keep=keep)
    assert link.count(StopRequest) == stops
    assert link.count(RemoveRequest) == (0 if keep else 7)


def test_a_definition_refused_moves_nothing_and_leaves_nothing() -> None:
    link = Refusing(ModeMessage, 2, ModeError("contradicts itself"))
    task = TASK + depart(TIP, PART)
    with pytest.raises(ModeError, match="contradicts itself"):
        task.run(Arm(link))
    assert (link.count(MoveRequest), link.count(StopRequest)) == (0, 0)
    assert link.count(RemoveRequest) == 10


def test_after_a_fault_the_fault_is_told_though_no_name_can_be_removed() -> None:
    link = Refusing(MoveRequest, 2, FaultError("joint 3: OVER_TORQUE"))

    def request(message: Message) -> Any:
        answer = Refusing.request(link, message)
        if isinstance(message, RemoveRequest | StopRequest):
            raise FaultError("halted")
        return answer

    link.request = request  # type: ignore[method-assign]
    with pytest.raises(FaultError, match="OVER_TORQUE"):
        TASK.run(Arm(link))


def test_names_that_the_program_has_come_to_use_are_not_taken_away_silently() -> None:
    link = Refusing(RemoveRequest, 6, ProgramError("transform 'task/part' is used by 'mine'"))
    with pytest.raises(ProgramError, match="used by 'mine'"):
        TASK.run(Arm(link))


@pytest.mark.parametrize("twin", ["sync", "async"])
def test_an_error_of_the_programs_own_function_stops_the_arm(twin: str) -> None:
    def broken(_: Arm) -> bool:
        raise ZeroDivisionError("mine")

    link = FakeLink()
    task = follow(TIP, PART, until=broken)
    with pytest.raises(ZeroDivisionError, match="mine"):
        task.run(Arm(link)) if twin == "sync" else run_async(task, link)
    assert any(isinstance(message, StopRequest) for message in link.heard)
    assert isinstance(link.heard[-1], RemoveRequest)


def test_a_move_that_was_stopped_is_told_as_the_program_api_tells_it() -> None:
    link = FakeLink()
    link.ended = {2: (Outcome.STOPPED, "stopped by stop()")}
    with pytest.raises(StoppedError, match="move 2 did not reach its goal"):
        TASK.run(Arm(link))


def test_following_looks_and_ends_when_it_is_told_to() -> None:
    link, looks, asked = FakeLink(), [], []

    def look(arm: Arm) -> None:
        looks.append(arm.time)

    def until(arm: Arm) -> bool:
        asked.append(arm.time)
        return len(asked) == 4

    report = follow(TIP, PART, until=until, look=look, every=0.04).run(Arm(link))
    assert [one.how for one in report.outcomes] == [Outcome.MADE] * 2
    assert looks == pytest.approx([0.04 * n for n in range(1, len(looks) + 1)])
    assert len(looks) == 13  # ten until it was there, 0.4 s, and three before the fourth question


# --- refused -------------------------------------------------------------------------------------

Given = Callable[[], Any]
REFUSED: list[tuple[Given, type[RfmsError], str]] = [
    (lambda: Frame("", Transform.identity()), TransformError, "frame '': a name is a text"),
    (lambda: Frame("t6", Transform.identity()), TransformError, "frame 't6'.*which is the arm"),
    (lambda: Frame("a", 0.3), TransformError, "frame 'a': 0.3 is not a Transform"),  # type: ignore[arg-type]
    (lambda: Frame("a", SQUASHED), TransformError, "frame 'a': not rigid.*nearest_rotation"),
    (lambda: PART @ Frame("part", SQUASHED @ PART.values["part"]), TransformError, "not rigid"),
    (
        lambda: PART @ Frame("part", Transform.identity()),
        TransformError,
        "part @ part: frame 'part' has two values; give one another name",
    ),
    (lambda: PART @ 3, EquationError, "part @ 3: 3 is not a frame; give Frame"),  # type: ignore[operator]
    (lambda: approach("tip", PART), EquationError, "approach: tool: 'tip' is not a frame"),  # type: ignore[arg-type]
    (lambda: approach(TIP, Expression("t6")), EquationError, "approach: frame: t6 contains t6"),
    (lambda: insert(PEG, 3, 1, chamfer=1, guided=1), EquationError, "insert: hole: 3 is not"),  # type: ignore[arg-type]
    (
        lambda: insert(PEG, Expression("hole"), 0.04, chamfer=0.006, guided=0.02),
        ProgramError,
        "insert hole: 'hole' is the program's own.*give Frame",
    ),
    (lambda: approach(TIP, PART, name=""), ProgramError, "approach: name '': give a text"),
    (
        lambda: approach(TIP, PART, name=60 * "n"),
        ProgramError,
        "has 71 characters, 64 are the most",
    ),
    (
        lambda: approach(TIP, PART, by=(0, 0)),
        ProgramError,
        r"approach part: by \(0, 0\): give three",
    ),
    (
        lambda: approach(TIP, PART, by=(0, 0, 0)),
        ProgramError,
        "is 0 m: more than 0, and 1 m at most",
    ),
    (lambda: approach(TIP, PART, by=(0, 0.9, 0.9)), ProgramError, "is 1.27279 m: .*1 m at most"),
    (lambda: approach(TIP, PART, by=(0, 0, math.nan)), ProgramError, "nan: give a number of m"),
    (
        lambda: approach(TIP, PART, speed=0),
        ProgramError,
        "approach part: speed 0: give more than 0",
    ),
    (lambda: approach(TIP, PART, speed=-1), ProgramError, "speed -1: give a number of m/s, 0 to"),
    (lambda: approach(TIP, PART, far={"sped": 1}), ModeError, "no setting 'sped'; there are:"),
    (lambda: approach(TIP, PART, far=3), ModeError, "approach part: 3: give settings of a mode"),  # type: ignore[arg-type]
    (lambda: approach(TIP, PART, far={"mass": -1.0}), ModeError, "mass -1.0: expected"),
    (
        lambda: depart(TIP, PART, comply={"x": 1}),
        SelectionError,
        "depart part: comply .*'x' is not",
    ),
    (lambda: depart(TIP, PART, comply={}), SelectionError, "depart part: comply {}: give direct"),
    (
        lambda: guarded_approach(TIP, PART, force={"fz": -1.0}),
        SelectionError,
        "guarded approach part: force: fz is -1.0: a bound is more than 0",
    ),
    (
        lambda: guarded_approach(TIP, PART, force={"fz": "10"}),  # type: ignore[dict-item]
        SelectionError,
        "force: fz is '10': give N or N m",
    ),
    (
        lambda: guarded_approach(TIP, PART, force={"fz": 1.0}, at_most=2.0),
        ProgramError,
        "at_most 2.0: give a number of m, 0 to 1",
    ),
    (
        lambda: insert(PEG, hole_at(0.0), 0.6, chamfer=0.006, guided=0.02),
        ProgramError,
        "insert hole: depth 0.6: give a number of m, 0 to 0.5",
    ),
    (
        lambda: insert(PEG, hole_at(0.0), 0.04, chamfer=0.006, guided=0.05),
        ProgramError,
        "depth 'guided' 0.05: give a number of m, 0 to 0.04",
    ),
    (
        lambda: insert(PEG, hole_at(0.0), 0.04, chamfer=0.03, guided=0.02),
        ProgramError,
        "depth 'guided' 0.02 m is not beyond 0.03 m: give 0 < chamfer < guided < depth",
    ),
    (
        lambda: insert(PEG, hole_at(0.0), 0.04, chamfer=0.01, guided=0.02, tolerance=0.05),
        ProgramError,
        "tolerance 0.05: give a number of m, 0 to 0.04",
    ),
    (
        lambda: insert(PEG, hole_at(0.0), 0.04, chamfer=0.01, guided=0.02, in_hole={"fz": 0.0}),
        ProgramError,
        "in_hole {'fz': 0.0}: along fz the peg is led down",
    ),
    (lambda: follow(TIP, PART), ProgramError, "follow part: when it ends is not said: give dur"),
    (lambda: follow(TIP, PART, duration=-1), ProgramError, "duration -1: give a number of s, 0 to"),
    (lambda: follow(TIP, PART, until=3), ProgramError, "until 3: give a function of the arm"),  # type: ignore[arg-type]
    (lambda: follow(TIP, PART, duration=1, every=0), ProgramError, "every 0: give a number of s"),
    (lambda: grip(0.0), ProgramError, "gripper force 0.0 is outside 0..1"),
    (lambda: release(2.0), ProgramError, "gripper force 2.0 is outside 0..1"),
    (lambda: Task("", ()), ProgramError, "task '': its name is a text"),
    (lambda: TASK.named("n" * 60), ProgramError, "has 65 characters, 64 are"),
    (lambda: Task("x", (Sleep(-1.0),)), ProgramError, "sleep: seconds -1.0: give a number of s"),
    (lambda: Task("x", (Comply({"fq": 0.0}),)), SelectionError, "'fq' is not a direction"),
    (lambda: Task("x", (Lock(""),)), SelectionError, "names no direction"),
    (
        lambda: Task("x", (Move("there", "far"),)),
        ProgramError,
        "move to 'there' with 'far': position: there is no 'there'; there are: none",
    ),
    (
        lambda: TASK.replace(TASK.mode("near")),
        ProgramError,
        "mode: there is no 'approach part: near'; there are: approach part: far",
    ),
    (
        lambda: TASK.replace(TASK.transform("tip")),
        ProgramError,
        "position 'approach part: over': transform: there is no 'tip'; there are: part",
    ),
    (lambda: TASK.replace(Tare()), ProgramError, r"Tare\(\) is not a step of it"),
    (
        lambda: TASK + approach(TIP, PART, speed=0.2),
        ProgramError,
        "'approach part: near' is defined twice, .*give one frame another name",
    ),
    (lambda: TASK.mode("slow"), ProgramError, "task 'task': mode: there is no 'slow'; there are:"),
    (
        lambda: (TASK + approach(TIP, PART, name="again")).change("near", speed=0.1),
        ProgramError,
        "definition 'near' may be any of 'approach part: near', 'again: near': give the whole name",
    ),
    (lambda: TASK.change("near", sped=0.1), ModeError, "change of 'approach part: near'.*'sped'"),
    (lambda: TASK.change("near", speed=-0.1), ModeError, "speed -0.1"),
    (lambda: TASK.change("near", acceleration_time=None), ModeError, "acceleration_time"),
    (lambda: TASK.change("back", valu=1), ProgramError, "attribute: there is no 'valu'; .*: value"),
    (lambda: TASK.change("back", value=1), TransformError, "a Transform is needed, not 1"),
    (lambda: TASK.change("over", config=1), EquationError, "configuration 1"),
]


@pytest.mark.parametrize(("make", "error", "told"), REFUSED, ids=[told for *_, told in REFUSED])
def test_what_cannot_be_is_refused_when_the_task_is_made(
    make: Given, error: type[RfmsError], told: str
) -> None:
    with pytest.raises(error, match=told) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_an_arm_of_coroutines_is_told_what_to_await() -> None:
    link = FakeLink()
    with pytest.raises(ProgramError, match=r"run\(\) is for an Arm: await task\.run_async\(arm\)"):
        TASK.run(AsyncArm(AsyncFakeLink(link)))  # type: ignore[arg-type]
    assert link.heard == []


def test_the_functions_of_a_coroutine_program_may_be_coroutines() -> None:
    link, looks = FakeLink(), []

    async def look(arm: AsyncArm) -> None:
        await arm.sleep(0.0)
        looks.append(arm.time)

    async def until(_: AsyncArm) -> bool:
        return len(looks) == 12

    run_async(follow(TIP, PART, until=until, look=look, every=0.04), link)
    assert len(looks) == 12


def test_a_task_and_something_else_are_no_task() -> None:
    with pytest.raises(TypeError):
        TASK + 3  # type: ignore[operator]


def test_every_definition_is_sent_before_the_first_move() -> None:
    link = FakeLink()
    (TASK + depart(TIP, PART)).run(Arm(link))
    kinds = [type(message) for message in link.heard]
    first = kinds.index(MoveRequest)
    assert not {TransformMessage, ModeMessage} & {*kinds[first:]}
    assert kinds[:first].count(ModeMessage) == sum(
        isinstance(step, DefineMode) for step in (TASK + depart(TIP, PART)).steps
    )
