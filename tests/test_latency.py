"""From an observation to T6 on the bus and to the DAC, as tools/bench_latency.py measures it."""

import pytest
from latency_twins import CYCLES, Latency, measure

pytestmark = pytest.mark.system

SAMPLES = 60


@pytest.fixture(scope="module")
def latencies() -> list[Latency]:
    return measure(SAMPLES, seed=3)


def test_an_observation_changes_the_dacs_within_two_cycles(latencies: list[Latency]) -> None:
    """Of the cycle in progress, at any moment within it, in motion and at rest.

    In the cycle that T6 changes in, but for the one in which a segment hands over to the next.
    """
    print(f"{max(latency.dac_ms for latency in latencies):.2f} ms at most")
    assert max(x.dac_cycles - x.closed for x in latencies) <= 2 < CYCLES
    at_once = [x for x in latencies if x.dac_cycles == x.setpoint_cycles]
    assert len(at_once) >= 0.9 * len(latencies)
    assert max(x.dac_ms for x in at_once) <= 8.0


def test_an_observation_reaches_t6_with_the_next_setpoint_made(latencies: list[Latency]) -> None:
    """One cycle after the one in progress: once that is closed, after the next."""
    assert {latency.closed for latency in latencies} == {0, 1}
    for latency in latencies:
        assert latency.setpoint_cycles == 1 + latency.closed


def test_the_moments_are_spread(latencies: list[Latency]) -> None:
    """What the maxima are worth: every fifth of a cycle is hit, in motion and at rest."""
    for moving in (False, True):
        fifths = {int(5 * x.phase) for x in latencies if x.moving is moving}
        assert fifths == set(range(5))
