"""Symbol tables: transforms by kind, what a redefinition does, and every refusal."""

import contextlib
import math
import re
from typing import Any, Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260
from rfms_can.errors import EquationError, ModeError, ProgramError, TransformError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import JointPosition, Limits, WorldModel
from rfms_can.messages import (
    T6,
    JointPositionMessage,
    Linear,
    ModeMessage,
    PositionMessage,
    TransformMessage,
)
from rfms_can.transform import Transform

OWN = Configuration(True, False, True)
PERIOD_S = 0.004
UP = Linear((0.0, 0.0, 1.0))
ACROSS = Linear((0.0, 1.0, 0.0), parameter="t")


def shift(x: float) -> Transform:
    return Transform.translation(x, 0.0, 0.0)


@pytest.fixture
def world() -> WorldModel:
    world = WorldModel(OWN, PERIOD_S)
    world.define_transform(TransformMessage("fixed", shift(0.1)))
    world.define_transform(TransformMessage("seen", shift(0.2), "reference"))
    world.define_transform(TransformMessage("curve", shift(0.3), "functional", UP))
    return world


def to(*right: str, name: str = "p") -> PositionMessage:
    return PositionMessage(name, [T6], list(right))


# --- kinds ---------------------------------------------------------------------------------------


def test_a_value_that_is_redefined_acts_where_a_position_is_bound_later(world: WorldModel) -> None:
    before = world.define_position(to("fixed")).goal
    world.define_transform(TransformMessage("fixed", shift(0.5)))
    after = world.position("p").goal
    assert [goal.pose(Moment(9)).px for goal in (before, after)] == [0.1, 0.5]


def test_a_value_beside_a_reference_is_the_one_it_was_bound_to_too(world: WorldModel) -> None:
    goal = world.define_position(to("seen", "fixed")).goal
    world.define_transform(TransformMessage("fixed", shift(0.5)))
    world.define_transform(TransformMessage("seen", shift(0.3), "reference"), 4)
    assert goal.pose(Moment(4)).px == pytest.approx(0.4)


def test_a_reference_that_is_redefined_acts_on_the_goal_under_way(world: WorldModel) -> None:
    goal = world.define_position(to("seen")).goal
    assert goal.pose(Moment(3)).px == 0.2
    world.define_transform(TransformMessage("seen", shift(0.6), "reference"), 4)
    assert goal.pose(Moment(4)).px == 0.6


def test_a_reference_serves_all_its_positions(world: WorldModel) -> None:
    goals = [
        world.define_position(to("seen")).goal,
        world.define_position(PositionMessage("q", [T6, "seen"], ["fixed"])).goal,
    ]
    world.define_transform(TransformMessage("seen", shift(0.6), "reference"), 4)
    assert [goal.pose(Moment(4)).px for goal in goals] == pytest.approx([0.6, 0.1 - 0.6])


def test_a_function_is_right_of_its_rows_and_of_the_parameter_it_names(world: WorldModel) -> None:
    turned = Transform.rotation((1.0, 0.0, 0.0), math.pi / 2) @ shift(0.1)
    world.define_transform(TransformMessage("seam", turned, "functional", ACROSS))
    goal = world.define_position(to("seam")).goal
    expected = turned @ Transform.translation(0.0, 0.7, 0.0)
    assert goal.pose(Moment(0, 0.2, 0.7)) == pytest.approx(expected)
    lift = world.define_position(to("curve", name="q")).goal
    assert lift.pose(Moment(0, 0.2, 0.7)) == pytest.approx(Transform.translation(0.3, 0.0, 0.2))
    assert not lift.constant


def test_a_function_that_is_redefined_acts_where_a_position_is_bound_later(
    world: WorldModel,
) -> None:
    bound = world.define_position(to("curve"))
    promised = bound.goal
    assert world.position("p") is bound
    world.define_transform(TransformMessage("curve", shift(0.4), "functional", ACROSS))
    here = Moment(0, 0.5, 0.25)
    assert promised.pose(here) == pytest.approx(Transform.translation(0.3, 0.0, 0.5))
    position = world.position("p")
    assert position.goal.pose(here) == pytest.approx(Transform.translation(0.4, 0.25, 0.0))
    assert position.compliance_frame(here, Transform.identity()) == Transform.identity()


def test_names_are_listed_by_kind(world: WorldModel) -> None:
    world.define_position(to("seen"))
    world.define_mode(ModeMessage("slow", "joint", 0.2, 2.0))
    names = world.names()
    kinds = {"fixed": "value", "seen": "reference", "curve": "functional"}
    assert (names.transforms, names.positions, names.modes) == (kinds, ["p"], ["slow"])


# --- refusals ------------------------------------------------------------------------------------

NOW = 500
"""Tick of the refused definitions: 2 s."""


@pytest.mark.parametrize(
    ("name", "fields", "reason"),
    [
        ("fixed", {"kind": "reference"}, " is of kind value and stays so, reference was requested"),
        ("seen", {}, " is of kind reference and stays so, value was requested; use another name, "),
        ("curve", {}, " is of kind functional and stays so, value was requested"),
        ("new", {"kind": "functional"}, ": of kind functional with no function"),
        ("new", {"function": UP}, ": of kind value with a function"),
        ("seen", {"kind": "reference", "function": UP}, ": of kind reference with a function"),
        ("new", {"stamp": 2.0}, ": of kind value with a twist, a stamp, a prediction"),
        ("new", {"twist": (0.0,) * 6}, ": of kind value with a twist, a stamp, a prediction"),
        ("new", {"predict": "velocity"}, ": of kind value with a twist, a stamp, a prediction"),
        ("new", {"rest_after": 0.5}, ": of kind value with a twist, a stamp, a prediction"),
        (T6, {}, " is the arm itself and cannot be defined"),
        ("new", {"rows": shift(math.nan)}, " is not a rotation: off by inf, 1e-06 may be"),
        ("new", {"rows": shift(0.0)._replace(nx=1.1)}, " is not a rotation: off by 0.1"),
        ("new", {"rows": shift(1e4)}, ": its origin has 10000, outside +-1000"),
        (
            "new",
            {"kind": "functional", "function": Linear((math.nan, 0.0, 0.0))},
            ": along has nan",
        ),
    ],
)
def test_transforms_that_are_refused(
    world: WorldModel, name: str, fields: dict[str, Any], reason: str
) -> None:
    kept = world.names()
    goal = world.define_position(to("seen", "curve")).goal
    before = goal.pose(Moment(NOW))
    message = TransformMessage(name, **{"rows": shift(0.7), **fields})
    with pytest.raises(TransformError, match=re.escape(f"transform '{name}'{reason}")):
        world.define_transform(message, NOW)
    assert world.names().transforms == kept.transforms
    assert goal.pose(Moment(NOW)) == before


def test_four_digits_are_refused_with_a_remedy_that_works(world: WorldModel) -> None:
    printed = Transform(*(round(x, 4) for x in Transform.rpy(0.3, -0.5, 0.7)))
    offered = r"Transform\.nearest_rotation\(\.\.\.\)\.transform, .* by 3.3e-05 at most"
    with pytest.raises(TransformError, match=offered):
        world.define_transform(TransformMessage("new", printed), NOW)
    squared = Transform.nearest_rotation(printed).transform
    world.define_transform(TransformMessage("new", squared), NOW)
    with pytest.raises(TransformError) as refused:
        world.define_transform(TransformMessage("new", printed._replace(nx=-1.0)), NOW)
    assert "nearest_rotation" not in str(refused.value)


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"stamp": math.nan}, "its stamp nan is not a time"),
        ({"stamp": -math.inf}, "its stamp -inf is not a time"),
        ({"stamp": 2.0041}, "its stamp 2.0041 s is 0.0041 s in the future, 0.004 s may be"),
        ({"stamp": 0.999}, "its stamp 0.999 s is 1 s old, 1 s may be"),
        ({"stamp": -1e300}, "old, 1 s may be"),
        ({"twist": (0.0, 0.0, math.nan, 0.0, 0.0, 0.0)}, "its twist has nan, outside +-100"),
        ({"twist": (0.0, 0.0, 0.0, 0.0, 0.0, -101.0)}, "its twist has -101, outside +-100"),
    ],
)
@pytest.mark.parametrize("name", ["seen", "new"])
def test_observations_that_are_refused(
    world: WorldModel, name: str, fields: dict[str, Any], reason: str
) -> None:
    kept = world.names()
    message = TransformMessage(name, shift(0.7), "reference", **fields)
    with pytest.raises(TransformError, match=f"transform '{name}': .*{re.escape(reason)}"):
        world.define_transform(message, NOW)
    assert world.names().transforms == kept.transforms
    assert world.define_position(to("seen")).goal.pose(Moment(NOW)).px == 0.2


@pytest.mark.parametrize("stamp", [1.0, 1.999, 2.0, 2.004])
def test_observations_at_the_bounds_are_taken(world: WorldModel, stamp: float) -> None:
    message = TransformMessage("seen", shift(0.7), "reference", stamp=stamp)
    world.define_transform(message, NOW)
    assert world.define_position(to("seen")).goal.pose(Moment(NOW)).px == 0.7


def test_tables_hold_so_many_and_redefinitions_need_no_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module, size, most in (
        ("transforms", "MAX_TRANSFORMS", 70),
        ("transforms", "MAX_LIVE", 5),
        ("model", "MAX_POSITIONS", 60),
        ("model", "MAX_MODES", 50),
    ):
        monkeypatch.setattr(f"rfms_can.master.world.{module}.{size}", most)
    world = WorldModel(OWN, PERIOD_S)
    for k in range(5):
        world.define_transform(TransformMessage(f"r{k}", shift(0.1), "reference"))
        world.define_transform(TransformMessage(f"c{k}", shift(0.1), "functional", UP))
    world.define_transform(TransformMessage("c1", shift(0.2), "functional", ACROSS))
    way_out = "define one of them again, or remove what nothing uses"
    reason = f"transform 'more' is one too many: 5 of kind {{}} are defined, .*; {way_out}"
    with pytest.raises(TransformError, match=reason.format("reference")):
        world.define_transform(TransformMessage("more", shift(0.1), "reference"))
    with pytest.raises(TransformError, match=reason.format("functional")):
        world.define_transform(TransformMessage("more", shift(0.1), "functional", UP))
    for k in range(60):
        world.define_transform(TransformMessage(f"f{k}", shift(0.1)))
    world.define_transform(TransformMessage("f7", shift(0.2)))
    reason = f"transform 'more' is one too many: 70 are defined, and no more may be; {way_out}"
    with pytest.raises(TransformError, match=reason):
        world.define_transform(TransformMessage("more", shift(0.1)))
    for k in range(60):
        world.define_position(to("f0", name=f"p{k}"))
    world.define_position(to("f1", name="p7"))
    with pytest.raises(EquationError, match=f"'more' is one too many: 60 are .*; {way_out}"):
        world.define_position(to("f0", name="more"))
    angles = JointPosition(
        JointPositionMessage("more", (0.1, 1.4, -3.3, 0.1, -1.25, 0.1)), PUMA_260
    )
    with pytest.raises(EquationError, match=f"'more' is one too many: 60 are .*; {way_out}"):
        world.define_joint_position(angles)
    for k in range(50):
        world.define_mode(ModeMessage(f"m{k}", "joint", 0.2, 2.0))
    world.define_mode(ModeMessage("m7", "joint", 0.2, 3.0))
    with pytest.raises(ModeError, match=f"'more' is one too many: 50 are .*; {way_out}"):
        world.define_mode(ModeMessage("more", "joint", 0.2, 2.0))
    with pytest.raises(ProgramError, match=r"there are: m0, .*, m19 and 30 more"):
        world.mode("more")


numbers = st.one_of(
    st.floats(), st.floats(-1.0, 1.0), st.sampled_from([0.0, 1.0, -1.0, 999.0, 2.0, 1.99])
)
twists = st.one_of(st.none(), st.tuples(*(numbers,) * 6))
turns = st.tuples(*(st.floats(-math.pi, math.pi),) * 3)


@settings(max_examples=200)
@given(
    st.lists(st.tuples(turns, numbers, numbers, twists, st.booleans(), st.booleans()), max_size=6)
)
def test_whatever_is_observed_is_refused_or_leaves_a_goal_that_is_a_pose(
    observations: list[tuple[Any, ...]],
) -> None:
    world = WorldModel(OWN, PERIOD_S)
    world.define_transform(TransformMessage("seen", shift(0.2), "reference"), NOW)
    goal = world.define_position(to("seen")).goal
    for k, (turn, x, stamp, twist, moves, fades) in enumerate(observations):
        rows = Transform.rpy(*turn)._replace(px=x)
        predict: Literal["velocity", "hold"] = "velocity" if moves else "hold"
        message = TransformMessage("seen", rows, "reference", None, predict, twist, stamp)
        with contextlib.suppress(TransformError):
            world.define_transform(message, NOW + k, Limits(1.0, 5.0) if fades else None)
        for tick in (0, NOW + k, NOW + k + 10, 10**7):
            assert goal.pose(Moment(tick)).is_rigid(1e-9)
