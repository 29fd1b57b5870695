#!/usr/bin/env python3
"""Refusals of random programs, looked at a hundred times as closely: was each of them due?

Of each seed the first refusal is taken. The refused move is made all the same, in periods 25 times
as short, with every pose solved: a refusal is due if a joint passes a limit or has no angle there,
with the time that was asked for and with the longest the mode allows. Results are kept in a file;
seeds already in it are not looked at again.
"""

from contextlib import closing

from campaign_options import backend, campaign_parser, exit_with
from random_programs.draw import MIX_NUMBER, draw
from random_programs.refusals import FILE, KEPT, Refusal
from random_programs.results import Conditions
from random_programs.trial import PERIOD_S, Trial

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.engine import Backend, Kept, Progress, run
from rfms_can.engine.signals import sigterm_interrupts


def one(job: tuple[str, int]) -> Refusal:
    """The first refusal of a seed."""
    name, seed = job
    arm = arm_by_name(name)
    trial = Trial(arm, draw(arm, seed), seed, looks=True)
    trial.run()
    words = "" if trial.case is None else trial.case.words
    return Refusal(name, seed, words, trial.due or "")


def look(wanted: int, kept: Kept[Conditions, Refusal], workers: Backend) -> list[Refusal]:
    """Refusals, seed by seed, until there are as many as are wanted."""
    refused = [each for each in kept.results if each.why]
    if len(refused) >= wanted:
        return refused
    done = {(each.a, each.s) for each in kept.results}
    jobs = ((arm, seed) for seed in range(100 * wanted) for arm in ARMS)
    left = (job for job in jobs if job not in done)
    with (
        sigterm_interrupts(),
        Progress("refusals", wanted, len(refused)) as progress,
        closing(run(one, left, workers, in_order=True)) as results,
    ):
        for result in results:
            kept.add(result)
            if not result.why:
                continue
            refused.append(result)
            if not result.due:
                progress.say(f"not due: {result.a} {result.s}: {result.why}")
            progress.advance()
            if len(refused) >= wanted:
                break
    return refused


def main() -> int:
    """Look at refusals until there are enough, and count; 1 if one was not due."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--refusals", type=int, default=20, help="to look at")
    options = parser.parse_args()
    if options.refusals < 1:
        parser.error(f"--refusals {options.refusals}: give at least 1")
    conditions = Conditions(1.0 / PERIOD_S, MIX_NUMBER)
    refused = look(options.refusals, FILE.open(options.keep, conditions), backend(options))
    due = sum(bool(each.due) for each in refused)
    print(f"{due} of {len(refused)} refusals were due")
    return int(due < len(refused))


if __name__ == "__main__":
    exit_with(main)
