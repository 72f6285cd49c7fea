"""Fills a model instance from columns by path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Layout, Table


def fill(instance: Any, layout: Layout, columns: Mapping[str, NDArray[np.generic]]) -> None:
    """Add the rows of `columns` (see `columns`) to the collections of an empty model instance.

    Parameters
    ----------
    instance : an instance of the model of `layout`
    columns : arrays by path; ``<path>.offsets`` gives the rows of a nested list for each row of its
        parent
    """
    collections: dict[str, Any] = {"": instance}
    for table in layout.tables:
        if not table.path:
            continue
        collections[table.path] = collections[table.parent][table.field]
        values = _values(table, layout, columns)
        if values:
            offsets = columns.get(f"{table.path}.offsets")
            parent = (
                None
                if offsets is None
                else np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
            )
            collections[table.path].extend(parent=parent, **values)


def _values(
    table: Table, layout: Layout, columns: Mapping[str, NDArray[np.generic]]
) -> dict[str, NDArray[np.generic]]:
    """Columns of the rows of `table` itself, without those of nested lists."""
    start = table.path + "."
    inner = tuple(t.path + "." for t in layout.tables if t.parent == table.path and t.path)
    return {
        path.removeprefix(start): values
        for path, values in columns.items()
        if path.startswith(start) and not path.startswith(inner) and not path.endswith(".offsets")
    }
