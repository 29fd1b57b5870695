"""Whose a line of code is, and what it says: names and fingerprints that outlive moved lines.

A function's fingerprint is made of its text without comments and blank lines, wherever it stands,
and without the functions inside it.
"""

import ast
import hashlib
from collections import defaultdict
from typing import Final

MODULE: Final = "module"
"""Owner of lines outside every function and class."""
DIGITS: Final = 8

_Block = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def digest(text: str) -> str:
    """A few hexadecimal digits of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]


def bare(text: str) -> str:
    """A text without indentation, blank lines, and lines that are comments."""
    stripped = (line.strip() for line in text.splitlines())
    return "\n".join(line for line in stripped if line and not line.startswith("#"))


def owners(source: str) -> list[str]:
    """For each line of a file, the function or class it is of, e.g. ``Ladder.miss``."""
    owner = [MODULE] * len(source.splitlines())

    def mark(node: ast.AST, path: tuple[str, ...]) -> None:
        inside = path
        if isinstance(node, _Block):
            inside = (*path, node.name)
            first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
            assert node.end_lineno is not None
            for line in range(first, node.end_lineno + 1):
                owner[line - 1] = ".".join(inside)
        for child in ast.iter_child_nodes(node):
            mark(child, inside)

    mark(ast.parse(source), ())
    return owner


def fingerprints(source: str) -> dict[str, str]:
    """By function or class, in the order of the text."""
    lines: dict[str, list[str]] = defaultdict(list)
    for owner, line in zip(owners(source), source.splitlines(), strict=True):
        lines[owner].append(line)
    return {owner: digest(bare("\n".join(own))) for owner, own in lines.items()}
