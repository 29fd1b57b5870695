#!/usr/bin/env python3
"""Corners drawn at random that must keep a deviation: planned, run, measured, and compared.

Each seed draws a corner: two legs of random directions, lengths, speeds, turns and modes, and a
joint or Cartesian transition between them. It is planned with a deviation it may have at most, run
through the generator and six joints, and compared with the transition of that deviation that an
acceleration time makes. Results are kept in a file; corners already in it are not repeated.
"""

import argparse
from functools import partial

from campaign_options import backend, campaign_parser, exit_with
from corners.draw import draw
from corners.results import FILE, KEPT, Conditions
from corners.run import Result, result_of
from corners.table import summary

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.engine import carry_out, run


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--arm", action="append", choices=ARMS, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=500, help="corners of each arm")
    parser.add_argument("--deviation", type=float, default=2e-3, help="largest, m")
    parser.add_argument("--rate", type=float, default=250.0, help="set-points a second")
    options = parser.parse_args()
    if not 0.0 < options.deviation <= 1.0:
        parser.error(f"--deviation {options.deviation:g} m is not in 0 to 1 m")
    if not 20.0 <= options.rate <= 2000.0:
        parser.error(f"--rate {options.rate:g} is not in 20 to 2000 Hz")
    if options.seeds < 1:
        parser.error(f"--seeds {options.seeds}: give at least 1")
    return options


def one(job: tuple[str, int], conditions: Conditions) -> Result:
    """The corner of a seed."""
    arm, seed = job
    period = 1.0 / conditions.rate
    return result_of(draw(arm_by_name(arm), seed, period), conditions.deviation, period)


def main() -> int:
    """Run what is missing, and print the table."""
    options = arguments()
    conditions = Conditions(options.deviation, options.rate)
    workers = backend(options)
    results = carry_out(
        [(arm, seed) for arm in options.arm or ARMS for seed in range(options.seeds)],
        lambda left: run(partial(one, conditions=conditions), left, workers),
        FILE.open(options.keep, conditions),
        what="corners",
        job_key=lambda job: job,
        result_key=lambda result: (result.arm, result.seed),
    )
    print(summary(results, conditions))
    return 0


if __name__ == "__main__":
    exit_with(main)
