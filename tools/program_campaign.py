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
from collections.abc import Generator
from itertools import chain
from typing import Final

from campaign_options import backend, campaign_parser, exit_with
from random_programs.draw import MIX_NUMBER, draw
from random_programs.on_bus import Batch
from random_programs.results import FILE, KEPT, Brief, Conditions
from random_programs.table import broken, summary
from random_programs.trial import PERIOD_S, Trial

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.engine import Backend, carry_out, run

IN_A_RUN: Final = 10
"""Programs in one run on the bus."""


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--arm", action="append", choices=ARMS, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=100, help="programs of each arm")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument(
        "--bus", action="store_true", help="on the whole simulated bus, some in each run"
    )
    options = parser.parse_args()
    if options.seeds < 1 or options.first < 0:
        parser.error(f"--seeds {options.seeds}, --first {options.first}: give at least 1 and 0")
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
    runs = (
        of_arm[first : first + IN_A_RUN]
        for first in range(0, max(map(len, of_arms)), IN_A_RUN)
        for of_arm in of_arms
    )
    return [batch for batch in runs if batch]


def made(
    jobs: list[tuple[str, int]], workers: Backend, *, bus: bool
) -> Generator[Brief, None, None]:
    """The results of all jobs, as they are there."""
    if not bus:
        yield from run(one, jobs, workers)
        return
    yield from chain.from_iterable(run(on_bus, batches(jobs), workers))


def main() -> int:
    """Run what is missing, and print the table; 1 if a promise was broken."""
    options = arguments()
    conditions = Conditions(1.0 / PERIOD_S, MIX_NUMBER)
    workers = backend(options)
    seeds = range(options.first, options.first + options.seeds)
    results = carry_out(
        [(arm, seed) for seed in seeds for arm in options.arm or ARMS],
        lambda left: made(left, workers, bus=options.bus),
        FILE.open(options.keep, conditions),
        what="programs",
        job_key=lambda job: job,
        result_key=lambda result: (result.a, result.s),
        remark=lambda each: f"{each.a} {each.s}: {each.bad or each.acc}" if broken(each) else "",
    )
    print(summary(results, conditions))
    return int(any(map(broken, results)))


if __name__ == "__main__":
    exit_with(main)
