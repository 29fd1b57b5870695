"""What sensors do to the motion under way: a part on a belt, and a goal corrected by a camera.

Positions are those of the arm by its encoders at the SYNC of a cycle, compared with where the part
truly is at that same moment of the server's time; the server only knows late pictures of it.
"""

import random
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from example_run import Array, Trace, Truth, example, on_the_belt, origin, run_example

from rfms_can.transform import Transform

pytestmark = pytest.mark.system

ARMS = ("puma260", "puma560")
THERE = 3
"""Number of the move to the part on the belt."""
SETTLED_S = 0.1
"""From the arrival at the part to steady state."""
NOISE_M = 0.2e-3
"""Of a picture, standard deviation in each direction."""


def riding(run: Trace, module: ModuleType) -> list[int]:
    """Cycles in which the tool rides along, settled, and before it grips."""
    arrived = run.statuses[run.arrival(THERE)].time
    begin, end = arrived + SETTLED_S, arrived + module.RIDE
    return [i for i, status in enumerate(run.statuses) if begin <= status.time < end]


def tool_errors(run: Trace, belt: Any, cycles: list[int]) -> Array:
    """Tool less true part, m (n, 3), at the same moments."""
    parts = np.array([origin(belt.part(run.statuses[i].time)) for i in cycles])
    errors: Array = run.measured_tools()[cycles] - parts
    return errors


def rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("friction", ["corke", "thesis"])
@pytest.mark.parametrize("arm", ARMS)
def test_a_part_on_a_belt_is_tracked(arm: str, friction: str, speed: float) -> None:
    module = example("conveyor", SPEED=speed)
    run, belt = on_the_belt(module, arm, friction)
    cycles = riding(run, module)
    assert len(cycles) >= 70
    errors = tool_errors(run, belt, cycles)
    worst = float(np.linalg.norm(errors, axis=1).max())
    print(
        f"{arm} {friction} {1e3 * speed:.0f} mm/s: {1e3 * rms(errors):.3f} mm rms, "
        f"{1e3 * worst:.3f} mm at most"
    )
    first, last = (origin(belt.part(run.statuses[i].time)) for i in (cycles[0], cycles[-1]))
    assert last[1] - first[1] == pytest.approx(speed * (module.RIDE - SETTLED_S), rel=0.05)
    assert rms(errors) < 0.2e-3


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("arm", ARMS)
def test_a_noisy_camera_is_good_enough_too(arm: str, speed: float) -> None:
    module = example("conveyor", SPEED=speed)
    chance = random.Random(7)

    def noisy(part: Truth, time: float) -> Transform:
        x, y, z = (chance.gauss(0.0, NOISE_M) for _ in range(3))
        return Transform.translation(x, y, z) @ part(time)

    run, belt = on_the_belt(module, arm, "corke", noisy)
    errors = tool_errors(run, belt, riding(run, module))
    print(f"{arm} {1e3 * speed:.0f} mm/s, 0.2 mm noise: {1e3 * rms(errors):.3f} mm rms")
    assert rms(errors) < 0.6e-3


def test_pictures_taken_as_fresh_would_be_late() -> None:
    """What the comparison is worth: without the time they were taken at, the tool lags behind."""
    module = example("conveyor", SPEED=0.2)
    late: float = module.LATE

    def older(part: Truth, time: float) -> Transform:
        return part(time - late)

    run, belt = on_the_belt(module, "puma560", "corke", older)
    errors = tool_errors(run, belt, riding(run, module))
    assert rms(errors) == pytest.approx(0.2 * late, rel=0.2)


# --- a correction on the way ---------------------------------------------------------------------


@cache
def with_camera(arm: str, friction: str) -> Trace:
    """One run of the example for all tests that look at it."""
    return run_example("camera", arm, friction)


@pytest.mark.parametrize("friction", ["corke", "thesis"])
@pytest.mark.parametrize("arm", ARMS)
def test_a_camera_correction_lands_on_the_part(arm: str, friction: str) -> None:
    module = example("camera")
    run = with_camera(arm, friction)
    hand = Transform(*run.statuses[0].t6)
    seen, drawn = (
        np.array(origin(p)) for p in (module.seen(hand), module.place(hand, module.DRAWN))
    )
    assert np.linalg.norm(seen - drawn) == pytest.approx(0.010)
    landed = run.arrival(2)
    assert run.statuses[landed].sequence == 2
    measured = float(np.linalg.norm(run.measured_tools()[landed] - seen))
    commanded = float(np.linalg.norm(run.commanded_tools()[landed] - seen))
    print(
        f"{arm} {friction}: landed {1e3 * measured:.3f} mm from the part, "
        f"commanded {1e6 * commanded:.2f} um"
    )
    assert commanded < 2e-5
    assert measured < 0.2e-3


@pytest.mark.parametrize("arm", ARMS)
def test_a_correction_adds_no_more_acceleration_than_the_mode_allows(arm: str) -> None:
    """The corrected run less its uncorrected twin: what the correction alone does to the tool."""
    corrected = with_camera(arm, "corke")
    twin = run_example("camera", arm, OFF=(0.0, 0.0, 0.0))
    module = example("camera")
    count = corrected.arrival(2)
    assert twin.arrival(2) == count
    added = corrected.commanded_tools()[:count] - twin.commanded_tools()[:count]
    acceleration = np.diff(added, n=2, axis=0) * 250.0**2
    largest = float(np.linalg.norm(acceleration, axis=1).max())
    step = float(np.linalg.norm(np.diff(acceleration, axis=0), axis=1).max())
    begun = int(np.flatnonzero(np.linalg.norm(added, axis=1) > 1e-6)[0])
    moving = corrected.statuses[begun]
    print(
        f"{arm}: the correction adds at most {largest:.3f} m/s2, "
        f"changing by at most {step:.3f} m/s2 a cycle"
    )
    assert moving.sequence == 2
    assert 0.01 < largest <= module.ACCELERATION
    assert np.linalg.norm(added[-1]) == pytest.approx(0.010, abs=2e-5)
