#!/usr/bin/env python3
"""Mutants of the joint node against the conformance suite, and in runs against the master.

A sample of the mutants that operators make of the joint's code, and mistakes by hand. Each is tried
in a process of its own; the code stays as it is. Results are kept in a file; mutants already in it
are not tried again. With ``--runs`` each is a joint of a whole simulated run instead.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, TypeVar

from node_mutants import in_runs, table, trial
from node_mutants.hand import by_hand
from node_mutants.mutant import Mutant
from node_mutants.population import SAMPLE, SEED, fingerprint, population, sample
from node_mutants.results import (
    KEPT,
    KEPT_RUNS,
    Conditions,
    Run,
    RunConditions,
    Tried,
    append,
    append_run,
    read,
    read_runs,
)

from rfms_can.errors import RfmsError

EVERY: Final = 20
"""Mutants between two lines of progress."""

Result = TypeVar("Result")


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", action="store_true", help="in simulated runs, not by the suite")
    parser.add_argument("--sample", type=int, default=SAMPLE, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=SEED, help="of the sample")
    parser.add_argument("--again", action="store_true", help="try those that survived once more")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help=f"file of results, e.g. {KEPT} or {KEPT_RUNS}")
    options = parser.parse_args()
    if options.sample < 0 or options.workers < 1:
        parser.error(f"--sample {options.sample}, --workers {options.workers}: at least 0 and 1")
    return options


def tried(jobs: list[Mutant], workers: int, one: Callable[[Mutant], Result]) -> Iterable[Result]:
    """The results of all, as they are there; threads wait for the processes of the trials."""
    began = time.monotonic()
    with ThreadPoolExecutor(workers) as pool:
        for count, result in enumerate(pool.map(one, jobs), start=1):
            yield result
            if count % EVERY == 0:
                left = (time.monotonic() - began) / count * (len(jobs) - count)
                print(f"{count} of {len(jobs)}, {left / 60:.0f} min left", file=sys.stderr)


def without_survivors(file: Path) -> None:
    """Forget those that survived, and those that hung."""
    conditions, results = read(file)
    gone = (trial.SURVIVED, trial.TIMEOUT)
    file.unlink()
    for result in results:
        if result.verdict not in gone:
            append(file, conditions, result)


def under_the_suite(options: argparse.Namespace, mutants: list[Mutant]) -> str:
    """Try those that are missing; the table."""
    conditions = Conditions(options.seed, len(population()), fingerprint())
    if options.again and options.keep and options.keep.exists():
        without_survivors(options.keep)
    results = read(options.keep, conditions)[1] if options.keep else []
    done = {result.name for result in results}
    jobs = [mutant for mutant in mutants if mutant.name not in done]
    for result in tried(jobs, options.workers, lambda m: Tried.of(m, trial.fate_of(m))):
        results.append(result)
        if options.keep:
            append(options.keep, conditions, result)
        if result.verdict in (trial.SURVIVED, trial.TIMEOUT):
            print(f"{result.verdict}: {result.name}", file=sys.stderr)
    return table.of_the_suite(results, conditions)


def in_simulated_runs(options: argparse.Namespace, mutants: list[Mutant]) -> str:
    """Run those that are missing; the table."""
    conditions = RunConditions(fingerprint(), in_runs.SETTINGS)
    results = read_runs(options.keep, conditions)[1] if options.keep else []
    done = {result.name for result in results}

    def one(mutant: Mutant) -> Run:
        joint = 2 + mutant.line % 2
        return Run.of(mutant, joint, in_runs.run_of(mutant, joint))

    jobs = [mutant for mutant in mutants if mutant.name not in done]
    for result in tried(jobs, options.workers, one):
        results.append(result)
        if options.keep:
            append_run(options.keep, conditions, result)
        if result.worst > in_runs.WRONG_RAD and result.how != in_runs.NAMED:
            print(f"{result.how}: {result.name} {result.told}", file=sys.stderr)
    return table.of_the_runs(results, conditions)


def main() -> int:
    """Try what is missing, and print the table."""
    options = arguments()
    try:
        drawn = sample(options.seed, options.sample)
        mutants = [*by_hand(), *drawn]
        print((in_simulated_runs if options.runs else under_the_suite)(options, mutants))
    except RfmsError as error:
        print(f"mutant_campaign.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
