"""A campaign's book-keeping: what is drawn, kept, compared and refused; the runs are elsewhere."""

import json
import math
from functools import partial
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.command_line import Rfms

from rfms_can.analysis.campaign import runs as campaign_runs
from rfms_can.analysis.campaign.conditions import Conditions
from rfms_can.analysis.campaign.insertion import insert
from rfms_can.analysis.campaign.job import (
    FRICTIONS,
    TASKS,
    Group,
    Insertion,
    Job,
    Misalignment,
    groups_of,
)
from rfms_can.analysis.campaign.results import RESULTS, read
from rfms_can.analysis.campaign.runs import jobs_of, run_all
from rfms_can.analysis.campaign.summary import HEADINGS, markdown, rows_of
from rfms_can.compliance import ControlLaw
from rfms_can.engine import Serial
from rfms_can.errors import RfmsError

RIGID = Group("position", "open", "thesis", 1.0, 0.5)
COMPLYING = RIGID._replace(law="weighted")
DATA = Path(__file__).parents[1] / "docs" / "data" / "peg_campaign.jsonl"
PROGRAM = Path(__file__).parents[1] / "examples" / "peg_in_hole.py"


def came(group: Group, seed: int, peak: float = 10.0, *, inserted: bool = True) -> Insertion:
    why = "" if inserted else "stopped 3.0 mm deep"
    return Insertion(
        *group,
        seed=seed,
        inserted=inserted,
        why=why,
        depth=0.04 if inserted else 0.003,
        lateral_peak=peak,
        lateral_mean=0.1 * peak,
        axial_peak=5.0,
        seconds=4.0,
    )


@pytest.fixture
def campaign(rfms: Rfms) -> Rfms:
    return partial(rfms, "campaign")


@pytest.fixture(scope="module")
def conditions() -> Conditions:
    return Conditions.of(PROGRAM, 0.9)


# --- what is asked -------------------------------------------------------------------------------


@given(st.integers(0, 10_000), st.floats(0.0, 3.0), st.floats(0.0, 5.0))
def test_a_misalignment_is_in_its_disks_and_the_same_each_time(
    seed: int, offset: float, tilt: float
) -> None:
    drawn = Misalignment.drawn(seed, offset, tilt)
    assert drawn == Misalignment.drawn(seed, offset, tilt)
    assert math.hypot(drawn.x_mm, drawn.y_mm) <= offset + 1e-4
    assert math.hypot(drawn.tilt_x_deg, drawn.tilt_y_deg) <= tilt + 1e-4


def test_misalignments_fill_their_disks() -> None:
    """Half of the points of a disk lie beyond 0.707 of its radius."""
    drawn = [Misalignment.drawn(seed, 1.0, 0.5) for seed in range(400)]
    beyond = sum(math.hypot(d.x_mm, d.y_mm) > math.sqrt(0.5) for d in drawn)
    assert 160 < beyond < 240
    assert all(sum(sign * d.x_mm > 0.0 for d in drawn) > 160 for sign in (-1, 1))


def test_all_laws_meet_the_same_holes_with_the_same_gains() -> None:
    groups = groups_of(TASKS, FRICTIONS)
    for task in TASKS:
        at_task = [g for g in groups if g.offset_mm == task.offset_mm]
        assert len(at_task) == len(FRICTIONS) * len(ControlLaw)
        assert len({Job(group, 7, 0.9).settings.scene for group in at_task}) == 1
    assert {g.loop for g in groups if g.law == "position"} == {"open"}
    assert len(groups) == len(set(groups))
    assert {g.law for g in groups_of(TASKS[1:], FRICTIONS, [ControlLaw.HYBRID])} == {"hybrid"}


# --- what is kept --------------------------------------------------------------------------------


def test_what_was_run_is_not_run_again(
    tmp_path: Path, conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Job] = []

    def fake(job: Job, program: Path) -> Insertion:
        assert program == PROGRAM
        made.append(job)
        return came(job.group, job.seed, peak=10.0 + job.seed)

    monkeypatch.setattr(campaign_runs, "insert", fake)
    file = tmp_path / "kept.jsonl"
    few, all_of_them = (jobs_of([RIGID, COMPLYING], range(n), 0.9) for n in (2, 5))
    run_all(few, PROGRAM, RESULTS.open(file, conditions), Serial())
    runs = run_all(all_of_them, PROGRAM, RESULTS.open(file, conditions), Serial())
    assert [job.seed for job in made] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]
    assert [(run.group, run.seed) for run in runs] == [(j.group, j.seed) for j in all_of_them]
    assert read(file) == (conditions, runs)


def test_a_line_that_was_cut_off_is_run_again(tmp_path: Path, conditions: Conditions) -> None:
    file = tmp_path / "kept.jsonl"
    first, second = came(RIGID, 0), came(RIGID, 1)
    results = RESULTS.open(file, conditions)
    results.add(first)
    results.add(second)
    file.write_bytes(file.read_bytes()[:-20])
    again = RESULTS.open(file, conditions)
    assert again.results == [first]
    again.add(second)
    assert read(file)[1] == [first, second]


def test_results_of_other_conditions_are_not_mixed_in(
    tmp_path: Path, conditions: Conditions
) -> None:
    file = tmp_path / "kept.jsonl"
    RESULTS.open(file, conditions).add(came(RIGID, 0))
    before = file.read_bytes()
    with pytest.raises(RfmsError, match=r"kept.jsonl holds runs with dither 0.9, not 0.5: give"):
        RESULTS.open(file, msgspec.structs.replace(conditions, dither=0.5))
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is not a file of runs: its first line has no conditions"),
        ("hello\n", "is not a file of runs: its first line has no conditions"),
        ('{"a": 1}\n', "is not a file of runs: its first line has no conditions"),
    ],
)
def test_a_file_that_is_none_is_refused_and_left_alone(
    tmp_path: Path, conditions: Conditions, text: str, says: str
) -> None:
    file = tmp_path / "kept.jsonl"
    file.write_text(text)
    with pytest.raises(RfmsError, match=says):
        RESULTS.open(file, conditions)
    assert file.read_text() == text


def test_a_line_that_is_no_run_is_named(tmp_path: Path, conditions: Conditions) -> None:
    file = tmp_path / "kept.jsonl"
    RESULTS.open(file, conditions).add(came(RIGID, 0))
    file.write_bytes(file.read_bytes() + b'{"law": 3}\n')
    with pytest.raises(RfmsError, match="line 3 is not one of the runs"):
        RESULTS.open(file, conditions)


# --- what it amounts to --------------------------------------------------------------------------


def test_peaks_are_compared_on_the_misalignments_both_have_met() -> None:
    rigid = [came(RIGID, seed, peak) for seed, peak in enumerate((40.0, 80.0, 120.0))]
    ours = [came(COMPLYING, 0, 10.0), came(COMPLYING, 1, 20.0, inserted=False)]
    theirs, row = rows_of([*rigid, *ours])
    assert (theirs.ratio, theirs.peak, theirs.largest) == (None, 80.0, 120.0)
    assert row.ratio == pytest.approx(30.0 / 120.0)
    assert (row.runs, row.inserted) == (2, 1)


def test_a_closed_loop_is_compared_with_position_control_too() -> None:
    wide = RIGID._replace(offset_mm=2.0, tilt_deg=1.0)
    closed = wide._replace(law="weighted", loop="closed")
    *_, row = rows_of([came(RIGID, 0, 50.0), came(wide, 0, 100.0), came(closed, 0, 15.0)])
    assert row.ratio == pytest.approx(0.15)


def test_a_table_has_a_cell_under_every_heading() -> None:
    text = markdown(rows_of([came(RIGID, 0), came(COMPLYING, 0, inserted=False)]))
    assert {line.count("|") for line in text.splitlines()} == {len(HEADINGS) + 1}
    assert "0 of 1" in text


# --- what is refused -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("--seeds 0", "seeds 0: give one or more"),
        ("--workers 0", "workers 0: give one or more"),
        ("--loop ajar", "loop 'ajar': it is open or closed"),
        ("--offset 9", "offset 9 is not in 0..3"),
        ("--tilt -1", "tilt -1 is not in 0..5"),
        ("--dither nan", "dither nan is not in 0..1"),
        ("--friction glue", "no friction set 'glue'"),
        ("--program nowhere.py", "nowhere.py cannot be read"),
        ("--keep nowhere/kept.jsonl", "nowhere/kept.jsonl"),
    ],
)
def test_wrong_words_are_told_in_one_line(campaign: Rfms, words: str, says: str) -> None:
    assert says in campaign(*words.split()).complaint


def test_a_worker_elsewhere_runs_the_text_that_it_was_sent(tmp_path: Path) -> None:
    """Its file may be missing there, or be another one."""
    here, there = tmp_path / "mine.py", tmp_path / "gone" / "mine.py"
    here.write_bytes(b"text")
    assert campaign_runs._here(here, b"text") == here
    for program in (there, here):
        copy = campaign_runs._here(program, b"another text")
        assert (copy.name, copy.read_bytes()) == ("mine.py", b"another text")
    assert here.read_bytes() == b"text"


def test_a_program_that_raises_gives_its_reason_without_its_place(tmp_path: Path) -> None:
    program = tmp_path / "gives_up.py"
    program.write_text(
        "from rfms_can.coordinator import ProgramError\n\n"
        "def program(arm):\n    raise ProgramError('it goes no further')\n"
    )
    run = insert(Job(COMPLYING, 0, 0.9), program)
    assert (run.inserted, run.why) == (False, "it goes no further")


# --- the one that is committed -------------------------------------------------------------------


def test_the_committed_campaign_is_whole_and_of_these_conditions(conditions: Conditions) -> None:
    theirs, runs = read(DATA)
    assert (
        json.loads(msgspec.json.encode(theirs)).items()
        >= {
            name: value
            for name, value in json.loads(msgspec.json.encode(conditions)).items()
            if name != "digest"
        }.items()
    )
    per_group: dict[Group, set[int]] = {}
    for run in runs:
        per_group.setdefault(run.group, set()).add(run.seed)
        assert "/" not in run.why
    assert all(seeds == set(range(100)) for seeds in per_group.values())
    assert set(per_group) == set(groups_of(TASKS, FRICTIONS))
