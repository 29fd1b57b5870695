"""The README's program runs as printed, and no page points to a file that is not there."""

import re
from pathlib import Path

import pytest

from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.session import Rig
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Sync

ROOT = Path(__file__).parents[1]
CYCLES = (718, 719)
"""Those of the README's candump."""
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).is_file()]
    assert missing == []


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
    """Joint 5 for two cycles of the transfer."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    printed = re.findall(r"^  vcan0  ([0-9A-F]{3})  \[\d\d\]  ([0-9A-F ]+)$", text, re.MULTILINE)
    identifiers = {int(identifier, 16) for identifier, _ in printed}
    codec = Wire().codec(Sync)
    sent: list[tuple[str, str]] = []
    cycle = 0

    def look(_: int, frame: Frame) -> None:
        nonlocal cycle
        if frame.id == codec.id:
            sync = codec.unpack(frame.data)
            assert sync is not None
            cycle = sync.cycle
        if cycle in CYCLES and frame.id in identifiers:
            sent.append((f"{frame.id:03X}", frame.data.hex(" ").upper()))

    program = load_program(ROOT / "examples" / "transfer.py")

    def watch(rig: Rig) -> None:
        assert isinstance(rig, SimulatedRig)
        rig.observe(look)

    execute(program, RunSettings(), watch=watch)
    assert printed == sent
