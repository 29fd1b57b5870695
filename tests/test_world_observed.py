"""Where an observed object is predicted to be: held, by its twist, or by the line of its past."""

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Goal, Moment
from rfms_can.master.world import WorldModel
from rfms_can.messages import T6, PositionMessage, TransformMessage
from rfms_can.transform import Transform

PERIOD_S = 0.004
AXIS = (0.6, 0.0, 0.8)


class Camera:
    """A world with one reference, seen now and then, and a goal that is just that."""

    def __init__(self) -> None:
        self.world = WorldModel(Configuration(True, True, True), PERIOD_S)
        self.see(Transform.identity(), 0, 0.0, predict="hold")
        message = PositionMessage("p", [T6], ["seen"])
        self.goal: Goal = self.world.define_position(message).goal

    def see(
        self,
        pose: Transform,
        tick: int,
        stamp: float | None = None,
        twist: tuple[float, ...] | None = None,
        predict: str = "velocity",
    ) -> None:
        self.world.define_transform(
            TransformMessage(
                "seen",
                pose,
                "reference",
                predict=predict,  # type: ignore[arg-type]
                twist=twist,  # type: ignore[arg-type]
                stamp=stamp,
            ),
            tick,
        )

    def pose(self, tick: int) -> Transform:
        return self.goal.pose(Moment(tick))


def moved(time: float) -> Transform:
    """A frame at 0.2 m/s that turns at 0.5 rad/s about an axis of the base."""
    turned = Transform.rotation(AXIS, 0.5 * time) @ Transform.rpy(0.3, -0.2, 0.1)
    return turned._replace(px=0.1, py=0.2 * time, pz=-0.3)


def test_one_observation_rests_and_hold_holds() -> None:
    camera = Camera()
    camera.see(moved(10.0), 2510, 10.0)
    assert camera.pose(2600) == moved(10.0)
    camera.see(moved(10.02), 2515, 10.02, predict="hold")
    assert camera.pose(2600) == moved(10.02)


def test_a_twist_says_how_fast() -> None:
    camera = Camera()
    wx, wy, wz = (0.5 * component for component in AXIS)
    camera.see(moved(10.0), 2510, 10.0, (0.0, 0.2, 0.0, wx, wy, wz))
    for tick in (2500, 2510, 2700):
        assert camera.pose(tick) == pytest.approx(moved(tick * PERIOD_S), abs=1e-12)


@pytest.mark.parametrize("count", [2, 3, 5, 9])
def test_an_even_motion_is_carried_on_to_the_tick(count: int) -> None:
    camera = Camera()
    for k in range(count):
        stamp = 10.0 + 0.02 * k
        camera.see(moved(stamp), 2505 + 5 * k, stamp)
    for tick in (2510 + 5 * count, 2700):
        assert camera.pose(tick) == pytest.approx(moved(tick * PERIOD_S), abs=1e-10)


@given(st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5), st.randoms(use_true_random=False))
def test_the_line_is_that_of_least_squares_through_the_newest_five(
    offsets: list[float], chance: random.Random
) -> None:
    """Against numpy's own fit; observations may come in any order."""
    stamps = [10.0 + 0.02 * k + 0.003 * (k % 2) for k in range(5)]
    seen = list(zip(stamps, offsets, strict=True))
    chance.shuffle(seen)
    camera = Camera()
    for k in range(3):
        camera.see(Transform.translation(5.0, 5.0, 5.0), 2470 + 5 * k, 9.88 + 0.02 * k)
    for stamp, x in seen:
        turned = Transform.rotation((0.0, 0.0, 1.0), 0.4 * x)
        camera.see(turned._replace(px=x, py=-2.0 * x), 2550, stamp)
    slope, value = np.polyfit(np.array(stamps) - stamps[-1], offsets, 1)
    expected = value + slope * (2560 * PERIOD_S - stamps[-1])
    pose = camera.pose(2560)
    assert (pose.px, pose.py) == pytest.approx((expected, -2.0 * expected), abs=1e-9)
    angle = math.atan2(pose.ny, pose.nx)
    assert math.remainder(angle - 0.4 * expected, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_what_was_seen_again_at_the_same_time_counts_once() -> None:
    """Else a millimetre between two pictures of one moment would be a velocity."""
    camera = Camera()
    camera.see(Transform.translation(0.1, 0.0, 0.0), 2500, 10.0)
    camera.see(Transform.translation(0.101, 0.0, 0.0), 2500, 10.0001)
    assert camera.pose(2700).px == 0.101


def test_what_was_seen_long_ago_says_nothing_of_the_velocity() -> None:
    camera = Camera()
    camera.see(Transform.translation(0.1, 0.0, 0.0), 2500, 10.0)
    camera.see(Transform.translation(0.7, 0.0, 0.0), 2751, 11.001)
    assert camera.pose(2900).px == 0.7


def test_an_observation_without_a_stamp_is_of_the_tick_it_acts_in() -> None:
    camera = Camera()
    camera.see(Transform.translation(0.1, 0.0, 0.0), 2500)
    camera.see(Transform.translation(0.2, 0.0, 0.0), 2525)
    assert camera.pose(2550).px == pytest.approx(0.3)


def test_a_stamp_of_the_future_is_of_now_and_does_not_shadow_what_comes_next() -> None:
    camera = Camera()
    camera.see(Transform.translation(0.1, 0.0, 0.0), 2500, 10.004, predict="hold")
    camera.see(Transform.translation(0.2, 0.0, 0.0), 2500, predict="hold")
    assert camera.pose(2500).px == 0.2
