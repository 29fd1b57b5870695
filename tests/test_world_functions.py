"""Functional transforms: the closed set of functions, and the tables they refuse."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfms_can.errors import TransformError
from rfms_can.master.world.functions import evaluator
from rfms_can.master.world.spline import Interpolation, clamped_slopes
from rfms_can.messages import AnyFunction, Circular, Linear, Table, TableRow, Weave
from rfms_can.transform import Transform

ABOUT_Z = (0.0, 0.0, 1.0)


def at(function: AnyFunction, u: float) -> Transform:
    return evaluator("curve", function)(u)


def rows(*pairs: tuple[float, float]) -> list[TableRow]:
    """Rows (u, x), the other coordinates from x."""
    return [TableRow(u, (x, 2.0 * x, 0.0, 0.0, 0.0, 0.1 * x)) for u, x in pairs]


def test_linear_moves_and_turns_with_the_parameter() -> None:
    expected = Transform.translation(0.05, 0.0, -0.1) @ Transform.rotation(ABOUT_Z, 0.3)
    assert at(Linear((0.1, 0.0, -0.2), (0.0, 0.0, 0.6)), 0.5) == pytest.approx(expected, abs=1e-15)
    assert at(Linear((0.1, 0.0, -0.2)), 0.5) == Transform.translation(0.05, 0.0, -0.1)
    assert at(Linear((0.1, 0.0, -0.2), (0.0, 0.0, 0.6)), 0.0) == Transform.identity()


@given(st.floats(-1.0, 2.0))
def test_circular_stays_on_its_circle_and_may_turn_with_it(u: float) -> None:
    function = Circular(0.2, 2.0 * math.pi, 0.5)
    angle = 0.5 + 2.0 * math.pi * u
    place = at(function, u)
    expected = Transform.translation(0.2 * math.cos(angle), 0.2 * math.sin(angle), 0.0)
    assert place == pytest.approx(expected, abs=1e-15)
    turned = at(Circular(0.2, 2.0 * math.pi, 0.5, turns=True), u)
    radial = Transform.rotation(ABOUT_Z, angle) @ Transform.translation(0.2, 0.0, 0.0)
    assert turned == pytest.approx(radial, abs=1e-15)


def test_a_weave_swings_across_the_seam() -> None:
    function = Weave((0.0, 0.004, 0.0), 3.0)
    heights = [at(function, u / 12.0).py for u in range(5)]
    assert heights == pytest.approx([0.0, 0.004, 0.0, -0.004, 0.0], abs=1e-15)


def test_a_linear_table_goes_straight_and_stays_beyond_its_ends() -> None:
    table = Table(rows((0.0, 0.1), (0.5, 0.3), (1.0, 0.2)), "linear")
    assert [at(table, u).px for u in (-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 9.0)] == pytest.approx(
        [0.1, 0.1, 0.2, 0.3, 0.25, 0.2, 0.2]
    )
    expected = Transform.translation(0.2, 0.4, 0.0) @ Transform.rotation(ABOUT_Z, 0.02)
    assert at(table, 0.25) == pytest.approx(expected)


def test_a_cubic_between_two_rows_is_the_smooth_step() -> None:
    table = Table(rows((0.0, 0.0), (1.0, 1.0)))
    for u in (0.0, 0.1, 0.5, 0.9, 1.0):
        assert at(table, u).px == pytest.approx(u * u * (3.0 - 2.0 * u))


growing = st.lists(
    st.tuples(st.floats(0.05, 1.0), st.floats(-1.0, 1.0)), min_size=3, max_size=8
).map(
    lambda steps: [(sum(step for step, _ in steps[: k + 1]), x) for k, (_, x) in enumerate(steps)]
)


@given(growing)
def test_the_spline_agrees_with_a_dense_solution_of_its_definition(
    points: list[tuple[float, float]],
) -> None:
    """All 4 n coefficients at once: values, slopes and curvatures that meet, ends at rest."""
    u, x = (list(column) for column in zip(*points, strict=True))
    count = len(u) - 1
    matrix, right = np.zeros((4 * count, 4 * count)), np.zeros(4 * count)
    row = 0

    def condition(value: float, *terms: tuple[int, list[float]]) -> None:
        nonlocal row
        for piece, coefficients in terms:
            matrix[row, 4 * piece : 4 * piece + 4] += coefficients
        right[row] = value
        row += 1

    for k in range(count):
        h = u[k + 1] - u[k]
        condition(x[k], (k, [1.0, 0.0, 0.0, 0.0]))
        condition(x[k + 1], (k, [1.0, h, h * h, h**3]))
        if k < count - 1:
            condition(0.0, (k, [0.0, 1.0, 2 * h, 3 * h * h]), (k + 1, [0.0, -1.0, 0.0, 0.0]))
            condition(0.0, (k, [0.0, 0.0, 2.0, 6.0 * h]), (k + 1, [0.0, 0.0, -2.0, 0.0]))
    h = u[-1] - u[-2]
    condition(0.0, (0, [0.0, 1.0, 0.0, 0.0]))
    condition(0.0, (count - 1, [0.0, 1.0, 2.0 * h, 3.0 * h * h]))
    expected = np.linalg.solve(matrix, right)

    slopes = [(slope,) for slope in clamped_slopes(u, x)]
    curve = Interpolation(u, [(value,) for value in x], slopes)
    for k, cubic in enumerate(expected.reshape(count, 4)):
        for part in (0.0, 0.3, 0.7, 0.99):
            step = part * (u[k + 1] - u[k])
            assert curve.at(u[k] + step)[0] == pytest.approx(
                float(np.polyval(cubic[::-1], step)), abs=1e-9
            )
    for knot, value in points:
        assert curve.at(knot)[0] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (Table(rows((0.0, 0.0))), "1 row in its table"),
        (
            Table(rows((0.0, 0.0), (0.0, 1.0))),
            "u of its table must grow by 1e-06 or more, row 1 has 0 after 0",
        ),
        (
            Table(rows((0.0, 0.0), (1.0, 1.0), (0.5, 1.0))),
            "u of its table must grow by 1e-06 or more, row 2 has 0.5 after 1",
        ),
        (Table(rows((0.0, 0.0), (math.nan, 1.0))), "u of its table has nan, outside +-1e+06"),
        (Table(rows((0.0, 0.0), (math.inf, 1.0))), "u of its table has inf"),
        (Table(rows((0.0, 0.0), (1.0, math.nan))), "row 1 of its table has nan"),
        (Table(rows((0.0, -math.inf), (1.0, 0.0))), "row 0 of its table has -inf"),
        (Table(rows((0.0, 0.0), (1e-200, 1.0))), "u of its table must grow by 1e-06"),
        (Linear((math.nan, 0.0, 0.0)), "along has nan"),
        (Linear(turn=(0.0, math.inf, 0.0)), "turn has inf"),
        (Linear((2e6, 0.0, 0.0)), "along has 2e+06, outside +-1e+06"),
        (Circular(math.nan, 1.0), "radius has nan"),
        (Circular(1e4, 1.0), "radius has 10000, outside +-1000"),
        (Circular(0.1, math.inf), "angle and phase has inf"),
        (Circular(0.1, 1.0, math.nan), "angle and phase has nan"),
        (Weave((0.0, math.nan, 0.0), 1.0), "amplitude has nan"),
        (Weave((0.0, 0.0, 0.0), -math.inf), "cycles has -inf"),
    ],
)
def test_functions_that_have_no_value_everywhere(function: AnyFunction, reason: str) -> None:
    with pytest.raises(TransformError, match=re.escape(f"transform 'curve': {reason}")):
        evaluator("curve", function)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.sampled_from("hijk"))
def test_what_is_taken_is_a_rotation_wherever_it_is_evaluated(
    u: float, number: float, which: str
) -> None:
    functions: dict[str, AnyFunction] = {
        "h": Linear((number, 0.0, 1.0), (number, 1.0, 0.0)),
        "i": Circular(0.1, number, number, turns=True),
        "j": Weave((0.1, 0.0, 0.0), number),
        "k": Table(rows((-abs(number), 0.0), (1.0, 3.0))),
    }
    assert at(functions[which], u).is_rigid()
