"""Tasks of the task level drawn at random, pasted as programs, and links that answer them."""

import asyncio
import inspect
import math
from collections.abc import Awaitable
from typing import Any

from hypothesis import strategies as st

from rfms_can.coordinator import (
    Arm,
    AsyncArm,
    Expression,
    Outcome,
    ProgramError,
    Transform,
)
from rfms_can.messages import Answer, AnyCondition, Message, MoveOutcome, Status
from rfms_can.task import (
    Comply,
    Follow,
    Frame,
    Insertion,
    Lock,
    Move,
    Sleep,
    Tare,
    Task,
    Touch,
    approach,
    depart,
    follow,
    grip,
    guarded_approach,
    insert,
    release,
)
from support.link import FakeLink

PEG = Frame("peg", Transform.translation(0.0, 0.0, 0.16))
HELD_AT = Transform.translation(0.3, 0.2, 0.1)
"""T6 of a ``FakeLink``."""


def hole_at(depth: float) -> Frame:
    """A hole in which the peg of a ``FakeLink`` is so deep, m."""
    return Frame("hole", HELD_AT @ PEG.values["peg"] @ Transform.translation(0.0, 0.0, -depth))


def pasted(task: Task, arm: Arm, **names: Any) -> None:
    """Run what a task prints."""
    known = {
        "arm": arm,
        "math": math,
        "Expression": Expression,
        "Outcome": Outcome,
        "ProgramError": ProgramError,
        "Transform": Transform,
    }
    exec(compile(str(task), "pasted task", "exec"), {**known, **names})


class AsyncFakeLink:
    """A ``FakeLink`` for coroutines: what is asked of it, one after the other.

    Attributes:
        link: that answers.
    """

    def __init__(self, link: FakeLink) -> None:
        self.link = link

    def status(self) -> Status:
        return self.link.status()

    def time(self) -> float:
        return self.link.time()

    async def request(self, message: Message) -> Answer:
        await asyncio.sleep(0)
        return self.link.request(message)

    async def wait(self, *any_of: AnyCondition) -> None:
        self.link.wait(*any_of)

    async def outcomes(self, first: int, last: int) -> list[MoveOutcome]:
        return self.link.outcomes(first, last)

    async def run(self, *parts: Awaitable[Any]) -> list[Any]:
        return [await part for part in parts]


def run_async(task: Task, link: FakeLink, **how: bool) -> Any:
    """Run a task as a program of coroutines."""
    arm = AsyncArm(AsyncFakeLink(link))
    ran = task.run_async(arm, **how)
    assert inspect.iscoroutine(ran)
    return asyncio.run(ran)


# --- at random -----------------------------------------------------------------------------------

NAMES = st.sampled_from(["part", "class", "2 mm off", "über", "arm", "a{b}", 'a "b"', "a-b", "a_b"])
_LENGTHS = st.floats(-0.5, 0.5)
_ANGLES = st.floats(-math.pi, math.pi) | st.sampled_from([math.pi, -math.pi, 0.5 * math.pi])
_AXES = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, -2.0, 0.5)])
TRANSLATIONS = st.builds(Transform.translation, _LENGTHS, _LENGTHS, _LENGTHS)
ROTATIONS = st.builds(Transform.rotation, _AXES, _ANGLES)
TRANSFORMS = (
    TRANSLATIONS | ROTATIONS | st.builds(lambda p, r: p @ r, TRANSLATIONS, ROTATIONS | ROTATIONS)
)
OFFSETS = st.tuples(_LENGTHS, _LENGTHS, st.floats(0.01, 0.5))
SPEEDS = st.floats(1e-3, 0.2)
BIASES = st.dictionaries(
    st.sampled_from(["fx", "fy", "rx", "ry", "rz"]), st.floats(-9.0, 9.0), min_size=1
)
BOUNDS = st.dictionaries(st.sampled_from(["fx", "fz", "rz"]), st.floats(0.1, 99.0), min_size=1)


@st.composite
def places(draw: st.DrawFn, number: int) -> Frame:
    """A frame, alone or in a product with others, some of which are the program's."""
    frame: Frame = Frame(f"{draw(NAMES)} {number}", draw(TRANSFORMS))
    if draw(st.booleans()):
        frame = Expression(draw(NAMES)) @ frame
    if draw(st.booleans()):
        frame = frame @ Frame(f"{draw(NAMES)} {number}'", draw(TRANSFORMS))
    return frame


@st.composite
def motions(draw: st.DrawFn, number: int) -> Task:
    """One primitive, named by a number."""
    tool, frame, name = draw(places(2 * number)), draw(places(2 * number + 1)), f"m{number}"
    kind = draw(st.sampled_from(["approach", "depart", "guarded", "insert", "follow"]))
    by, speed, wait = draw(OFFSETS), draw(SPEEDS), draw(st.booleans())
    match kind:
        case "approach":
            far = {"segment_time": draw(SPEEDS), "mass_centre": (0.0, 0.0, draw(_LENGTHS))}
            return approach(
                tool,
                frame,
                by=by,
                speed=speed,
                far=far,
                config="left up flip",
                wait=wait,
                name=name,
            )
        case "depart":
            yields = draw(st.none() | BIASES)
            return depart(tool, frame, by=by, speed=speed, comply=yields, wait=wait, name=name)
        case "guarded":
            bounds, tare = draw(BOUNDS), draw(st.booleans())
            return guarded_approach(tool, frame, force=bounds, by=by, tare=tare, name=name)
        case "insert":
            depth = draw(st.floats(0.01, 0.1))
            return insert(
                PEG,
                hole_at(depth),
                depth,
                chamfer=0.1 * depth,
                guided=0.7 * depth,
                force=draw(st.none() | BOUNDS),
                at_mouth=draw(BIASES),
                name=name,
            )
        case _:
            return follow(
                tool, frame, duration=draw(st.floats(0.0, 0.2)), keep=draw(st.booleans()), name=name
            )


@st.composite
def tasks(draw: st.DrawFn) -> Task:
    """A few motions after one another, and single steps between them."""
    first = draw(motions(0))
    between: list[Task] = draw(
        st.lists(
            st.sampled_from(
                [
                    grip(0.5),
                    release(),
                    Task("x", (Tare(),)),
                    Task("x", (Sleep(0.1),)),
                    Task("x", (Comply({"fx": 0.0, "rz": 1.0}), Lock("rz"))),
                ]
            ),
            max_size=2,
        )
    )
    task = first
    for other in between:
        task = task + other
    if draw(st.booleans()) and not _inserts_twice(first, second := draw(motions(1))):
        task = task + second
    return task.named(draw(NAMES))


def _inserts_twice(first: Task, second: Task) -> bool:
    return "hole" in first.scope.values and "hole" in second.scope.values


def guards_of(task: Task) -> dict[int, tuple[Outcome, str]]:
    """What a ``FakeLink`` has to tell of moves that must end on contact."""
    numbers, number = {}, 0
    for step in task.steps:
        if isinstance(step, Insertion):
            number += len(step.legs)
        elif isinstance(step, Move | Touch | Follow):
            number += 1
            if isinstance(step, Touch):
                numbers[number] = (Outcome.GUARDED, "fz 11 N reached 10 N")
            number += isinstance(step, Follow) and step.rest is not None
    return numbers
