"""The tables of docs/safety-mutants.md, and the rule by which survivors are too many."""

from collections.abc import Iterable, Sequence
from typing import Final

from generated import table
from node_mutants import trial
from node_mutants.survivors import EQUIVALENT

from safety_mutants.core import CORE
from safety_mutants.operators import OPERATORS
from safety_mutants.results import Conditions, Tried
from safety_mutants.survivors import SURVIVED_FOR

TEXT: Final = 60
"""Characters of a mutant's text that are shown."""
TOLERATED: Final = 20
"""One of so many may survive, and one of fewer."""


def is_equivalent(result: Tried) -> bool:
    """Whether a survivor does what the code as it is does."""
    return SURVIVED_FOR.get(result.name, ("", ""))[0] == EQUIVALENT


def judged(results: Iterable[Tried]) -> list[Tried]:
    """Those that do something else than the code as it is."""
    return [r for r in results if r.verdict != trial.SURVIVED or not is_equivalent(r)]


def survivors(results: Iterable[Tried]) -> list[Tried]:
    """Those of them that no test has found. One that hung is found: a test that hangs is seen."""
    return [r for r in judged(results) if r.verdict == trial.SURVIVED]


def are_killed(results: Sequence[Tried]) -> bool:
    """Whether 95 of 100 are killed; of fewer than 20 all but one."""
    return len(survivors(results)) <= max(1, len(judged(results)) // TOLERATED)


def of_the_campaign(results: Sequence[Tried], conditions: Conditions) -> str:
    """What was drawn, rows for files and operators, and the survivors."""
    head = (
        f"{len(results)} of {conditions.population} mutants drawn without replacement by "
        f"`random.Random({conditions.seed})`."
    )
    columns = ("tried", "failed a test", "raised", "hung", "survived", "equivalent")
    files = [
        (f"`{file}`", *_row([r for r in results if r.file == file]), _tests(file)) for file in CORE
    ]
    kinds = [(kind, *_row([r for r in results if r.kind == kind])) for kind in OPERATORS]
    total = ("**all**", *_row(results))
    return "\n\n".join(
        (
            head,
            table(("file", *columns, "killed of the others", "tests"), [*files, (*total, "")]),
            table(("operator", *columns, "killed of the others"), [*kinds, total]),
            _survivors(results),
        )
    )


def _tests(file: str) -> str:
    return ", ".join(f"`{name}`" for name in CORE[file])


def _row(results: Sequence[Tried]) -> tuple[str, ...]:
    def count(verdict: str) -> str:
        return str(sum(r.verdict == verdict for r in results))

    others = judged(results)
    killed = len(others) - len(survivors(results))
    rate = f"{killed} of {len(others)}"
    if others:
        rate += f" ({100 * killed / len(others):.1f} %)"
    verdicts = (trial.KILLED, trial.RAISED, trial.TIMEOUT, trial.SURVIVED)
    same = str(len(results) - len(others))
    return str(len(results)), *map(count, verdicts), same, rate


def _survivors(results: Iterable[Tried]) -> str:
    rows = []
    for r in results:
        if r.verdict == trial.SURVIVED:
            word, why = SURVIVED_FOR.get(r.name, ("not judged", ""))
            what = f"{r.kind}: {_code(r.before)} → {_code(r.after)}"
            rows.append((word, f"{r.file} `{r.function}`", what, why))
    return table(("survivor", "where", "what", "why"), sorted(rows))


def _code(text: str) -> str:
    line = " ".join(text.split())
    return f"`{line if len(line) <= TEXT else line[:TEXT] + '...'}`"
