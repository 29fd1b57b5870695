"""The tables of docs/mutants.md, from results that are kept."""

import math
from collections.abc import Callable, Iterable, Sequence

from generated import table

from node_mutants import in_runs, trial
from node_mutants.hand import BY_HAND
from node_mutants.operators import OPERATORS
from node_mutants.results import Conditions, Run, RunConditions, Tried
from node_mutants.survivors import EQUIVALENT, MISSED, SURVIVED_FOR

TEXT = 60
"""Characters of a mutant's text that are shown."""


def is_equivalent(result: Tried) -> bool:
    """Whether a survivor does what the code as it is does."""
    return SURVIVED_FOR.get(result.name, ("", ""))[0] == EQUIVALENT


def killed_of(results: Iterable[Tried]) -> tuple[int, int]:
    """How many the suite killed, and of how many: without equivalents and those that hung."""
    judged = [r for r in results if r.verdict != trial.TIMEOUT and not is_equivalent(r)]
    return sum(r.verdict != trial.SURVIVED for r in judged), len(judged)


def of_the_suite(results: Sequence[Tried], conditions: Conditions) -> str:
    """What was drawn, a row for each operator, and the survivors."""
    drawn = [r for r in results if r.kind != BY_HAND]
    by_hand = [r for r in results if r.kind == BY_HAND]
    rows = [_row(kind, [r for r in drawn if r.kind == kind]) for kind in OPERATORS]
    rows += [_row("**all drawn**", drawn), _row("**by hand**", by_hand)]
    columns = ("operator", "tried", "failed a check", "raised", "hung", "survived", "equivalent")
    head = (
        f"{len(drawn)} of {conditions.population} mutants drawn without replacement by "
        f"`random.Random({conditions.seed})`, {len(by_hand)} by hand; code {conditions.code}"
    )
    return "\n\n".join((head, table((*columns, "killed of the others"), rows), _survivors(results)))


def _row(name: str, results: Sequence[Tried]) -> tuple[str, ...]:
    def count(verdict: str) -> str:
        return str(sum(r.verdict == verdict for r in results))

    killed, judged = killed_of(results)
    rate = f"{killed} of {judged}" + (f" ({100 * killed / judged:.1f} %)" if judged else "")
    verdicts = (trial.KILLED, trial.RAISED, trial.TIMEOUT, trial.SURVIVED)
    same = str(sum(map(is_equivalent, results)))
    return name, str(len(results)), *map(count, verdicts), same, rate


def _survivors(results: Iterable[Tried]) -> str:
    rows = []
    for r in results:
        if r.verdict in (trial.SURVIVED, trial.TIMEOUT):
            word, why = SURVIVED_FOR.get(r.name, ("not judged", ""))
            what = (
                r.name if r.kind == BY_HAND else f"{r.kind}: {_code(r.before)} → {_code(r.after)}"
            )
            rows.append((word, f"{r.file}:{r.line}", what, why))
    return table(("survivor", "where", "what", "why"), sorted(rows))


def _code(text: str) -> str:
    line = " ".join(text.split())
    return f"`{line if len(line) <= TEXT else line[:TEXT] + '...'}`"


# --- in runs --------------------------------------------------------------------------------------


def is_wrong(run: Run) -> bool:
    """Whether the arm was off by more than 2 degrees while the master let it go on."""
    return run.worst > in_runs.WRONG_RAD


def found_of(runs: Iterable[Run]) -> tuple[int, int]:
    """Of the mutants that moved the arm wrongly: stopped by the master and named, and all."""
    wrong = [run for run in runs if is_wrong(run)]
    return sum(run.how == in_runs.NAMED for run in wrong), len(wrong)


_COLUMNS: dict[str, Callable[[Run], bool]] = {
    "not enabled": lambda r: r.how == in_runs.BEFORE,
    "within 2 degrees: finished": lambda r: not is_wrong(r) and r.how == in_runs.FINISHED,
    "stopped, named": lambda r: not is_wrong(r) and r.how == in_runs.NAMED,
    "stopped, not named": lambda r: not is_wrong(r) and r.how == in_runs.UNNAMED,
    "hung": lambda r: r.how == in_runs.HUNG,
    "over 2 degrees: finished": lambda r: is_wrong(r) and r.how == in_runs.FINISHED,
    "then stopped, named": lambda r: is_wrong(r) and r.how == in_runs.NAMED,
    "then stopped, not named": lambda r: is_wrong(r) and r.how == in_runs.UNNAMED,
}


def of_the_runs(runs: Sequence[Run], conditions: RunConditions) -> str:
    """How the runs ended, and those in which the master missed what it should have seen."""
    groups = {
        "drawn": [r for r in runs if r.kind != BY_HAND],
        "by hand": [r for r in runs if r.kind == BY_HAND],
        "**all**": list(runs),
    }
    rows = [
        (name, str(len(group)), *(str(sum(map(is_so, group))) for is_so in _COLUMNS.values()))
        for name, group in groups.items()
    ]
    found, wrong = found_of(runs)
    stopped = sum(r.how == in_runs.NAMED for r in runs)
    amiss = [
        r for r in runs if (is_wrong(r) or r.how == in_runs.UNNAMED) and r.how != in_runs.NAMED
    ]
    told = [
        f"{conditions.settings}; code {conditions.code}",
        table(("mutants", "runs", *_COLUMNS), rows),
        f"Over 2 degrees: {found} of {wrong} stopped and named"
        + (f" ({100 * found / wrong:.0f} %)" if wrong else "")
        + f". Stopped and named in all, most before that: {stopped}.",
    ]
    if amiss:
        lines = [
            (r.name, str(r.joint), f"{math.degrees(r.worst):.1f}", r.how, MISSED.get(r.name, ""))
            for r in sorted(amiss, key=lambda r: -r.worst)
        ]
        told.append(table(("not stopped, or not named", "joint", "degrees", "", "why"), lines))
    return "\n\n".join(told)
