#!/usr/bin/env python3
"""An arm that follows what a camera sees, with all that cameras do; without a plant.

Each seed draws a part, its way (also through the wrist singularity, and out of reach), and a
camera: rate, noise, jitter, loss, outliers, latency, and silence from some time on. The arm must
neither fault nor pass its joints' limits, and stay at a part that stands still when the camera
falls silent. Results are kept in a file; runs already in it are not made again.
"""

import argparse
import multiprocessing
import sys
from pathlib import Path

from servoing.results import KEPT, Conditions, append, read
from servoing.scene import draw
from servoing.table import broken, summary
from servoing.trial import PERIOD_S, Result, Servoing

from rfms_can.arm import ARMS, arm_by_name
from rfms_can.errors import RfmsError


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--arm", action="append", choices=ARMS, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=50, help="runs of each arm")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--keep", type=Path, help=f"file of results, e.g. {KEPT}")
    options = parser.parse_args()
    if options.seeds < 1 or options.workers < 1:
        parser.error(f"--seeds {options.seeds}, --workers {options.workers}: give at least 1")
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
    try:
        results = read(options.keep, conditions)[1] if options.keep else []
    except RfmsError as error:
        print(f"servoing_campaign.py: {error}", file=sys.stderr)
        return 1
    wanted = [(arm, seed) for seed in range(options.seeds) for arm in options.arm or ARMS]
    done = {(each.arm, each.seed) for each in results}
    with multiprocessing.Pool(options.workers) as pool:
        for result in pool.imap(one, [job for job in wanted if job not in done]):
            results.append(result)
            if options.keep:
                append(options.keep, conditions, result)
            if broken(result):
                print(result, file=sys.stderr)
    chosen = set(wanted)
    kept = [each for each in results if (each.arm, each.seed) in chosen]
    print(summary(kept, conditions))
    return int(any(map(broken, kept)))


if __name__ == "__main__":
    sys.exit(main())
