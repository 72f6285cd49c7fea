"""Real roots in [0, 1] of polynomials in Bernstein form.

The form bounds the polynomial by its coefficients, so a root is never missed for want of a start:
no change of sign among the coefficients means no root (Descartes' rule), and the interval is
halved until each part has at most one. Lane, Riesenfeld: Bounds on a polynomial, BIT 21 (1981).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import comb

_DEPTH = 44
"""Halvings after which several roots that could not be separated count as one."""


@cache
def _ratios(m: int, n: int) -> tuple[tuple[float, ...], ...]:
    return tuple(
        tuple(comb(m, i) * comb(n, j) / comb(m + n, i + j) for j in range(n + 1))
        for i in range(m + 1)
    )


def product(f: Sequence[float], g: Sequence[float]) -> list[float]:
    """Bernstein coefficients of the product of two polynomials, of the sum of their degrees."""
    m, n = len(f) - 1, len(g) - 1
    found = [0.0] * (m + n + 1)
    for i, row in enumerate(_ratios(m, n)):
        fi = f[i]
        for j, ratio in enumerate(row):
            found[i + j] += ratio * fi * g[j]
    return found


def derivative(f: Sequence[float]) -> list[float]:
    """Bernstein coefficients of the derivative."""
    n = len(f) - 1
    return [n * (f[i + 1] - f[i]) for i in range(n)]


def value(f: Sequence[float], t: float) -> float:
    """Value at `t`, by de Casteljau's scheme."""
    row = list(f)
    for n in range(len(row) - 1, 0, -1):
        for i in range(n):
            row[i] += t * (row[i + 1] - row[i])
    return row[0]


def halves(f: Sequence[float], t: float = 0.5) -> tuple[list[float], list[float]]:
    """Coefficients on [0, t] and on [t, 1]."""
    row = list(f)
    first, last = [row[0]], [row[-1]]
    for n in range(len(row) - 1, 0, -1):
        for i in range(n):
            row[i] += t * (row[i + 1] - row[i])
        first.append(row[0])
        last.append(row[n - 1])
    last.reverse()
    return first, last


def roots(f: Sequence[float]) -> list[float]:
    """Roots in [0, 1], ascending; a multiple root is listed once, the zero polynomial has none.

    Coefficients below 1e-15 of the largest count as zero.
    """
    size = max(map(abs, f))
    if not size > 0.0:
        return []
    small = 1e-15 * size
    found: list[float] = []
    todo = [([0.0 if abs(c) <= small else c for c in f], 0.0, 1.0, 0)]
    while todo:
        row, low, high, depth = todo.pop()
        if row[-1] == 0.0:
            found.append(high)
        if row[0] == 0.0:
            found.append(low)
        changes = _changes(row)
        if changes == 0:
            continue
        if changes == 1 and row[0] * row[-1] < 0.0:
            found.append(low + (high - low) * _single(row))
        elif depth >= _DEPTH:
            found.append(0.5 * (low + high))
        else:
            first, last = halves(row)
            middle = 0.5 * (low + high)
            if abs(last[0]) <= small:
                first[-1] = last[0] = 0.0
            todo.append((last, middle, high, depth + 1))
            todo.append((first, low, middle, depth + 1))
    found.sort()
    return [t for i, t in enumerate(found) if i == 0 or t - found[i - 1] > 1e-13]


def _changes(row: Sequence[float]) -> int:
    count, last = 0, 0.0
    for c in row:
        if c != 0.0:
            if c * last < 0.0:
                count += 1
            last = c
    return count


def _single(row: Sequence[float]) -> float:
    """The root of a polynomial with one change of sign (ITP-like: Newton kept in a bracket)."""
    slope = derivative(row)
    low, high = 0.0, 1.0
    rising = row[-1] > 0.0
    t = row[0] / (row[0] - row[-1])
    for _ in range(100):
        f = value(row, t)
        if f == 0.0:
            return t
        if (f > 0.0) == rising:
            high = t
        else:
            low = t
        d = value(slope, t)
        step = t - f / d if d != 0.0 else low - 1.0
        new = step if low < step < high else 0.5 * (low + high)
        if abs(new - t) <= 1e-16 or high - low <= 1e-16:
            return new
        t = new
    return t
