"""Names of the world model that are removed: what keeps them, and a day's work of them."""

import gc
import tracemalloc
from typing import Any, Literal

import pytest

from rfms_can.errors import EquationError, ModeError, ProgramError, TransformError
from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world import WorldModel
from rfms_can.messages import (
    NAMES_LISTED,
    T6,
    Linear,
    ModeMessage,
    PositionMessage,
    RemoveRequest,
    TransformMessage,
)
from rfms_can.transform import Transform

OWN = Configuration(True, False, True)
PERIOD_S = 0.004
PICKS = 100_000


def shift(x: float) -> Transform:
    return Transform.translation(x, 0.0, 0.0)


@pytest.fixture
def world() -> WorldModel:
    world = WorldModel(OWN, PERIOD_S)
    world.define_transform(TransformMessage("part", shift(0.1)))
    world.define_transform(TransformMessage("tool", shift(0.2)))
    world.define_position(PositionMessage("at part", [T6, "tool"], ["part"]))
    world.define_mode(ModeMessage("slow", "joint", 0.2, 2.0))
    return world


def remove(world: WorldModel, name: str, what: Any = None) -> None:
    world.remove(world.entry_of(RemoveRequest(name, what)))


def test_what_nothing_uses_is_removed_and_its_name_is_free(world: WorldModel) -> None:
    remove(world, "at part")
    remove(world, "part")
    remove(world, "slow", "mode")
    names = world.names()
    assert (names.transforms, names.positions, names.modes) == ({"tool": "value"}, [], [])
    assert names.sizes == {"transform": 1, "position": 0, "mode": 0}
    function = Linear((0.0, 0.0, 1.0))
    world.define_transform(TransformMessage("part", shift(0.3), "functional", function))
    goal = world.define_position(PositionMessage("at part", [T6], ["part"])).goal
    assert goal.pose(Moment(0, 0.5)) == pytest.approx(Transform.translation(0.3, 0.0, 0.5))


def test_a_transform_is_kept_by_the_positions_that_use_it(world: WorldModel) -> None:
    reason = "transform 'part' is used by position 'at part': remove that, or define it without"
    with pytest.raises(TransformError, match=reason):
        remove(world, "part")
    world.define_position(PositionMessage("q", [T6], ["tool"]))
    with pytest.raises(TransformError, match="used by position 'at part' and 1 more"):
        remove(world, "tool")
    world.define_position(PositionMessage("at part", [T6], ["tool"]))  # uses it no more
    remove(world, "part")
    with pytest.raises(TransformError, match="'tool' is used by position 'q' and 1 more"):
        remove(world, "tool")


def test_a_definition_that_was_refused_leaves_what_uses_what(world: WorldModel) -> None:
    former = world.former(PositionMessage("at part", [T6], ["tool"]))
    world.define_position(PositionMessage("at part", [T6], ["tool"]))
    assert world.differs(former)
    world.restore(former)
    assert not world.differs(former)
    with pytest.raises(TransformError, match="transform 'part' is used by position 'at part':"):
        remove(world, "part")
    with pytest.raises(EquationError, match="transform 'nothing' is not defined"):
        world.define_position(PositionMessage("at part", [T6], ["nothing"]))
    with pytest.raises(EquationError, match="must stand right after"):
        world.define_position(PositionMessage("at part", [T6], ["tool"], tool="tool"))
    assert world.position("at part").uses("part")
    remove(world, "at part")
    remove(world, "part")


@pytest.mark.parametrize(
    ("name", "what", "error", "reason"),
    [
        ("nothing", None, ProgramError, "remove 'nothing': no transform, position or mode has"),
        ("nothing", "transform", TransformError, "'nothing' is not defined; there are: part, tool"),
        ("part", "position", EquationError, "position 'part' is not defined; there are: at part"),
        ("part", "mode", ModeError, "mode 'part' is not defined; there are: slow"),
        ("slow", "transform", TransformError, "transform 'slow' is not defined"),
        (T6, None, TransformError, "transform 't6' is the arm itself and cannot be removed"),
        (T6, "position", EquationError, "position 't6' is not defined"),
        ("both", None, ProgramError, "'both': it is the name of a transform and of a mode; say"),
    ],
)
def test_what_cannot_be_removed_is_refused_in_one_line(
    world: WorldModel,
    name: str,
    what: Literal["transform", "position", "mode"] | None,
    error: type[ProgramError],
    reason: str,
) -> None:
    world.define_transform(TransformMessage("both", shift(0.1)))
    world.define_mode(ModeMessage("both", "joint", 0.2, 2.0))
    before = world.names()
    with pytest.raises(error, match=reason) as refused:
        remove(world, name, what)
    assert type(refused.value) is error
    assert "\n" not in str(refused.value)
    assert world.names() == before


def test_a_reference_that_was_removed_is_no_longer_looked_at(world: WorldModel) -> None:
    for tick in range(0, 100, 5):
        seen = TransformMessage("belt", shift(0.1 + 0.001 * tick), "reference", predict="velocity")
        world.define_transform(seen, tick)
    assert world.silent(1000) == ["belt"]
    remove(world, "belt")
    assert world.silent(1000) == []


def test_the_same_definition_again_changes_nothing(world: WorldModel) -> None:
    function = Linear((0.0, 0.0, 1.0))
    curve = TransformMessage("curve", shift(0.3), "functional", function)
    world.define_transform(curve)
    slow, at_part = world.mode("slow"), world.position("at part")
    for message in (
        TransformMessage("part", shift(0.1)),
        TransformMessage("curve", shift(0.3), "functional", Linear((0.0, 0.0, 1.0))),
    ):
        former = world.former(message)
        world.define_transform(message)
        assert not world.differs(former)
    assert world.define_position(PositionMessage("at part", [T6, "tool"], ["part"])) is at_part
    assert world.define_mode(ModeMessage("slow", "joint", 0.2, 2.0)) is slow


@pytest.mark.system
@pytest.mark.parametrize("again", [True, False])
def test_a_days_picks_take_no_more_memory_than_the_first(again: bool) -> None:
    """Each with a name of its own that is removed, or with one name that is defined again."""
    world = WorldModel(OWN, PERIOD_S)
    world.define_transform(TransformMessage("tool", shift(0.2)))

    def pick(number: int) -> None:
        name = "pick" if again else f"pick {number}"
        world.define_transform(TransformMessage(name, shift(1e-6 * number)))
        world.define_position(PositionMessage(name, [T6, "tool"], [name]))
        world.define_mode(ModeMessage(name, "joint", 0.2, 1.0 + 1e-6 * number))
        assert world.position(name).goal.pose(Moment(0)).px == pytest.approx(1e-6 * number - 0.2)
        if not again:
            for what in ("position", "transform", "mode"):
                remove(world, name, what)

    for number in range(PICKS - 1000):
        pick(number)
    gc.collect()
    tracemalloc.start()
    for number in range(PICKS - 1000, PICKS):
        pick(number)
    gc.collect()
    added = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert added < 60 * 1000  # bytes: a fifth of the transforms alone, if they were left
    most = 1 if again else 0
    assert world.names().sizes == {"transform": 1 + most, "position": most, "mode": most}


def test_the_names_of_a_large_world_are_read_page_by_page() -> None:
    world = WorldModel(OWN, PERIOD_S)
    count = 2 * NAMES_LISTED + 7
    for k in range(count):
        world.define_transform(TransformMessage(f"f{k}", shift(0.1)))
    world.define_position(PositionMessage("p", [T6], ["f0"]))
    read: list[str] = []
    for start in range(0, count, NAMES_LISTED):
        page = world.names(start)
        assert page.sizes == {"transform": count, "position": 1, "mode": 0}
        assert page.positions == ([] if start else ["p"])
        read += page.transforms
    assert read == [f"f{k}" for k in range(count)]
    assert world.names(count).transforms == {}
