"""What of the safety core has changed since the committed table: its mutants, and the verdict."""

import random
import time
from collections.abc import Iterator, Sequence
from typing import Final

from rfms_can.engine import Backend, run
from safety_mutants.core import CORE
from safety_mutants.population import SEED, Case, cases_of
from safety_mutants.results import Conditions, Tried
from safety_mutants.survivors import SURVIVED_FOR
from safety_mutants.table import are_killed, judged, survivors
from safety_mutants.trial import fate_of, sound, to_be_sound

SAMPLE: Final = 80
"""Most mutants that are tried of what has changed."""
TIME_S: Final = 120.0
"""After this no other mutant is begun: with the last ones it stays below three minutes."""
ENOUGH: Final = 20
"""Mutants, or all of them, that must have been tried for a verdict."""


def changed(then: Conditions, now: Conditions) -> dict[str, frozenset[str]]:
    """Functions of each file that are new or read otherwise, or whose tests do.

    Where the tests of a file have changed, all of its functions are meant.
    """
    found: dict[str, frozenset[str]] = {}
    for file in now.functions:
        before, after = then.functions.get(file, {}), now.functions[file]
        functions = {name for name, code in after.items() if before.get(name) != code}
        if then.tests.get(file) != now.tests[file]:
            functions = set(after)
        if functions:
            found[file] = frozenset(functions)
    return found


def cases_of_changed(found: dict[str, frozenset[str]], size: int = SAMPLE) -> list[Case]:
    """A sample of their mutants, by seed."""
    pool = [case for file in CORE if file in found for case in cases_of(file)]
    pool = [case for case in pool if case.function in found[case.mutant.file]]
    return random.Random(SEED).sample(pool, min(size, len(pool)))


def try_all(cases: Sequence[Case], workers: Backend, time_s: float = TIME_S) -> Iterator[Tried]:
    """What becomes of mutants, as long as there is time.

    Raises:
        RfmsError: a test fails with the code as it is.
    """
    end = time.monotonic() + time_s

    def one(case: Case) -> Tried | None:
        if time.monotonic() > end:
            return None
        return Tried.of(case, fate_of(case.mutant))

    for _ in run(sound, to_be_sound({case.mutant.file for case in cases}), workers):
        pass
    yield from (result for result in run(one, list(cases), workers) if result is not None)


def verdict(cases: Sequence[Case], results: Sequence[Tried]) -> tuple[bool, list[str]]:
    """Whether all is well, and lines that say so: the survivors first."""
    alive = survivors(results)
    lines = [f"survived: {r.name}: {r.before} -> {r.after}{_reason(r)}" for r in alive]
    tried = f"{len(results)} of {len(cases)} mutants of what has changed tried"
    if len(results) < min(ENOUGH, len(cases)):
        return False, [*lines, f"{tried} in {TIME_S:g} s: too few for a verdict, use more workers"]
    well = are_killed(results)
    of = len(judged(results))
    lines.append(f"{tried}: {of - len(alive)} of {of} killed{'' if well else ', 95 of 100 wanted'}")
    return well, lines


def _reason(result: Tried) -> str:
    why = SURVIVED_FOR.get(result.name, ("", ""))[1]
    return f" ({why})" if why else ""
