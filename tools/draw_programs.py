"""Write the tables of docs/random-programs.md from the campaigns in docs/data."""

from pathlib import Path

from generated import DOCS, main_of_pages
from random_programs import refusals, results
from random_programs.results import read
from random_programs.table import summary

ROOT = DOCS.parent


def programs(file: str) -> str:
    """The conditions, a row for each arm, and what was refused and mended."""
    conditions, kept = read(ROOT / Path(file))
    return summary(kept, conditions)


def looked_at() -> str:
    """What was found of refusals."""
    _, kept = refusals.FILE.read(ROOT / refusals.KEPT)
    return refusals.summary(kept)


PAGES = {
    "random-programs.md": {
        "draw_programs.py": lambda: programs(results.KEPT),
        "draw_programs.py: bus": lambda: programs(results.KEPT_ON_THE_BUS),
        "draw_programs.py: refusals": looked_at,
    }
}
"""What stands between which markers."""

if __name__ == "__main__":
    main_of_pages("draw_programs.py", PAGES)
