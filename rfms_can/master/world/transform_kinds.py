"""Transforms by kind, as the thesis' TRSF has them: a value, its inverse, and whether it is valid.

A value is a plain :class:`Transform`, taken into positions when these are defined. What may differ
from one moment to the next is a :class:`Live` one. It hands out the same object for as long as its
value stays: who keeps a product or an inverse knows by that whether it is still valid.
"""

from typing import Final, Protocol

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.functions import Evaluator
from rfms_can.messages.functions import Parameter
from rfms_can.transform import Transform


class Live(Protocol):
    """A transform that may be another one at another moment."""

    def at(self, moment: Moment) -> Transform:
        """Its value; the same object while it does not change."""

    def inverse_at(self, moment: Moment) -> Transform:
        """Its inverse, likewise."""


class Inverse:
    """The inverse of a transform, computed when it is another one than before."""

    __slots__ = ("_inverse", "_of")

    def __init__(self) -> None:
        self._of = self._inverse = Transform.identity()

    def of(self, value: Transform) -> Transform:
        """The inverse of ``value``."""
        if value is not self._of:
            self._of, self._inverse = value, value.inverse()
        return self._inverse


class Functional:
    """``rows`` times a function of h or t; it never changes: a redefinition makes another one.

    Args:
        rows: what stands left of the function.
        function: of the parameter.
        parameter: which one.
    """

    __slots__ = ("_function", "_inverse", "_of_time", "_rows", "_u", "_value")

    def __init__(self, rows: Transform, function: Evaluator, parameter: Parameter) -> None:
        self._rows: Final = rows
        self._function: Final = function
        self._of_time: Final = parameter == "t"
        self._inverse: Final = Inverse()
        self._u = 0.0
        self._value = rows @ function(0.0)

    def at(self, moment: Moment) -> Transform:
        """Its value at the motion parameters."""
        u = moment.t if self._of_time else moment.h
        if u != self._u:
            self._u, self._value = u, self._rows @ self._function(u)
        return self._value

    def inverse_at(self, moment: Moment) -> Transform:
        """The inverse of its value."""
        return self._inverse.of(self.at(moment))


class FunctionalSymbol:
    """What the name of a functional transform stands for: the one defined last.

    Attributes:
        current: that one.
    """

    __slots__ = ("current",)

    def __init__(self, current: Functional) -> None:
        self.current = current

    def at(self, moment: Moment) -> Transform:
        """Its value at the motion parameters."""
        return self.current.at(moment)

    def inverse_at(self, moment: Moment) -> Transform:
        """The inverse of its value."""
        return self.current.inverse_at(moment)
