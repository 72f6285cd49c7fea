"""What a parameter type is; those that a step is added to, numbers and vectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arael.manifolds.linear import Vector, add, sub
from arael.symbolic.graph import Graph

Tangents = list[dict[int, int]]
"""Per scalar, its derivative by each component of delta that it depends on, as a node."""

Caches = dict[str, Vector]

AXES = (".x", ".y", ".z")


@dataclass(frozen=True)
class ParameterType:
    """One type of parameter.

    Attributes
    ----------
    name : as the language spells it
    storage : number of scalars stored
    tangent_width : number of scalars solved for
    neutral : stored value of a parameter that was given none
    retract : (graph, stored, delta) -> stored value moved by delta
    tangent : (graph, stored, caches) -> derivative of the stored scalars by delta, at delta = 0
    caches : (graph, stored) -> values worth keeping per entity, by name; matrices row by row
    cache_tangents : (graph, stored, caches) -> derivative by delta at 0 of each cached value that
        constraints read; what only tangents read has none
    local : (graph, base, stored) -> delta with ``retract(base, delta) = stored``, of the shortest
        rotation
    cache_names : the names in `caches` with their numbers of scalars
    stored_names : suffix of the name of each stored scalar
    tangent_names : suffix of the name of each component of delta
    parts : components of delta that can be frozen by themselves: name, first, count
    """

    name: str
    storage: int
    tangent_width: int
    neutral: tuple[float, ...]
    retract: Callable[[Graph, Sequence[int], Sequence[int]], Vector]
    tangent: Callable[[Graph, Sequence[int], Caches], Tangents]
    caches: Callable[[Graph, Sequence[int]], Caches]
    cache_tangents: Callable[[Graph, Sequence[int], Caches], dict[str, Tangents]]
    local: Callable[[Graph, Sequence[int], Sequence[int]], Vector]
    cache_names: tuple[tuple[str, int], ...] = ()
    stored_names: tuple[str, ...] = ()
    tangent_names: tuple[str, ...] = ()
    parts: tuple[tuple[str, int, int], ...] = ()

    @property
    def flat(self) -> bool:
        """Whether the stored value is simply added to."""
        return self.retract is add


def difference(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    """``stored - base``, of parameters that a step is added to."""
    return sub(g, stored, base)


def numbered(count: int) -> tuple[str, ...]:
    """Suffixes of `count` alike scalars: nothing, ``.x``, or ``[4]``."""
    if count == 1:
        return ("",)
    return AXES[:count] if count <= 3 else tuple(f"[{i}]" for i in range(count))


def diagonal(g: Graph, stored: Sequence[int], caches: Caches) -> Tangents:
    """Tangents of stored scalars that delta is added to."""
    one = g.const(1.0)
    return [{k: one} for k in range(len(stored))]


def by_columns(g: Graph, by: Sequence[Sequence[int]]) -> Tangents:
    """From the derivatives by each component of delta, to those of each scalar; zeros left out."""
    return [
        {k: entry for k, entry in enumerate(entries) if g.value(entry) != 0}
        for entries in zip(*by, strict=True)
    ]


def shifted(tangents: Tangents, first: int) -> Tangents:
    """Tangents by components of delta that begin at `first`."""
    return [{first + k: node for k, node in row.items()} for row in tangents]


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
        difference,
        stored_names=numbered(width),
        tangent_names=numbered(width),
    )
