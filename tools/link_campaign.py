"""Trials of the coordinator's link, one for each seed; a file that is given goes on where it ends.

    python tools/link_campaign.py --trials 200 --keep docs/data/link_campaign.jsonl

is the table of docs/link-campaign.md (then python tools/draw_link_campaign.py). Exit code 1 if a
trial is not as it must be; its row and what is wrong are printed. ``--seed N`` repeats one trial.
"""

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Final

import msgspec
from link_trials.judgement import Row, violations
from link_trials.trial import Server, run_trial, runtime_directory

SERVER: Final = ("--friction", "none")
"""Virtual time, in one process."""
TRIALS_A_SERVER: Final = 40


def read(path: Path) -> list[Row]:
    """The rows of a file; none if it does not exist."""
    if not path.exists():
        return []
    decoder = msgspec.json.Decoder(Row)
    return [decoder.decode(line) for line in path.read_bytes().splitlines() if line]


def main() -> int:
    """Run the trials that are missing; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=200, help="seeds 0 to N - 1")
    parser.add_argument("--seed", type=int, help="this one alone")
    parser.add_argument("--keep", type=Path, help="JSON lines to go on with")
    options = parser.parse_args()
    rows = [] if options.keep is None else read(options.keep)
    done = {row.seed for row in rows}
    seeds = [s for s in range(options.trials) if s not in done]
    if options.seed is not None:
        seeds = [options.seed]
    with tempfile.TemporaryDirectory(prefix="rfms-") as directory:
        runtime_directory(Path(directory))
        for first in range(0, len(seeds), TRIALS_A_SERVER):
            with Server(*SERVER) as server:
                for seed in seeds[first : first + TRIALS_A_SERVER]:
                    row = run_trial(seed, server)
                    rows.append(row)
                    _tell(row, options.keep)
    wrong = [row for row in rows if violations(row)]
    print(f"{len(rows)} trials, {sum(row.in_motion for row in rows)} in motion, {len(wrong)} wrong")
    return 1 if wrong else 0


def _tell(row: Row, keep: Path | None) -> None:
    line = msgspec.json.encode(row)
    if keep is not None:
        with keep.open("ab") as file:
            file.write(line + b"\n")
    found = violations(row)
    print(f"seed {row.seed}: {row.event.value}, {row.program}, heard {row.heard}", flush=True)
    if found:
        print(f"  WRONG: {'; '.join(found)}\n  {line.decode()}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
