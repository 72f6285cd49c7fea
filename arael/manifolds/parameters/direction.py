"""Directions: points of the unit sphere, moved along it."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import sphere
from arael.manifolds.linear import flatten, matrix, transpose
from arael.manifolds.parameters.kind import AXES, Caches, ParameterType, Tangents, by_columns
from arael.symbolic.graph import Graph


def _caches(g: Graph, stored: Sequence[int]) -> Caches:
    return {"B": flatten(sphere.basis(g, stored))}


def _tangent(g: Graph, stored: Sequence[int], caches: Caches) -> Tangents:
    """Columns of the basis of the tangent plane."""
    return by_columns(g, transpose(matrix(caches["B"], 3, 2)))


def _cache_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    return {}


DIRECTION = ParameterType(
    "direction",
    3,
    2,
    (0.0, 0.0, 1.0),
    sphere.move,
    _tangent,
    _caches,
    _cache_tangents,
    sphere.log,
    (("B", 6),),
    AXES,
    (".u", ".v"),
)
