"""A campaign's book-keeping, and the command: what is kept, summed up, replayed and refused."""

import json
from pathlib import Path

import msgspec
import pytest
from support.command_line import Rfms

from rfms_can.engine import Serial
from rfms_can.errors import RfmsError
from rfms_can.faults import campaign, results
from rfms_can.faults.campaign import (
    lines_of,
    met_rows,
    rows_from,
    run_all,
    trial_from,
    trials_of,
)
from rfms_can.faults.facts import Facts
from rfms_can.faults.results import digest, kept_in, read
from rfms_can.faults.table import ROWS, Where, variants
from rfms_can.faults.trial import Result, Trial

ARM = "puma260"


def came(trial: Trial, found: float | None = 0.5, *, met: bool = True) -> Result:
    facts = Facts(node=1, injected=1, effect=0.0, reenabled=[] if met else ["a brake opened"])
    why = [] if met else ["too late"]
    return Result(*trial, met, why, found, "R1" if met else "R2", met, facts)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Trial]:
    """Trials that are made, which are met at once."""
    asked: list[Trial] = []

    def make(trials: list[Trial]) -> list[Result]:
        asked.extend(trials)
        return [came(trial) for trial in trials]

    monkeypatch.setattr(campaign, "made_of", make)
    return asked


@pytest.mark.parametrize(
    ("text", "rows"), [("", list(ROWS)), ("3", [3]), ("1,4-6", [1, 4, 5, 6]), (" 2 , 1", [2, 1])]
)
def test_rows_in_words(text: str, rows: list[int]) -> None:
    assert rows_from(text) == rows


@pytest.mark.parametrize("text", ["x", "1,", "40", "0", "3-", "1-50", "-1"])
def test_rows_that_do_not_exist_are_refused(text: str) -> None:
    with pytest.raises(RfmsError, match="row"):
        rows_from(text)


def test_a_trial_in_words_is_the_one_it_was() -> None:
    for row, variant in variants():
        trial = Trial(row, variant.name, ARM, 7)
        assert trial_from(trial.words, ARM, variant.where) == trial
        (other,) = set(Where) - {variant.where}
        with pytest.raises(RfmsError, match=f"it needs {variant.where.value}; give another --bus"):
            trial_from(trial.words, ARM, other)


@pytest.mark.parametrize("text", ["", "1", "1:lose_dac", "1:lose_dac:x", "1:nothing:0", "99:x:0"])
def test_trials_that_do_not_exist_are_refused(text: str) -> None:
    with pytest.raises(RfmsError):
        trial_from(text, ARM, Where.SIM)


def test_no_seed_is_left_out_and_none_is_made_twice(made: list[Trial], tmp_path: Path) -> None:
    keep = tmp_path / "kept.jsonl"
    trials = trials_of([1], [ARM], 3)
    assert len(trials) == 3 * len(ROWS[1].variants)
    run_all(trials[:5], kept_in(keep), Serial())
    assert made == trials[:5]
    told = run_all(trials, kept_in(keep), Serial())
    assert sorted(made) == sorted(trials)
    assert [result.seed for result in told] == [trial.seed for trial in trials]


def test_a_line_that_was_cut_off_is_made_again(made: list[Trial], tmp_path: Path) -> None:
    keep = tmp_path / "kept.jsonl"
    trials = trials_of([3], [ARM], 1)
    run_all(trials, kept_in(keep), Serial())
    keep.write_bytes(keep.read_bytes()[:-9])
    made.clear()
    run_all(trials, kept_in(keep), Serial())
    assert made == trials[-1:]
    assert len(read(keep)[1]) == len(trials)


def test_results_of_other_code_are_not_taken(
    made: list[Trial], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep = tmp_path / "kept.jsonl"
    run_all(trials_of([3], [ARM], 1), kept_in(keep), Serial())
    before = keep.read_bytes()
    monkeypatch.setattr(results, "digest", lambda: "another")
    with pytest.raises(RfmsError, match=r"holds faults with code .*, not another"):
        kept_in(keep)
    assert keep.read_bytes() == before
    keep.write_text("no results\n", encoding="utf-8")
    with pytest.raises(RfmsError, match="is not a file of faults"):
        kept_in(keep)


def test_the_digest_is_of_all_code_that_trials_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(results, "PACKAGE", tmp_path)
    for name in ("master/node.py", "faults/judge.py", "cli/run.py"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text("a = 1\n", encoding="utf-8")
    first = digest()
    (tmp_path / "cli/run.py").write_text("a = 2\n", encoding="utf-8")
    assert digest() == first, "the command line runs in no trial"
    for name in ("master/node.py", "faults/judge.py"):
        (tmp_path / name).write_text("a = 2\n", encoding="utf-8")
        assert digest() != first
        first = digest()


def test_a_row_is_met_if_all_its_seeds_are() -> None:
    trials = trials_of([3], [ARM], 3)
    good = [came(trial) for trial in trials]
    lines = lines_of([3], [ARM], good)
    assert met_rows(lines) == {3: True}
    assert {line.replay for line in lines} == {None}
    bad = [
        came(t, 2.5, met=False) if t.seed == 1 and t.variant == "copy_dac" else came(t)
        for t in trials
    ]
    lines = lines_of([3], [ARM], bad)
    assert met_rows(lines) == {3: False}
    (line,) = [line for line in lines if not line.met]
    assert (line.variant, line.seeds, line.worst, line.reaction) == ("copy_dac", 3, 2.5, "R1, R2")
    assert (line.replay, line.why) == ("3:copy_dac:1", ["too late"])
    assert (line.culprit_ok, line.reenabled) == (False, True)


def test_one_that_was_never_found_has_no_worst() -> None:
    trials = trials_of([34], [ARM], 2)
    (line,) = lines_of([34], [ARM], [came(trials[0]), came(trials[1], None, met=False)])
    assert line.worst is None


def test_each_system_has_the_trials_and_lines_of_its_own_variants() -> None:
    for where, names in ((Where.SIM, ["stop_joint"]), (Where.PROCESSES, ["kill_joint"])):
        trials = trials_of([11], [ARM], 2, where)
        assert [trial.variant for trial in trials] == names * 2
        lines = lines_of([11], [ARM], [came(trial) for trial in trials], where)
        assert [(line.variant, line.seeds, line.met) for line in lines] == [(names[0], 2, True)]
    assert trials_of([18, 39], [ARM], 1) == [], "processes alone have a clock and a disk"


def test_lines_as_json_have_the_keys_that_others_read() -> None:
    (line,) = lines_of([34], [ARM], [came(trials_of([34], [ARM], 1)[0])])
    wanted = [
        "row",
        "variant",
        "arm",
        "seeds",
        "met",
        "bound",
        "worst",
        "reaction",
        "culprit_ok",
        "reenabled",
    ]
    assert list(msgspec.to_builtins(line))[: len(wanted)] == wanted


# --- the command ----------------------------------------------------------------------------------


@pytest.mark.system
def test_the_command_tells_rows_and_exits_by_them(rfms: Rfms) -> None:
    met = rfms("faults", "--rows", "30", "--seeds", "1", "--jobs", "1", "--arm", ARM, "--json")
    assert met.code == 0, met.err
    rows = json.loads(met.out)["rows"]
    assert [(row["variant"], row["met"]) for row in rows] == [
        ("ask_unreachable", True),
        ("ask_no_rotation", True),
    ]
    missed = rfms("faults", "--rows", "29,30", "--seeds", "1", "--jobs", "2", "--arm", ARM)
    assert missed.code == 1
    assert "1 of 2 rows met; not met: 29" in missed.out
    assert "rfms faults --arm puma260 --replay '29:lead_singular:0'" in missed.out


@pytest.mark.system
def test_a_replay_writes_a_record_and_a_plot(rfms: Rfms, tmp_path: Path) -> None:
    ended = rfms(
        "faults", "--replay", "13:mute_plant:0", "--arm", ARM, "--record", "again", "--json"
    )
    assert ended.code == 0, ended.err
    told = json.loads(ended.out)
    assert (told["met"], told["reaction"]) == (True, "R4")
    again = tmp_path / "again"
    assert {path.name for path in again.iterdir()} >= {"bus.log", "fault.png", "summary.json"}
    assert (again / "bus.log").stat().st_size > 100_000


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--rows", "77"), "row 77 does not exist"),
        (("--seeds", "0"), "seeds 0"),
        (("--jobs", "0"), "jobs 0"),
        (("--bus", "hub:x"), "bus 'hub:x': faults are tried on sim, hub, vcan0"),
        (("--bus", "vcan0", "--jobs", "2"), "jobs 2: there is one vcan0"),
        (("--bus", "hub", "--cluster", "tcp://127.0.0.1:1"), "processes are started on this"),
        (("--rows", "18"), "rows 18: none is tried with all nodes in one process"),
        (("--arm", "scara"), "arm 'scara' does not exist"),
        (("--replay", "1:nothing:0"), "no variant 'nothing'"),
        (("--replay", "18:wall_clock:0"), "it needs a process for each node"),
    ],
)
def test_what_cannot_be_asked_is_refused(
    rfms: Rfms, arguments: tuple[str, ...], complaint: str
) -> None:
    assert complaint in rfms("faults", *arguments).complaint
