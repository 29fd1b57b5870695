"""The mutants by hand: the literal patches of ``by_hand.toml``, checked to be in the code."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from node_mutants.mutant import Mutant, source_of
from rfms_can.errors import RfmsError

BY_HAND: Final = "by hand"
PATCHES: Final = Path(__file__).with_name("by_hand.toml")


def by_hand() -> list[Mutant]:
    """All of them.

    Raises:
        RfmsError: a text to be changed is not in its file, or not once.
    """
    return list(_made(tomllib.loads(PATCHES.read_text(encoding="utf-8"))["mutant"]))


def _made(patches: list[dict[str, str]]) -> Iterator[Mutant]:
    for patch in patches:
        file, before = patch["file"], patch["before"]
        text = source_of(file)
        if text.count(before) != 1:
            raise RfmsError(
                f"{file} has {before!r} {text.count(before)} times, not once: "
                f"mend {patch['what']!r} in {PATCHES.name}"
            )
        begin = text.index(before)
        line = text.count("\n", 0, begin) + 1
        yield Mutant(patch["what"], file, line, BY_HAND, before, patch["after"], begin)
