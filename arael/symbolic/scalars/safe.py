"""Regularised functions: finite in value and derivative everywhere.

They hide a singularity from the solver; a constraint that avoids it is better. Outside their domain
they are constant, and so is what the solver sees of them there.
"""

from __future__ import annotations

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import prescribed


def _safe_sqrt(g: Graph, x: int) -> int:
    return g.op("sqrt", g.op("max", x, g.const(0.0)))


def _held(g: Graph, x: int) -> int:
    return g.op("min", g.op("max", x, g.const(-1.0)), g.const(1.0))


def _safe_asin(g: Graph, x: int) -> int:
    return g.op("asin", _held(g, x))


def _safe_acos(g: Graph, x: int) -> int:
    return g.op("acos", _held(g, x))


def _safe_atan2(g: Graph, y: int, x: int) -> int:
    return g.op("atan2", y, x)


FUNCTIONS = (
    prescribed(
        "safe_sqrt",
        1,
        _safe_sqrt,
        "sqrt(max(x, 0))",
        "1 / (2 sqrt(x + 1e-12)) if x >= 0 else 0",
        "0 at 0 with derivative 5e5; 0 with derivative 0 for x < 0",
    ),
    prescribed(
        "safe_asin",
        1,
        _safe_asin,
        "asin(clamp(x, -1, 1))",
        "1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "pi/2 at 1, -pi/2 at -1, derivative 1e6 at both; constant with derivative 0 beyond",
    ),
    prescribed(
        "safe_acos",
        1,
        _safe_acos,
        "acos(clamp(x, -1, 1))",
        "-1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "0 at 1, pi at -1, derivative -1e6 at both; constant with derivative 0 beyond",
    ),
    prescribed(
        "safe_atan2",
        2,
        _safe_atan2,
        "atan2(x, y)",
        "y / (x^2 + y^2 + 1e-12); -x / (x^2 + y^2 + 1e-12)",
        "0 at (0, 0) with derivatives 0 and 0; derivatives never above 5e5",
    ),
)
