"""The README's program runs as printed, and no page points to a file that is not there."""

import re
from pathlib import Path

import draw_candump
import pytest
from generated import with_section

from rfms_can.bus.url import OWN
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.settings import RunSettings

ROOT = Path(__file__).parents[1]
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).is_file()]
    assert missing == []


def test_every_bus_of_our_own_has_its_row() -> None:
    buses = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Buses")[2]
    rows = [line for line in buses.splitlines() if line.startswith("| `")]
    assert [word for word in OWN if not any(f"`{word}" in row for row in rows)] == []


@pytest.mark.system
def test_the_program_of_the_readme_runs(tmp_path: Path) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    path = tmp_path / "readme.py"
    path.write_text(program, encoding="utf-8")
    outcome = execute(load_program(path), RunSettings())
    assert outcome.fault is None
    assert outcome.result.incomplete == 0


@pytest.mark.system
def test_the_candump_of_the_readme_is_what_a_run_sends() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    written = with_section(text, "draw_candump.py", draw_candump.render())
    assert written == text, "run python tools/draw_candump.py"
    assert len(re.findall(r"^  vcan0  ", text, re.MULTILINE)) == 8
