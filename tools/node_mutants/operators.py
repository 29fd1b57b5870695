"""The mutation operators: from a syntax tree to texts that stand instead of others.

Each operator is a function from a node of the tree to replacements of a part of it; ``OPERATORS``
is the table of all. What no joint computes with (annotations, docstrings, messages of errors) has
no mutants.
"""

import ast
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple


class Change(NamedTuple):
    """A part of the tree, and the text that stands there instead."""

    node: ast.AST
    after: str


Changes = Iterator[Change]
Operator = Callable[[ast.AST], Changes]
"""Replacements of a node of the tree, or of a part of it."""

_ARITHMETIC: Final[dict[type[ast.AST], type[ast.AST]]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
}
_NEGATED: Final[dict[type[ast.AST], type[ast.AST]]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_BOUNDARY: Final[dict[type[ast.AST], type[ast.AST]]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
}


def arithmetic(node: ast.AST) -> Changes:
    """Another operator between two numbers; also in ``+=``."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in _ARITHMETIC:
        other = _ARITHMETIC[type(node.op)]()
        if isinstance(node, ast.BinOp):
            yield Change(node, _text(ast.BinOp(node.left, other, node.right)))  # type: ignore[arg-type]
        else:
            yield Change(node, _text(ast.AugAssign(node.target, other, node.value)))  # type: ignore[arg-type]


def sign(node: ast.AST) -> Changes:
    """A minus left out."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield Change(node, f"({_text(node.operand)})")


def comparison(node: ast.AST) -> Changes:
    """The opposite of one comparison of a chain."""
    yield from _compared(node, _NEGATED)


def boundary(node: ast.AST) -> Changes:
    """The bound itself counts on the other side."""
    yield from _compared(node, _BOUNDARY)


def _compared(node: ast.AST, table: dict[type[ast.AST], type[ast.AST]]) -> Changes:
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            if type(operator) in table:
                other = [*node.ops[:i], table[type(operator)](), *node.ops[i + 1 :]]
                yield Change(node, _text(ast.Compare(node.left, other, node.comparators)))  # type: ignore[arg-type]


def constant(node: ast.AST) -> Changes:
    """One more, one less, twice as much, nothing; the other truth value."""
    if not isinstance(node, ast.Constant):
        return
    value = node.value
    if isinstance(value, bool):
        yield Change(node, repr(not value))
    elif isinstance(value, int | float):
        for other in dict.fromkeys((value + 1, value - 1, 2 * value, 0 * value)):
            if other != value:
                yield Change(node, f"({other!r})" if other < 0 else repr(other))


def negation(node: ast.AST) -> Changes:
    """``and`` for ``or`` and the reverse; a ``not`` left out."""
    if isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield Change(node, f"({_text(ast.BoolOp(other, node.values))})")
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield Change(node, f"bool({_text(node.operand)})")


def branch(node: ast.AST) -> Changes:
    """A branch that is never, or always, taken."""
    if isinstance(node, ast.If | ast.IfExp):
        yield Change(node.test, "False")
        yield Change(node.test, "True")


def deletion(node: ast.AST) -> Changes:
    """A statement left out."""
    called = isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)
    if called or isinstance(node, ast.Assign | ast.AugAssign | ast.Continue):
        yield Change(node, "pass")


def swap(node: ast.AST) -> Changes:
    """Two arguments, one for the other."""
    if isinstance(node, ast.Call):
        given = node.args
        for i in range(len(given) - 1):
            first, second = given[i], given[i + 1]
            if ast.dump(first) != ast.dump(second) and not isinstance(second, ast.GeneratorExp):
                other = [*given[:i], second, first, *given[i + 2 :]]
                yield Change(node, _text(ast.Call(node.func, other, node.keywords)))


def returned(node: ast.AST) -> Changes:
    """Another value is returned: none, or the negative of a product, a sum or a name."""
    if isinstance(node, ast.Return) and node.value is not None:
        value = node.value
        if not (isinstance(value, ast.Constant) and value.value is None):
            yield Change(value, "None")
        if isinstance(value, ast.BinOp):
            yield Change(value, f"-({_text(value)})")
        elif isinstance(value, ast.Compare | ast.BoolOp):
            yield Change(value, f"not ({_text(value)})")


def off_by_one(node: ast.AST) -> Changes:
    """The element beside the one that is meant; one round more or less."""
    if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        index = node.slice
        if isinstance(index, ast.Name | ast.Attribute) and "index" in _text(index):
            yield Change(index, f"{_text(index)} - 1")
    elif isinstance(node, ast.Call) and _text(node.func) == "range":
        end = node.args[-1]
        yield Change(end, f"{_text(end)} - 1")
        yield Change(end, f"{_text(end)} + 1")


OPERATORS: Final[dict[str, Operator]] = {
    "arithmetic": arithmetic,
    "sign": sign,
    "comparison": comparison,
    "boundary": boundary,
    "constant": constant,
    "negation": negation,
    "branch": branch,
    "deletion": deletion,
    "swap": swap,
    "return": returned,
    "off by one": off_by_one,
}


def _text(node: ast.AST) -> str:
    return ast.unparse(ast.fix_missing_locations(node))
