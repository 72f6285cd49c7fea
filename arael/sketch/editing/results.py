"""What edits give that is more than one record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from arael.sketch.document.records import Constraint, Entity


@dataclass(frozen=True, slots=True)
class Added:
    """A new entity and what was added with it.

    Attributes
    ----------
    entity : the new one
    connected : coincident constraints that were found
    tangents : tangent constraints that were found
    """

    entity: Entity
    connected: tuple[Constraint, ...] = ()
    tangents: tuple[Constraint, ...] = ()


@dataclass(frozen=True, slots=True)
class Deleted:
    """What was deleted.

    Attributes
    ----------
    names : all records, those that went with others included
    dissolved : groups that were dissolved, and the part that was deleted
    """

    names: tuple[str, ...]
    dissolved: Mapping[str, str]
