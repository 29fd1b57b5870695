"""The campaign of docs/link-campaign.md: its judgement can fail, its table is that of the file."""

from pathlib import Path
from typing import Any, Final

import msgspec
import pytest
from link_campaign import read
from link_trials.judgement import Event, Row, summary, violations
from link_trials.trial import Server, run_trial

ROOT: Final = Path(__file__).parents[1]
DATA: Final = ROOT / "docs" / "data" / "link_campaign.jsonl"
LOST: Final = Row(
    seed=1,
    event=Event.FREEZE,
    program="waits",
    lasted_s=1.0,
    in_motion=True,
    lost=True,
    exit=3,
    heard="LeaseError",
    claims={},
    truth={"7": "lapsed"},
    rest_s=0.4,
    served="made",
    fault=None,
)
KEPT: Final = msgspec.structs.replace(
    LOST, lost=False, exit=0, heard=None, claims={"7": "made"}, truth={"7": "made"}
)


@pytest.mark.parametrize("row", [LOST, KEPT])
def test_what_is_as_it_must_be_is_no_violation(row: Row) -> None:
    assert violations(row) == []


@pytest.mark.parametrize(
    ("row", "changes", "violation"),
    [
        (LOST, {"heard": None, "exit": 0}, "lost the lease and heard None"),
        (LOST, {"heard": None, "exit": 0, "lost": False}, "although moves 7 were not made"),
        (LOST, {"claims": {"7": "made"}}, "move 7: the client took it for made, it was lapsed"),
        (LOST, {"exit": None}, "the client never ended"),
        (LOST, {"heard": None}, "exit code 3 without an error"),
        (LOST, {"rest_s": None}, "the arm did not come to rest"),
        (LOST, {"served": "stopped"}, "the next client's move: stopped"),
        (LOST, {"fault": "joint 3"}, "the arm is halted: joint 3"),
        (KEPT, {"event": Event.GIVEN}, "heard None, not KeyboardInterrupt"),
        (KEPT, {"event": Event.KILL}, "killed, with exit code 0"),
        (KEPT, {"truth": {}, "claims": {}}, "exit code 0 without a move"),
    ],
)
def test_every_lie_is_a_violation(row: Row, changes: dict[str, Any], violation: str) -> None:
    assert violation in "; ".join(violations(msgspec.structs.replace(row, **changes)))


def test_the_file_holds_two_hundred_trials_and_no_lie() -> None:
    rows = read(DATA)
    assert [row.seed for row in rows] == list(range(200))
    assert {row.event for row in rows} == set(Event)
    assert sum(row.in_motion for row in rows) >= 195
    assert [(row.seed, violations(row)) for row in rows if violations(row)] == []
    assert sum(int(line[1]) for line in summary(rows)) == 200


@pytest.mark.processes
def test_a_trial_of_each_kind(runtime: Path) -> None:
    with Server("--friction", "none") as server:
        for seed in range(1000, 1000 + len(Event)):
            row = run_trial(seed, server)
            assert violations(row) == [], row
