"""``rfms doctor`` tells the truth about this machine and leaves it as it was."""

import json
import os
import re
import tomllib
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from rfms_can.cli import doctor as doctor_module
from rfms_can.cli.doctor import PACKAGES, can_interfaces, doctor, memory_lock, package, real_time
from rfms_can.wire.codec import database_hash

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"

app = typer.Typer()
app.command()(doctor)


def test_looks_at_every_dependency_of_the_package() -> None:
    dependencies = tomllib.loads(PYPROJECT.read_text())["project"]["dependencies"]
    assert [re.split(r"[<>=!~ ]", line)[0] for line in dependencies] == list(PACKAGES)


def test_default_run_works_where_the_tests_run() -> None:
    result = CliRunner().invoke(app, ["--json"])
    report = json.loads(result.stdout)
    assert (result.exit_code, report["ready"]) == (0, True)
    assert f"0x{database_hash():04X}" in report["checks"]["wire contract"]["detail"]
    assert re.search(r"imports in \d+\.\d\d s", report["checks"]["mujoco"]["detail"])
    for check in report["checks"].values():
        assert check["good"] or check["advice"]


def test_a_missing_package_is_named_and_ends_with_exit_code_1(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(doctor_module, "PACKAGES", {"no-such-package": "no_such_package"})
    result = CliRunner().invoke(app)
    assert result.exit_code == 1
    assert re.search(r"MISSING +no-such-package +not installed", result.stdout)
    assert "pip install no-such-package" in result.stdout
    assert "the default run does NOT work here" in result.stdout


def test_a_package_that_cannot_be_imported_says_why() -> None:
    finding = package("numpy", "numpy.no_such_module", needed=True)
    assert not finding.good
    assert "ModuleNotFoundError: No module named 'numpy.no_such_module'" in finding.detail


def test_interfaces_are_those_of_type_can(tmp_path: Path) -> None:
    for name, kind in {"vcan0": "280\n", "can0": "280\n", "eth0": "1\n"}.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "type").write_text(kind)
    assert list(can_interfaces(tmp_path)) == ["can0", "vcan0"]


def test_trying_real_time_changes_neither_policy_nor_locked_memory() -> None:
    def locked() -> str:
        status = Path("/proc/self/status").read_text()
        return next(line for line in status.splitlines() if line.startswith("VmLck"))

    before = os.sched_getscheduler(0), os.sched_getparam(0), locked()
    real_time()
    memory_lock()
    assert (os.sched_getscheduler(0), os.sched_getparam(0), locked()) == before
