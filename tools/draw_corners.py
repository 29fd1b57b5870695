"""Write the table of docs/corners.md from the corners in docs/data/corner_campaign.jsonl."""

from corners.results import read
from corners.table import summary
from generated import DOCS, main


def render() -> str:
    """The conditions, and a row for each arm and kind of corner."""
    conditions, results = read(DOCS / "data" / "corner_campaign.jsonl")
    return summary(results, conditions)


if __name__ == "__main__":
    main("draw_corners.py", "corners.md", render)
