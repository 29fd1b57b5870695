"""docs/stability.md: its commands print what it says."""

import re
import shlex
from pathlib import Path

import pytest
from support.command_line import Rfms

from rfms_can.analysis.stability import largest_frequency
from rfms_can.compliance import LAWS
from rfms_can.master.rows.math_processor import COMPLIANT_DAMPING

PAGE = (Path(__file__).parents[1] / "docs" / "stability.md").read_text(encoding="utf-8")
EXAMPLES = [
    example
    for block in re.findall(r"```console\n(.*?)```", PAGE, re.DOTALL)
    for example in re.findall(r"\$ rfms (.*)\n((?:[^$].*\n)*)", block)
]


def test_every_law_is_named() -> None:
    assert [law.value for law in LAWS if f"`{law.value}`" not in PAGE] == []


def test_the_page_has_examples() -> None:
    assert len(EXAMPLES) == PAGE.count("$ rfms stability") >= 10


@pytest.mark.parametrize(("command", "printed"), EXAMPLES, ids=[c for c, _ in EXAMPLES])
def test_a_command_prints_what_the_page_says(command: str, printed: str, rfms: Rfms) -> None:
    ended = rfms(*shlex.split(command))
    shown = " ".join(ended.out.split())
    for line in printed.splitlines():
        assert line in shown


def test_the_table_of_rates() -> None:
    rows = re.findall(r"^\| (\d+) Hz \| ([\d.]+) rad/s \| (\d+) \| ([\d.]+) \|", PAGE, re.MULTILINE)
    assert len(rows) == 4
    for rate, largest, natural, margin in rows:
        bound = largest_frequency(1.0 / float(rate))
        assert float(largest) == pytest.approx(bound, abs=0.06)
        assert float(natural) == min(30.0, 0.15 * float(rate))
        assert float(margin) == pytest.approx(bound / float(natural), rel=5e-3)
    assert largest_frequency(1.0) == pytest.approx(0.426, abs=5e-4)
    assert largest_frequency(1.0, 0.7) == pytest.approx(0.495, abs=5e-4)


def test_the_damping_of_the_nodes() -> None:
    assert f"`--compliant {COMPLIANT_DAMPING:g}`" in PAGE
