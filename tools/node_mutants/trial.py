"""A mutant against the conformance suite, in a process of its own, which may hang or raise."""

from collections.abc import Iterable
from functools import cache
from typing import Final, NamedTuple

from node_mutants.apart import apart
from node_mutants.loading import joint_of
from node_mutants.mutant import Mutant
from rfms_can.conform.lines import PumpedLine
from rfms_can.conform.outcome import Verdict
from rfms_can.conform.runner import run_checks
from rfms_can.conform.table import CHECKS, Check
from rfms_can.conform.tester import Tester
from rfms_can.conform.vectors import Vectors
from rfms_can.wire.contract import Wire

CPU_S: Final = 60
"""Processor time after which a mutant has hung; the suite takes 3 s for a joint."""
SLOW: Final = ("31", "43b", "30c", "40e", "8", "29c", "43e", "29", "30b", "30")
"""Checks that take nine tenths of the time, by time: asked last."""
ALIKE: Final = ("43b", "30c", "40e", "8", "29c", "43e", "29", "30b", "30")
"""Those of them that ask every joint the same: of joint 3 alone."""
LIKELY: Final = {
    "setpoint/": ("30",),
    "kinematics/": ("31e", "31f", "31g", "31h", "31i", "31"),
    "joint_nodes/servo.py": ("29",),
    "joint_nodes/friction.py": ("29",),
    "joint_nodes/compliance.py": ("29",),
    "joint_nodes/stop_ramp.py": ("43b",),
    "joint_nodes/homing.py": ("43b",),
    "joint_nodes/detectors/runaway.py": ("40e",),
    "wire/configuration.py": ("12", "12b", "19"),
    "wire/protection.py": ("4", "5"),
}
"""Checks that are about a file: asked first."""
FIRST: Final = 3
"""The joint that all checks are run with."""
OTHERS: Final = {True: (6, 1, 2, 4, 5), False: (6,)}
"""Then these, with the others: all where the mutant is in what solves one joint's angle."""
OF_ONE_JOINT: Final = ("kinematics/", "joint_nodes/angle_solver.py")

KILLED: Final = "killed"
RAISED: Final = "raised"
TIMEOUT: Final = "timeout"
SURVIVED: Final = "survived"


class Fate(NamedTuple):
    """What became of a mutant.

    Attributes:
        verdict: ``KILLED``, ``RAISED``, ``TIMEOUT`` or ``SURVIVED``.
        check: the first that failed, or "".
        joint: that it failed with, or 0.
        told: what the node answered, or what was raised.
    """

    verdict: str
    check: str = ""
    joint: int = 0
    told: str = ""


@cache
def _tester_parts() -> tuple[Wire, Vectors]:
    return Wire(), Vectors()


def examine(mutant: Mutant | None) -> Fate:
    """The suite on a mutant, joint by joint, up to the first required check that fails."""
    wire, vectors = _tester_parts()
    joint = FIRST
    try:
        make = joint_of(mutant)
        for joint, checks in _asked(mutant):
            line = PumpedLine(lambda joint=joint: make(joint, 0x100 + joint))  # type: ignore[misc]
            for outcome in run_checks(Tester(line, joint, wire, vectors), checks, fail_fast=True):
                if outcome.required and outcome.verdict is Verdict.FAILED:
                    return Fate(KILLED, outcome.id, joint, outcome.got[:160])
    except Exception as error:  # whatever a mutant raises ends it
        return Fate(RAISED, "", joint, f"{type(error).__name__}: {error}"[:160])
    return Fate(SURVIVED)


def _asked(mutant: Mutant | None) -> Iterable[tuple[int, list[Check]]]:
    """Joints and their checks, in order."""
    file = "" if mutant is None else mutant.file
    likely = [id_ for begin, ids in LIKELY.items() if file.startswith(begin) for id_ in ids]

    def rank(check: Check) -> int:
        if check.id in likely:
            return -1
        return SLOW.index(check.id) + 1 if check.id in SLOW else 0

    checks = sorted(CHECKS, key=rank)
    yield FIRST, checks
    some = [check for check in checks if check.id not in ALIKE]
    for joint in OTHERS[file.startswith(OF_ONE_JOINT)]:
        yield joint, some


def fate_of(mutant: Mutant | None) -> Fate:
    """What becomes of a mutant in a process of its own."""
    _tester_parts()  # made once, before there are children
    return apart(lambda: examine(mutant), CPU_S) or Fate(TIMEOUT)
