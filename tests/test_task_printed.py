"""What a task prints is what it does: pasted into a program it asks for the same."""

import keyword
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.link import FakeLink
from support.tasks import PEG, TRANSFORMS, guards_of, hole_at, pasted, run_async, tasks

from rfms_can.coordinator import Arm, Expression, ProgramError, Transform
from rfms_can.messages import ModeMessage, PositionMessage, RemoveRequest, TransformMessage
from rfms_can.task import (
    GUIDED,
    Comply,
    Frame,
    Lock,
    Tare,
    Task,
    depart,
    follow,
    grip,
    guarded_approach,
    insert,
    release,
)
from rfms_can.task.frames import Scope
from rfms_can.task.words import Words, transform_words

DOWN = Transform.rotation((0.0, 1.0, 0.0), math.pi)


def answering(task: Task) -> FakeLink:
    link = FakeLink()
    link.ended = guards_of(task)
    return link


KINDS: dict[type, str] = {
    TransformMessage: "transform",
    PositionMessage: "position",
    ModeMessage: "mode",
}


# --- properties ----------------------------------------------------------------------------------


@given(task=tasks())
def test_a_task_pasted_asks_for_what_it_asks_for_when_it_runs(task: Task) -> None:
    ran, said = answering(task), answering(task)
    task.run(Arm(ran), keep=True)
    pasted(task, Arm(said))
    assert ran.heard == said.heard
    assert ran.now == said.now


@given(task=tasks())
def test_the_async_twin_asks_for_the_same_and_reports_the_same(task: Task) -> None:
    one, other = answering(task), answering(task)
    assert task.run(Arm(one)) == run_async(task, other)
    assert one.heard == other.heard


@given(task=tasks())
def test_what_a_task_defines_is_all_that_it_removes_users_first(task: Task) -> None:
    link = answering(task)
    task.run(Arm(link))
    defined = {
        (KINDS[type(message)], message.name)
        for message in link.heard
        if isinstance(message, TransformMessage | PositionMessage | ModeMessage)
    }
    removed = [(m.what, m.name) for m in link.heard if isinstance(m, RemoveRequest)]
    assert {*removed} == defined
    assert len(removed) == len(defined)
    assert all(name.startswith(f"{task.name}/") for _, name in removed)
    kinds = [kind for kind, _ in removed]
    assert kinds == sorted(kinds, key=("position", "mode", "transform").index)
    link.heard.clear()
    task.run(Arm(answering(task)))  # and again


@given(value=TRANSFORMS | st.builds(lambda a, b: a @ b, TRANSFORMS, TRANSFORMS))
def test_a_transform_is_printed_so_that_it_is_the_same_again(value: Transform) -> None:
    words = transform_words(value)
    assert eval(words, {"Transform": Transform, "math": math}) == value


@given(names=st.lists(st.text(min_size=1), unique=True, min_size=1))
def test_variables_are_distinct_identifiers(names: list[str]) -> None:
    words = Words(Scope("task", {}))
    variables = [words.variable(kind, name) for name in names for kind in ("transform", "mode")]
    assert all(word.isidentifier() and not keyword.iskeyword(word) for word in variables)
    assert len({*variables}) == len(variables)
    assert not {"arm", "Transform", "math"} & {*variables}


def test_a_name_that_a_printed_task_needs_itself_is_not_taken() -> None:
    words = Words(Scope("task", {}))
    needed = re.findall(r"[A-Za-z]+", f"{TOUCH} {INSERTED} {FOLLOWED}")
    uses = {"arm", "math", "here", "number", "travelled", "goal", "mode", "depth", "mouth", "end"}
    uses |= {"ends", "until", "look", "Transform", "Expression", "Outcome", "ProgramError"}
    assert uses <= {*needed}
    assert not uses & {words.variable("transform", name) for name in uses}


# --- golden printouts ----------------------------------------------------------------------------

TOUCH = """\
tip = arm.transform("touch/tip", Transform.translation(0.0, 0.0, 0.16))
plate = arm.transform("touch/plate", Transform.rotation((0.0, 1.0, 0.0), math.pi))
back = arm.transform("touch/guarded approach plate: back", Transform.translation(0.0, 0.0, -0.02))
over = arm.position("touch/guarded approach plate: over", arm.t6 @ tip == plate @ back)
through = arm.transform(
    "touch/guarded approach plate: through",
    Transform.translation(0.0, 0.0, 0.01),
)
beyond = arm.position("touch/guarded approach plate: beyond", arm.t6 @ tip == plate @ through)
far = arm.mode(
    "touch/guarded approach plate: far",
    acceleration_time=0.25,
    lengthen=True,
    segment_time=1.5,
    mass=0.4,
)
feel = arm.mode(
    "touch/guarded approach plate: feel",
    speed=0.01,
    acceleration_time=0.1,
    interpolation="cartesian",
    stop_on_force={"fz": 10.0},
)
arm.wait(arm.move(over, far))
arm.tare()
here = arm.pose
number = arm.move(beyond, feel)
arm.wait(number)
travelled = math.hypot(*(here.inverse() @ arm.pose).apply((0.0, 0.0, 0.0)))
if arm.outcome(number).how is not Outcome.GUARDED:
    raise ProgramError(
        "guarded approach plate: no contact after {:.1f} mm, the end of its guarded move: \
is the part there? give a larger at_most, or a smaller force".format(1e3 * travelled),
    )"""

INSERTED = """\
arm.comply("fx rz", 0.0, 1.0)
mouth = Transform.rotation((0.0, 1.0, 0.0), math.pi)
end = Transform.translation(0.0, 0.0, 0.16)
for goal, mode in (
    (entered, enter),
    (guided, slide),
    (bottom, finish),
):
    number = arm.move(goal, mode)
    arm.wait(number)
    depth = (mouth.inverse() @ arm.pose @ end).pz
    if arm.outcome(number).how is not Outcome.MADE:
        raise ProgramError(
            "insert hole: {:.1f} of 40 mm deep: {}".format(1e3 * depth, arm.outcome(number).reason),
        )
if depth < 0.039:
    raise ProgramError(
        "insert hole: {:.1f} of 40 mm deep: {}".format(1e3 * depth, "it goes no further"),
    )
arm.gripper.open(1.0)
number = arm.move(away, leave)
arm.lock("fx rz")
arm.wait(number)"""

FOLLOWED = """\
belt = Expression("belt")
tip = arm.transform("ride/tip", Transform.translation(0.0, 0.0, 0.16))
off = arm.transform("ride/follow belt: off", Transform.translation(0.0, 0.0, -0.1))
at = arm.position("ride/follow belt: at", arm.t6 @ tip == belt @ off)
join = arm.mode(
    "ride/follow belt: join",
    segment_time=0.7,
    acceleration_time=0.3,
    interpolation="cartesian",
)
stopped = arm.transform("ride/follow belt: stopped", Transform.translation(0.0, 0.0, 0.0))
rest = arm.position("ride/follow belt: rest", arm.t6 == stopped)
halt = arm.mode("ride/follow belt: halt", segment_time=0.4, acceleration_time=0.1)
until = gripped
look = camera
number = arm.move(at, join)
while arm.status.completed < number:
    arm.sleep(0.02)
    look(arm)
arm.wait(number)
ends = arm.time + 0.4
while arm.time < ends and not until(arm):
    arm.sleep(0.02)
    look(arm)
arm.stop()
arm.transform("ride/follow belt: stopped", arm.pose)
arm.wait(arm.move(rest, halt))"""


def test_a_guarded_approach_is_printed() -> None:
    tip = Frame("tip", Transform.translation(0.0, 0.0, 0.16))
    task = guarded_approach(
        tip,
        Frame("plate", DOWN),
        force={"fz": 10},
        by=(0, 0, -0.02),
        at_most=0.03,
        far={"segment_time": 1.5, "mass": 0.4},
        tare=True,
    )
    assert str(task.named("touch")) == TOUCH


def test_an_insertion_and_single_steps_are_printed() -> None:
    hole = Frame("hole", DOWN)
    task = (
        Task("assembly", (Comply({"fx": 0.0, "rz": 1.0}),))
        + insert(PEG, hole, 0.04, chamfer=0.006, guided=0.028)
        + release()
        + depart(PEG, hole, comply=GUIDED, wait=False)
        + Task("lock", (Lock("fx rz"),))
    )
    assert str(task).endswith(f"\n{INSERTED}")


def gripped(arm: Arm) -> bool:
    return arm.time > 3.0


def camera(arm: Arm) -> None:
    arm.observe("belt", Transform.translation(0.0, arm.time, 0.0), at=arm.time)


def observing(link: FakeLink) -> Arm:
    """The arm of a program that has defined the belt."""
    arm = Arm(link)
    arm.reference("belt", Transform.identity())
    return arm


def test_following_is_printed_and_the_functions_are_the_programs_own() -> None:
    tip = Frame("tip", Transform.translation(0.0, 0.0, 0.16))
    belt = Expression("belt")
    task = follow(tip, belt, by=(0.0, 0.0, -0.1), duration=0.4, until=gripped, look=camera)
    task = task.named("ride")
    assert str(task) == FOLLOWED
    ran, said = FakeLink(), FakeLink()
    task.change("join", segment_time=0.5).run(observing(ran), keep=True)
    pasted(task.change("join", segment_time=0.5), observing(said), gripped=gripped, camera=camera)
    assert ran.heard == said.heard
    assert sum(isinstance(message, TransformMessage) for message in ran.heard) > 40


@pytest.mark.parametrize(
    ("task", "told"),
    [
        (
            guarded_approach(PEG, hole_at(0.0), force={"fz": 10.0}, name="{touch}"),
            "{touch}: no contact after 0.0 mm",
        ),
        (
            insert(PEG, hole_at(0.02), 0.04, chamfer=0.006, guided=0.028),
            "insert hole: 20.0 of 40 mm deep: it goes no further",
        ),
    ],
)
def test_a_pasted_task_says_what_it_says_when_it_runs(task: Task, told: str) -> None:
    for does in (task.run, lambda arm: pasted(task, arm)):
        with pytest.raises(ProgramError, match=re.escape(told)):
            does(Arm(FakeLink()))


def test_only_what_is_used_of_the_program_is_named() -> None:
    task = grip(0.4) + Task("x", (Tare(),))
    assert str(task) == "arm.gripper.close(0.4)\narm.tare()"
