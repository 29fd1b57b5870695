"""Derivatives of a history: polynomials by least squares (docs/node-setpoint.md, the fit)."""

import math
from fractions import Fraction

LONGEST = 128  # samples of a history
LONG = 32  # samples taken where there are fewer than all

WEIGHTS: dict[tuple[int, bool], list[list[float]]] = {}
"""For so many samples, at the newest or one period ahead: weights for value to jerk, period 1."""


def inverse(matrix: list[list[Fraction]]) -> list[list[Fraction]]:
    """The inverse of a small matrix, by Gauss and Jordan."""
    size = len(matrix)
    unit = [[Fraction(int(i == j)) for j in range(size)] for i in range(size)]
    rows = [list(row) + own for row, own in zip(matrix, unit, strict=True)]
    for i in range(size):
        pivot = next(r for r in range(i, size) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for r in range(size):
            if r != i and rows[r][i] != 0:
                factor = rows[r][i]
                rows[r] = [x - factor * y for x, y in zip(rows[r], rows[i], strict=True)]
    return [row[size:] for row in rows]


def degree(m: int) -> int:
    """Of the polynomial through m samples."""
    if m >= 10:
        return 4
    return 3 if m >= 8 else min(m - 1, 2)


def weights(m: int, ahead: bool) -> list[list[float]]:
    """P(0), P'(0), P''(0), P'''(0) of the fit as sums over the samples."""
    if (m, ahead) not in WEIGHTS:
        g = degree(m)
        times = [i - (m - 1) - int(ahead) for i in range(m)]
        sums = [Fraction(sum(t**e for t in times)) for e in range(2 * g + 1)]
        back = inverse([[sums[i + j] for j in range(g + 1)] for i in range(g + 1)])
        table = []
        for n in range(4):
            if n > g:
                table.append([0.0] * m)
                continue
            row = [sum(back[n][j] * t**j for j in range(g + 1)) for t in times]
            table.append([float(math.factorial(n) * w) for w in row])
        WEIGHTS[(m, ahead)] = table
    return WEIGHTS[(m, ahead)]


def fit(history: list[float], asked: int, ahead: bool, tau: float) -> list[float]:
    """Value, rate, acceleration, jerk by the last samples; ``history`` is not empty."""
    m = min(asked, len(history))
    if LONG < m < LONGEST:
        m = LONG
    samples = history[-m:]
    newest = samples[-1]
    found = [
        sum(w * (y - newest) for w, y in zip(row, samples, strict=True))
        for row in weights(m, ahead)
    ]
    return [found[0] + newest, found[1] / tau, found[2] / tau**2, found[3] / tau**3]


def remember(history: list[float], value: float) -> None:
    """Append a sample; the oldest is forgotten."""
    history.append(value)
    del history[:-LONGEST]
