"""A mutant under the tests of its file, in a process of its own that has everything to load again.

What the tests need besides the package is loaded once, before there are children.
"""

import importlib
import os
import sys
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

import pytest
from node_mutants.apart import apart
from node_mutants.loading import Finder
from node_mutants.mutant import Mutant
from node_mutants.trial import KILLED, RAISED, SURVIVED, TIMEOUT

from rfms_can.errors import RfmsError
from safety_mutants.core import CORE, ROOT, path_of_test

CPU_S: Final = 60
"""Processor time after which a mutant has hung; tests of a file take 10 s at most."""
AT_ONCE: Final = 6
"""Test files that are run together with the code as it is: loading it costs as much as one."""
TOLD: Final = 160
"""Characters that are kept of what a test said."""

_WARM: Final = (
    "cantools",
    "e2e.p05",
    "hypothesis.stateful",
    "msgspec",
    "mujoco",
    "numpy",
    "pytest",
)
_COLD: Final = ("rfms_can", "support", "conftest", "test_")
"""Beginnings of modules that a child loads again: the package, and its tests."""
_ARGUMENTS: Final = (
    *("-x", "-q", "-p", "no:cacheprovider", "-p", "no:faulthandler", "-p", "no:xdist"),
    *("-m", "not system and not processes and not vcan", f"--rootdir={ROOT}"),
    *("-c", str(ROOT / "pyproject.toml")),
)


class Fate(NamedTuple):
    """What became of a mutant.

    Attributes:
        verdict: ``KILLED`` by a test; ``RAISED`` where it is imported; ``TIMEOUT``; ``SURVIVED``.
        test: that failed first, or "".
        told: what it said.
    """

    verdict: str
    test: str = ""
    told: str = ""


class _First:
    """A plugin of pytest that keeps the first failure."""

    def __init__(self) -> None:
        self.test = self.told = ""

    def pytest_runtest_logreport(self, report: Any) -> None:
        """A phase of a test is over."""
        self._keep(report)

    def pytest_collectreport(self, report: Any) -> None:
        """A file has been loaded, or has not."""
        self._keep(report)

    def _keep(self, report: Any) -> None:
        if report.failed and not self.told:
            crash = getattr(report.longrepr, "reprcrash", None)
            words = str(report.longrepr) if crash is None else crash.message
            last = words.strip().splitlines()[0 if crash else -1]
            self.test, self.told = report.nodeid.removeprefix("tests/"), last[:TOLD]


@cache
def warm() -> None:
    """Load what does not depend on the package."""
    for name in _WARM:
        importlib.import_module(name)


def examine(mutant: Mutant | None, tests: Sequence[str]) -> Fate:
    """Tests with a mutant in the place of its file, in this process, which is spoilt by it."""
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(quiet, stream)
    os.chdir(ROOT)
    for name in [name for name in sys.modules if name.startswith(_COLD)]:
        del sys.modules[name]
    if mutant is not None:
        sys.meta_path.insert(0, Finder(mutant))
    first = _First()
    paths = [str(path_of_test(name)) for name in tests]
    code = int(pytest.main([*_ARGUMENTS, *paths], plugins=[first]))
    if code == pytest.ExitCode.OK:
        return Fate(SURVIVED)
    if code == pytest.ExitCode.TESTS_FAILED and "::" in first.test:  # else a file, as it loaded
        return Fate(KILLED, first.test, first.told)
    return Fate(RAISED, first.test, first.told or f"pytest ended with exit code {code}")


def fate_of(mutant: Mutant) -> Fate:
    """What becomes of a mutant in a process of its own."""
    warm()
    return apart(lambda: examine(mutant, CORE[mutant.file]), CPU_S) or Fate(TIMEOUT)


def to_be_sound(files: Iterable[str]) -> list[tuple[str, ...]]:
    """The tests of files of the core, each once, some at a time."""
    names = sorted({name for file in files for name in CORE[file]})
    return [tuple(names[k : k + AT_ONCE]) for k in range(0, len(names), AT_ONCE)]


def sound(tests: tuple[str, ...]) -> tuple[str, ...]:
    """That tests pass with the code as it is: what fails then would kill every mutant.

    Raises:
        RfmsError: one does not.
    """
    warm()
    fate = apart(lambda: examine(None, tests), CPU_S) or Fate(TIMEOUT)
    if fate.verdict != SURVIVED:
        raise RfmsError(
            f"{fate.test or ', '.join(tests)} fails with the code as it is ({fate.verdict}: "
            f"{fate.told}): mend the test before mutants are tried"
        )
    return tests
