"""Write the table of docs/servoing.md from the runs in docs/data/servoing_campaign.jsonl."""

from generated import DOCS, main
from servoing.results import read
from servoing.table import summary


def render() -> str:
    """The conditions, and a row for each arm and way of the part."""
    conditions, results = read(DOCS / "data" / "servoing_campaign.jsonl")
    return summary(results, conditions)


if __name__ == "__main__":
    main("draw_servoing.py", "servoing.md", render)
