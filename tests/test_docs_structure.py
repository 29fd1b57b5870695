"""CONTRIBUTING.md, README.md and docs/architecture.md: folders, files and imports are as told."""

import re
import tomllib
from pathlib import Path
from typing import Any, Final

import pytest
import typer

from rfms_can.cli.app import app

ROOT: Final = Path(__file__).parents[1]
PACKAGE: Final = ROOT / "rfms_can"
CONTRIBUTING: Final = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
ARCHITECTURE: Final = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
README: Final = (ROOT / "README.md").read_text(encoding="utf-8")
ROOMS: Final = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
PAGES: Final = {"CONTRIBUTING.md": CONTRIBUTING, "architecture.md": ARCHITECTURE}


def code_spans(page: str) -> list[str]:
    """What stands in backticks, outside of blocks."""
    return re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", page, flags=re.DOTALL))


def layers() -> list[set[str]]:
    """The ladder of imports that import-linter enforces, the most general layer first."""
    project: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    (contract,) = (c for c in contracts if c["name"] == "imports run one way")
    return [
        {module.strip().removeprefix("rfms_can.") for module in layer.split("|")}
        for layer in reversed(contract["layers"])
    ]


def test_the_ladder_of_imports_is_that_of_pyproject() -> None:
    (block,) = re.findall(r"```\n(errors\n.*?)```", CONTRIBUTING, re.DOTALL)
    told = [{word.strip() for word in line.split("|")} for line in block.splitlines()]
    assert told == layers()


def test_every_room_is_in_the_ladder() -> None:
    modules = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}
    assert set().union(*layers()) == ROOMS | modules


def test_the_table_of_rooms_has_every_room_in_the_order_of_imports() -> None:
    """A room imports from those above it."""
    table = ARCHITECTURE.partition("## Rooms")[2].partition("\n## ")[0]
    told = re.findall(r"^\| `(\w+)/` \|", table, re.MULTILINE)
    assert set(told) == ROOMS
    height = {name: number for number, names in enumerate(layers()) for name in names}
    assert told == sorted(told, key=height.__getitem__)


def test_the_readme_has_every_room() -> None:
    tree = README.partition("## Where things are")[2].partition("\n## ")[0]
    (block,) = re.findall(r"```\n(.*?)```", tree, re.DOTALL)
    named = re.findall(r"(?:^|(?<= ))([\w./]+/|dbc/rfms\.dbc)(?= |$)", block, re.MULTILINE)
    inside = block.partition("rfms_can/\n")[2].partition("\nexamples/")[0]
    assert set(re.findall(r"(\w+)/(?= )", inside)) == ROOMS
    for name in set(named) - {f"{room}/" for room in ROOMS}:
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize("page", PAGES)
def test_every_path_that_is_named_exists(page: str) -> None:
    missing = []
    for span in code_spans(PAGES[page]):
        for word in re.findall(r"[\w.-]*[\w-]/[\w./-]*|[\w-]+\.(?:py|md|toml|dbc)", span):
            if word.startswith(("/", "vcan")) or word in ("docs/", "CHANGELOG.md"):
                continue
            places = (ROOT / word, PACKAGE / word, *_parts_of_a_joint(word, page))
            if not any(place.exists() for place in places):
                missing.append(word)
    assert missing == []


def _parts_of_a_joint(word: str, page: str) -> list[Path]:
    """Short names of files in a room that the paragraph is about."""
    if page != "architecture.md" or "/" in word:
        return []
    return list(PACKAGE.rglob(word))


def test_the_files_in_the_drawing_of_a_joint_exist() -> None:
    drawing = ARCHITECTURE.partition("## A joint")[2].partition("\n## ")[0]
    files = re.findall(r"\((\w+\.py)\)", drawing)
    assert len(files) >= 7
    assert [file for file in files if not (PACKAGE / "joint_nodes" / file).is_file()] == []


def test_every_command_that_is_named_exists() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^(\w+):", makefile, re.MULTILINE))
    group = typer.main.get_group(app)
    assert set(re.findall(r"\bmake (\w+)", CONTRIBUTING)) - {"..."} <= targets
    scripts = re.findall(r"python (tools/\w+\.py)|(?<![\w/])(\.ci/\w+)", CONTRIBUTING)
    for script in {name for names in scripts for name in names if name}:
        assert (ROOT / script).is_file(), script
    verbs = set(re.findall(r"rfms (\w+)", " ".join(code_spans(CONTRIBUTING))))
    assert verbs <= set(group.commands)
    tests = set(re.findall(r"(tests/test_\w+\.py)", CONTRIBUTING))
    assert len(tests) > 10
    assert [test for test in sorted(tests) if not (ROOT / test).is_file()] == []


def test_the_names_in_the_recipes_exist() -> None:
    """Constants and functions in backticks, in the first file that their row names."""
    recipes = CONTRIBUTING.partition("## Recipes")[2].partition("\n## A pull request")[0]
    rows = [row.split("|")[2:4] for row in recipes.splitlines() if re.match(r"\| \d", row)]
    assert len(rows) > 35
    for where, what in rows:
        files = [ROOT / span for span in re.findall(r"`([\w/.]+)`", where + what) if "/" in span]
        text = "".join(file.read_text(encoding="utf-8") for file in files if file.suffix == ".py")
        if text:
            for name in re.findall(r"`([A-Z][A-Za-z_]+|\w+\(\))`", what):
                assert name.removesuffix("()") in text or name in ("Port", "Arm", "View"), name
