"""The measures of the planners' bench, and ``tools/bench_planners.py`` as it is typed."""

import dataclasses
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from planners.bench import BASELINE, PLANNERS, Figures, Row, compare
from planners.deviation import deviation
from planners.planner import NotPossibleError
from planners.run import Run
from planners.smoothness import HIGHEST, continuity, peak
from planners.table import COLUMNS, cells
from planners.task import TASKS
from pytest import approx

from rfms_can.arm import PUMA_260
from rfms_can.kinematics import Joints

TOOL = Path(__file__).parents[1] / "tools" / "bench_planners.py"
CORNER = TASKS["corner"](PUMA_260)


class Power:
    """Joint 1 rests for 0.2 s, then runs as 0.2 t^order: that derivative is the first to step."""

    def __init__(self, period_s: float, order: int, arrival: float = 0.5) -> None:
        self.leg = 0
        self.blending = False
        self._period = period_s
        self._order = order
        self._arrival = arrival
        self._cycle = 0

    def step(self) -> Joints:
        self._cycle += 1
        time = self._cycle * self._period
        if time >= self._arrival:
            self.leg = len(CORNER.legs)
        since = time - 0.2
        q1, q2, q3, q4, q5, q6 = CORNER.start
        return (q1 + (0.2 * since**self._order if since > 0.0 else 0.0), q2, q3, q4, q5, q6)


def power(order: int, period_s: float, arrival: float = 0.5) -> Run:
    return Run(lambda _, tau: Power(tau, order, arrival), CORNER, period_s)


@pytest.mark.parametrize("order", range(7))
def test_the_order_is_that_before_the_first_derivative_that_steps(order: int) -> None:
    coarse, fine = (power(order, period) for period in (0.002, 0.001))
    assert continuity(coarse, fine) == min(order - 1, HIGHEST)


def test_peaks_are_those_of_the_derivatives() -> None:
    run = power(3, 0.001)
    last = run.time[-1] - 0.2
    assert peak(run, 3) == approx(0.2 * 6.0, rel=1e-3)
    assert peak(run, 2) == approx(0.2 * 6.0 * last, rel=0.01)


def test_distances_are_of_the_tool_from_its_line_and_goal() -> None:
    """A joint that runs away from the first line: what its tool does in space is measured."""
    run = power(1, 0.004)
    off = deviation(run)
    x = run.q[-1][0] - CORNER.start[0]
    assert off.line is not None
    assert 0.05 * x < off.line.distance < 0.5 * x  # m per rad: the tool's distance from joint 1
    assert off.goal.distance > off.line.distance


def test_a_planner_that_never_arrives_is_told_so() -> None:
    with pytest.raises(NotPossibleError, match="does not arrive"):
        power(1, 0.01, arrival=1e9)


def test_costs_are_compared_with_the_thesis_planner_even_if_it_is_not_asked_for() -> None:
    rows = compare(CORNER, ["paul", BASELINE], 0.01, 1)
    assert [row.planner for row in rows] == ["paul", BASELINE]
    paul, ours = (row.figures for row in rows)
    assert paul is not None
    assert ours is not None
    assert (ours.cost_ratio, ours.worst_ratio) == (1.0, 1.0)
    assert paul.cost_ratio == approx(paul.cost_us / ours.cost_us)
    assert paul.worst_ratio == approx(paul.worst_us / ours.worst_us)
    (alone,) = compare(CORNER, ["paul"], 0.01, 1)
    assert alone.figures is not None
    assert alone.figures.cost_ratio > 0.0
    assert len(cells(alone.figures)) == len(COLUMNS)


def test_what_no_planner_can_do_has_a_reason_and_no_figures() -> None:
    (row,) = compare(TASKS["belt"](PUMA_260), ["taylor"], 0.01, 1)
    assert row == Row("belt", "taylor", None, row.not_possible)
    assert row.not_possible is not None
    assert "no goal may move" in row.not_possible


# --- The command ----------------------------------------------------------------------------------


def bench(*arguments: str, hide: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(TOOL), *arguments]
    if hide:
        run = (
            "import runpy, sys; sys.modules[sys.argv[1]] = None; del sys.argv[0:2]; "
            f"sys.path.insert(0, {str(TOOL.parent)!r}); "
        )
        command = [sys.executable, "-c", run + "runpy.run_path(sys.argv[0], run_name='__main__')"]
        command += [hide, str(TOOL), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


FAST = ("--rate", "100", "--repeats", "1")


@pytest.fixture(scope="module")
def printed() -> dict[str, Any]:
    ended = bench(*FAST, "--json")
    assert ended.returncode == 0, ended.stderr
    answer = json.loads(ended.stdout)
    assert isinstance(answer, dict)
    return answer


def test_json_has_every_planner_on_every_task(printed: dict[str, Any]) -> None:
    assert {key: printed[key] for key in ("arm", "rate_hz", "repeats")} == {
        "arm": "puma260",
        "rate_hz": 100.0,
        "repeats": 1,
    }
    pairs = [(row["task"], row["planner"]) for row in printed["rows"]]
    assert pairs == [(task, planner) for task in TASKS for planner in PLANNERS]


def test_json_rows_have_all_figures_or_a_reason(printed: dict[str, Any]) -> None:
    names = {field.name for field in dataclasses.fields(Figures)}
    for row in printed["rows"]:
        assert set(row) == {"task", "planner", "figures", "not_possible"}
        assert (row["figures"] is None) == (row["not_possible"] is not None)
        if row["figures"] is None:
            assert row["not_possible"]
            continue
        assert set(row["figures"]) == names
        may_be_missing = {"line_mm", "line_deg", "corner_mm"}
        missing = {name for name, value in row["figures"].items() if value is None}
        assert missing <= may_be_missing
        assert isinstance(row["figures"]["order"], int)


def test_orders_and_refusals_are_those_the_page_tells_of(printed: dict[str, Any]) -> None:
    orders = {
        (row["planner"], row["task"]): row["figures"] and row["figures"]["order"]
        for row in printed["rows"]
    }
    told = {
        "thesis": (3, 3, 3),
        "thesis-printed": (1, 2, 1),
        "whitney-open": (0, None, None),
        "whitney": (0, None, 0),
        "paul": (0, 0, 2),
        "taylor": (1, 1, None),
        "ruckig": (2, 2, 2),
    }
    assert orders == {
        (planner, task): order
        for planner, row in told.items()
        for task, order in zip(TASKS, row, strict=True)
    }


def test_the_table_shows_the_planners_and_tasks_that_were_asked_for() -> None:
    ended = bench(*FAST, "--planner", "taylor", "--planner", "thesis", "--task", "belt")
    assert ended.returncode == 0, ended.stderr
    assert "belt: " in ended.stdout
    assert "corner: Along" not in ended.stdout
    rows = [line for line in ended.stdout.splitlines() if line.startswith("│")]
    assert [row.split()[1] for row in rows] == ["taylor", "thesis"]
    assert "taylor: not possible: its knots are solved before the motion" in ended.stdout


def test_a_planner_asked_for_without_its_library_is_one_line() -> None:
    ended = bench(*FAST, "--planner", "ruckig", "--task", "corner", hide="ruckig")
    assert ended.returncode == 1
    assert ended.stdout == ""
    (line,) = ended.stderr.splitlines()
    assert line == "bench_planners: ruckig needs ruckig: pip install 'rfms_can[bench]'"


def test_the_rest_is_measured_without_the_library() -> None:
    ended = bench(*FAST, "--task", "corner", "--json", hide="ruckig")
    assert ended.returncode == 0, ended.stderr
    reasons = {row["planner"]: row["not_possible"] for row in json.loads(ended.stdout)["rows"]}
    assert {planner for planner, reason in reasons.items() if reason} == {"ruckig"}


def test_accelerations_are_drawn(tmp_path: Path) -> None:
    picture = tmp_path / "planners.png"
    ended = bench(*FAST, "--task", "belt", "--planner", "paul", "--picture", str(picture))
    assert ended.returncode == 0, ended.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--planner", "nobody"), "invalid choice: 'nobody'"),
        (("--rate", "5"), "--rate 5 is not in 20 to 2000 Hz"),
        (("--repeats", "0"), "--repeats 0: give at least 1"),
    ],
)
def test_a_wrong_argument_is_refused_with_what_would_do(
    arguments: tuple[str, ...], complaint: str
) -> None:
    ended = bench(*arguments)
    assert ended.returncode == 2
    assert complaint in ended.stderr
