"""Position equations that read like the mathematics: ``t6 @ tool == part @ above`` (Eq. 3.6)."""

from typing import NoReturn

from rfms_can.errors import EquationError
from rfms_can.transform import Transform


class Expression:
    """A product of named transforms, or one alone.

    ``@`` composes, ``==`` makes an :class:`Equation` of two sides. Expressions stand for frames
    of the world model; their values live on the server.

    Attributes:
        names: names of the transforms, left to right.
    """

    __slots__ = ("names",)
    __hash__ = object.__hash__
    __array_ufunc__ = None  # numpy leaves its arrays' products to this class

    def __init__(self, *names: str) -> None:
        self.names = names

    def __matmul__(self, other: "Expression") -> "Expression":
        if not isinstance(other, Expression):
            raise _unnamed(self, "@", other)
        return Expression(*self.names, *other.names)

    def __rmatmul__(self, other: object) -> NoReturn:
        raise _unnamed(other, "@", self)

    def __eq__(self, other: object) -> "Equation":  # type: ignore[override]  # an equation, not a truth
        if isinstance(other, Transform):
            raise _unnamed(self, "==", other)
        if not isinstance(other, Expression):
            return NotImplemented
        return Equation(self.names, other.names)

    def __repr__(self) -> str:
        return " @ ".join(self.names)


def _unnamed(left: object, operator: str, right: object) -> EquationError:
    """The error for a value, or a name, where a transform of the world model belongs."""
    value = left if isinstance(right, Expression) else right
    said = repr(value) if isinstance(value, str | None) else f"a {type(value).__name__}"
    sides = [said if side is value else repr(side) for side in (left, right)]
    return EquationError(
        f"{f' {operator} '.join(sides)}: an equation consists of named transforms, and {said} is "
        f'not one; define it, part = arm.transform("part", ...), and write part for it'
    )


class Equation:
    """Two sides that are to be the same frame.

    Attributes:
        left, right: names of the transforms of either side.
    """

    __slots__ = ("left", "right")

    def __init__(self, left: tuple[str, ...], right: tuple[str, ...]) -> None:
        self.left = left
        self.right = right

    def __bool__(self) -> NoReturn:
        raise EquationError(
            f"{self!r} is a position equation and neither true nor false; give it to position()"
        )

    def __repr__(self) -> str:
        return f"{' @ '.join(self.left)} == {' @ '.join(self.right)}"
