"""Position equations that read like the mathematics: ``t6 @ tool == part @ above`` (Eq. 3.6)."""

from typing import NoReturn

from rfms_can.errors import EquationError


class Expression:
    """A product of named transforms, or one alone.

    ``@`` composes, ``==`` makes an :class:`Equation` of two sides. Expressions stand for frames
    of the world model; their values live on the server.

    Attributes:
        names: names of the transforms, left to right.
    """

    __slots__ = ("names",)
    __hash__ = object.__hash__

    def __init__(self, *names: str) -> None:
        self.names = names

    def __matmul__(self, other: "Expression") -> "Expression":
        if not isinstance(other, Expression):
            return NotImplemented
        return Expression(*self.names, *other.names)

    def __eq__(self, other: object) -> "Equation":  # type: ignore[override]  # an equation, not a truth
        if not isinstance(other, Expression):
            return NotImplemented
        return Equation(self.names, other.names)

    def __repr__(self) -> str:
        return " @ ".join(self.names)


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
