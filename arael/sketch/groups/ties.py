"""Which points of a set of entities are one place, by the coincidences of the document."""

from __future__ import annotations

from collections.abc import Sequence

from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.records import Entity


def points_of(entity: Entity) -> dict[str, str]:
    """Handle of every point of an entity by the point's name, each place once."""
    found: dict[str, str] = {}
    seen: set[int] = set()
    for point, at in point_offsets(entity).items():
        if at not in seen:
            seen.add(at)
            found[point] = entity.name if entity.kind == "point" else f"{entity.name}.{point}"
    return found


def places(document: Document) -> dict[str, str]:
    """For every handle in a coincidence, one handle that stands for all that are one place."""
    parent: dict[str, str] = {}

    def root(one: str) -> str:
        while parent.setdefault(one, one) != one:
            parent[one] = parent[parent[one]]
            one = parent[one]
        return one

    for constraint in document.constraints.values():
        if constraint.kind == "coincident" and constraint.active:
            a, b = constraint.args
            parent[root(a)] = root(b)
    return {one: root(one) for one in parent}


def classes(document: Document, names: Sequence[str]) -> list[list[str]]:
    """Handles of points of these entities that are one place; every point is in one list."""
    place = places(document)
    found: dict[str, list[str]] = {}
    for name in names:
        for handle in points_of(document.entities[name]).values():
            found.setdefault(place.get(handle, handle), []).append(handle)
    return list(found.values())
