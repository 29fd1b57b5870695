#!/usr/bin/env python3
"""An arm that follows what a camera sees, with all that cameras do; without a plant.

Each seed draws a part, its way (also through the wrist singularity, and out of reach), and a
camera: rate, noise, jitter, loss, outliers, latency, and silence from some time on. The arm must
neither fault nor pass its joints' limits, and stay at a part that stands still when the camera
falls silent. Results are kept in a file; runs already in it are not made again.
"""

import argparse

from campaign_options import backend, campaign_parser, exit_with
from servoing.results import FILE, KEPT, Conditions
from servoing.scene import draw
from servoing.table import broken, summary
from servoing.trial import PERIOD_S, Result, Servoing

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.engine import carry_out, run


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--arm", action="append", choices=ARMS, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=50, help="runs of each arm")
    options = parser.parse_args()
    if options.seeds < 1:
        parser.error(f"--seeds {options.seeds}: give at least 1")
    return options


def one(job: tuple[str, int]) -> Result:
    """The run of a seed."""
    name, seed = job
    arm = arm_by_name(name)
    return Servoing(arm, draw(arm, seed), seed).run()


def main() -> int:
    """Make what is missing, and print the table; 1 if a promise was broken."""
    options = arguments()
    conditions = Conditions(1.0 / PERIOD_S)
    workers = backend(options)
    results = carry_out(
        [(arm, seed) for seed in range(options.seeds) for arm in options.arm or ARMS],
        lambda left: run(one, left, workers),
        FILE.open(options.keep, conditions),
        what="runs",
        job_key=lambda job: job,
        result_key=lambda result: (result.arm, result.seed),
        remark=lambda result: str(result) if broken(result) else "",
    )
    print(summary(results, conditions))
    return int(any(map(broken, results)))


if __name__ == "__main__":
    exit_with(main)
