"""Values bind when a motion begins: what a redefinition does to moves that wait, or its refusal."""

import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx
from support.motion import Program

from rfms_can.errors import ModeError, MoveError, ProgramError, TransformError
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.queue import MAX_QUEUE
from rfms_can.master.world.reference import Reference
from rfms_can.messages import (
    Answer,
    ComplyRequest,
    FeedRequest,
    Linear,
    ModeMessage,
    PauseRequest,
    PositionMessage,
    ResumeRequest,
    StopRequest,
    TransformMessage,
)
from rfms_can.setpoint import CartesianSetpoint
from rfms_can.transform import Transform

FAR = 1.5
"""Out of reach, m."""


@pytest.fixture
def program() -> Program:
    """An arm that can go to a, b and c, 20 mm apart."""
    program = Program()
    for k, name in enumerate("abc", 1):
        program.place(name, 0.0, 0.0, 0.02 * k)
    program.mode("slow")
    program.mode("fast", 0.3)
    return program


def at(program: Program, x: float, y: float = 0.0, z: float = 0.0) -> Any:
    """Where the arm is, of a place as the program defines it."""
    return approx(program.park @ Transform.translation(x, y, z), abs=1e-9)


# --- binding -------------------------------------------------------------------------------------


def test_a_value_defined_again_acts_in_the_next_move_and_not_in_the_one_under_way(
    program: Program,
) -> None:
    program.move("a", "slow")
    program.run(20)
    program.transform("a", 0.01)
    assert program.finish() == at(program, 0.0, 0.0, 0.02)
    program.move("a", "slow")
    assert program.finish() == at(program, 0.01)


def test_a_move_that_waits_goes_where_the_value_is_when_it_begins(program: Program) -> None:
    first, second = program.move("a", "slow"), program.move("b", "slow")
    program.run(20)
    answer = program.transform("b", 0.01)
    (planned,) = answer.replanned
    assert planned.sequence == second.sequence
    assert planned.segment_time == approx(0.4)
    assert planned.via_deviation is not None
    assert program.finish() == at(program, 0.01)
    assert program.motion.is_over(first.sequence)
    assert program.setpoints[-1].sequence == second.sequence


def test_a_move_that_is_settled_has_begun(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "slow")
    generator = program.motion.generator
    program.run(20)
    while len(generator.active_goals) < 2:
        program.run(1)
    assert generator.sequence == 1
    assert program.transform("b", 0.01).replanned == []
    assert program.finish() == at(program, 0.0, 0.0, 0.04)


@pytest.mark.parametrize("again", ["position", "mode", "function"])
def test_positions_modes_and_functions_bind_as_values_do(program: Program, again: str) -> None:
    rise = TransformMessage("rise", Transform.identity(), "functional", Linear((0.0, 0.0, 0.01)))
    program.motion.handle(rise)
    program.position("high", "a", "rise")
    program.move("a", "slow")
    program.move("high", "fast")
    program.run(20)
    redefine: dict[str, Callable[[], Answer]] = {
        "position": lambda: program.position("high", "c"),
        "mode": lambda: program.mode("fast", 0.9),
        "function": lambda: program.motion.handle(
            TransformMessage("rise", Transform.identity(), "functional", Linear((0.0, 0.0, -0.01)))
        ),
    }
    (planned,) = redefine[again]().replanned
    assert planned.segment_time == approx(0.9 if again == "mode" else 0.3)
    ends = {"position": 0.06, "mode": 0.03, "function": 0.01}
    assert program.finish() == at(program, 0.0, 0.0, ends[again])


def test_a_function_keeps_its_course_in_the_move_under_way(program: Program) -> None:
    def rise(z: float) -> Answer:
        function = Linear((0.0, 0.0, z))
        message = TransformMessage("rise", Transform.identity(), "functional", function)
        return program.motion.handle(message)

    rise(0.01)
    program.position("high", "a", "rise")
    program.move("high", "slow")
    program.run(20)
    assert rise(-0.01).replanned == []
    assert program.finish() == at(program, 0.0, 0.0, 0.03)


def test_corrections_of_a_reference_mind_where_the_tool_has_come_to_be(program: Program) -> None:
    """A turn of it moves what is beyond: as far as a redefined value says, once it is accepted."""

    def lever() -> float:
        reference = program.motion.world._transforms.table["seen"]
        assert isinstance(reference, Reference)
        return reference.lever

    def beyond(x: float) -> None:
        value = Transform.translation(x, 0.0, 0.0)
        program.motion.handle(TransformMessage("beyond", value))

    seen = TransformMessage("seen", program.park, "reference")
    program.motion.handle(seen)
    beyond(0.01)
    program.position("at it", "seen", "beyond")
    assert lever() == approx(0.01)
    program.move("a", "slow")
    program.move("at it", "slow")
    program.run(20)
    beyond(0.02)
    assert lever() == approx(0.02)
    with pytest.raises(MoveError):
        beyond(FAR)
    assert lever() == approx(0.02)
    program.finish()
    beyond(0.03)
    assert lever() == approx(0.02), "no move goes there yet"
    program.move("at it", "slow")
    assert lever() == approx(0.03)


def test_what_is_defined_again_as_it_was_leaves_all_plans_alone(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "slow")
    program.run(20)
    queue = program.motion.generator.not_begun
    assert program.transform("b", 0.0, 0.0, 0.04) == Answer()
    assert program.position("b", "b") == Answer()
    assert program.mode("slow") == Answer()
    assert program.motion.generator.not_begun == queue


def test_only_what_can_tell_the_difference_is_planned_again(program: Program) -> None:
    for name in ("a", "b", "c", "a", "c", "a"):
        program.move(name, "slow")
    program.run(20)
    assert [move.sequence for move in program.transform("b", 0.005).replanned] == [2, 3, 4]
    assert [move.sequence for move in program.transform("c", 0.005).replanned] == [3, 4, 5, 6]


def test_the_mode_lengthens_a_segment_that_has_become_longer(program: Program) -> None:
    program.motion.handle(ModeMessage("careful", "cartesian", 0.1, speed=0.1, lengthen=True))
    program.move("a", "slow")
    before = program.move("b", "careful")
    program.run(20)
    (planned,) = program.transform("b", 0.0, 0.0, -0.08).replanned
    assert before.segment_time == approx(0.208)
    assert planned.segment_time == approx(1.0)


def test_a_large_rotation_is_made_in_parts_of_what_was_one(program: Program) -> None:
    program.mode("turning", 2.0)
    program.move("a", "slow")
    program.move("b", "turning")
    program.run(20)
    generator = program.motion.generator
    assert [len(parts) for parts in generator.not_begun.values()] == [1]
    turned = program.park @ Transform.rotation((0.0, 0.0, 1.0), 0.9 * math.pi)
    program.motion.handle(TransformMessage("b", turned))
    assert [len(parts) for parts in generator.not_begun.values()] == [2]
    program.run(150)  # in the first part
    assert generator.not_begun == {}
    assert generator.waiting == 1
    assert program.transform("b", 0.0).replanned == []
    assert program.finish() == approx(turned, abs=1e-9)


def test_in_a_pause_moves_that_wait_are_bound_as_well(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "slow")
    program.run(20)
    program.motion.handle(PauseRequest())
    program.run(60)
    program.transform("b", 0.01)
    program.motion.handle(ResumeRequest())
    assert program.finish() == at(program, 0.01)


def test_what_complied_when_a_move_was_asked_for_stays(program: Program) -> None:
    motion = program.motion
    program.move("a", "slow")
    motion.handle(ComplyRequest("fx", [0.0]))
    program.move("b", "slow")
    program.run(20)
    motion.handle(ComplyRequest("fy", [0.0]))
    program.transform("b", 0.01)
    program.finish()
    assert motion.force_request is not None
    assert motion.force_request.specification.selection.word == "fx"


def test_a_mode_defined_again_brings_its_load_and_its_compliance(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "fast")
    program.run(20)
    program.mode("fast", 0.3, comply={"fz": 5.0}, mass=1.5)
    program.finish()
    request = program.motion.force_request
    assert request is not None
    assert request.specification.selection.word == "fz"
    assert request.specification.load is not None
    assert request.specification.load.mass == 1.5


# --- refusing ------------------------------------------------------------------------------------


def plans(program: Program) -> tuple[object, ...]:
    motion = program.motion
    return (motion.generator.not_begun, motion.planner.memory, motion._moves.last_guarded)


@pytest.mark.parametrize(
    ("redefine", "reason"),
    [
        (
            lambda p: p.transform("b", FAR),
            "transform 'b' stays as it was.*move 2, to 'b' with 'slow': ",
        ),
        (
            lambda p: p.position("b", "far"),
            "position 'b' stays as it was.*move 2, to 'b' with 'slow': the path at h",
        ),
        (
            lambda p: p.mode("fast", 0.1),
            "mode 'fast' stays as it was.*move 3, to 'c' with 'fast': segment time 0.1 s",
        ),
        (
            lambda p: p.mode("fast", 0.3, acceleration_time=0.001, transition="joint"),
            "mode 'fast' stays as it was.*move 3, to 'c' with 'fast': a time of 0.001 s is under",
        ),
        (
            lambda p: p.mode("slow", 0.4, stop_on_distance={"dz": 0.01}),
            "mode 'slow' stays.*move 3, to 'c' with 'fast': it waits behind move 2, which would be",
        ),
    ],
)
def test_what_a_move_could_not_be_made_with_is_refused_and_nothing_changes(
    program: Program, redefine: Callable[[Program], None], reason: str
) -> None:
    program.transform("far", FAR)
    for name, mode in (("a", "slow"), ("b", "slow"), ("c", "fast")):
        program.move(name, mode)
    program.run(20)
    world, before = program.motion.world, plans(program)
    stood = (world.position("b").goal, world.mode("slow"), world.mode("fast"))
    with pytest.raises(MoveError, match=reason) as refused:
        redefine(program)
    assert "define it otherwise, wait for that move, or stop" in str(refused.value)
    assert "\n" not in str(refused.value)
    assert plans(program) == before
    assert world.position("b").goal.pose(Moment(0)) == stood[0].pose(Moment(0))
    assert (world.mode("slow"), world.mode("fast")) == stood[1:]
    assert program.finish() == at(program, 0.0, 0.0, 0.06)


def test_bad_input_of_a_redefinition_is_refused_as_that_of_a_definition(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "slow")
    program.run(20)
    before = plans(program)
    with pytest.raises(TransformError, match="transform 'b' is not a rotation: off by"):
        program.motion.handle(TransformMessage("b", program.park._replace(nx=2.0)))
    with pytest.raises(ProgramError, match="position 'b': t6 stands 0 times; it must stand once"):
        program.motion.handle(PositionMessage("b", ["a"], ["c"]))
    with pytest.raises(ModeError, match="mode 'slow': a segment time of 1 s and speed contradict"):
        program.motion.handle(ModeMessage("slow", "joint", 0.1, 1.0, speed=0.1))
    with pytest.raises(TransformError, match=r"'b' is of kind value and stays so, .* remove"):
        program.motion.handle(TransformMessage("b", program.park, "reference"))
    assert plans(program) == before


def test_in_real_time_no_more_is_planned_in_a_cycle_than_it_has_time_for() -> None:
    program = Program(replans=2)
    for k, name in enumerate("abc", 1):
        program.place(name, 0.0, 0.0, 0.02 * k)
    program.mode("slow")
    for name in ("a", "b", "c", "a"):
        program.move(name, "slow")
    program.run(20)
    before = plans(program)
    reason = (
        "move 4, to 'a' with 'slow': it is one more than the 2 that can be planned again in one"
    )
    with pytest.raises(MoveError, match=reason):
        program.transform("b", 0.01)
    assert plans(program) == before
    assert len(program.transform("c", 0.01).replanned) == 2


def test_force_control_may_refuse_too(program: Program) -> None:
    motion = program.motion
    program.move("a", "slow")
    program.move("b", "fast")
    program.run(20)
    motion._vet = lambda request, *_: "too strong" if any(request.specification.bias) else None
    before = plans(program)
    with pytest.raises(MoveError, match="move 2, to 'b' with 'fast': too strong"):
        program.mode("fast", 0.3, comply={"fz": 500.0})
    assert plans(program) == before


def test_a_guard_that_is_taken_away_lets_another_move_follow(program: Program) -> None:
    program.mode("feel", 0.4, stop_on_distance={"dz": 0.1})
    program.move("a", "slow")
    program.move("b", "feel")
    program.run(20)
    with pytest.raises(MoveError, match="move 2 is guarded"):
        program.move("c", "slow")
    program.mode("feel", 0.4)
    program.move("c", "slow")
    with pytest.raises(MoveError, match="it waits behind move 2, which would be guarded"):
        program.mode("feel", 0.4, stop_on_distance={"dz": 0.1})
    assert program.finish() == at(program, 0.0, 0.0, 0.06)


def test_a_feed_rate_bounds_a_redefined_acceleration_time(program: Program) -> None:
    program.motion.handle(ModeMessage("calm", "cartesian", 1.0, 20.0))
    program.mode("slow", 20.0)
    program.move("a", "slow")
    program.move("b", "calm")
    program.motion.handle(FeedRequest(0.05))
    program.run(20)
    before = plans(program)
    reason = r"at a feed rate of 0\.05 would take 120 s, over 100 s"
    with pytest.raises(MoveError, match=reason):
        program.motion.handle(ModeMessage("calm", "cartesian", 6.0, 20.0))
    assert plans(program) == before


def test_a_full_queue_has_no_room_for_another_part(program: Program) -> None:
    program.mode("turning", 2.0)
    program.place("r", 0.0, 0.0, 0.03)
    for k in range(MAX_QUEUE - 1):
        program.move("abc"[k % 3], "slow")
    program.move("r", "turning")
    before = plans(program)
    turned = program.park @ Transform.rotation((0.0, 0.0, 1.0), 0.9 * math.pi)
    reason = "transform 'r' stays.*move 256: 257 moves would wait and 256 may: wait until one is"
    with pytest.raises(MoveError, match=reason):
        program.motion.handle(TransformMessage("r", turned))
    assert plans(program) == before


# --- removal -------------------------------------------------------------------------------------


def test_names_a_move_is_to_be_made_with_are_kept_until_it_is_over(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "fast")
    program.run(20)
    for name, what, user in (
        ("a", "position", "position 'a': move 1"),
        ("b", "position", "position 'b': move 2"),
        ("fast", None, "mode 'fast': move 2"),
    ):
        reason = re.escape(f"{user} is to be made with it: wait for it before removing it")
        with pytest.raises(ProgramError, match=reason):
            program.remove(name, what)
    with pytest.raises(TransformError, match="transform 'a' is used by position 'a'"):
        program.remove("a", "transform")
    program.remove("c", "position")
    program.remove("c")
    program.finish()
    for name in "ab":
        program.remove(name, "position")
        program.remove(name, "transform")
    program.remove("fast")
    assert program.motion.world.names().sizes == {"transform": 0, "position": 0, "mode": 1}


def test_a_name_is_kept_by_a_later_move_although_an_earlier_one_is_over(program: Program) -> None:
    program.move("a", "slow")
    program.finish()
    program.motion.handle(PauseRequest())
    program.move("b", "slow")
    program.move("a", "slow")
    program.run(5)
    with pytest.raises(ProgramError, match="position 'a': move 3 is to be made with it"):
        program.remove("a", "position")


def test_a_value_is_removed_although_the_move_under_way_was_bound_to_it(program: Program) -> None:
    program.move("a", "slow")
    program.run(20)
    program.position("a", "b")
    program.remove("a", "transform")
    assert program.finish() == at(program, 0.0, 0.0, 0.02)


def test_a_reference_is_kept_while_the_arm_follows_it(program: Program) -> None:
    motion, part = program.motion, program.park @ Transform.translation(0.0, 0.0, 0.03)
    motion.handle(TransformMessage("belt", part, "reference", predict="velocity"))
    program.position("on belt", "belt")
    program.move("on belt", "slow")
    program.finish()
    program.remove("on belt")
    reason = "transform 'belt': move 1 follows it: move elsewhere, or stop, before removing it"
    with pytest.raises(ProgramError, match=reason):
        program.remove("belt")
    program.move("a", "slow")
    program.finish()
    program.remove("belt")


def test_after_a_stop_nothing_keeps_its_names(program: Program) -> None:
    program.move("a", "slow")
    program.move("b", "slow")
    program.run(20)
    program.motion.handle(StopRequest())
    with pytest.raises(ProgramError, match="position 'b': move 2 is to be made with it"):
        program.remove("b", "position")
    program.finish()
    program.remove("b", "position")
    program.remove("a", "position")


def test_a_program_that_names_each_pick_goes_on_for_ever(program: Program) -> None:
    for number in range(150):
        name = f"pick {number}"
        program.place(name, 0.001 * (number % 5), 0.0, 0.01)
        program.move(name, "fast")
        program.finish()
        program.remove(name, "position")
        program.remove(name, "transform")
    motion = program.motion
    assert motion.world.names().sizes == {"transform": 3, "position": 3, "mode": 2}
    assert len(motion._moves._moves) <= 2


# --- properties ----------------------------------------------------------------------------------

values = st.floats(-0.03, 0.03)
places = st.tuples(values, values, values)
names = st.sampled_from("abc")
modes = st.sampled_from(["joint", "straight", "curved", "long"])
requests = st.lists(st.tuples(names, modes), min_size=1, max_size=4)
DEFINED: dict[str, tuple[float, float, float]] = {
    "a": (0.0, 0.0, 0.02),
    "b": (0.0, 0.01, 0.04),
    "c": (0.01, 0.0, 0.0),
}


def defined(**again: tuple[float, float, float]) -> Program:
    """A program with three places, those of ``again`` elsewhere, and a mode of each sort."""
    program = Program()
    for name, place in {**DEFINED, **again}.items():
        program.place(name, *place)
    program.mode("joint", 0.4, interpolation="joint")
    program.mode("straight", 0.4)
    program.mode("curved", 0.5, transition="cartesian")
    program.motion.handle(ModeMessage("long", "cartesian", 0.1, speed=0.2, lengthen=True))
    return program


def asked(program: Program, moves: list[tuple[str, str]]) -> None:
    for position, mode in moves:
        try:
            program.move(position, mode)
        except MoveError:
            continue


def course(program: Program) -> list[CartesianSetpoint]:
    program.finish()
    return program.setpoints


@settings(max_examples=40, deadline=None)
@given(requests, names, places, st.integers(1, 60))
def test_accepted_moves_are_those_asked_for_with_the_new_definitions(
    moves: list[tuple[str, str]],
    name: str,
    place: tuple[float, float, float],
    cycles: int,
) -> None:
    """One move is under way; the others are asked for, and then what they go to is redefined."""
    redefined, twin = defined(), defined()
    for program in (redefined, twin):
        program.place("first", 0.0, 0.0, 0.03)
        program.move("first", "straight")
        program.run(cycles)
    asked(redefined, moves)
    accepted = [
        (move.request.position, move.request.mode)
        for k, move in redefined.motion._moves._moves.items()
        if k > 1
    ]
    try:
        redefined.transform(name, *place)
    except MoveError:
        return
    twin.transform(name, *place)
    for move in accepted:
        twin.move(*move)
    assert course(redefined) == course(twin)


@settings(max_examples=40, deadline=None)
@given(requests, names, st.sampled_from(["far", "short", "sudden", "guarded"]), st.integers(1, 90))
def test_a_refused_redefinition_leaves_every_setpoint_as_it_was(
    moves: list[tuple[str, str]], name: str, how: str, cycles: int
) -> None:
    redefine: dict[str, Callable[[Program], object]] = {
        "far": lambda program: program.transform(name, FAR),
        "short": lambda program: program.mode("straight", 0.15),
        "sudden": lambda program: program.mode("joint", 0.4, acceleration_time=0.35),
        "guarded": lambda program: program.mode("curved", 0.5, stop_on_force={"fz": 10.0}),
    }
    refused, twin = defined(), defined()
    for program in (refused, twin):
        asked(program, moves)
        program.run(cycles)
    kept = plans(refused)
    try:
        redefine[how](refused)
    except MoveError:
        assert plans(refused) == kept
        assert course(refused) == course(twin)
        asked(refused, moves)
        asked(twin, moves)
        assert course(refused) == course(twin)
