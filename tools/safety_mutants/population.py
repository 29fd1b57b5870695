"""All mutants of the safety core, by names that stay when lines move, and a sample of them."""

import random
from collections import Counter
from collections.abc import Iterator
from functools import cache
from typing import Final, NamedTuple

from node_mutants.mutant import Mutant, source_of
from node_mutants.population import mutants_of

from safety_mutants.core import CORE, LEFT_OUT, path_of_test, tests_of
from safety_mutants.operators import OPERATORS
from safety_mutants.owners import bare, digest, fingerprints, owners

SEED: Final = 1986
SAMPLE: Final = 300
TEXT: Final = 40
"""Characters of the replacement that a name has."""


class Case(NamedTuple):
    """A mutant, the function it is of, and the file it is made from.

    Attributes:
        mutant: its name is unique, and the same wherever its line stands in the function.
        function: e.g. ``Ladder.miss``.
        code: digest of the file as it is.
    """

    mutant: Mutant
    function: str
    code: str


@cache
def population() -> tuple[Case, ...]:
    """Every mutant, file by file, in the order of the text."""
    return tuple(case for file in CORE for case in cases_of(file))


def sample(seed: int = SEED, size: int = SAMPLE) -> list[Case]:
    """Drawn without replacement, each mutant as likely as any other."""
    return random.Random(seed).sample(population(), min(size, len(population())))


@cache
def functions_of(file: str) -> dict[str, str]:
    """Fingerprints of the functions of a file."""
    return fingerprints(source_of(file))


@cache
def tests_fingerprint(file: str) -> str:
    """Of all tests of a file."""
    return digest(bare(tests_of(file)))


def killer_fingerprint(file: str, test: str) -> str:
    """Of what a fate depends on besides the code: the file of the test that failed, or all tests.

    Args:
        file: the mutated one.
        test: e.g. ``test_joint_ladder.py::test_a_fault``; another or "" where no test has failed.
    """
    name, found, _ = test.partition(".py::")
    return _test_fingerprint(name) if found and name in CORE[file] else tests_fingerprint(file)


@cache
def _test_fingerprint(name: str) -> str:
    return digest(bare(path_of_test(name).read_text(encoding="utf-8")))


def cases_of(file: str) -> Iterator[Case]:
    """The mutants of one file."""
    source = source_of(file)
    owner, lines = owners(source), source.splitlines()
    code = digest(bare(source))
    seen: Counter[str] = Counter()
    for mutant in mutants_of(file, LEFT_OUT.get(file, frozenset()), OPERATORS):
        function = owner[mutant.line - 1]
        about = _about(mutant, function, lines, source)
        seen[about] += 1
        after = " ".join(mutant.after.split())[:TEXT]
        name = f"{file} {function} {mutant.kind} {after} #{digest(f'{about} {seen[about]}')}"
        yield Case(mutant._replace(name=name), function, code)


def _about(mutant: Mutant, function: str, lines: list[str], source: str) -> str:
    """What is changed, and into what: the lines it stands in, and where in them."""
    last = mutant.line + mutant.before.count("\n")
    whole = bare("\n".join(lines[mutant.line - 1 : last]))
    column = mutant.begin - source.rfind("\n", 0, mutant.begin) - 1
    line = lines[mutant.line - 1]
    inside = column - (len(line) - len(line.lstrip()))
    return "\0".join((function, mutant.kind, whole, str(inside), mutant.before, mutant.after))
