"""What docs/ say of the wire and of the states is what the DBC and the tables say."""

from collections.abc import Callable

import draw_states
import draw_wire
import pytest
from generated import DOCS, with_section


@pytest.mark.parametrize(
    ("tool", "file", "render"),
    [
        ("draw_states.py", "states.md", draw_states.render),
        ("draw_wire.py", "wire.md", draw_wire.render),
    ],
)
def test_generated_part_is_up_to_date(tool: str, file: str, render: Callable[[], str]) -> None:
    text = (DOCS / file).read_text(encoding="utf-8")
    assert with_section(text, tool, render()) == text, f"run python tools/{tool}"


def test_every_message_of_the_contract_is_listed() -> None:
    listed = draw_wire.render()
    for message in draw_wire.load_database().messages:
        kind = draw_wire.kind_of(message)
        assert f"0x{message.frame_id:03X}" in listed or f"{kind.comment}" in listed
        for signal in message.signals:
            if signal.name not in draw_wire.HEADER:
                assert f"| {signal.name} |" in listed


def test_a_file_without_markers_is_refused() -> None:
    with pytest.raises(SystemExit, match=r"no section <!-- begin draw_wire\.py -->"):
        with_section("# No markers here\n", "draw_wire.py", "")
