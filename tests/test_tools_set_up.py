"""What stands between a fresh machine and ``make test`` says what is missing, and how to get it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import run_tests
from run_tests import Outcome, run_on_vcan0, run_pytest, skipped, summarise

MAKE_VENV = Path(__file__).parents[1] / "tools" / "make-venv"
REPORT = """<testsuites><testsuite name="pytest" tests="2" skipped="1">
<testcase classname="tests.test_a" name="test_runs"/>
<testcase classname="tests.test_a" name="test_waits"><skipped message="no candump"/></testcase>
</testsuite></testsuites>"""


def make_venv(tmp_path: Path, python3: str) -> "subprocess.CompletedProcess[str]":
    """Call make-venv where ``python3`` is this shell script and no other Python is found."""
    fake = tmp_path / "bin" / "python3"
    fake.parent.mkdir()
    fake.write_text(f"#!/bin/sh\n{python3}\n")
    fake.chmod(0o755)
    return subprocess.run(
        ["/bin/sh", MAKE_VENV, tmp_path / "venv"],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": str(fake.parent)},
    )


def test_an_old_python_is_refused_with_the_packages_that_help(tmp_path: Path) -> None:
    old = 'case "$*" in *version_info*) exit 1;; *) echo "Python 3.9.2";; esac'
    done = make_venv(tmp_path, old)
    assert done.returncode == 1
    assert "Python 3.11 or newer with venv is needed; here is Python 3.9.2" in done.stderr
    assert "sudo apt-get install python3 python3-venv" in done.stderr


def test_a_python_without_ensurepip_is_refused_with_its_package(tmp_path: Path) -> None:
    bare = 'case "$*" in *ensurepip*) exit 1;; *print*) echo 3.11;; esac'
    done = make_venv(tmp_path, bare)
    assert done.returncode == 1
    assert "python3 has no ensurepip" in done.stderr
    assert "sudo apt-get install python3.11-venv" in done.stderr
    assert not (tmp_path / "venv").exists()


@pytest.mark.system
def test_a_good_python_makes_an_environment(tmp_path: Path) -> None:
    environment = {**os.environ, "RFMS_PYTHON": sys.executable}
    subprocess.run(["/bin/sh", MAKE_VENV, tmp_path / "venv"], check=True, env=environment)
    subprocess.run([tmp_path / "venv" / "bin" / "python", "-c", "import pip"], check=True)


def test_skipped_tests_are_read_from_the_report_with_their_reasons(tmp_path: Path) -> None:
    (tmp_path / "fast.xml").write_text(REPORT)
    assert skipped(tmp_path / "fast.xml") == ("tests.test_a.test_waits: no candump",)
    assert skipped(tmp_path / "none.xml") == ()


@pytest.mark.parametrize("required", [False, True])
def test_a_machine_without_vcan_says_so_and_fails_only_if_it_must_not_lack_it(
    required: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    check = [sys.executable, "-c", "import sys; sys.exit('with-vcan: not possible: no vcan0')"]
    monkeypatch.setattr(run_tests, "WITH_VCAN", check)
    monkeypatch.setattr(run_tests, "vcan_tests", lambda: ["tests/test_b.py::test_on_vcan0"])
    good = summarise([run_on_vcan0(required)])
    said = capsys.readouterr().out
    assert good is not required
    assert "COULD NOT RUN ON THIS MACHINE" in said
    assert "with-vcan: not possible: no vcan0" in said
    assert "tests/test_b.py::test_on_vcan0" in said
    assert "apt-get install user-mode-linux can-utils iproute2" in said


def test_a_group_without_tests_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run_tests, "RESULTS", tmp_path)
    outcome = run_pytest("none", ["tests/test_tools_set_up.py", "-k", "no_such_test"])
    assert outcome.failed
    assert outcome.closing.startswith("exit 5: ")
    assert not summarise([outcome])
    assert "FAILED   none tests" in capsys.readouterr().out


def test_no_test_for_vcan_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_tests, "vcan_tests", list)
    assert run_on_vcan0(required=False).failed


def test_all_good_is_said_plainly(capsys: pytest.CaptureFixture[str]) -> None:
    assert summarise([Outcome("fast tests", False, 1.0, "9 passed in 0.9s")])
    said = capsys.readouterr().out
    assert re.search(r"passed   fast tests +0 min  1 s +9 passed in 0\.9s", said)
    assert " PASSED =" in said
    assert "COULD NOT" not in said
