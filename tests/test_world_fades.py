"""Jumps of a reference under way: continuous up to the jerk, within the limits, soon over."""

import math
import random
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfms_can.kinematics import Configuration
from rfms_can.master.trajectory.goal import Goal, Moment
from rfms_can.master.world import Limits, WorldModel
from rfms_can.messages import T6, PositionMessage, TransformMessage
from rfms_can.transform import Transform

Array = npt.NDArray[np.float64]

PERIOD_S = 0.004
LIMITS = Limits(1.0, 5.0)
REST = Transform.identity()


class Follower:
    """A reference that something moving uses, at one tick after another."""

    def __init__(self, start: Transform = REST, lever: float = 0.0, period: float = PERIOD_S):
        self.period = period
        self.tick = 0
        self.world = WorldModel(Configuration(True, True, True), period)
        self.see(start)
        self.world.define_transform(TransformMessage("arm", Transform.translation(lever, 0.0, 0.0)))
        message = PositionMessage("p", [T6], ["seen", "arm"])
        position = self.world.define_position(message)
        self.world.note_levers(position, 0)
        self.goal: Goal = position.goal
        self.poses: list[Transform] = []

    def see(
        self,
        pose: Transform,
        predict: str = "hold",
        age: float = 0.0,
        limits: Limits | None = LIMITS,
        twist: tuple[float, ...] | None = None,
    ) -> None:
        message = TransformMessage(
            "seen",
            pose,
            "reference",
            predict="velocity" if twist else predict,  # type: ignore[arg-type]
            twist=twist,  # type: ignore[arg-type]
            stamp=self.tick * self.period - age,
        )
        self.world.define_transform(message, self.tick, limits)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self.period)):
            self.poses.append(self.goal.pose(Moment(self.tick)))
            self.tick += 1

    @property
    def places(self) -> Array:
        return np.array([(pose.px, pose.py, pose.pz) for pose in self.poses])

    def accelerations(self) -> Array:
        return np.diff(self.places, n=2, axis=0) / self.period**2

    def angular_accelerations(self) -> Array:
        turns = np.array([np.array(pose.rows())[:, :3] for pose in self.poses])
        steps = np.einsum("kij,klj->kil", turns[1:], turns[:-1])
        rates = 0.5 * np.stack(
            [
                steps[:, 2, 1] - steps[:, 1, 2],
                steps[:, 0, 2] - steps[:, 2, 0],
                steps[:, 1, 0] - steps[:, 0, 1],
            ],
            axis=1,
        )
        return np.diff(rates, axis=0) / self.period**2


def largest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())


def test_a_jump_of_10_mm_fades_within_its_span_and_the_limit() -> None:
    follower = Follower()
    follower.run(0.1)
    follower.see(Transform.translation(0.006, 0.0, -0.008))
    follower.run(0.4)
    acceleration = follower.accelerations()
    assert 0.7 < largest(acceleration) <= LIMITS.acceleration
    span = math.sqrt(7.51 * 0.01 / 0.8)  # 0.8 of the limit from rest, 7.51 a0 / span^2 at most
    settled = math.ceil(1.08 * span / PERIOD_S)
    assert np.abs(follower.places[25 + settled :] - [0.006, 0.0, -0.008]).max() < 1e-12
    assert largest(np.diff(acceleration, axis=0)) < 0.15  # of 0.75 at its peak: no step
    assert np.all(np.diff(follower.places[:, 0]) >= 0.0)  # and straight there


def test_nothing_jumps_where_nothing_moves() -> None:
    follower = Follower()
    follower.run(0.1)
    follower.see(Transform.translation(0.01, 0.0, 0.0), limits=None)
    follower.run(0.1)
    assert follower.places[:, 0].tolist() == [0.0] * 25 + [0.01] * 25


def test_a_jump_without_limits_ends_a_fade() -> None:
    follower = Follower()
    follower.see(Transform.translation(0.01, 0.0, 0.0))
    follower.run(0.1)
    follower.see(Transform.translation(0.02, 0.0, 0.0), limits=None)
    follower.run(0.02)
    assert follower.places[25:, 0].tolist() == [0.02] * 5


def test_small_jumps_take_their_time_too() -> None:
    follower = Follower()
    follower.see(Transform.translation(1e-4, 0.0, 0.0))
    follower.run(0.3)
    assert largest(follower.accelerations()) == pytest.approx(7.51 * 1e-4 / 0.2**2, rel=0.01)
    assert np.all(follower.places[50:, 0] == 1e-4)


@pytest.mark.parametrize("angle", [0.1, 2.0, 3.1])
@pytest.mark.parametrize("lever", [0.0, 0.5])
def test_a_turn_keeps_both_limits_at_the_end_of_its_lever(angle: float, lever: float) -> None:
    follower = Follower(lever=lever)
    follower.run(0.1)
    follower.see(Transform.rotation((0.0, 0.6, 0.8), angle))
    follower.run(5.0)
    assert largest(follower.angular_accelerations()) <= LIMITS.angular_acceleration
    ends = follower.places - (follower.places[0] if lever else 0.0)
    rates = np.linalg.norm(np.diff(ends, axis=0), axis=1) / PERIOD_S
    along = np.diff(rates) / PERIOD_S  # without the centripetal part
    assert np.abs(along).max() <= LIMITS.acceleration
    expected = Transform.rotation((0.0, 0.6, 0.8), angle) @ Transform.translation(lever, 0.0, 0.0)
    assert follower.poses[-1] == pytest.approx(expected, abs=1e-12)


def scenario(period: float) -> Follower:
    """Jumps and turns of a held and of a moving reference, some in the midst of a fade."""
    follower = Follower(period=period)
    follower.run(0.04)
    follower.see(Transform.translation(0.01, 0.0, 0.0))
    follower.run(0.12)
    turned = Transform.rotation((0.0, 0.6, 0.8), 0.2)
    follower.see(turned._replace(px=0.012, py=0.003))
    follower.run(0.08)
    follower.see(turned._replace(px=0.011, py=0.003), "velocity", age=0.016)
    follower.run(0.08)
    again = Transform.rotation((0.6, 0.0, 0.8), 0.01) @ turned
    follower.see(again._replace(px=0.013, py=0.004), "velocity", age=0.016)
    follower.run(0.6)
    return follower


def fourth_differences(follower: Follower) -> Array:
    """Changes of the jerk from sample to sample, of all twelve elements."""
    return np.diff(np.array(follower.poses), n=4, axis=0) / follower.period**3


def test_fades_are_continuous_up_to_the_jerk() -> None:
    """Half the period, half the change of the jerk: a step of it would stay, others grow."""
    coarse, fine = (np.abs(fourth_differences(scenario(p))).max() for p in (0.002, 0.001))
    assert fine == pytest.approx(coarse / 2.0, rel=0.15)


def test_a_jump_goes_on_from_the_last_sample_and_tells_in_the_next() -> None:
    """Whatever is under way: no cycle is lost, and what was sent is where it begins."""
    follower = Follower(period=0.001)
    follower.see(Transform.translation(0.01, 0.0, 0.0))
    follower.run(0.1)
    last, upcoming = (Moment(follower.tick - 1), Moment(follower.tick))
    sent, promised = (follower.goal.pose(moment) for moment in (last, upcoming))
    follower.see(Transform.rotation((0.0, 0.0, 1.0), 0.3)._replace(px=0.02, py=0.01))
    assert follower.goal.pose(last) == pytest.approx(sent, abs=1e-14)
    assert follower.goal.pose(upcoming) != pytest.approx(promised, abs=1e-14)
    assert follower.goal.pose(upcoming) == pytest.approx(promised, abs=1e-8)


def test_a_pose_of_six_digits_makes_no_jump() -> None:
    """Its rotation is one to 1e-6 only: taken as it is, two of them would differ by that."""
    rounded = Transform(*(round(x, 6) for x in Transform.rpy(0.3, -0.2, 0.1)))
    assert rounded.rigidity_error() > 1e-7
    follower = Follower(rounded)
    follower.run(0.1)
    sent = follower.poses[-1]
    assert sent.is_rigid(1e-12)
    follower.see(Transform.rpy(0.32, -0.2, 0.1))
    assert follower.goal.pose(Moment(follower.tick - 1)) == pytest.approx(sent, abs=1e-14)


@pytest.mark.parametrize("later", range(1, 25))
def test_a_fade_that_has_to_wait_goes_on_from_the_last_sample_too(later: int) -> None:
    """At the peak of the acceleration no margin remains; observed again before or after."""
    follower = Follower()
    follower.see(Transform.translation(0.01, 0.0, 0.0))
    follower.run(14 * PERIOD_S)
    promised = follower.goal.pose(Moment(follower.tick))
    follower.see(Transform.translation(0.1, 0.0, 0.0))
    assert follower.goal.pose(Moment(follower.tick)) == promised
    follower.run(later * PERIOD_S)
    follower.see(Transform.translation(0.0, 0.02, 0.0))
    sent = follower.goal.pose(Moment(follower.tick - 1))
    assert sent == pytest.approx(follower.poses[-1], abs=1e-14)
    follower.run(3.0)
    assert largest(follower.accelerations()) <= LIMITS.acceleration
    assert follower.poses[-1] == Transform.translation(0.0, 0.02, 0.0)


def test_half_a_turn_is_one_whichever_way_it_is_seen() -> None:
    """From a frame that turns to one at rest: in the midst of the samples the short way changes."""
    follower = Follower()
    follower.see(REST, twist=(0.0, 0.0, 0.0, 0.0, 0.0, 1.0), limits=None)
    follower.run(0.6)
    follower.poses.clear()
    angle = (follower.tick - 1) * PERIOD_S
    follower.run(0.02)
    follower.see(Transform.rotation((0.0, 0.0, 1.0), angle + 0.02 + 1e-4 - math.pi))
    follower.run(4.0)
    assert largest(follower.angular_accelerations()) <= LIMITS.angular_acceleration
    assert follower.poses[-1] == pytest.approx(follower.poses[-2], abs=1e-12)


def test_a_reference_is_a_function_of_the_tick_in_any_order() -> None:
    follower = scenario(PERIOD_S)
    ticks = list(range(follower.tick - 60, follower.tick))
    forwards = [follower.goal.pose(Moment(tick)) for tick in ticks]
    backwards = [follower.goal.pose(Moment(tick)) for tick in reversed(ticks)]
    assert forwards == backwards[::-1]


def track(
    truth: Callable[[float], Transform], noise: float, seconds: float, moving_from: float
) -> Follower:
    """Observed at 50 Hz, 20 ms late; used by a motion from some time on."""
    chance = random.Random(5)
    follower = Follower(truth(0.0))
    for _ in range(round(seconds / 0.02)):
        follower.run(0.02)
        time = follower.tick * PERIOD_S
        x, y, z = (chance.gauss(0.0, noise) for _ in range(3))
        seen = Transform.translation(x, y, z) @ truth(time - 0.02)
        limits = LIMITS if time >= moving_from else None
        follower.see(seen, "velocity", 0.02, limits)
    return follower


def belt(time: float) -> Transform:
    return Transform.translation(0.3, 0.2 * time, -0.1)


@pytest.mark.parametrize("moving_from", [0.0, 0.5], ids=["from the start", "once it is known"])
def test_a_part_on_a_belt_is_followed_to_the_noise_of_its_pictures(moving_from: float) -> None:
    follower = track(belt, 0.2e-3, 4.0, moving_from)
    times = np.arange(follower.tick) * PERIOD_S
    truth = np.array([belt(time)[3::4] for time in times])
    errors = (follower.places - truth)[600:]
    assert np.sqrt(np.mean(np.sum(errors**2, axis=1))) < math.sqrt(3.0) * 0.2e-3
    assert np.abs(errors.mean(axis=0)).max() < 0.05e-3  # no lag
    settled = round(max(moving_from, 0.04) / PERIOD_S)
    accelerations = follower.accelerations()[settled:]
    assert largest(accelerations) <= LIMITS.acceleration
    assert largest(accelerations[600:]) < 0.6 * LIMITS.acceleration


def test_without_noise_the_part_is_followed_exactly() -> None:
    follower = track(belt, 0.0, 4.0, 0.0)
    times = np.arange(follower.tick) * PERIOD_S
    truth = np.array([belt(time)[3::4] for time in times])
    errors = np.linalg.norm(follower.places - truth, axis=1)
    assert errors[0] == 0.0
    assert errors[25:250].max() > 0.01  # caught up within the limits, which takes its time
    assert errors[600:].max() < 1e-9


@settings(max_examples=40)
@given(st.integers(0, 2**32), st.floats(0.2, 3.0), st.sampled_from([1, 3, 13, 40]))
def test_any_observations_keep_the_limits_and_are_reached(
    seed: int, acceleration: float, rarest: int
) -> None:
    """Jumps of up to 10 mm and 0.05 rad, each before the one before is over; then none."""
    chance = random.Random(seed)
    limits = Limits(acceleration, 5.0 * acceleration)
    follower = Follower(lever=0.1)
    pose = REST
    for _ in range(40):
        axis = [chance.gauss(0.0, 1.0) for _ in range(3)]
        pose = Transform.rotation(axis, chance.uniform(0.0, 0.05))._replace(
            px=chance.uniform(-0.005, 0.005), pz=chance.uniform(-0.005, 0.005)
        )
        follower.see(pose, limits=limits)
        if follower.poses:
            sent = follower.goal.pose(Moment(follower.tick - 1))
            assert sent == pytest.approx(follower.poses[-1], abs=1e-13)
        follower.run(chance.randint(1, rarest) * PERIOD_S)
    follower.run(5.0)
    assert largest(follower.accelerations()) <= acceleration
    assert largest(follower.angular_accelerations()) <= limits.angular_acceleration
    expected = pose @ Transform.translation(0.1, 0.0, 0.0)
    assert follower.poses[-1] == pytest.approx(expected, abs=1e-12)
