#!/usr/bin/env python3
"""Random programs through planner, trajectory generator and six joints, without a plant.

Each seed draws a program: joint, Cartesian and mixed moves, to and by way of singularities, ends
of ranges and half turns, to goals that stand and that move, with waits, pauses and changes of
feed. What is accepted must be made, within the joints' limits; what a refusal offers is taken, and
must be accepted and made as well. Results are kept in a file; programs already in it are not run
again. With ``--bus`` the same programs run on the whole simulated bus, plant included; refusals end
them there.
"""

import argparse
import multiprocessing
import multiprocessing.pool
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from random_programs.draw import MIX_NUMBER, draw
from random_programs.on_bus import Batch
from random_programs.results import KEPT, Brief, Conditions, append, read
from random_programs.table import broken, summary
from random_programs.trial import PERIOD_S, Trial

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.errors import RfmsError

IN_A_RUN: Final = 10
"""Programs in one run on the bus."""
EVERY: Final = 100
"""Programs between two lines of progress."""


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--arm", action="append", choices=ARMS, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=100, help="programs of each arm")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument(
        "--bus", action="store_true", help="on the whole simulated bus, some in each run"
    )
    parser.add_argument("--keep", type=Path, help=f"file of results, e.g. {KEPT}")
    options = parser.parse_args()
    if options.seeds < 1 or options.workers < 1 or options.first < 0:
        parser.error(
            f"--seeds {options.seeds}, --workers {options.workers}, --first {options.first}: "
            f"give at least 1, 1 and 0"
        )
    return options


def one(job: tuple[str, int]) -> Brief:
    """The program of a seed."""
    name, seed = job
    arm = arm_by_name(name)
    return Brief.of(Trial(arm, draw(arm, seed), seed).run())


def on_bus(jobs: list[tuple[str, int]]) -> list[Brief]:
    """Programs of one arm in one run on the bus; after a fault the others in another run."""
    results: list[Brief] = []
    while len(results) < len(jobs):
        left = jobs[len(results) :]
        results += Batch(left[0][0], [seed for _, seed in left]).run()
    return results


def batches(jobs: list[tuple[str, int]]) -> list[list[tuple[str, int]]]:
    """Jobs for ``on_bus``, the arms in turn."""
    of_arms = [[job for job in jobs if job[0] == arm] for arm in ARMS]
    runs = [
        of_arm[first : first + IN_A_RUN]
        for first in range(0, max(map(len, of_arms)), IN_A_RUN)
        for of_arm in of_arms
    ]
    return [run for run in runs if run]


def made(
    pool: "multiprocessing.pool.Pool", jobs: list[tuple[str, int]], *, bus: bool
) -> Iterator[Brief]:
    """The results of all jobs, as they are there."""
    if not bus:
        yield from pool.imap(one, jobs)
        return
    for results in pool.imap(on_bus, batches(jobs)):
        yield from results


def main() -> int:
    """Run what is missing, and print the table; 1 if a promise was broken."""
    options = arguments()
    conditions = Conditions(1.0 / PERIOD_S, MIX_NUMBER)
    try:
        results = read(options.keep, conditions)[1] if options.keep else []
    except RfmsError as error:
        print(f"program_campaign.py: {error}", file=sys.stderr)
        return 1
    seeds = range(options.first, options.first + options.seeds)
    wanted = [(arm, seed) for seed in seeds for arm in options.arm or ARMS]
    done = {(each.a, each.s) for each in results}
    jobs = [job for job in wanted if job not in done]
    began = time.monotonic()
    with multiprocessing.Pool(options.workers) as pool:
        for count, result in enumerate(made(pool, jobs, bus=options.bus), start=1):
            results.append(result)
            if options.keep:
                append(options.keep, conditions, result)
            if broken(result):
                print(f"{result.a} {result.s}: {result.bad or result.acc}", file=sys.stderr)
            if count % EVERY == 0:
                left = (time.monotonic() - began) / count * (len(jobs) - count)
                print(f"{count} of {len(jobs)}, {left / 60:.0f} min left", file=sys.stderr)
    chosen = set(wanted)
    kept = [each for each in results if (each.a, each.s) in chosen]
    print(summary(kept, conditions))
    return int(any(map(broken, kept)))


if __name__ == "__main__":
    sys.exit(main())
