"""Starship, a bounded residual.

gamma atan(r / gamma) is near r for small r and never exceeds gamma pi / 2, so no single residual
costs more than (gamma pi / 2)^2. Its authors describe the method as patented (US 12,346,118).
"""

from __future__ import annotations

import math

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import ScalarFunction, prescribed


def _starship(g: Graph, r: int, gamma: int) -> int:
    return g.op("mul", gamma, g.op("atan", g.op("div", r, gamma)))


def _starship_gamma(g: Graph, bound: int) -> int:
    return g.op("mul", g.const(2 / math.pi), g.op("sqrt", bound))


FUNCTIONS = (
    prescribed(
        "starship",
        2,
        _starship,
        "y atan(x / y)",
        "1 / (1 + (x / y)^2); atan(x / y) - (x / y) / (1 + (x / y)^2)",
        "at y = 0: 0 with derivatives 0 and NaN; all NaN at (0, 0)",
    ),
    ScalarFunction(
        "starship_gamma",
        1,
        _starship_gamma,
        "2 sqrt(x) / pi: the y of starship that bounds the cost of a residual by x",
        "1 / (pi sqrt(x))",
        "0 at 0 with derivative inf; NaN for x < 0",
    ),
)
