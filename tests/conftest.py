"""Deterministic hypothesis, and the wire compiled once for all tests."""

import pytest
from hypothesis import HealthCheck, settings

from rfms_can.wire import Wire

settings.register_profile(
    "ci",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("ci")


@pytest.fixture(scope="session")
def wire() -> Wire:
    return Wire()
