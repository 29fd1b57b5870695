#!/usr/bin/env python3
"""Refusals of random programs, looked at a hundred times as closely: was each of them due?

Of each seed the first refusal is taken. The refused move is made all the same, in periods 25 times
as short, with every pose solved: a refusal is due if a joint passes a limit or has no angle there,
with the time that was asked for and with the longest the mode allows. Results are kept in a file;
seeds already in it are not looked at again.
"""

import argparse
import multiprocessing
import sys
from pathlib import Path

from random_programs.draw import MIX_NUMBER, draw
from random_programs.refusals import FILE, KEPT, Refusal
from random_programs.results import Conditions
from random_programs.trial import PERIOD_S, Trial

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.errors import RfmsError


def one(job: tuple[str, int]) -> Refusal:
    """The first refusal of a seed."""
    name, seed = job
    arm = arm_by_name(name)
    trial = Trial(arm, draw(arm, seed), seed, looks=True)
    trial.run()
    words = "" if trial.case is None else trial.case.words
    return Refusal(name, seed, words, trial.due or "")


def main() -> int:
    """Look at refusals until there are enough, and count; 1 if one was not due."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--refusals", type=int, default=20, help="to look at")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help=f"file of results, e.g. {KEPT}")
    options = parser.parse_args()
    if options.refusals < 1 or options.workers < 1:
        parser.error(f"--refusals {options.refusals}, --workers {options.workers}: at least 1")
    conditions = Conditions(1.0 / PERIOD_S, MIX_NUMBER)
    try:
        results = FILE.read(options.keep, conditions)[1] if options.keep else []
    except RfmsError as error:
        print(f"refusal_campaign.py: {error}", file=sys.stderr)
        return 1
    done = {(each.a, each.s) for each in results}
    jobs = ((arm, seed) for seed in range(100 * options.refusals) for arm in ARMS)
    refused = [each for each in results if each.why]
    with multiprocessing.Pool(options.workers) as pool:
        if len(refused) < options.refusals:
            for result in pool.imap(one, (job for job in jobs if job not in done)):
                if options.keep:
                    FILE.append(options.keep, conditions, result)
                refused += [result] if result.why else []
                if result.why and not result.due:
                    print(f"not due: {result.a} {result.s}: {result.why}", file=sys.stderr)
                if len(refused) >= options.refusals:
                    break
        pool.terminate()
    due = sum(bool(each.due) for each in refused)
    print(f"{due} of {len(refused)} refusals were due")
    return int(due < len(refused))


if __name__ == "__main__":
    sys.exit(main())
