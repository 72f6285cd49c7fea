"""Starship, a bounded residual.

gamma atan(r / gamma) is near r for small r and never exceeds gamma pi / 2, so no single residual
costs more than (gamma pi / 2)^2. Its authors describe the method as patented (US 12,346,118).
"""

from __future__ import annotations

import math

from arael.symbolic.graph import Graph


def starship(g: Graph, r: int, gamma: int) -> int:
    """Gamma atan(r / gamma)."""
    return g.op("mul", gamma, g.op("atan", g.op("div", r, gamma)))


def starship_gamma(g: Graph, bound: int) -> int:
    """The gamma at which a residual costs at most `bound`."""
    return g.op("mul", g.const(2 / math.pi), g.op("sqrt", bound))
