"""Write the table of docs/link-campaign.md from the trials in docs/data/link_campaign.jsonl."""

from generated import DOCS, main, table
from link_campaign import SERVER, TRIALS_A_SERVER, read
from link_trials.judgement import summary, violations
from link_trials.trial import LEASE_S, LIFT_M, SEGMENT_S

COLUMNS = (
    "what happened",
    "trials",
    "in motion",
    "lease lost",
    "what the client heard",
    "longest time to rest, s",
    "next client's move made",
    "not the truth",
)


def render() -> str:
    """The settings, and a row for each event."""
    rows = read(DOCS / "data" / "link_campaign.jsonl")
    settings = (
        f"rfms serve {' '.join(SERVER)}: virtual time, PUMA 260; {TRIALS_A_SERVER} trials a server",
        f"lease {LEASE_S:g} s; moves of {1e3 * LIFT_M:g} mm in {SEGMENT_S:g} s of the arm's clock",
        f"{len(rows)} trials, seeds {rows[0].seed} to {rows[-1].seed}, "
        f"{sum(bool(violations(row)) for row in rows)} of them not the truth",
    )
    lines = "\n".join(f"- {line}" for line in settings)
    return f"{lines}\n\n{table(COLUMNS, list(summary(rows)))}"


if __name__ == "__main__":
    main("draw_link_campaign.py", "link-campaign.md", render)
