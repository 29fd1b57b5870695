"""Where an observed object is predicted to be: held, by its twist, or by the line of its past."""

import math

import numpy as np
import pytest
from reference_campaign import Conditions, run

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Goal, Moment
from rfms_can.master.world import Limits, WorldModel
from rfms_can.master.world.line_fit import fit_line
from rfms_can.messages import T6, PositionMessage, TransformMessage
from rfms_can.transform import Transform

PERIOD_S = 0.004
AXIS = (0.6, 0.0, 0.8)
TIMES = np.linspace(-0.3, 0.0, 16)


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
        rest_after: float | None = None,
    ) -> None:
        self.world.define_transform(
            TransformMessage(
                "seen",
                pose,
                "reference",
                predict=predict,  # type: ignore[arg-type]
                twist=twist,  # type: ignore[arg-type]
                stamp=stamp,
                rest_after=rest_after,
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
    for tick in (2500, 2510, 2550):
        assert camera.pose(tick) == pytest.approx(moved(tick * PERIOD_S), abs=1e-12)


@pytest.mark.parametrize("count", [9, 16, 40])
@pytest.mark.parametrize("interval", [1, 5, 10, 50], ids=lambda ticks: f"{250 / ticks:g} Hz")
def test_an_even_motion_is_carried_on_to_the_tick(count: int, interval: int) -> None:
    """Once it has been seen for 0.15 s: before, its noise is not known."""
    camera, first = Camera(), 2500
    count = max(count, 40 // interval)
    for k in range(count):
        tick = first + interval * k
        camera.see(moved(tick * PERIOD_S), tick, tick * PERIOD_S)
    last = first + interval * (count - 1)
    for tick in (last + 1, last + interval):
        assert camera.pose(tick) == pytest.approx(moved(tick * PERIOD_S), abs=1e-10)


@pytest.mark.parametrize(("count", "least", "most"), [(2, 0.0, 0.0), (3, 0.5, 0.99), (5, 0.9, 1.0)])
def test_a_motion_is_believed_by_and_by(count: int, least: float, most: float) -> None:
    """Of 0.2 m/s at 50 Hz: none of it from two observations, most of it from five."""
    camera = Camera()
    for k in range(count):
        camera.see(moved(10.0 + 0.02 * k), 2500 + 5 * k, 10.0 + 0.02 * k)
    tick = 2500 + 5 * count
    believed = (camera.pose(tick).py - camera.pose(tick - 1).py) / (0.2 * PERIOD_S)
    assert least <= believed <= most


@pytest.mark.parametrize("noise", [1e-4, 1e-3])
def test_the_line_is_that_of_least_squares_through_the_newest(noise: float) -> None:
    """Against numpy's own fit of 0.3 s, which ``fit_line`` believes but for the noise of it."""
    rows = np.random.default_rng(3).normal(0.0, noise, (16, 6))
    rows[:, 1] += 0.5 * TIMES
    rows[:, 5] += 2.0 * TIMES
    fit = fit_line(TIMES, rows)
    slope, value = np.polyfit(TIMES, rows, 1)
    middle = value + slope * TIMES.mean()
    kept = fit.slope[1] / slope[1]
    assert 0.9 < kept <= 1.0
    np.testing.assert_allclose(fit.slope[:3], kept * slope[:3], atol=1e-12)
    np.testing.assert_allclose(fit.value + fit.slope * TIMES.mean(), middle, atol=1e-12)
    assert fit.noise[0] == pytest.approx(noise, rel=0.5)


def test_of_noise_alone_no_velocity_is_believed() -> None:
    """In 2000 windows; of one in a hundred, some."""
    chance = np.random.default_rng(4)
    slopes = [
        float(np.linalg.norm(fit_line(TIMES, chance.normal(0.0, 0.5e-3, (16, 6))).slope[:3]))
        for _ in range(2000)
    ]
    assert sum(slope > 0.0 for slope in slopes) < 40
    assert max(slopes) < 5e-3


def test_where_the_motion_bends_the_newest_count() -> None:
    """A belt that is switched on: after five observations of its motion that is its speed."""
    rows = np.zeros((16, 6))
    rows[11:, 0] = 0.2 * (TIMES[11:] - TIMES[11])
    assert fit_line(TIMES, rows).slope[0] == pytest.approx(0.2, abs=0.01)
    rows[11:, 0] += 1e-6  # and by far not that of all
    assert fit_line(TIMES, rows).slope[0] > 3.0 * np.polyfit(TIMES, rows[:, 0], 1)[0]


# --- the gate -----------------------------------------------------------------------------------


def still(camera: Camera, count: int, first: int = 2500, interval: int = 5) -> int:
    """See an object at rest; the tick after."""
    for k in range(count):
        tick = first + interval * k
        camera.see(Transform.translation(0.1, 1e-4 * (k % 3), 0.0), tick, tick * PERIOD_S)
    return first + interval * count


@pytest.mark.parametrize("outliers", [1, 2, 3])
def test_what_is_a_metre_off_changes_nothing(outliers: int) -> None:
    camera = Camera()
    tick = still(camera, 20)
    before = camera.pose(tick)
    for k in range(outliers):
        camera.see(Transform.translation(1.1, 0.2, 0.0), tick + 5 * k, (tick + 5 * k) * PERIOD_S)
    assert camera.pose(tick + 5 * outliers) == before
    turned = Transform.rotation(AXIS, math.pi)._replace(px=0.1)
    camera.see(turned, tick + 20, (tick + 20) * PERIOD_S)
    assert camera.pose(tick + 25) == before, "nor does a pose that is upside down"


def test_a_jump_is_followed_once_four_have_seen_it() -> None:
    camera = Camera()
    tick = still(camera, 20)
    there = Transform.translation(0.3, 0.4, 0.0)
    for k in range(4):
        assert camera.pose(tick + 5 * k).px == pytest.approx(0.1, abs=1e-3)
        camera.see(there, tick + 5 * k, (tick + 5 * k) * PERIOD_S)
    assert camera.pose(tick + 20) == there
    still_there = camera.pose(tick + 400)
    assert still_there == there, "and it is no velocity"


def test_outliers_among_those_of_a_jump_do_not_count() -> None:
    camera = Camera()
    tick = still(camera, 20)
    for k in range(8):
        x = 0.3 if k % 2 else 1.0 + 0.37 * k
        camera.see(Transform.translation(x, 0.0, 0.0), tick + 3 * k, (tick + 3 * k) * PERIOD_S)
    assert camera.pose(tick + 24).px == pytest.approx(0.3, abs=1e-12)


def test_others_in_between_do_not_confirm_one_another() -> None:
    """A reflection beside the object, seen in turn with it: the arm stays with the object."""
    camera = Camera()
    tick = still(camera, 20)
    for k in range(40):
        x = 0.6 if k % 2 else 0.1
        camera.see(Transform.translation(x, 0.0, 0.0), tick + 5 * k, (tick + 5 * k) * PERIOD_S)
        assert camera.pose(tick + 5 * k).px == pytest.approx(0.1, abs=1e-3)


def test_a_flash_of_a_fast_camera_is_too_short_for_a_jump() -> None:
    camera = Camera()
    tick = still(camera, 60, interval=1)
    for k in range(5):  # 16 ms
        camera.see(Transform.translation(0.6, 0.0, 0.0), tick + k, (tick + k) * PERIOD_S)
    assert camera.pose(tick + 5).px == pytest.approx(0.1, abs=1e-3)


def test_the_definition_is_not_an_observation() -> None:
    """A nominal place, 10 mm from the true one, is neither averaged nor a velocity."""
    camera = Camera()
    camera.see(Transform.translation(0.0, 0.01, 0.0), 2, 2 * PERIOD_S)
    assert camera.pose(3) == Transform.translation(0.0, 0.01, 0.0)
    camera.see(Transform.translation(0.0, 0.01, 0.0), 7, 7 * PERIOD_S)
    assert camera.pose(8) == Transform.translation(0.0, 0.01, 0.0)


def test_who_looks_rarely_is_believed_at_once() -> None:
    camera = Camera()
    for k, x in enumerate((0.1, 0.3, 0.2, 0.9)):
        tick = 2500 + 250 * k
        camera.see(Transform.translation(x, 0.0, 0.0), tick, tick * PERIOD_S)
        assert camera.pose(tick + 1).px == x


# --- silence ------------------------------------------------------------------------------------


def silent(camera: Camera, first: int, last: int, limits: Limits | None = None) -> list[Transform]:
    """What is followed, tick by tick, while nothing is observed."""
    poses = []
    for tick in range(first, last):
        for name in camera.world.silent(tick):
            camera.world.settle_transform(name, tick, limits)
        poses.append(camera.pose(tick))
    return poses


@pytest.mark.parametrize("interval", [1, 5, 10])
@pytest.mark.parametrize("rest_after", [None, 0.2, 0.5, 1.0])
def test_silence_brings_a_motion_to_rest_in_its_time(
    interval: int, rest_after: float | None
) -> None:
    """Two usual intervals after the last observation it brakes, half the time ahead it rests."""
    camera, last = Camera(), 2500 + 100 * interval
    for tick in range(2500, last + 1, interval):
        camera.see(moved(tick * PERIOD_S), tick, tick * PERIOD_S, rest_after=rest_after)
    overdue, span = last + 2 * interval, rest_after or 0.2
    poses = silent(camera, last, overdue + round(span / PERIOD_S) + 50)
    for k in range(2 * interval):
        assert poses[k] == pytest.approx(moved((last + k) * PERIOD_S), abs=1e-9)
    rest = poses[2 * interval + round(span / PERIOD_S) :]
    assert all(pose == rest[0] for pose in rest)
    halfway = (overdue - 1) * PERIOD_S + 0.5 * span
    assert rest[0] == pytest.approx(moved(halfway), abs=1e-9)
    speeds = np.diff([pose.py for pose in poses]) / PERIOD_S
    assert np.abs(np.diff(speeds)).max() / PERIOD_S < 1.9 * 0.2 / span, "no jump of the velocity"
    assert np.all(np.diff(speeds) < 1e-9), "nor back"


def test_a_fast_object_rests_within_the_limits_of_the_mode() -> None:
    """0.8 m/s against 1 m/s2 takes longer than 0.2 s."""
    camera = Camera()
    for tick in range(2500, 2700, 5):
        seen = Transform.translation(0.8 * tick * PERIOD_S, 0.0, 0.0)
        camera.see(seen, tick, tick * PERIOD_S)
    xs = [pose.px for pose in silent(camera, 2700, 3400, Limits(1.0, 5.0))]
    assert np.abs(np.diff(xs, n=2)).max() / PERIOD_S**2 < 1.0
    assert xs[-1] == xs[-100]


@pytest.mark.parametrize("rate", [25, 100, 500])
@pytest.mark.parametrize("outliers", [0.0, 0.05], ids=["clean", "with outliers"])
@pytest.mark.parametrize("limited", [False, True], ids=["unused", "moving"])
def test_a_still_object_stays_where_it_is_when_it_is_not_seen_any_more(
    rate: int, outliers: float, limited: bool
) -> None:
    """0.5 mm of noise, jitter, 30 % loss, silence at any time: the campaign, three runs of it."""
    for seed in range(3):
        numbers = run(Conditions("still", rate, 0.5e-3, 0.6, 0.3, outliers, limited, seed))
        assert numbers.silent_max is not None
        assert numbers.silent_max < 2.5e-3
        assert numbers.rest_s < 0.6


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
    for k in range(20):
        camera.see(Transform.translation(0.1 + 0.004 * k, 0.0, 0.0), 2500 + 5 * k)
    assert camera.pose(2602).px == pytest.approx(0.1 + 0.2 * 0.408)


def test_a_stamp_of_the_future_is_of_now_and_does_not_shadow_what_comes_next() -> None:
    camera = Camera()
    camera.see(Transform.translation(0.1, 0.0, 0.0), 2500, 10.004, predict="hold")
    camera.see(Transform.translation(0.2, 0.0, 0.0), 2500, predict="hold")
    assert camera.pose(2500).px == 0.2
