"""Deterministic hypothesis, and the fixtures of many files: the wire, ``rfms``, recorded runs.

A failing example is told as it was found: to shrink a whole motion takes minutes. For a smaller
one: ``pytest --hypothesis-profile=shrink``.

Fixtures import what they need when they are asked for: a file's tests load no more than the file.
"""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.internal.conjecture import providers

from rfms_can.wire.contract import Wire

if TYPE_CHECKING:
    from support.command_line import Rfms

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

# Hypothesis also draws the numbers it finds in the source of what is loaded. Then any constant that
# is added anywhere, or the choice of test files, would be other examples: seeds fixed or not.
vars(providers)["_get_local_constants"] = lambda: vars(providers)["_local_constants"]  # none


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


@pytest.fixture
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty directory, in which hubs and servers of the test find each other, and no others."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


@pytest.fixture
def rfms(
    runtime: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> "Rfms":
    """``rfms`` with some arguments, in this process and in the empty directory ``runtime``."""
    from support.command_line import run_here

    monkeypatch.chdir(runtime)
    return partial(run_here, capsys, monkeypatch)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run of ``there_and_back``; it serves all tests, so none may change it."""
    from support.system import recorded_run

    return recorded_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="session")
def recorded_with_terms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same with the terms of the joint torques."""
    from support.system import recorded_run

    return recorded_run(tmp_path_factory.mktemp("terms"), terms=True)
