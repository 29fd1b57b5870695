"""A stop in joint angles where a path cannot be followed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfms_can.arm import PUMA_260
from rfms_can.errors import TrackingError
from rfms_can.kinematics import direct
from rfms_can.master.motion import Motion
from rfms_can.master.trajectory.braking import Brake
from rfms_can.master.trajectory.commanded import PAST_END
from rfms_can.messages import (
    ModeMessage,
    MoveRequest,
    PositionMessage,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend

TAU = 0.004
LIMITS = tuple(acceleration * TAU**2 for acceleration in PUMA_260.acceleration_limits)
LOWER, UPPER = np.array(PUMA_260.joint_limits).T


@settings(max_examples=100)
@given(
    st.tuples(*[st.floats(0.0, 1.0)] * 6),
    st.tuples(*[st.floats(-1.0, 1.0)] * 6),
)
def test_it_keeps_the_limits_and_the_ranges_and_ends(
    places: tuple[float, ...], rates: tuple[float, ...]
) -> None:
    speeds = np.array(rates) * PUMA_260.speed_limits
    steps = speeds * TAU
    stop = np.abs(steps) * (np.abs(steps) / np.array(LIMITS) - 1.0) / 2.0
    stop = np.maximum(stop, 0.0) + np.array(LIMITS) / 8.0  # steps are whole cycles
    theta = LOWER + stop + np.array(places) * (UPPER - LOWER - 2.0 * stop)
    brake = Brake(PUMA_260, theta.tolist(), steps.tolist(), LIMITS)
    run = [theta - steps, theta]
    for _ in range(200):
        run.append(np.array(brake.step()))
    assert brake.over
    bends = np.abs(np.diff(run, n=2, axis=0)).max(axis=0)
    assert np.all(bends <= np.array(LIMITS) * 1.125 + 1e-12)  # an eighth where a range ends it
    assert np.all(run[-1] >= LOWER - 1e-9) and np.all(run[-1] <= UPPER + 1e-9)


class Servoing:
    """An arm that follows a part it is shown, by a move that has come to it."""

    def __init__(self, q: tuple[float, float, float, float, float, float]) -> None:
        self.motion = Motion(PUMA_260, TAU, Blend.CONTINUOUS, lambda *_: None)
        self.motion.enable(q)
        self.start = direct(PUMA_260, q)
        self.q: list[tuple[float, ...]] = []
        self.told: list[str] = []
        self.see(Transform.identity())
        self.ask()

    def see(self, by: Transform) -> None:
        self.show(self.start @ by)

    def show(self, pose: Transform) -> None:
        """The part as it is seen; what the arm says of it is kept."""
        for _ in range(2):
            try:
                self.motion.handle(TransformMessage("part", pose, "reference"))
            except TrackingError as error:
                self.told.append(str(error))
            else:
                return

    def ask(self) -> None:
        names = self.motion.world.names().positions
        if "part" not in names:
            self.motion.handle(PositionMessage("part", ["t6"], ["part"]))
            mode = ModeMessage("follow", "cartesian", 0.2, 1.0, acceleration=20.0)
            self.motion.handle(mode)
        self.motion.handle(MoveRequest("part", "follow"))

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            self.motion.next_setpoint()
            added = self.motion.following.displaced(None) or (0.0,) * 6
            theta = self.motion.commanded.theta
            self.q.append(tuple(a + b for a, b in zip(theta, added, strict=True)))

    def check_limits(self) -> None:
        q = np.array(self.q)
        bends = np.abs(np.diff(q, n=2, axis=0)).max(axis=0) / TAU**2
        assert np.all(bends <= 1.02 * np.array(PUMA_260.acceleration_limits))
        rates = np.abs(np.diff(q, axis=0)).max(axis=0) / TAU
        assert np.all(rates <= 1.05 * np.array(PUMA_260.speed_limits))


def test_servoing_into_the_wrist_singularity_stops_short_and_can_be_led_out() -> None:
    servoing = Servoing((0.2, 1.3, -2.8, 0.4, 0.3, 0.1))
    servoing.run(400)
    for k in range(120):  # turn theta5 through zero, a little beside it
        servoing.see(Transform.rotation((0.1, 1.0, 0.0), 0.006 * k))
        servoing.run(5)
    reason = servoing.motion.stopped_short
    assert reason is not None and "joint 4" in reason
    assert "reference 'part' leads there, observed at (" in reason
    servoing.check_limits()
    assert servoing.motion.at_rest
    assert servoing.told == [f"stopped short: {reason}"]  # once: no move was under way to tell
    servoing.see(Transform.rotation((0.0, 1.0, 0.0), -0.1))
    servoing.motion.handle(ModeMessage("out", "joint", 0.3, 1.5))
    servoing.motion.handle(MoveRequest("part", "out"))
    servoing.motion.stopped_short = None
    servoing.run(600)
    servoing.check_limits()
    assert servoing.motion.at_rest and servoing.motion.stopped_short is None


def test_one_observation_out_of_reach_stops_short_and_names_itself() -> None:
    servoing = Servoing((0.2, 1.3, -2.8, 0.4, 1.0, 0.1))
    servoing.run(400)
    servoing.see(Transform.translation(0.0, 0.0, 1.5))
    servoing.run(1500)
    reason = servoing.motion.stopped_short
    assert reason is not None and reason.startswith("puma260: ")
    where = servoing.start @ Transform.translation(0.0, 0.0, 1.5)
    assert f"observed at ({where.px:.4g}, {where.py:.4g}, {where.pz:.4g}) m at t = " in reason
    servoing.check_limits()
    assert servoing.motion.at_rest


def test_a_joint_that_comes_to_its_range_by_servoing_stops_inside_it() -> None:
    servoing = Servoing((2.2, 1.3, -2.8, 0.4, 1.0, 0.1))
    servoing.run(400)
    for k in range(150):
        turned = Transform.rotation((0.0, 0.0, 1.0), 0.01 * k) @ servoing.start
        servoing.show(turned)
        servoing.run(4)
    servoing.run(300)
    servoing.check_limits()
    assert servoing.motion.stopped_short is not None
    assert "joint 1" in servoing.motion.stopped_short
    assert max(q[0] for q in servoing.q) <= UPPER[0] + PAST_END


@pytest.mark.parametrize("step", [0.0, 1e-13])
def test_at_rest_it_is_over_at_once(step: float) -> None:
    assert Brake(PUMA_260, PUMA_260.park, (step,) * 6, LIMITS).over
    assert not math.isnan(step)
