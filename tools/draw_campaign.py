"""Write the table of docs/peg-campaign.md from the runs in docs/data/peg_campaign.jsonl."""

from generated import DOCS, main

from rfms_can.analysis.campaign.job import FRICTIONS, TASKS, groups_of
from rfms_can.analysis.campaign.results import read
from rfms_can.analysis.campaign.summary import markdown, rows_of


def render() -> str:
    """The conditions, and a row for each group."""
    conditions, runs = read(DOCS / "data" / "peg_campaign.jsonl")
    order = groups_of(TASKS, FRICTIONS)  # a file has them as they were run
    runs = sorted(runs, key=lambda run: order.index(run.group))
    return "\n".join(f"- {line}" for line in conditions.lines) + "\n\n" + markdown(rows_of(runs))


if __name__ == "__main__":
    main("draw_campaign.py", "peg-campaign.md", render)
