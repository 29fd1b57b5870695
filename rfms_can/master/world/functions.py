"""Functional transforms: what the closed set of functions yields at (h, t) (thesis III.3.2).

A client sends data, never code: the numbers of one of four functions.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Final

from rfms_can.errors import TransformError
from rfms_can.master.world.numbers import MAX_LENGTH, MAX_NUMBER, check_numbers
from rfms_can.master.world.spline import Interpolation, clamped_slopes
from rfms_can.messages import AnyFunction, Circular, Linear, Table, Weave
from rfms_can.transform import Transform, Vector3

Evaluator = Callable[[float], Transform]
"""A function of the one parameter it names, h or t (s)."""

LEAST_STEP: Final = 1e-6
"""From row to row of a table, of u: a slope over less is rounding."""

_Z: Final = (0.0, 0.0, 1.0)


def evaluator(name: str, function: AnyFunction) -> Evaluator:
    """The function a transform's message describes; it never raises.

    Args:
        name: of the transform, for errors.
        function: as it was sent.

    Raises:
        TransformError: numbers that are not finite or out of bounds, or a table whose u does not
            grow.
    """
    match function:
        case Linear(along, turn):
            check_numbers(name, "along", along, MAX_NUMBER)
            check_numbers(name, "turn", turn, MAX_NUMBER)
            return lambda u: screw(_times(along, u), _times(turn, u))
        case Circular():
            check_numbers(name, "radius", (function.radius,), MAX_LENGTH)
            check_numbers(name, "angle and phase", (function.angle, function.phase), MAX_NUMBER)
            return _circular(function)
        case Weave(amplitude, cycles):
            check_numbers(name, "amplitude", amplitude, MAX_LENGTH)
            check_numbers(name, "cycles", (cycles,), MAX_NUMBER)
            rate = 2.0 * math.pi * cycles
            return lambda u: Transform.translation(*_times(amplitude, math.sin(rate * u)))
        case Table():
            return _table(name, function)


def cycle(function: AnyFunction) -> float:
    """How far its parameter runs until it has shown all it does; 0 where it goes on for ever."""
    match function:
        case Weave(_, cycles):
            return 1.0 / abs(cycles) if cycles else 0.0
        case Circular():
            return math.tau / abs(function.angle) if function.angle else 0.0
        case Table():
            return max(0.0, function.rows[-1].u)
        case Linear():
            return 0.0


def screw(place: Vector3, turn: Vector3) -> Transform:
    """The transform with origin ``place``, m, turned by the rotation vector ``turn``, rad."""
    x, y, z = turn
    angle = math.sqrt(x * x + y * y + z * z)
    if not angle:
        return Transform.translation(*place)
    px, py, pz = place
    return Transform.rotation(turn, angle)._replace(px=px, py=py, pz=pz)


def _times(vector: Vector3, factor: float) -> Vector3:
    x, y, z = vector
    return (x * factor, y * factor, z * factor)


def _circular(function: Circular) -> Evaluator:
    radius, rate, phase = function.radius, function.angle, function.phase

    def evaluate(u: float) -> Transform:
        angle = phase + rate * u
        turned = Transform.rotation(_Z, angle) if function.turns else Transform.identity()
        return turned._replace(px=radius * math.cos(angle), py=radius * math.sin(angle))

    return evaluate


def _table(name: str, table: Table) -> Evaluator:
    u = [row.u for row in table.rows]
    rows = [row.coordinates for row in table.rows]
    check_numbers(name, "u of its table", u, MAX_NUMBER)
    for i, row in enumerate(rows):
        check_numbers(name, f"row {i} of its table", row, MAX_LENGTH)
    for i, (before, after) in enumerate(pairwise(u)):
        if not after - before >= LEAST_STEP:
            raise TransformError(
                f"transform {name!r}: u of its table must grow by {LEAST_STEP:g} or more, row "
                f"{i + 1} has {after:g} after {before:g}; sort the rows, and leave out double ones"
            )
    if len(u) < 2:
        raise TransformError(f"transform {name!r}: {len(u)} row in its table, give two or more")
    slopes = None
    if table.interpolation == "cubic":
        columns = zip(*rows, strict=True)
        slopes = list(zip(*(clamped_slopes(u, column) for column in columns), strict=True))
    curve = Interpolation(u, rows, slopes)

    def evaluate(u: float) -> Transform:
        x, y, z, ex, ey, ez = curve.at(u)
        return screw((x, y, z), (ex, ey, ez))

    return evaluate
