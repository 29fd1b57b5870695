"""``tools/bench_thesis.py``: every figure of the thesis has a measure, and the page shows them all.

Nothing here asserts a time: only that each is measured, finite and positive.
"""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import bench_thesis
import pytest
from thesis_operations import MEASURES, Settings, measure
from thesis_times import FIGURES, Figure, Row

ROOT = Path(__file__).parents[1]
TOOL = ROOT / "tools" / "bench_thesis.py"
PAGE = (ROOT / "docs" / "thesis-times.md").read_text(encoding="utf-8")
FEW = ("--repeats", "2", "--batches", "1", "--rounds", "1", "--cycles", "5")

SETTINGS = ("arm", "rate_hz", "repeats", "batches", "rounds", "cycles")

IN_1986 = {
    "t6": ("VI.4.7", 0.005),
    "drive": ("VI.4.7", 0.00327),
    "drive_whole": ("VI.4.7", 0.00327),
    "inverse_1": ("VI.4.7", 0.0013),
    "inverse_2": ("VI.4.7", 0.0013),
    "inverse_3": ("VI.4.7", 0.0013),
    "inverse_4": ("VI.4.7", 0.0013),
    "inverse_5": ("VI.4.7", 0.0013),
    "inverse_6": ("VI.4.7", 0.0013),
    "torque": ("VI.4.7", 0.0014),
    "joint": ("VI.4.7", 0.004),
    "setpoint": ("VI.4.7", 0.00827),
    "rccl": ("V.5", 0.014),
    "dynamics_full": ("VI.4.5", 0.021),
    "dynamics_simplified": ("VI.4.5", 0.021),
    "c_hybrid": ("VI.4.5", 0.014),
    "c_stiffness": ("VI.4.5", 0.014),
    "c_free_joint": ("VI.4.5", 0.014),
    "background": ("VI.4.5", 28.6),
    "serial": ("VI.4.7", 137.6),
    "pipelined": ("VI.4.7", 250.0),
    "bus": ("VI.4.7", 250.0),
    "network": ("VI.2", 0.000288),
    "network_can": ("VI.2", 0.000288),
}
"""Section and figure, s or Hz, once more: read from the thesis and its errata."""


def bench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(TOOL), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


@pytest.fixture(scope="module")
def printed() -> dict[str, Any]:
    ended = bench(*FEW, "--json")
    assert ended.returncode == 0, ended.stderr
    answer = json.loads(ended.stdout)
    assert isinstance(answer, dict)
    return answer


def test_the_figures_of_1986_are_those_of_the_thesis() -> None:
    assert {figure.key: figure.section for figure in FIGURES} == {
        key: section for key, (section, _) in IN_1986.items()
    }
    for figure in FIGURES:
        assert figure.value == pytest.approx(IN_1986[figure.key][1], rel=1e-3)
        assert figure.counted
        assert figure.printed


def test_every_figure_has_a_measure_and_every_measure_a_figure() -> None:
    assert [figure.key for figure in FIGURES] == list(MEASURES)


def test_json_has_every_row_with_finite_positive_numbers(printed: dict[str, Any]) -> None:
    assert {key: printed[key] for key in SETTINGS} == {
        "arm": "puma260",
        "rate_hz": 250.0,
        "repeats": 2,
        "batches": 1,
        "rounds": 1,
        "cycles": 5,
    }
    assert [row["key"] for row in printed["rows"]] == list(IN_1986)
    for row, figure in zip(printed["rows"], FIGURES, strict=True):
        assert row["unit"] in ("s", "Hz")
        assert row["value_1986"] == figure.value
        for name in ("value_here", "ratio"):
            assert math.isfinite(row[name])
            assert row[name] > 0.0


def test_the_ratio_tells_how_many_times_better_it_is() -> None:
    time = Figure("", "", "", "s", 0.004, "", "")
    rate = Figure("", "", "", "Hz", 250.0, "", "")
    assert Row(time, 0.001).ratio == pytest.approx(4.0)
    assert Row(rate, 1000.0).ratio == pytest.approx(4.0)


def test_what_is_computed_is_that_of_the_bus_and_the_same_everywhere() -> None:
    computed = {row.figure.key: row.here for row in measure(Settings(), FIGURES[-3:])}
    assert computed["network_can"] == pytest.approx(10 * 137.6e-6)  # 48 bytes on 1/5 Mbit/s
    assert 300.0 < computed["bus"] < 500.0


def test_the_page_has_the_rows_and_the_figures_of_1986() -> None:
    lines = PAGE.partition("<!-- begin bench_thesis.py -->")[2].splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if "|" in line]
    assert tuple(rows[0]) == bench_thesis.COLUMNS
    told = rows[2:]
    assert len(told) == len(FIGURES)
    for cells, figure in zip(told, FIGURES, strict=True):
        expected = bench_thesis.cells(Row(figure, figure.value))
        assert (cells[0], cells[1], cells[2], cells[5]) == (*expected[:3], expected[5])
    usual = Settings()
    for name in ("arm", "repeats", "batches", "rounds", "cycles"):
        assert f"| `--{name}` | {getattr(usual, name)} |" in PAGE


def test_the_table_is_printed_with_what_made_it() -> None:
    ended = bench(*FEW, "--arm", "puma560", "--rate", "200")
    assert ended.returncode == 0, ended.stderr
    for figure in FIGURES:
        assert figure.operation in ended.stdout
    assert "puma560, 200 Hz; the best of 1 rounds of 1 batches of 2 calls" in ended.stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--arm", "nobody"), "invalid choice: 'nobody'"),
        (("--rate", "5"), "--rate 5 is not in 20 to 300 Hz"),
        (("--rate", "nan"), "--rate nan is not in 20 to 300 Hz"),
        (("--repeats", "0"), "--repeats 0: give at least 1"),
        (("--rounds", "0"), "--rounds 0: give at least 1"),
        (("--cycles", "-1"), "--cycles -1: give at least 1"),
        (("--cycles", "40000"), "--cycles 40000: at most 30000, then the arm rests"),
        (("--json", "--write"), "not allowed with argument"),
    ],
)
def test_a_wrong_argument_is_refused_with_what_would_do(
    arguments: tuple[str, ...], complaint: str
) -> None:
    ended = bench(*arguments)
    assert ended.returncode == 2
    assert complaint in ended.stderr
