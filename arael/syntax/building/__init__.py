"""Builds tree nodes from productions, with the checks that the grammar does not express.

One method per production, named ``_make_`` and the production, called with the kept parts and the
place of the production.
"""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import Span
from arael.syntax.building.expressions import ExpressionBuilder
from arael.syntax.building.items import ItemBuilder
from arael.syntax.building.members import MemberBuilder
from arael.syntax.building.types import TypeBuilder


class TreeBuilder(ItemBuilder, MemberBuilder, TypeBuilder, ExpressionBuilder):
    """Builds nodes bottom-up."""

    def __call__(self, production: str, parts: list[Any], start: int, end: int) -> Any:
        """Value of `production`."""
        return getattr(self, "_make_" + production)(parts, Span(self._source, start, end))
