"""Values of primitive operations on constants.

Folding is done in binary64 with the C library's functions. What has no finite value is never
folded: the operation stays in the graph, so that the NaN or the infinity appears at run time, where
it can be reported with its place.
"""

from __future__ import annotations

import math

from arael.operations.numbers import value


def fold(name: str, *values: float) -> float | None:
    """Value of operation `name` on `values`, or None if it has none that is finite."""
    result = value(name, *values)
    return result if math.isfinite(result) else None
