#!/usr/bin/env python3
"""Mutants of the joint node against the conformance suite, and in runs against the master.

A sample of the mutants that operators make of the joint's code, and mistakes by hand. Each is tried
in a process of its own; the code stays as it is. Results are kept in a file; mutants already in it
are not tried again. With ``--runs`` each is a joint of a whole simulated run instead.
"""

import argparse
from pathlib import Path

from campaign_options import backend, campaign_parser, exit_with
from node_mutants import in_runs, table, trial
from node_mutants.hand import by_hand
from node_mutants.mutant import Mutant
from node_mutants.population import SAMPLE, SEED, fingerprint, population, sample
from node_mutants.results import (
    KEPT,
    KEPT_RUNS,
    RUNS,
    SUITE,
    Conditions,
    Run,
    RunConditions,
    Tried,
)

from rfms_can.engine import carry_out, run


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, f"{KEPT} or {KEPT_RUNS}")
    parser.add_argument("--runs", action="store_true", help="in simulated runs, not by the suite")
    parser.add_argument("--sample", type=int, default=SAMPLE, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=SEED, help="of the sample")
    parser.add_argument("--again", action="store_true", help="try those that survived once more")
    options = parser.parse_args()
    if options.sample < 0:
        parser.error(f"--sample {options.sample}: at least 0")
    return options


def without_survivors(file: Path) -> None:
    """Forget those that survived, and those that hung."""
    conditions, results = SUITE.read(file)
    gone = (trial.SURVIVED, trial.TIMEOUT)
    SUITE.write(file, conditions, [each for each in results if each.verdict not in gone])


def under_the_suite(mutant: Mutant) -> Tried:
    """What becomes of a mutant under the suite."""
    return Tried.of(mutant, trial.fate_of(mutant))


def in_a_run(mutant: Mutant) -> Run:
    """What becomes of a run with a mutant."""
    joint = 2 + mutant.line % 2
    return Run.of(mutant, joint, in_runs.run_of(mutant, joint))


def of_a_survivor(result: Tried) -> str:
    """A line about a mutant that was not killed."""
    lives = result.verdict in (trial.SURVIVED, trial.TIMEOUT)
    return f"{result.verdict}: {result.name}" if lives else ""


def of_a_wrong_run(result: Run) -> str:
    """A line about a run in which the arm was elsewhere, unless the master named the joint."""
    wrong = result.worst > in_runs.WRONG_RAD and result.how != in_runs.NAMED
    return f"{result.how}: {result.name} {result.told}" if wrong else ""


def try_by_the_suite(options: argparse.Namespace, mutants: list[Mutant]) -> str:
    """Try those that are missing; the table."""
    conditions = Conditions(options.seed, len(population()), fingerprint())
    workers = backend(options)
    if options.again and options.keep and options.keep.exists():
        without_survivors(options.keep)
    kept = SUITE.open(options.keep, conditions)
    carry_out(
        mutants,
        lambda left: run(under_the_suite, left, workers),
        kept,
        what="mutants",
        job_key=lambda mutant: mutant.name,
        result_key=lambda result: result.name,
        remark=of_a_survivor,
    )
    return table.of_the_suite(kept.results, conditions)


def try_in_runs(options: argparse.Namespace, mutants: list[Mutant]) -> str:
    """Run those that are missing; the table."""
    conditions = RunConditions(fingerprint(), in_runs.SETTINGS)
    workers = backend(options)
    kept = RUNS.open(options.keep, conditions)
    carry_out(
        mutants,
        lambda left: run(in_a_run, left, workers),
        kept,
        what="runs",
        job_key=lambda mutant: mutant.name,
        result_key=lambda result: result.name,
        remark=of_a_wrong_run,
    )
    return table.of_the_runs(kept.results, conditions)


def main() -> int:
    """Try what is missing, and print the table."""
    options = arguments()
    mutants = [*by_hand(), *sample(options.seed, options.sample)]
    print((try_in_runs if options.runs else try_by_the_suite)(options, mutants))
    return 0


if __name__ == "__main__":
    exit_with(main)
