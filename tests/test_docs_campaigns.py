"""docs/campaigns.md: every campaign is in its table, and its program runs."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

from rfms_can.engine.cluster import CERTIFICATES

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = (ROOT / "docs" / "campaigns.md").read_text(encoding="utf-8")
TOOLS: Final = sorted(
    path for path in (ROOT / "tools").glob("*_campaign.py") if not path.name.startswith("draw_")
)


@pytest.mark.parametrize("tool", TOOLS, ids=lambda path: str(path.stem))
def test_every_campaign_is_in_the_table_and_takes_the_common_flags(tool: Path) -> None:
    assert re.search(rf"^\| .*`python tools/{tool.name}[ `]", PAGE, re.MULTILINE)
    text = tool.read_text(encoding="utf-8")
    for name in ("campaign_parser(__doc__", "backend(options)", "exit_with(main)"):
        assert name in text
    assert "multiprocessing" not in text


def test_the_certificates_are_named() -> None:
    named = PAGE.replace("${role}", "CLIENT")
    assert [name for name in CERTIFICATES if name not in named] == []


def test_the_campaign_of_the_page_runs(tmp_path: Path) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    file = tmp_path / "my_campaign.py"
    file.write_text(program + "print([result.seed for result in results])\n")
    ended = subprocess.run(
        [sys.executable, file],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert ended.stdout == f"{list(range(100))}\n"
