"""Every piece of code in docs/programs.md runs: files, pieces of a program, scripts on the link."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.server import Running

from rfms_can import coordinator
from rfms_can.coordinator import Arm
from rfms_can.messages import Query
from rfms_can.messages.outcomes import OUTCOMES
from rfms_can.rig.program import load_program
from rfms_can.rig.runner import execute
from rfms_can.rig.serve import Listening
from rfms_can.rig.settings import RunSettings

pytestmark = pytest.mark.system

PAGE = Path(__file__).parents[1] / "docs" / "programs.md"
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
FILES = [block for block in BLOCKS if "def program(" in block]
SCRIPTS = [block for block in BLOCKS if "with connect" in block]
PIECES = [block for block in BLOCKS if block not in FILES and block not in SCRIPTS]


@pytest.fixture
def running(runtime: Path) -> Iterator[Running]:
    with Running(RunSettings(), Listening("rfms")) as server:
        yield server


def test_the_page_has_all_kinds() -> None:
    assert (len(FILES), len(SCRIPTS)) == (1, 2)
    assert len(PIECES) > 8


@pytest.mark.parametrize("block", FILES)
def test_a_program_file_runs(block: str, tmp_path: Path) -> None:
    path = tmp_path / "page.py"
    path.write_text(block, encoding="utf-8")
    outcome = execute(load_program(path), RunSettings())
    assert outcome.fault is None
    assert outcome.result.incomplete == 0


def test_the_pieces_are_one_program(capsys: pytest.CaptureFixture[str]) -> None:
    ran: list[int] = []

    def program(arm: Arm) -> None:
        names: dict[str, Any] = {"arm": arm}
        for number, piece in enumerate(PIECES):
            exec(compile(piece, f"{PAGE.name}, piece {number}", "exec"), names)
            ran.append(number)

    outcome = execute(program, RunSettings())
    assert outcome.fault is None
    assert outcome.result.incomplete == 0
    assert len(ran) == len(PIECES)
    deviation, refusal = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"\d\.\d\d s, past the last goal at \d+\.\d mm", deviation)
    assert re.fullmatch(r"to 'to the moon' with 'far': .*reach is 0\.4064 m.*", refusal)


@pytest.mark.parametrize("block", SCRIPTS)
def test_a_script_runs_against_a_server(block: str, running: Running) -> None:
    exec(compile(block, PAGE.name, "exec"), {})
    told = running.client("reader").ask(Query()).status
    assert (told.completed, told.at_rest, told.lease, told.fault) == (1, True, None, None)


def test_settings_and_errors_are_all_on_the_page() -> None:
    text = PAGE.read_text(encoding="utf-8")
    settings = coordinator.ModeSettings.__annotations__
    errors = [name for name in coordinator.__all__ if name.endswith("Error")]
    missing = [name for name in (*settings, *errors) if f"`{name}`" not in text]
    assert missing == ["RfmsError"]


def test_every_outcome_is_on_the_page_with_what_it_raises() -> None:
    rows = re.findall(r"^\| `Outcome\.(\w+)` \|(.*)$", PAGE.read_text(encoding="utf-8"), re.M)
    assert [name for name, _ in rows] == [how.name for how in OUTCOMES]
    for name, told in rows:
        error = OUTCOMES[coordinator.Outcome[name]].error
        assert ("Error`" in told) == (error is not None)
        assert error is None or f"`{error.__name__}`" in told
