"""Trials of the coordinator's link, one for each seed; a file that is given goes on where it ends.

    python tools/link_campaign.py --trials 200 --keep docs/data/link_campaign.jsonl

is the table of docs/link-campaign.md (then python tools/draw_link_campaign.py). Exit code 1 if a
trial is not as it must be; its row and what is wrong are printed. ``--seed N`` repeats one trial.
"""

import tempfile
from collections.abc import Generator
from itertools import chain
from pathlib import Path
from typing import Final

import msgspec
from campaign_options import backend, campaign_parser, exit_with
from link_trials.judgement import Row, violations
from link_trials.trial import Server, run_trial, runtime_directory

from rfms_can.engine import Backend, ResultFile, carry_out, run

SERVER: Final = ("--friction", "none")
"""Virtual time, in one process."""
TRIALS_A_SERVER: Final = 40
FILE: Final = ResultFile[None, Row]("trials", "tools/link_campaign.py", None, Row)


def read(path: Path) -> list[Row]:
    """The rows of a file; none if it does not exist."""
    return FILE.read(path)[1]


def trials(seeds: list[int]) -> list[Row]:
    """Trials of some seeds with one server."""
    with tempfile.TemporaryDirectory(prefix="rfms-") as directory:
        runtime_directory(Path(directory))
        with Server(*SERVER) as server:
            return [run_trial(seed, server) for seed in seeds]


def made(seeds: list[int], workers: Backend) -> Generator[Row, None, None]:
    """The rows of all seeds, server by server."""
    batches = [seeds[n : n + TRIALS_A_SERVER] for n in range(0, len(seeds), TRIALS_A_SERVER)]
    yield from chain.from_iterable(run(trials, batches, workers))


def main() -> int:
    """Run the trials that are missing; the exit code."""
    parser = campaign_parser(__doc__, "docs/data/link_campaign.jsonl")
    parser.add_argument("--trials", type=int, default=200, help="seeds 0 to N - 1")
    parser.add_argument("--seed", type=int, help="this one alone, in no file")
    options = parser.parse_args()
    workers = backend(options)
    alone = options.seed is not None
    kept = FILE.open(None if alone else options.keep, None)
    carry_out(
        [options.seed] if alone else range(options.trials),
        lambda left: made(left, workers),
        kept,
        what="trials",
        job_key=lambda seed: seed,
        result_key=lambda row: row.seed,
        remark=told,
    )
    rows = kept.results
    wrong = [row for row in rows if violations(row)]
    print(f"{len(rows)} trials, {sum(row.in_motion for row in rows)} in motion, {len(wrong)} wrong")
    return 1 if wrong else 0


def told(row: Row) -> str:
    """A row in words, and what of it is wrong."""
    line = f"seed {row.seed}: {row.event.value}, {row.program}, heard {row.heard}"
    found = violations(row)
    return f"{line}\n  WRONG: {'; '.join(found)}\n  {_json(row)}" if found else line


def _json(row: Row) -> str:
    return msgspec.json.encode(row).decode()


if __name__ == "__main__":
    exit_with(main)
