"""Functions with kinks and jumps: finite in value and derivative everywhere."""

from __future__ import annotations

from arael.symbolic.graph import Graph


def clamp(g: Graph, x: int, low: int, high: int) -> int:
    """X held in low .. high."""
    return g.op("min", g.op("max", x, low), high)
