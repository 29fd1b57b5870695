"""Plans of controlled stops, to the number: where they begin, how fast, and how hard they brake."""

import math

import pytest

from rfms_can.arm import PUMA_260
from rfms_can.joint_nodes.stop_ramp import StopPlan, StopRamp
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.wire.vocabulary import Parameter

P = Parameter
PARAMETERS = all_parameters(PUMA_260, "corke", 0.004)[2]
TAU, FASTEST = PARAMETERS[P.PERIOD], PARAMETERS[P.SPEED_LIMIT]
BRAKES = PARAMETERS[P.ACCELERATION_LIMIT]
LOWER, UPPER = PARAMETERS[P.POSITION_MIN], PARAMETERS[P.POSITION_MAX]
MIDDLE = 0.5 * (LOWER + UPPER)
FAR = 0.25 * 1.5 * FASTEST * TAU


def deceleration(ramp: StopRamp) -> float:
    """rad/s2, of the first step."""
    before = ramp.speed
    ramp.step()
    return abs(before - ramp.speed) / TAU


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("measured", "rate", "speed"),
    [(0.3, 0.2, 0.2), (0.2, 0.3, 0.2), (0.3, -0.2, 0.0), (0.3, 0.0, 0.0), (0.0, 0.3, 0.0)],
)
def test_a_stop_is_no_faster_than_the_joint_and_than_it_was_told(
    sign: float, measured: float, rate: float, speed: float
) -> None:
    ramp = StopPlan(PARAMETERS).ramp(MIDDLE, sign * measured, MIDDLE, sign * rate)
    assert (ramp.position, ramp.speed, ramp.acceleration) == (MIDDLE, sign * speed, 0.0)
    if speed:
        assert deceleration(ramp) == pytest.approx(BRAKES)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_stop_is_faster_than_the_speed_limit(sign: float) -> None:
    ramp = StopPlan(PARAMETERS).ramp(MIDDLE, sign * 9.0, MIDDLE, sign * 8.0)
    assert ramp.speed == sign * FASTEST


@pytest.mark.parametrize(("off", "taken"), [(0.9, 0.9), (1.1, 1.0), (9.0, 1.0)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_stop_begins_a_little_off_the_joint_at_most(
    off: float, taken: float, sign: float
) -> None:
    ramp = StopPlan(PARAMETERS).ramp(MIDDLE, 0.0, MIDDLE + sign * off * FAR, 0.0)
    assert ramp.position == pytest.approx(MIDDLE + sign * taken * FAR, abs=1e-12)


@pytest.mark.parametrize(("end", "outward"), [(UPPER, 1.0), (LOWER, -1.0)])
def test_a_stop_near_an_end_brakes_so_hard_that_it_ends_there(end: float, outward: float) -> None:
    speed, room = 0.5 * FASTEST, 0.01
    begin = end - outward * room
    ramp = StopPlan(PARAMETERS).ramp(begin, outward * speed, begin, outward * speed)
    hard = speed * speed / (2.0 * room)
    assert hard > BRAKES
    assert deceleration(ramp) == pytest.approx(hard)
    while ramp.speed:
        ramp.step()
    assert ramp.position == pytest.approx(end, abs=2e-4)
    inward = StopPlan(PARAMETERS).ramp(begin, -outward * speed, begin, -outward * speed)
    assert deceleration(inward) == pytest.approx(BRAKES), "there is room on the other side"


@pytest.mark.parametrize(("end", "outward"), [(UPPER, 1.0), (LOWER, -1.0)])
def test_a_stop_that_begins_at_an_end_has_a_count_of_room(end: float, outward: float) -> None:
    slow = 0.01
    count = 1.0 / abs(PARAMETERS[P.COUNTS_PER_UNIT])
    far = 1.0 / (2.0 * BRAKES) * slow * slow
    for speed in (slow, math.sqrt(2.0 * BRAKES * count * 1.21)):
        ramp = StopPlan(PARAMETERS).ramp(end, outward * speed, end, outward * speed)
        expected = min(max(BRAKES, speed * speed / (2.0 * count)), speed / TAU)
        assert deceleration(ramp) == pytest.approx(expected)
    assert far < count


def test_the_place_of_rest_is_chosen_once_the_ramp_has_ended_and_for_half_a_second() -> None:
    ramp = StopRamp(1.0, 0.03, 5.0, TAU)
    ramp.step()
    for _ in range(40):
        ramp.watch(0.9)
    assert ramp.position > 1.0, "the joint stands, but the ramp has not ended"
    ramp.step()
    assert ramp.speed == 0.0
    end = ramp.position
    for k in range(13):
        assert ramp.position == end, k
        ramp.watch(0.9)
    assert ramp.position == 0.9
    moved = StopRamp(1.0, 0.0, 5.0, TAU)
    for k in range(round(0.5 / TAU)):
        moved.watch(0.9 + 1e-3 * (k % 12 == 0) * (k + 1))
        assert moved.position == 1.0, k
    for _ in range(40):
        moved.watch(0.8)
    assert moved.position == 1.0, "after half a second it does not yield"


def test_the_last_of_the_half_second_still_counts() -> None:
    cycles = round(0.5 / TAU)
    for late, position in ((0, 0.9), (1, 1.0)):
        ramp = StopRamp(1.0, 0.0, 5.0, TAU)
        for k in range(cycles - 13 + late):
            ramp.watch(float(k))
        for _ in range(13):
            ramp.watch(0.9)
        assert ramp.position == position, late
