"""Guards: words, units, both senses, and the way a move has gone."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.compliance import DIRECTIONS
from rfms_can.errors import ModeError
from rfms_can.master.force.guards import DISTANCES, Guards, reached_force
from rfms_can.master.force.specification import NO_FORCE, Guard
from rfms_can.master.world.modes import MotionMode
from rfms_can.messages import ModeMessage
from rfms_can.transform import Transform

HERE = Transform.translation(0.3, 0.1, 0.2) @ Transform.rpy(0.3, 2.0, -0.4)
TOOL = Transform.translation(0.01, 0.02, 0.15) @ Transform.rpy(0.0, 0.5, 0.2)


def only(index: int, value: float) -> tuple[float, float, float, float, float, float]:
    values = [0.0] * 6
    values[index] = value
    a, b, c, d, e, f = values
    return (a, b, c, d, e, f)


def watching(guard: Guard, frame: Transform = TOOL) -> Guards:
    guards = Guards()
    guards.begin(guard, HERE, frame)
    return guards


# --- forces ------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("index", range(6))
def test_a_force_stops_a_move_in_either_sense_and_no_other_does(index: int, sign: float) -> None:
    guards = watching(Guard(force=only(index, 15.0)))
    for other in range(6):
        if other != index:
            assert guards.watch(7, only(other, 500.0 * sign), HERE) is None
    assert guards.watch(7, only(index, 14.99 * sign), HERE) is None
    assert guards.tripped is None
    reason = guards.watch(7, only(index, 15.0 * sign), HERE)
    unit = "N" if index < 3 else "N m"
    assert reason == f"{DIRECTIONS[index]} {15.0 * sign:g} {unit} reached 15 {unit}"
    assert guards.tripped == f"move 7: {reason}"


def test_a_guard_trips_once() -> None:
    guards = watching(Guard(force=only(2, 5.0)))
    assert guards.watch(3, only(2, 8.0), HERE) is not None
    assert guards.watch(3, only(2, 8.0), HERE) is None
    assert guards.tripped == "move 3: fz 8 N reached 5 N"


def test_what_tripped_is_told_until_another_guarded_move() -> None:
    guards = watching(Guard(force=only(2, 5.0)))
    guards.watch(3, only(2, 8.0), HERE)
    guards.begin(Guard(), HERE, TOOL)
    assert guards.watch(4, only(2, 80.0), HERE) is None
    assert guards.tripped == "move 3: fz 8 N reached 5 N"
    guards.begin(Guard(force=only(0, 9.0)), HERE, TOOL)
    assert guards.tripped is None


@given(st.tuples(*[st.floats(0.0, 50.0)] * 6), st.tuples(*[st.floats(-60.0, 60.0)] * 6))
def test_the_first_reached_is_named_and_only_where_one_is(
    bounds: tuple[float, ...], force: tuple[float, ...]
) -> None:
    a, b, c, d, e, f = bounds
    reached = [
        name
        for name, bound, value in zip(DIRECTIONS, bounds, force, strict=True)
        if bound > 0.0 and abs(value) >= bound
    ]
    words = reached_force(Guard(force=(a, b, c, d, e, f)), force)
    assert (words.split()[0] if words else None) == (reached[0] if reached else None)


# --- the way -----------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("index", range(3))
def test_a_way_along_an_axis_of_the_frame_stops_a_move(index: int, sign: float) -> None:
    guards = watching(Guard(distance=only(index, 0.04)))
    for part in (0.5, 0.999, 1.001):
        x, y, z, *_ = only(index, 0.04 * part * sign)
        T6 = HERE @ TOOL @ Transform.translation(x, y, z) @ TOOL.inverse()
        reason = guards.watch(2, NO_FORCE, T6)
        assert (reason is not None) == (part > 1.0)
    assert reason == f"{DISTANCES[index]} {0.04 * sign:.3g} m reached 0.04 m"


@pytest.mark.parametrize("bound", [0.3, 1.2, 2.0, 3.0])
def test_a_turn_stops_a_move_however_large_it_is(bound: float) -> None:
    """The sine of the angle would never reach 1.2 rad, and half a turn would look like none."""
    guards = watching(Guard(distance=only(5, bound)))
    for k in range(1, 100):
        angle = k * 0.035
        turned = TOOL @ Transform.rotation((0, 0, 1), angle) @ TOOL.inverse()
        if guards.watch(2, NO_FORCE, HERE @ turned):
            break
    assert bound <= angle < bound + 0.035


def test_ways_across_do_not_count() -> None:
    guards = watching(Guard(distance=only(2, 0.01)))
    across = TOOL @ Transform.translation(0.5, -0.5, 0.0) @ TOOL.inverse()
    assert guards.watch(2, NO_FORCE, HERE @ across) is None


@given(st.tuples(*[st.floats(-0.5, 0.5)] * 3))
def test_in_a_frame_that_stands_in_the_world_it_is_the_arm_that_travels(
    way: tuple[float, ...],
) -> None:
    """Such a frame never moves; how far the arm has gone along its axes is what is asked."""
    frame = Transform.translation(0.4, 0.0, 0.0) @ Transform.rotation((0, 0, 1), math.pi / 2)
    guards = watching(Guard(distance=only(0, 0.1)), HERE.inverse() @ frame)
    x, y, z = way
    moved = Transform.translation(x, y, z) @ HERE
    reason = guards.watch(1, NO_FORCE, moved)
    assert (reason is not None) == (abs(y) >= 0.1)  # its x is the world's y


# --- words -------------------------------------------------------------------------------------


def mode(**more: object) -> ModeMessage:
    return ModeMessage("touch", "cartesian", 0.2, 1.0, **more)  # type: ignore[arg-type]


def test_a_mode_says_what_stops_it_by_words() -> None:
    guard = MotionMode.from_message(
        mode(stop_on_force={"fz": 15.0, "rx": 2.0}, stop_on_distance={"dz": 0.04, "ry": 0.1})
    ).guard
    assert guard == Guard((0, 0, 15.0, 2.0, 0, 0), (0, 0, 0.04, 0, 0.1, 0))
    assert guard.active
    assert not MotionMode.from_message(mode()).guard.active


@pytest.mark.parametrize(
    ("more", "complaint"),
    [
        (
            {"stop_on_force": {"dz": 3.0}},
            "stop on force: 'dz' is not a direction: there are fx, fy",
        ),
        ({"stop_on_distance": {"fz": 3.0}}, "stop on distance: 'fz' is not a direction: .* dx, dy"),
        ({"stop_on_force": {"fz": 0.0}}, "stop on force: fz 0.0 must be more than zero"),
        ({"stop_on_force": {"fz": -4.0}}, "stop on force: fz -4.0 must be more than zero"),
        ({"stop_on_force": {"fz": math.nan}}, "fz nan must be more than zero"),
        ({"stop_on_distance": {"dx": math.inf}}, "dx inf must be more than zero"),
        ({"stop_on_distance": {"dx": 1e9}}, "dx 1e\\+09: it would never stop there, 3 is the most"),
        ({"stop_on_distance": {"rz": 3.2}}, "rz 3.2: it would never .*, 3.14 is the most"),
        ({"comply": {"fw": 0.0}}, "'fw' is not a direction"),
        ({"comply": {"fx": math.nan}}, "the bias of fx is nan"),
        ({"mass": -1.0}, "mass -1.0 must be a number"),
    ],
)
def test_words_that_mean_nothing_are_refused(more: dict[str, object], complaint: str) -> None:
    with pytest.raises(ModeError, match=f"mode 'touch': .*{complaint}"):
        MotionMode.from_message(mode(**more))
