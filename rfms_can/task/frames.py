"""Frames of a task: transforms that are defined with it, or that the program has defined."""

from collections.abc import Iterator
from typing import Final, NamedTuple, NoReturn

from rfms_can.coordinator import EquationError, Expression, ProgramError, Transform, TransformError

T6: Final = "t6"


class Part(NamedTuple):
    """One transform of a product.

    Attributes:
        name: within the task, or in the world model if the program has defined it.
        ours: whether it is defined with the task.
    """

    name: str
    ours: bool


Parts = tuple[Part, ...]


class Frame(Expression):
    """A product of named transforms, some of which are defined when the task runs.

    ``Frame("hole", value)`` is one that the task defines, and removes again. ``@`` composes it with
    other frames and with what ``arm.transform`` and ``arm.reference`` returned, which are used and
    left alone.

    Attributes:
        names: of the transforms, left to right.
        parts: the same, each with whether it is defined with the task.
        values: of those that are.
    """

    __slots__ = ("parts", "values")
    __hash__ = object.__hash__

    def __init__(self, name: str, value: Transform) -> None:
        """A frame of one transform.

        Args:
            name: within the task.
            value: a rigid transform, in metres.

        Raises:
            TransformError: the value is not a rigid transform, or the name is not a text.
        """
        if not isinstance(name, str) or not name or name == T6:
            raise TransformError(
                f"frame {name!r}: a name is a text, not empty, and not {T6!r}, which is the arm"
            )
        if not isinstance(value, Transform):
            raise TransformError(
                f"frame {name!r}: {value!r} is not a Transform; what arm.transform() or "
                f"arm.reference() returned is a frame as it is"
            )
        if not value.is_rigid():
            raise TransformError(
                f"frame {name!r}: not rigid, n, o, a are {value.rigidity_error():.3g} from "
                f"orthonormal and 1e-06 is allowed: Transform.nearest_rotation() squares it up"
            )
        super().__init__(name)
        self.parts: Parts = (Part(name, True),)
        self.values: dict[str, Transform] = {name: value}

    def __matmul__(self, other: Expression) -> "Frame":
        return _product(self, other)

    def __rmatmul__(self, other: object) -> "Frame":  # type: ignore[override]  # of Expression: raises
        return _product(other, self)


def frame_of(what: str, given: object) -> Frame:
    """What a task relates, as a frame.

    Args:
        what: which argument of which call it is, for the error.
        given: a frame, or an expression of the program's own transforms.

    Raises:
        EquationError: it is neither, or contains the arm.
    """
    if isinstance(given, Frame):
        return given
    if not isinstance(given, Expression):
        raise EquationError(
            f"{what}: {given!r} is not a frame; give Frame(name, Transform), or what "
            f"arm.transform() or arm.reference() returned"
        )
    if T6 in given.names:
        raise EquationError(
            f"{what}: {given!r} contains {T6}; a task puts the arm there itself: give the frame "
            f"alone"
        )
    return _frame(tuple(Part(name, False) for name in given.names), {})


def _product(left: object, right: object) -> Frame:
    one, other = (frame_of(f"{left!r} @ {right!r}", side) for side in (left, right))
    for name in one.values.keys() & other.values.keys():
        if one.values[name] != other.values[name]:
            raise TransformError(
                f"{left!r} @ {right!r}: frame {name!r} has two values; give one another name"
            )
    return _frame(one.parts + other.parts, one.values | other.values)


def _frame(parts: Parts, values: dict[str, Transform]) -> Frame:
    frame = Frame.__new__(Frame)
    Expression.__init__(frame, *(part.name for part in parts))
    frame.parts = parts
    frame.values = values
    return frame


class Scope:
    """Names and values of one task: what is called how on the server, and worth what.

    Attributes:
        task: name of the task.
        values: of the transforms it defines, by their names in it.
    """

    __slots__ = ("task", "values")

    def __init__(self, task: str, values: dict[str, Transform]) -> None:
        self.task = task
        self.values = values

    def full(self, name: str) -> str:
        """The name on the server of a definition of the task."""
        return f"{self.task}/{name}"

    def names(self, parts: Parts) -> Iterator[str]:
        """Names of a product on the server."""
        return (self.full(part.name) if part.ours else part.name for part in parts)

    def expression(self, parts: Parts) -> Expression:
        """A product as the program API has it."""
        return Expression(*self.names(parts))

    def value(self, what: str, parts: Parts) -> Transform:
        """Value of a product of transforms of the task.

        Raises:
            ProgramError: one is the program's own: the task does not know its value.
        """
        product = Transform.identity()
        for part in parts:
            if not part.ours:
                raise ProgramError(
                    f"{what}: {part.name!r} is the program's own, so the task does not know its "
                    f"value: give Frame({part.name!r}, value) for it"
                )
            product = product @ self.values[part.name]
        return product


def unknown(what: str, name: object, known: tuple[str, ...]) -> NoReturn:
    """Raise for a name that a task does not have.

    Raises:
        ProgramError: always.
    """
    raise ProgramError(f"{what}: there is no {name!r}; there are: {', '.join(known) or 'none'}")
