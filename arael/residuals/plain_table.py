"""A table beside the model's: without bounds, held components and optional values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class PlainTable:
    """What the tables of a runtime residual have in common; subclasses add `column`."""

    size = 1
    #: Bounds are those of the columns, and never change.
    bounds_version = ()

    def column(self, path: str) -> Array:
        """Live values (size, *shape)."""
        raise NotImplementedError

    def columns(self, paths: tuple[str, ...]) -> list[Array]:
        """Live values of several columns."""
        return [self.column(path) for path in paths]

    def present(self, path: str) -> Array:
        """All are present."""
        return np.ones(self.size, dtype=bool)

    def component_flags(self, path: str) -> Array | None:
        """No component is held."""
        return None

    def fixed_components(self, path: str) -> Array | None:
        """No component is fixed."""
        return None

    def bound(self, path: str, end: str) -> Array | None:
        """Bounds are those of the column."""
        return None

    def parent_rows(self) -> Array:
        """Return the root's row."""
        return np.zeros(self.size, dtype=np.int64)
