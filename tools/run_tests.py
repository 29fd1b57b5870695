"""Run every check and test this machine can, and say plainly at the end what ran and what did not.

``--check`` stops after lint, formatting, types and import direction. Results of the tests go to
build/test-results/*.xml (JUnit). Exit code 0 only if nothing failed; what this machine cannot run
(vcan0) does not count as a failure unless the environment has RFMS_REQUIRE_VCAN=1.
"""

import argparse
import os
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "build" / "test-results"
BIN = Path(sys.executable).parent
WITH_VCAN = [sys.executable, "tools/with-vcan"]
WORKERS = str(min(4, os.cpu_count() or 1))
WIDTH = 100

BY_FILE = ["--dist", "loadfile", "--no-loadscope-reorder"]
"""Tests of a file share their runs; in order of names the longest files do not come last."""

CHECKS = {
    "ruff check": ["ruff", "check", "."],
    "ruff format": ["ruff", "format", "--check", "."],
    "mypy --strict": ["mypy"],
    "import direction": ["lint-imports"],
}
TESTS = {
    "fast": ["-m", "not system and not processes and not vcan", "-n", WORKERS],
    "system": ["-m", "system and not processes and not vcan", "-n", WORKERS, *BY_FILE],
    "processes": ["-m", "processes and not vcan"],
}
"""pytest's arguments for each group; tests of many processes have the processors to themselves."""

JOINT = "3"
"""The joint that stands before the conformance suite; tests have the others."""

HOW_TO_GET_VCAN = """\
    Debian:  sudo apt-get install user-mode-linux can-utils iproute2
    Ubuntu:  sudo apt-get install linux-modules-extra-$(uname -r) can-utils iproute2"""


@dataclass(frozen=True)
class Outcome:
    """How one group of checks or tests went.

    Attributes:
        name: of the group.
        failed: whether it fails the whole.
        seconds: wall-clock time.
        closing: last line it printed.
        skipped: tests that did not run, each with its reason.
    """

    name: str
    failed: bool
    seconds: float
    closing: str
    skipped: tuple[str, ...] = ()


def run(name: str, command: list[str]) -> Outcome:
    """Run a command, show its output as it comes, keep its last line."""
    print(f"\n{f' {name} ':=^{WIDTH}}", flush=True)
    begin = time.monotonic()
    last = ""
    with subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(line, end="", flush=True)
            last = line.strip() or last
    closing = last.strip("= ") if process.returncode == 0 else f"exit {process.returncode}: {last}"
    return Outcome(name, process.returncode != 0, time.monotonic() - begin, closing.strip("= "))


def run_pytest(name: str, arguments: list[str], prefix: list[str] | None = None) -> Outcome:
    """Run a group of tests; a group without tests fails (pytest's exit code 5)."""
    report = RESULTS / f"{name}.xml"
    pytest = [sys.executable, "-m", "pytest", "-q", f"--junitxml={report}", *arguments]
    outcome = run(name, [*(prefix or []), *pytest])
    return Outcome(
        f"{name} tests", outcome.failed, outcome.seconds, outcome.closing, skipped(report)
    )


def skipped(report: Path) -> tuple[str, ...]:
    """Tests a JUnit report lists as skipped, each with its reason."""
    if not report.exists():
        return ()
    return tuple(
        f"{case.get('classname')}.{case.get('name')}: {reason.get('message')}"
        for case in ET.parse(report).iter("testcase")
        for reason in case.findall("skipped")
    )


def run_conformance() -> Outcome:
    """Our joint before the conformance suite; its checks go to conform.xml."""
    report = str(RESULTS / "conform.xml")
    words = ["conform", JOINT, "--bus", "sim", "--class", "sensor", "--junit", report]
    return run("conformance", [str(BIN / "rfms"), *words])


def run_safety_mutants() -> Outcome:
    """Mutants of what has changed in the safety core since the committed table of them."""
    words = [sys.executable, "tools/safety_campaign.py", "--changed", "--workers", WORKERS]
    return run("safety mutants", words)


def vcan_tests() -> list[str]:
    """Node ids of the tests marked ``vcan``, collected here because it is slow inside."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", "vcan"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return re.findall(r"^tests/\S+\.py::.*$", done.stdout, re.MULTILINE)


def run_on_vcan0(required: bool) -> Outcome:
    """Run the tests marked ``vcan`` on a real vcan0, if one can be had."""
    name = "vcan0 tests"
    tests = vcan_tests()
    if not tests:
        return Outcome(name, True, 0.0, "no test is marked vcan, or collecting them failed")
    check = subprocess.run(
        [*WITH_VCAN, "--check"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if check.returncode != 0:
        reason = check.stderr.strip()
        return Outcome(name, required, 0.0, f"none of {len(tests)} ran", (reason, *tests))
    files = sorted({test.partition("::")[0] for test in tests})
    outcome = run_pytest("vcan", ["-m", "vcan", *files], WITH_VCAN)
    ran = len(tests) - len(outcome.skipped)
    way = check.stdout.partition(":")[0]
    closing = f"{ran} of {len(tests)} ran on vcan0 ({way}): {outcome.closing}"
    failed = outcome.failed or bool(outcome.skipped)
    return Outcome(name, failed, outcome.seconds, closing, outcome.skipped)


def summarise(outcomes: list[Outcome]) -> bool:
    """Print what ran, what could not, and whether all is well; return the latter."""
    print(f"\n{' SUMMARY ':=^{WIDTH}}")
    for outcome in outcomes:
        word = "FAILED" if outcome.failed else "not run" if not outcome.seconds else "passed"
        minutes, seconds = divmod(round(outcome.seconds), 60)
        print(f"{word:8} {outcome.name:18} {minutes:3} min {seconds:2} s   {outcome.closing}")
    minutes, seconds = divmod(round(sum(outcome.seconds for outcome in outcomes)), 60)
    print(f"{'':8} {'together':18} {minutes:3} min {seconds:2} s")
    lacking = [reason for outcome in outcomes for reason in outcome.skipped]
    if lacking:
        print(f"\n{' COULD NOT RUN ON THIS MACHINE ':*^{WIDTH}}")
        print("\n".join(f"  {reason}" for reason in lacking))
        if any("vcan" in reason for reason in lacking):
            print(f"  What gives this machine a vcan0:\n{HOW_TO_GET_VCAN}")
        print("*" * WIDTH)
    good = not any(outcome.failed for outcome in outcomes)
    verdict = "FAILED" if not good else "PASSED, with gaps: see above" if lacking else "PASSED"
    print(f"{f' {verdict} ':=^{WIDTH}}", flush=True)
    return good


def main() -> int:
    """Run checks, then tests from fast to slow."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="no tests: lint, types, imports")
    checks_only: bool = parser.parse_args().check
    outcomes = [
        run(name, [str(BIN / command[0]), *command[1:]]) for name, command in CHECKS.items()
    ]
    if not checks_only:
        RESULTS.mkdir(parents=True, exist_ok=True)
        for stale in RESULTS.glob("*.xml"):
            stale.unlink()
        outcomes += [run_pytest(name, arguments) for name, arguments in TESTS.items()]
        outcomes.append(run_conformance())
        outcomes.append(run_safety_mutants())
        outcomes.append(run_on_vcan0(os.environ.get("RFMS_REQUIRE_VCAN") == "1"))
    return 0 if summarise(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
