"""Functions with kinks and jumps: finite in value and derivative everywhere."""

from __future__ import annotations

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import prescribed, primitive


def _clamp(g: Graph, x: int, low: int, high: int) -> int:
    return g.op("min", g.op("max", x, low), high)


FUNCTIONS = (
    primitive("abs", 1, "sign(x)", "derivative 0 at 0", "|x|"),
    primitive("sign", 1, "0", "0 at 0; derivative 0 there too", "-1, 0 or 1"),
    primitive("heaviside", 1, "0", "0.5 at 0; derivative 0 there too", "0 for x < 0, 1 for x > 0"),
    primitive("floor", 1, "0", "derivative 0 at the jumps too", "largest integer not above x"),
    primitive("ceil", 1, "0", "derivative 0 at the jumps too", "smallest integer not below x"),
    primitive(
        "round", 1, "0", "derivative 0 at the jumps too", "nearest integer, halves away from zero"
    ),
    primitive(
        "min",
        2,
        "1 if x <= y else 0; 1 if y < x else 0",
        "at x = y the derivative is that of x",
        "the smaller",
    ),
    primitive(
        "max",
        2,
        "1 if y <= x else 0; 1 if x < y else 0",
        "at x = y the derivative is that of x",
        "the larger",
    ),
    prescribed(
        "clamp",
        3,
        _clamp,
        "min(max(x, y), z): x held in y .. z",
        "1 if y <= x <= z else 0; 1 if x < y else 0; 1 if z < x else 0",
        "at x = y and at x = z the derivative is that of x",
    ),
)
