"""Keep the generated part of a Markdown file true: what stands between its two marker comments."""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; upright strokes inside a cell are escaped."""
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (columns, *rows)]
    lines = [f"| {' | '.join(row)} |" for row in cells]
    return "\n".join([lines[0], "|" + "---|" * len(columns), *lines[1:]])


def with_section(text: str, tool: str, section: str) -> str:
    """``text`` with the part between the markers of ``tool`` replaced.

    Raises:
        SystemExit: the markers are not there.
    """
    begin, end = f"<!-- begin {tool} -->\n", f"<!-- end {tool} -->\n"
    before, opening, rest = text.partition(begin)
    _, closing, after = rest.partition(end)
    if not opening or not closing:
        sys.exit(f"no section {begin.strip()} ... {end.strip()}: add the two lines")
    return f"{before}{begin}\n{section.strip()}\n\n{end}{after}"


Sections = Mapping[str, Callable[[], str]]
"""What stands between the markers of each name."""


def main(tool: str, file: str, render: Callable[[], str]) -> None:
    """Write the section of a page of docs/, or with ``--check`` exit 1 if it is not up to date."""
    main_of_pages(tool, {file: {tool: render}})


def main_of_pages(tool: str, pages: Mapping[str, Sections]) -> None:
    """The same for several sections of several pages, each between markers of its own name."""
    files = ", ".join(f"docs/{file}" for file in pages)
    parser = argparse.ArgumentParser(description=f"Write the generated part of {files}.")
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if it is old")
    check: bool = parser.parse_args().check
    for file, sections in pages.items():
        path = DOCS / file
        text = path.read_text(encoding="utf-8")
        new = text
        for name, render in sections.items():
            new = with_section(new, name, render())
        if text == new:
            continue
        if check:
            sys.exit(f"docs/{file} is not up to date: run python tools/{tool}")
        path.write_text(new, encoding="utf-8")
