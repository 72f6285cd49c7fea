"""Names of C++ classes."""

from __future__ import annotations

from arael.exporting.identifiers import identifier


def class_name(name: str) -> str:
    """Name of a class: ``edge_between`` as ``EdgeBetween``."""
    return "".join(word.capitalize() for word in identifier(name).split("_"))
