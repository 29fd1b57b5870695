"""Campaigns: what a file has is not made again, what is made is kept at once, and in order."""

import io
import json
import os
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec
import pytest

from rfms_can.engine import Backend, Kept, Processes, Progress, ResultFile, Serial, carry_out, run
from rfms_can.engine.progress import EVERY_S, left_in_words
from rfms_can.engine.signals import Terminated, exit_code
from rfms_can.errors import EngineError, JobError

ROOT: Final = Path(__file__).parents[1]


class Conditions(NamedTuple):
    rate: float
    mix: int = 1


class Squared(NamedTuple):
    number: int
    square: float


class Nested(NamedTuple):
    where: Conditions
    square: Squared


class Struct(msgspec.Struct, frozen=True):
    number: int
    square: float


FILE: Final = ResultFile("squares", "tools/squares.py", Conditions, Squared)
OURS: Final = Conditions(250.0)


def squared(number: int) -> Squared:
    return Squared(number, number**2 / 3.0)


def until(number: int, last: int, error: BaseException) -> Squared:
    """A job that ends the campaign."""
    if number == last:
        raise error
    return squared(number)


def campaign(
    numbers: "range | list[int]",
    kept: Kept[Conditions, Squared],
    one: Callable[[int], Squared] = squared,
    backend: Backend | None = None,
) -> list[Squared]:
    return carry_out(
        list(numbers),
        lambda left: run(one, left, backend or Serial()),
        kept,
        what="squares",
        job_key=lambda number: number,
        result_key=lambda result: result.number,
    )


# --- resumption ----------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", [Serial(), Processes(3)])
def test_an_interrupted_campaign_goes_on_and_ends_in_the_same_file(
    tmp_path: Path, backend: Backend
) -> None:
    whole, file = tmp_path / "whole.jsonl", tmp_path / "kept.jsonl"
    campaign(range(20), FILE.open(whole, OURS))
    with pytest.raises(JobError, match="job 7"):
        campaign(
            range(20),
            FILE.open(file, OURS),
            partial(until, last=7, error=ValueError("no")),
            backend,
        )
    before = {result.number for result in FILE.read(file, OURS)[1]}
    assert 0 < len(before) < 20
    made: list[int] = []

    def counted(number: int) -> Squared:
        made.append(number)
        return squared(number)

    results = campaign(range(20), FILE.open(file, OURS), counted)
    assert set(made) == set(range(20)) - before
    assert [result.number for result in results] == list(range(20))
    assert file.read_bytes() == whole.read_bytes()


def test_results_that_came_in_another_order_stand_in_that_of_the_jobs(tmp_path: Path) -> None:
    """Those of other jobs keep their places."""
    file = tmp_path / "kept.jsonl"
    kept = FILE.open(file, OURS)
    for number in (9, 3, 1, 8, 2):
        kept.add(squared(number))
    assert [each.number for each in campaign(range(1, 4), kept)] == [1, 2, 3]
    assert [each.number for each in FILE.read(file)[1]] == [9, 1, 2, 8, 3]
    before = os.stat(file).st_ino
    campaign(range(1, 4), FILE.open(file, OURS))
    assert os.stat(file).st_ino == before  # in order: not touched


def test_without_a_file_results_are_handed_back_all_the_same() -> None:
    assert campaign(range(3), FILE.open(None, OURS)) == [squared(n) for n in range(3)]


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["ctrl-c", "sigterm"]
)
def test_signals_end_it_at_once_and_lose_nothing(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    def one(job: int) -> Squared:
        if job == 4:
            os.kill(os.getpid(), number)
        return squared(job)

    file, before = tmp_path / "kept.jsonl", signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt) as ended:
        campaign(range(20), FILE.open(file, OURS), one)
    assert exit_code(ended.value) == code
    assert isinstance(ended.value, Terminated) == (number == signal.SIGTERM)
    assert [each.number for each in FILE.read(file)[1]] == [0, 1, 2, 3]
    assert signal.getsignal(signal.SIGTERM) is before


# --- the file ------------------------------------------------------------------------------------


def test_floats_of_named_tuples_are_kept_to_seven_digits(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    FILE.open(file, OURS).add(squared(1))
    assert file.read_text() == ('{"rate": 250.0, "mix": 1}\n{"number": 1, "square": 0.3333333}\n')


def test_structs_are_kept_as_they_are(tmp_path: Path) -> None:
    file, kind = tmp_path / "kept.jsonl", ResultFile("squares", "-", Struct, Struct)
    kind.open(file, Struct(0, 0.1)).add(Struct(1, 1.0 / 3.0))
    assert kind.read(file) == (Struct(0, 0.1), [Struct(1, 1.0 / 3.0)])


def test_a_file_may_have_no_conditions_and_records_in_records(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    kind = ResultFile[None, Nested]("squares", "-", None, Nested, digits=3)
    assert kind.read(file) == (None, [])
    kind.open(file, None).add(Nested(OURS, squared(1)))
    assert kind.read(file) == (None, [Nested(OURS, Squared(1, 0.333))])


def test_a_line_that_was_cut_off_is_made_again(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    campaign(range(4), FILE.open(file, OURS))
    whole = file.read_bytes()
    file.write_bytes(whole[:-5])
    assert len(FILE.open(file, OURS).results) == 3
    campaign(range(4), FILE.open(file, OURS))
    assert file.read_bytes() == whole


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not a file of squares: its first line has no conditions"),
        ("hello", "not a file of squares: its first line has no conditions"),
        ('{"a": 1}\n', "not a file of squares: its first line has no conditions"),
        ("[1]\n", "not a file of squares: its first line has no conditions"),
        ('{"rate": 250.0}\n{"a": 1}\n', "line 2 is not one of the squares"),
        ('{"rate": 250.0}\n3\n', "line 2 is not one of the squares"),
        ('{"rate": 125.0}\n', "holds squares with rate 125.0, not 250.0: give another --keep"),
    ],
)
def test_a_file_that_is_another_one_is_refused_and_left_alone(
    tmp_path: Path, text: str, says: str
) -> None:
    file = tmp_path / "kept.jsonl"
    file.write_text(text)
    with pytest.raises(EngineError, match=says):
        FILE.open(file, OURS)
    assert file.read_text() == text


def test_a_file_that_cannot_be_had_is_named(tmp_path: Path) -> None:
    with pytest.raises(EngineError, match=r"no/kept.jsonl: No such file or directory$"):
        FILE.open(tmp_path / "no" / "kept.jsonl", OURS)
    with pytest.raises(EngineError, match=r"Is a directory$"):
        FILE.open(tmp_path, OURS)
    with pytest.raises(EngineError, match=r"does not exist: run tools/squares.py --keep"):
        FILE.read(tmp_path / "kept.jsonl")


@pytest.mark.parametrize(
    "file", sorted((ROOT / "docs" / "data").glob("*.jsonl")), ids=lambda file: str(file.stem)
)
def test_committed_results_are_read_and_written_as_they_are(file: Path, tmp_path: Path) -> None:
    kind: Any = kinds()[file.stem]
    conditions, results = kind.read(file)
    again = tmp_path / file.name
    kind.write(again, conditions, results)
    assert len(results) >= FEWER.get(file.stem, 100)
    assert list(map(json.loads, again.read_bytes().splitlines())) == list(
        map(json.loads, file.read_bytes().splitlines())
    )


FEWER = {"faults_hub": 13, "soak": 50}
"""Campaigns of which each result takes long."""


def kinds() -> dict[str, Any]:
    """The file of each campaign whose results are committed."""
    import corners.results
    import link_campaign
    import node_mutants.results
    import random_programs.refusals
    import random_programs.results
    import safety_mutants.results
    import servoing.results
    import soak.results

    import rfms_can.analysis.campaign.results
    import rfms_can.faults.results

    return {
        "corner_campaign": corners.results.FILE,
        "faults": rfms_can.faults.results.RESULTS,
        "faults_hub": rfms_can.faults.results.RESULTS,
        "link_campaign": link_campaign.FILE,
        "mutant_campaign": node_mutants.results.SUITE,
        "mutant_held_out": node_mutants.results.SUITE,
        "mutant_runs": node_mutants.results.RUNS,
        "peg_campaign": rfms_can.analysis.campaign.results.RESULTS,
        "program_bus_campaign": random_programs.results.FILE,
        "program_campaign": random_programs.results.FILE,
        "refusal_campaign": random_programs.refusals.FILE,
        "safety_mutants": safety_mutants.results.SAFETY,
        "servoing_campaign": servoing.results.FILE,
        "soak": soak.results.FILE,
    }


# --- progress ------------------------------------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_lines_tell_the_time_left_of_what_is_made_now() -> None:
    """Results from earlier took no time."""
    clock, out = Clock(), io.StringIO()
    with Progress("runs", 100, 40, clock=clock, file=out) as progress:
        for _ in range(20):
            clock.now += EVERY_S / 10.0
            progress.advance()
    assert out.getvalue() == "50 of 100 runs, 2 min left\n60 of 100 runs, 2 min left\n"


def test_a_terminal_gets_a_bar_and_remarks_above_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    clock, out = Clock(), Terminal()
    with Progress("runs", 100, 40, clock=clock, file=out) as progress:
        progress.say("not [due]")
        for _ in range(10):
            clock.now += 1.0
            progress.advance()
    shown = out.getvalue()
    assert "not [due]" in shown
    assert "50/100" in shown
    assert "0:00:50" in shown


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "0 s left"), (89.0, "89 s left"), (90.0, "2 min left"), (7200.0, "2.0 h left")],
)
def test_a_time_that_is_left_is_told_in_its_unit(seconds: float, words: str) -> None:
    assert left_in_words(seconds) == words
