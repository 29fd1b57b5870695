"""Deterministic hypothesis, and the wire compiled once for all tests.

A failing example is told as it was found: to shrink a whole motion takes minutes. For a smaller
one: ``pytest --hypothesis-profile=shrink``.
"""

import pytest
from hypothesis import HealthCheck, Phase, settings

from rfms_can.wire.contract import Wire

settings.register_profile(
    "shrink",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "ci", settings.get_profile("shrink"), phases=[Phase.explicit, Phase.generate]
)
settings.load_profile("ci")


def pytest_configure(config: pytest.Config) -> None:
    """Without ``-m`` leave out what needs a vcan0, and say so; tools/run_tests.py asks for it."""
    if not config.option.markexpr:
        config.option.markexpr = "not vcan"


def pytest_report_header(config: pytest.Config) -> str | None:
    if config.option.markexpr == "not vcan":
        return "tests on vcan0 are left out: tools/with-vcan python -m pytest -m vcan"
    return None


@pytest.fixture(scope="session")
def wire() -> Wire:
    return Wire()
