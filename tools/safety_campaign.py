#!/usr/bin/env python3
"""Mutants of the safety core under the project's own tests of it.

A sample of the mutants that operators make of it. Each is tried in a process of its own; the code
stays as it is. Results are kept in a file; those of code and tests that have not changed since are
taken over. ``--changed`` tries some of what has changed since the committed table, and fails if it
is not tested well: 95 of 100 killed, of fewer than 20 all but one.
"""

import argparse
from pathlib import Path

from campaign_options import backend, campaign_parser, exit_with
from node_mutants import trial
from safety_mutants import changed, table
from safety_mutants.population import SAMPLE, SEED, Case, sample
from safety_mutants.results import KEPT, SAFETY, Conditions, Tried, opened
from safety_mutants.trial import fate_of, sound, to_be_sound, warm

from rfms_can.engine import carry_out, run

ROOT = Path(__file__).resolve().parents[1]


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--sample", type=int, default=SAMPLE, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=SEED, help="of the sample")
    parser.add_argument("--again", action="store_true", help="try those that survived once more")
    parser.add_argument("--changed", action="store_true", help=f"since {KEPT} was made, and judge")
    options = parser.parse_args()
    if options.sample < 0:
        parser.error(f"--sample {options.sample}: at least 0")
    return options


def under_its_tests(case: Case) -> Tried:
    """What becomes of a mutant."""
    return Tried.of(case, fate_of(case.mutant))


def of_a_survivor(result: Tried) -> str:
    """A line about a mutant that was not killed."""
    return f"{result.verdict}: {result.name}" if result.verdict == trial.SURVIVED else ""


def try_missing(options: argparse.Namespace) -> int:
    """Try what is missing, and print the tables."""
    cases = sample(options.seed, options.sample)
    conditions = Conditions.here(options.seed)
    workers = backend(options)
    forget = frozenset({trial.SURVIVED, trial.TIMEOUT} if options.again else ())
    kept = opened(options.keep, conditions, cases, forget)
    known = {r.name for r in kept.results}
    files = {case.mutant.file for case in cases if case.mutant.name not in known}
    for _ in run(sound, to_be_sound(files), workers):
        pass
    carry_out(
        cases,
        lambda left: run(under_its_tests, left, workers),
        kept,
        what="mutants",
        job_key=lambda case: case.mutant.name,
        result_key=lambda result: result.name,
        remark=of_a_survivor,
    )
    print(table.of_the_campaign(kept.results, conditions))
    return 0


def try_changed(options: argparse.Namespace) -> int:
    """Try some of what has changed; 1 if it is not tested well."""
    then, _ = SAFETY.read(options.keep or ROOT / KEPT)
    found = changed.changed(then, Conditions.here(then.seed))
    cases = changed.cases_of_changed(found)
    if not cases:
        print(f"nothing of the safety core has changed since {KEPT} was made")
        return 0
    print(f"changed since {KEPT} was made: {', '.join(found)}")
    well, lines = changed.verdict(cases, list(changed.try_all(cases, backend(options))))
    print("\n".join(lines))
    return 0 if well else 1


def main() -> int:
    """The campaign, or its share in the tests."""
    options = arguments()
    warm()
    return try_changed(options) if options.changed else try_missing(options)


if __name__ == "__main__":
    exit_with(main)
