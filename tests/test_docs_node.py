"""docs/node.md and the pages beside it: what they print is what a joint of ours does."""

import re
from collections.abc import Callable

import draw_node
import pytest
from generated import DOCS, with_section

SECTIONS = [
    pytest.param(file, name, render, id=name.removeprefix("draw_node.py: "))
    for file, sections in draw_node.PAGES.items()
    for name, render in sections.items()
]


@pytest.mark.parametrize(("file", "name", "render"), SECTIONS)
def test_generated_part_is_up_to_date(file: str, name: str, render: Callable[[], str]) -> None:
    text = (DOCS / file).read_text(encoding="utf-8")
    assert with_section(text, name, render()) == text, "run python tools/draw_node.py"


@pytest.mark.parametrize("file", draw_node.PAGES)
def test_every_marked_part_is_generated(file: str) -> None:
    text = (DOCS / file).read_text(encoding="utf-8")
    marked = [line for line in text.splitlines() if line.startswith("<!-- begin ")]
    assert sorted(marked) == sorted(f"<!-- begin {name} -->" for name in draw_node.PAGES[file])


@pytest.mark.parametrize("file", [*draw_node.PAGES, "hub.md"])
def test_every_link_leads_to_a_heading(file: str) -> None:
    text = (DOCS / file).read_text(encoding="utf-8")
    links = re.findall(r"\]\(([\w.-]*)#([\w-]+)\)", text)
    for page, anchor in links:
        told = (DOCS / (page or file)).read_text(encoding="utf-8")
        headings = re.findall(r"^#+ (.*)$", told, re.MULTILINE)
        slugs = {re.sub(r"[^\w -]", "", h.lower()).replace(" ", "-") for h in headings}
        assert anchor in slugs, f"{page}#{anchor}"
    assert links or file == "hub.md"
