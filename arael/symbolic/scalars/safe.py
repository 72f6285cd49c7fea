"""Regularised functions: finite in value and derivative everywhere.

They hide a singularity from the solver; a constraint that avoids it is better. Outside their domain
they are constant, and so is what the solver sees of them there.
"""

from __future__ import annotations

from arael.symbolic.graph import Graph


def safe_sqrt(g: Graph, x: int) -> int:
    """Root of what is positive of x."""
    return g.op("sqrt", g.op("max", x, g.const(0.0)))


def _held(g: Graph, x: int) -> int:
    return g.op("min", g.op("max", x, g.const(-1.0)), g.const(1.0))


def safe_asin(g: Graph, x: int) -> int:
    """Arc sine of x held in -1 .. 1."""
    return g.op("asin", _held(g, x))


def safe_acos(g: Graph, x: int) -> int:
    """Arc cosine of x held in -1 .. 1."""
    return g.op("acos", _held(g, x))


def safe_atan2(g: Graph, y: int, x: int) -> int:
    """Arc tangent of two arguments; only its derivatives are regularised."""
    return g.op("atan2", y, x)
