"""What a redefinition does to the motion under way, as the master hands it on."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from rfms_can.arm import PUMA_260
from rfms_can.master.motion import Motion
from rfms_can.master.trajectory.goal import Moment
from rfms_can.messages import (
    ModeMessage,
    MoveRequest,
    PositionMessage,
    StopRequest,
    TransformMessage,
)
from rfms_can.transform import Transform
from rfms_can.wire.vocabulary import Blend

Array = npt.NDArray[np.float64]

PERIOD_S = 0.004
ACCELERATION = 0.5


class Run:
    """An arm at park, a part it may see 40 mm above, and the set-points made."""

    def __init__(self) -> None:
        self.motion = Motion(PUMA_260, PERIOD_S, Blend.CONTINUOUS, lambda *_: None)
        self.motion.enable(PUMA_260.park)
        park = self.motion.generator.tick().T6_1
        self.part = park @ Transform.translation(0.0, 0.0, 0.04)
        self.see(0.0)
        for message in (
            TransformMessage("home", park),
            PositionMessage("home", ["t6"], ["home"]),
            PositionMessage("part", ["t6"], ["part"]),
            ModeMessage(
                *("slow", "cartesian", 0.2, 1.2), acceleration=ACCELERATION, transition="cartesian"
            ),
            ModeMessage("gentle", "cartesian", 0.2, 1.2, acceleration=0.5 * ACCELERATION),
        ):
            self.motion.handle(message)
        self.places: list[tuple[float, float, float]] = []

    def see(self, x: float) -> None:
        """The part, x to the side."""
        seen = self.part @ Transform.translation(x, 0.0, 0.0)
        self.motion.handle(TransformMessage("part", seen, "reference"))

    def move(self, position: str, mode: str = "slow") -> None:
        self.motion.handle(MoveRequest(position, mode))

    def run(self, seconds: float) -> Transform:
        for _ in range(round(seconds / PERIOD_S)):
            setpoint = self.motion.next_setpoint()
            assert self.motion.stopped_short is None
            pose = setpoint.T6_1
            self.places.append((pose.px, pose.py, pose.pz))
        return pose

    def accelerations(self) -> Array:
        second: Array = np.diff(np.array(self.places), n=2, axis=0) / PERIOD_S**2
        return second

    def goal(self) -> Transform:
        """Where the part is taken to be in the next set-point."""
        goal = self.motion.world.position("part").goal
        return goal.pose(Moment(self.motion.generator.tick_count))


def jumped(run: Run) -> bool:
    """Whether an observation 10 mm aside acts at once."""
    before = run.goal()
    run.see(0.01)
    after = run.goal()
    return after != pytest.approx(before, abs=1e-3)


def test_a_correction_on_the_way_lands_on_the_part_within_the_limit() -> None:
    corrected, twin = Run(), Run()
    for run in (corrected, twin):
        run.move("part")
        run.run(0.6)
        if run is corrected:
            run.see(0.01)
        end = run.run(1.4)
        assert run.motion.at_rest
        aside = 0.01 if run is corrected else 0.0
        assert end == pytest.approx(run.part @ Transform.translation(aside, 0.0, 0.0), abs=1e-9)
    added = corrected.accelerations() - twin.accelerations()
    largest = float(np.linalg.norm(added, axis=1).max())
    assert 0.5 * ACCELERATION < largest <= ACCELERATION
    steps = [float(np.linalg.norm(after - before)) for before, after in pairwise(added)]
    assert max(steps) < 0.15 * ACCELERATION


def test_what_stands_at_the_part_follows_it_within_the_limit() -> None:
    run = Run()
    run.move("part")
    run.run(2.0)
    run.places.clear()
    run.see(0.01)
    end = run.run(1.0)
    assert end == pytest.approx(run.part @ Transform.translation(0.01, 0.0, 0.0), abs=1e-9)
    assert np.linalg.norm(run.accelerations(), axis=1).max() <= ACCELERATION


def test_a_part_nothing_goes_to_jumps() -> None:
    run = Run()
    assert jumped(run)  # at rest, nowhere near it


def test_a_part_that_only_a_waiting_move_goes_to_jumps_until_that_is_settled() -> None:
    run = Run()
    run.move("home", "gentle")
    run.move("part", "gentle")
    run.run(0.4)
    assert jumped(run)
    run.see(0.0)
    generator = run.motion.generator
    while len(generator.active_goals) < 2:
        run.run(PERIOD_S)
    assert generator.sequence == 1
    assert not jumped(run)


def test_a_part_left_behind_jumps() -> None:
    run = Run()
    run.move("part")
    run.run(2.0)
    run.move("home")
    run.run(1.0)
    assert jumped(run)


def test_the_mode_the_arm_moves_with_counts() -> None:
    run = Run()
    run.move("part")
    run.move("part", "gentle")
    run.run(3.4)
    run.places.clear()
    run.see(0.01)
    run.run(1.0)
    largest = np.linalg.norm(run.accelerations(), axis=1).max()
    assert 0.25 * ACCELERATION < largest <= 0.5 * ACCELERATION


def test_after_a_stop_the_arm_holds_where_it_stands() -> None:
    run = Run()
    run.move("part")
    run.run(0.6)
    run.motion.handle(StopRequest())
    end = run.run(1.0)
    run.see(0.01)
    assert run.run(0.2) == end


def test_what_nobody_observes_any_more_is_not_followed_for_ever() -> None:
    """Two pictures after the last one the belt is taken to stop, within the mode's limits."""
    run = Run()
    motion, part = run.motion, run.part
    speed = 0.05
    motion.handle(TransformMessage("belt", part, "reference", predict="velocity"))
    motion.handle(PositionMessage("on the belt", ["t6"], ["belt"]))
    run.move("on the belt")
    places = []
    for k in range(900):
        if k < 400 and k % 5 == 0:
            seen = Transform.translation(0.0, speed * k * PERIOD_S, 0.0) @ part
            motion.handle(
                TransformMessage("belt", seen, "reference", predict="velocity", stamp=None)
            )
        setpoint = motion.next_setpoint()
        assert motion.stopped_short is None
        places.append(setpoint.T6_1.py)
    rates = np.diff(places) / PERIOD_S
    last_seen = 395
    assert rates[last_seen + 8] == pytest.approx(speed, rel=1e-3)  # carried on for 40 ms
    assert rates[last_seen + 10 + 50] > 1e-4  # 0.2 s are too few for the mode's 0.5 m/s2
    assert np.max(np.abs(rates[last_seen + 10 + 60 :])) < 1e-9  # and at rest soon after
    fading = np.diff(places[last_seen:], n=2) / PERIOD_S**2
    assert np.max(np.abs(fading)) <= ACCELERATION
