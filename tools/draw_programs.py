"""Write the table of docs/random-programs.md from docs/data/program_campaign.jsonl."""

from generated import DOCS, main
from random_programs.results import read
from random_programs.table import summary


def render() -> str:
    """The conditions, a row for each arm, and what was refused and mended."""
    conditions, results = read(DOCS / "data" / "program_campaign.jsonl")
    return summary(results, conditions)


if __name__ == "__main__":
    main("draw_programs.py", "random-programs.md", render)
