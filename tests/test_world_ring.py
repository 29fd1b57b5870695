"""Rings: T6, tool and compliance frame out of any equation, against plain matrix algebra."""

import math
import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.errors import EquationError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import WorldModel
from rfms_can.master.world.ring import Chain, Ring
from rfms_can.messages import T6, Linear, PositionMessage, TransformMessage
from rfms_can.transform import Transform

Matrix = npt.NDArray[np.float64]

OWN = Configuration(True, False, True)
PERIOD_S = 0.004
NAMES = "abcdefgh"
KINDS = ("value", "reference", "functional")


@st.composite
def rigid(draw: Callable[[st.SearchStrategy[float]], float]) -> Transform:
    turn = [draw(st.floats(-math.pi, math.pi)) for _ in range(3)]
    place = [draw(st.floats(-1.0, 1.0)) for _ in range(3)]
    return Transform.translation(*place) @ Transform.rpy(*turn)


class Drawn(NamedTuple):
    """An equation with values and kinds for its transforms."""

    message: PositionMessage
    values: dict[str, Transform]
    kinds: dict[str, str]

    def world(self, *, kinds: bool) -> WorldModel:
        world = WorldModel(OWN, PERIOD_S)
        for name, value in self.values.items():
            kind = self.kinds[name] if kinds else "value"
            function = Linear() if kind == "functional" else None
            world.define_transform(TransformMessage(name, value, kind, function))  # type: ignore[arg-type]
        return world

    def product(self, names: list[str], t6: Matrix) -> Matrix:
        matrix = np.eye(4)
        for name in names:
            matrix = matrix @ (t6 if name == T6 else as_matrix(self.values[name]))
        return matrix


@st.composite
def equations(draw: Callable[..., object]) -> Drawn:
    """T6 anywhere, up to three transforms around it, and one to four on the other side."""
    before = draw(st.lists(st.sampled_from(NAMES), max_size=3))
    after = draw(st.lists(st.sampled_from(NAMES), max_size=3))
    other = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=4))
    assert isinstance(before, list) and isinstance(after, list) and isinstance(other, list)
    with_t6 = [*before, T6, *after]
    sides = (with_t6, other) if draw(st.booleans()) else (other, with_t6)
    tool = after[0] if after and draw(st.booleans()) else None
    every = [*before, *after, *other]
    once = [name for name in every if every.count(name) == 1]
    comply = draw(st.sampled_from([None, T6, *once]))
    assert comply is None or isinstance(comply, str)
    values = {name: draw(rigid()) for name in NAMES}
    kinds = {name: draw(st.sampled_from(KINDS)) for name in NAMES}
    return Drawn(PositionMessage("p", *sides, tool, comply), values, kinds)  # type: ignore[arg-type]


def as_matrix(transform: Transform) -> Matrix:
    return np.array([*transform.rows(), [0.0, 0.0, 0.0, 1.0]])


@given(equations())
def test_t6_of_the_ring_satisfies_the_equation(drawn: Drawn) -> None:
    message = drawn.message
    position = drawn.world(kinds=True).define_position(message)
    t6 = as_matrix(position.goal.pose(Moment(3, 0.4, 0.2)))
    left, right = drawn.product(message.left, t6), drawn.product(message.right, t6)
    assert left == pytest.approx(right, abs=1e-11)


@given(equations())
def test_all_kinds_solve_alike_and_values_alone_are_constant(drawn: Drawn) -> None:
    here = Moment(3, 0.4, 0.2)
    goal = drawn.world(kinds=True).define_position(drawn.message).goal
    fixed = drawn.world(kinds=False).define_position(drawn.message).goal
    used = {*drawn.message.left, *drawn.message.right} - {T6}
    assert fixed.constant
    assert goal.constant == all(drawn.kinds[name] == "value" for name in used)
    for mine, theirs in (
        (goal.left(here), fixed.left(here)),
        (goal.right(here), fixed.right(here)),
        (goal.pose(here), fixed.pose(here)),
        (goal.left(here) @ goal.right(here), fixed.pose(here)),
    ):
        assert mine == pytest.approx(theirs, abs=1e-12)


@given(equations())
def test_the_ring_is_closed_and_may_be_walked_either_way(drawn: Drawn) -> None:
    """Over the tool it is the inverse of a product, over the base the product of inverses."""
    ring = Ring(drawn.message, dict(drawn.values))
    here = Moment(0)
    t6 = Chain(ring.backwards(0)).at(here)
    assert Chain(ring.forwards(len(ring.links))).at(here).inverse() == pytest.approx(t6, abs=1e-11)
    for place in range(len(ring.links) + 1):
        over_tool = t6 @ Chain(ring.forwards(place)).at(here)
        assert Chain(ring.backwards(place)).at(here) == pytest.approx(over_tool, abs=1e-11)


@given(equations())
def test_the_tool_runs_straight_and_the_compliance_frame_keeps_its_place(drawn: Drawn) -> None:
    message = drawn.message
    position = drawn.world(kinds=True).define_position(message)
    here = Moment(3, 0.4, 0.2)
    own, other = message.left, message.right
    if T6 in other:
        own, other = other, own
    place = own.index(T6)
    tools = own[place + 1 :] if message.tool is None else [message.tool]
    tool = drawn.product(tools, np.eye(4))
    assert as_matrix(position.goal.right(here)) @ tool == pytest.approx(np.eye(4), abs=1e-12)

    pose = position.goal.pose(here)
    t6 = as_matrix(pose)
    base = t6 @ as_matrix(position.compliance_frame(here, pose))
    expected = t6 @ tool
    if message.compliance is not None:
        side = own if message.compliance in own else other
        both_begin = np.linalg.inv(drawn.product(own[:place], t6))  # seen from the base of T6
        expected = both_begin @ drawn.product(side[: side.index(message.compliance) + 1], t6)
    assert base == pytest.approx(expected, abs=1e-11)


def test_links_are_multiplied_where_values_stand_together_and_kept_until_one_changes() -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name in "abcd":
        world.define_transform(TransformMessage(name, Transform.translation(0.1, 0.2, 0.3)))
    world.define_transform(TransformMessage("seen", Transform.identity(), "reference"))
    goal = world.define_position(PositionMessage("p", ["a", T6, "b"], ["c", "seen", "d"])).goal
    first = goal.pose(Moment(0))
    assert goal.pose(Moment(1)) is first
    assert goal.left(Moment(2)) is goal.left(Moment(1))
    world.define_transform(TransformMessage("seen", Transform.identity(), "reference"), 3)
    assert goal.pose(Moment(3)) is first  # observed where it is
    world.define_transform(
        TransformMessage("seen", Transform.translation(0.0, 0.0, 1.0), "reference"), 4
    )
    assert goal.pose(Moment(4)).pz == pytest.approx(first.pz + 1.0)


def test_the_lever_of_a_reference_reaches_to_the_tool_and_from_the_tools_side_to_t6() -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name, x in (("tool", 0.1), ("grip", 0.03), ("far", 2.0), ("back", 0.25)):
        world.define_transform(TransformMessage(name, Transform.translation(x, 0.0, 0.0)))
    at_part = Transform.translation(0.7, 0.0, 0.0)
    for name in ("part", "hand"):
        world.define_transform(TransformMessage(name, at_part, "reference"))
    equation = PositionMessage("p", [T6, "hand", "tool"], ["far", "part", "back"])
    position = world.define_position(equation)
    assert position.levers(Moment(0)) == pytest.approx({"part": 0.25, "hand": 0.7})
    turned = PositionMessage("q", ["part", T6, "tool"], ["far"], "tool")
    levers = world.define_position(turned).levers(Moment(0))
    assert levers == pytest.approx({"part": 2.0 - 0.7})


def test_a_position_knows_what_it_uses() -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name in "abc":
        world.define_transform(TransformMessage(name, Transform.identity()))
    position = world.define_position(PositionMessage("p", ["a", T6], ["b"]))
    assert [position.uses(name) for name in ("a", "b", "c", T6)] == [True, True, False, False]


@pytest.mark.parametrize(
    ("compliance", "times"), [("b", 2), ("c", 0), ("nothing", 0)], ids=["twice", "else", "unknown"]
)
def test_a_compliance_frame_stands_in_the_equation_once(compliance: str, times: int) -> None:
    world = WorldModel(OWN, PERIOD_S)
    for name in "abc":
        world.define_transform(TransformMessage(name, Transform.identity()))
    reason = f"position 'p': compliance '{compliance}' must stand in the equation once, it stands "
    message = PositionMessage("p", [T6, "a", "b"], ["b"], compliance=compliance)
    with pytest.raises(EquationError, match=re.escape(f"{reason}{times} times")):
        world.define_position(message)
