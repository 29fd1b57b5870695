"""What docs/ say of the wire, the states and the verbs is what the code says."""

import re
from collections.abc import Callable

import draw_campaign
import draw_cli
import draw_conform
import draw_corners
import draw_faults
import draw_link
import draw_link_campaign
import draw_mutants
import draw_programs
import draw_safety_mutants
import draw_servoing
import draw_soak
import draw_states
import draw_wire
import msgspec
import pytest
from generated import DOCS, with_section

from rfms_can import messages
from rfms_can.wire.codec import load_database


@pytest.mark.parametrize(
    ("tool", "file", "render"),
    [
        ("draw_campaign.py", "peg-campaign.md", draw_campaign.render),
        ("draw_cli.py", "command-line.md", draw_cli.render),
        ("draw_conform.py", "conform.md", draw_conform.render),
        ("draw_corners.py", "corners.md", draw_corners.render),
        ("draw_link.py", "link.md", draw_link.render),
        ("draw_link_campaign.py", "link-campaign.md", draw_link_campaign.render),
        *[
            (name, file, render)
            for pages in (
                *(draw_programs.PAGES, draw_mutants.PAGES, draw_faults.PAGES, draw_soak.PAGES),
                draw_safety_mutants.PAGES,
            )
            for file, sections in pages.items()
            for name, render in sections.items()
        ],
        ("draw_servoing.py", "servoing.md", draw_servoing.render),
        ("draw_states.py", "states.md", draw_states.render),
        ("draw_wire.py", "wire.md", draw_wire.render),
    ],
)
def test_generated_part_is_up_to_date(tool: str, file: str, render: Callable[[], str]) -> None:
    text = (DOCS / file).read_text(encoding="utf-8")
    assert with_section(text, tool, render()) == text, f"run python tools/{tool}"


def test_every_identifier_of_the_contract_is_listed_once() -> None:
    listed: list[int] = []
    for first, last in re.findall(r"^\| 0x(\w+)(?:\.\.0x(\w+))? ", draw_wire.render(), re.M):
        listed.extend(range(int(first, 16), int(last or first, 16) + 1))
    assert listed == sorted(message.frame_id for message in load_database().messages)


def test_every_message_of_the_link_is_listed_with_its_meaning() -> None:
    page = draw_link.render()
    listed = {cls for _, _, classes in draw_link.GROUPS for cls in classes}
    known = {cls for cls in vars(messages).values() if isinstance(cls, type)}
    assert {cls for cls in known if issubclass(cls, msgspec.Struct)} - {messages.Message} == listed
    for cls in listed - {messages.Envelope}:
        said = draw_link.meanings(cls)
        assert set(said) - {""} <= set(cls.__struct_fields__), f"{cls.__name__}: no such field"
    assert "| `duration_s` | number (>= 0.1, <= 10) | 1.0 | time after which it lapses" in page


def test_a_file_without_markers_is_refused() -> None:
    with pytest.raises(SystemExit, match=r"no section <!-- begin draw_wire\.py -->"):
        with_section("# No markers here\n", "draw_wire.py", "")
