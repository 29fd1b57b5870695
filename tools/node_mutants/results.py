"""The files of the two campaigns: what became of each mutant, under the suite and in runs."""

from typing import Final, NamedTuple

from node_mutants.in_runs import Ended
from node_mutants.mutant import Mutant
from node_mutants.trial import Fate
from rfms_can.engine import ResultFile

KEPT: Final = "docs/data/mutant_campaign.jsonl"
KEPT_HELD_OUT: Final = "docs/data/mutant_held_out.jsonl"
KEPT_RUNS: Final = "docs/data/mutant_runs.jsonl"
"""The campaigns that docs/mutants.md tells of."""


class Conditions(NamedTuple):
    """What all mutants of a file have in common.

    Attributes:
        seed: of the sample.
        population: how many mutants the operators make.
        code: fingerprint of the code they are made of.
    """

    seed: int
    population: int
    code: str


class Tried(NamedTuple):
    """A mutant and what became of it under the suite.

    Attributes:
        name, file, line, kind, before, after: see ``Mutant``.
        verdict, check, joint, told: see ``Fate``.
    """

    name: str
    file: str
    line: int
    kind: str
    before: str
    after: str
    verdict: str
    check: str
    joint: int
    told: str

    @classmethod
    def of(cls, mutant: Mutant, fate: Fate) -> "Tried":
        """From its parts."""
        return cls(*mutant[:6], *fate)


class RunConditions(NamedTuple):
    """What all runs of a file have in common.

    Attributes:
        code: fingerprint of the code that the mutants are made of.
        settings: of the run, in words.
    """

    code: str
    settings: str


class Run(NamedTuple):
    """A mutant in a whole simulated run.

    Attributes:
        name, kind: see ``Mutant``.
        joint: whose node it was.
        worst: farthest that a joint was from where the master had it, rad.
        how: see ``Ended``.
        told: the last line that the run printed.
    """

    name: str
    kind: str
    joint: int
    worst: float
    how: str
    told: str

    @classmethod
    def of(cls, mutant: Mutant, joint: int, ended: Ended) -> "Run":
        """From its parts."""
        return cls(mutant.name, mutant.kind, joint, *ended)


SUITE: Final = ResultFile("mutants", "tools/mutant_campaign.py", Conditions, Tried)
RUNS: Final = ResultFile("runs", "tools/mutant_campaign.py --runs", RunConditions, Run)
read, read_runs = SUITE.read, RUNS.read
