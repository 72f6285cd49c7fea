"""Parameters that a step is added to: numbers and vectors."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds.linear import add
from arael.manifolds.parameters.kind import Caches, ParameterType, Tangents, diagonal, numbered
from arael.symbolic.graph import Graph


def no_caches(g: Graph, stored: Sequence[int]) -> Caches:
    """Nothing to keep."""
    return {}


def no_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    """No caches, no derivatives of them."""
    return {}


def plain(name: str, width: int) -> ParameterType:
    """Type of a number, or of a vector of `width`."""
    return ParameterType(
        name,
        width,
        width,
        (0.0,) * width,
        add,
        diagonal,
        no_caches,
        no_tangents,
        stored_names=numbered(width),
        tangent_names=numbered(width),
    )
