"""Transforms by kind, as the thesis' TRSF has them: a value, its inverse, and whether it is valid.

A value is a plain :class:`Transform`, multiplied with its neighbours when a position is bound. What
may differ from one moment to the next is a :class:`Live` one. It hands out the same object for as
long as its value stays: who keeps a product or an inverse knows by that whether it is still valid.
"""

from typing import Final, Protocol

import msgspec

from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.world.functions import Evaluator, cycle
from rfms_can.messages import AnyFunction
from rfms_can.transform import Transform

_encode: Final = msgspec.msgpack.Encoder().encode
"""A function as it was sent: a tenth of the memory it takes as an object."""


class Live(Protocol):
    """A transform that may be another one at another moment."""

    def at(self, moment: Moment) -> Transform:
        """Its value; the same object while it does not change."""

    def inverse_at(self, moment: Moment) -> Transform:
        """Its inverse, likewise."""

    @property
    def cycle_s(self) -> float:
        """Time in which it shows all it does, s; 0 where time alone does not change it, or for
        ever, or where nothing is known of it."""


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
        function: as it was sent.
        evaluator: of it.

    Attributes:
        cycle_s: as of ``Live``.
    """

    __slots__ = (
        *("_evaluator", "_function", "_inverse", "_of_time", "_rows", "_u", "_value"),
        "cycle_s",
    )

    def __init__(self, rows: Transform, function: AnyFunction, evaluator: Evaluator) -> None:
        self._rows: Final = rows
        self._function: Final = _encode(function)
        self._evaluator: Final = evaluator
        self._of_time: Final = function.parameter == "t"
        self.cycle_s: Final = cycle(function) if self._of_time else 0.0
        self._inverse: Final = Inverse()
        self._u = 0.0
        self._value = rows @ evaluator(0.0)

    def is_of(self, rows: Transform, function: AnyFunction) -> bool:
        """Whether it is defined by these."""
        return self._rows == rows and self._function == _encode(function)

    def at(self, moment: Moment) -> Transform:
        """Its value at the motion parameters."""
        u = moment.t if self._of_time else moment.h
        if u != self._u:
            self._u, self._value = u, self._rows @ self._evaluator(u)
        return self._value

    def inverse_at(self, moment: Moment) -> Transform:
        """The inverse of its value."""
        return self._inverse.of(self.at(moment))
