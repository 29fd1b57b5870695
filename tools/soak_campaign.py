#!/usr/bin/env python3
"""The soak: sound arms with worn joints and noisy boards, which no protection may stop.

Each program is drawn by kind, arm and seed: fast motion, tracking, contact, compliance, excitation,
homing again and again; so are friction, the boards and their noise. None may end by a fault, and
nothing may be counted as one. How near each quantity that detectors watch came to what a fault
would make of it is kept. Programs already in the file are not run again.
"""

import argparse

from campaign_options import backend, campaign_parser, exit_with
from soak.kinds import BOTH, KINDS, Job, jobs_of
from soak.results import FILE, KEPT, Conditions
from soak.table import summary
from soak.trial import Result, run

from rfms_can.engine import carry_out
from rfms_can.engine import run as run_jobs
from rfms_can.rig.settings import RunSettings


def arguments() -> argparse.Namespace:
    """Command-line arguments."""
    parser = campaign_parser(__doc__, KEPT)
    parser.add_argument("--kind", action="append", choices=KINDS, help="repeatable; all if absent")
    parser.add_argument("--arm", action="append", choices=BOTH, help="repeatable; both if absent")
    parser.add_argument("--seeds", type=int, default=1, help="programs of each kind and arm")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument(
        "--new", action="store_true", help="the arm of the data sheet, without wear and noise"
    )
    options = parser.parse_args()
    if options.seeds < 1 or options.first < 0:
        parser.error(f"--seeds {options.seeds}, --first {options.first}: give at least 1 and 0")
    return options


def remark(result: Result) -> str:
    """A line about a program that tripped."""
    if not result.trips:
        return ""
    return f"tools/soak_campaign.py {result.job.name}: {'; '.join(result.trips)}"


def main() -> int:
    """Run what is missing, and print the tables; 1 if anything tripped."""
    options = arguments()
    seeds = range(options.first, options.first + options.seeds)
    jobs = jobs_of(
        options.kind or list(KINDS), options.arm or list(BOTH), seeds, worn=not options.new
    )
    workers = backend(options)
    results = carry_out(
        jobs,
        lambda left: run_jobs(run, left, workers, name=name),
        FILE.open(options.keep, Conditions(RunSettings().rate)),
        what="programs",
        job_key=lambda job: job,
        result_key=lambda result: result.job,
        remark=remark,
    )
    print(summary(results))
    return int(any(result.trips for result in results))


def name(job: Job) -> str:
    """For messages."""
    return job.name


if __name__ == "__main__":
    exit_with(main)
