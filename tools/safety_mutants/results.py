"""The file of the campaign: what became of each mutant, of which code, under which tests."""

from pathlib import Path
from typing import Final, NamedTuple

from rfms_can.engine import Kept, ResultFile
from safety_mutants.core import CORE
from safety_mutants.population import (
    Case,
    functions_of,
    killer_fingerprint,
    population,
    tests_fingerprint,
)
from safety_mutants.trial import Fate

KEPT: Final = "docs/data/safety_mutants.jsonl"
"""The campaign that docs/safety-mutants.md tells of."""


class Conditions(NamedTuple):
    """What all mutants of a file have in common.

    Attributes:
        seed: of the sample.
        population: how many mutants the operators make.
        functions: their fingerprints, by file and function.
        tests: fingerprint of the tests of each file.
    """

    seed: int
    population: int
    functions: dict[str, dict[str, str]]
    tests: dict[str, str]

    @classmethod
    def here(cls, seed: int) -> "Conditions":
        """Of the code and the tests as they are."""
        return cls(
            seed,
            len(population()),
            {file: functions_of(file) for file in CORE},
            {file: tests_fingerprint(file) for file in CORE},
        )


class Tried(NamedTuple):
    """A mutant and what became of it.

    Attributes:
        name, file, kind, before, after: see ``Mutant``.
        function, code: see ``Case``.
        tests: digest of the file of the test that killed it, or of all tests of the file.
        verdict, test, told: see ``Fate``.
    """

    name: str
    file: str
    function: str
    kind: str
    before: str
    after: str
    code: str
    tests: str
    verdict: str
    test: str
    told: str

    @classmethod
    def of(cls, case: Case, fate: Fate) -> "Tried":
        """From its parts."""
        m = case.mutant
        by = killer_fingerprint(m.file, fate.test)
        return cls(m.name, m.file, case.function, m.kind, m.before, m.after, case.code, by, *fate)

    @property
    def holds(self) -> bool:
        """Whether the tests are those that it was tried by, or the one that killed it still is."""
        return self.file in CORE and self.tests == killer_fingerprint(self.file, self.test)


SAFETY: Final = ResultFile("mutants", "tools/safety_campaign.py", Conditions, Tried)


def opened(
    file: Path | None, conditions: Conditions, cases: list[Case], forget: frozenset[str]
) -> Kept[Conditions, Tried]:
    """The results of a file that are still true, and a place for others.

    Args:
        file: of results of this code, or of earlier code: then what has changed is left out.
        conditions: of the code and the tests as they are.
        cases: of the campaign: results of others are left out.
        forget: verdicts that are left out too.
    """
    if file is not None and file.exists():
        _, results = SAFETY.read(file)
        true = {(case.mutant.name, case.code) for case in cases}
        left = [r for r in results if (r.name, r.code) in true and r.holds]
        left = [r for r in left if r.verdict not in forget]
        SAFETY.write(file, conditions, left)
    return SAFETY.open(file, conditions)
