"""The figures of any solved model: its points, its Hessian, the history of the solve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, GREY, INK, ORANGE, beside, new_figure, save, styled
from arael.plot.history import history_figure
from arael.plot.sparsity import hessian_pattern, sparsity_figure
from arael.runtime.layout import Column, Layout

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.result import Result

Array = NDArray[np.float64]


def plot_solution(instance: Any, layout: Layout, result: Result, path: Path) -> list[str]:
    """Draw a solved model into `path` and related files; return their names.

    `path` shows the points and their links, or cost and damping if the model has none.
    """
    written = []
    points = point_columns(instance, layout)
    history = history_figure([(one.name, one.history) for one in result.passes])
    if points:
        written.append(save(map_figure(points, links(instance, layout)), path))
        written.append(save(history, beside(path, "cost")))
    else:
        written.append(save(history, path))
    jacobian = instance.jacobian()
    pattern = sparsity_figure(*hessian_pattern(jacobian), len(jacobian.names))
    written.append(save(pattern, beside(path, "hessian")))
    return written


def model_figure(instance: Any, layout: Layout) -> Figure:
    """The points of a model and their links from above; if it has none, the pattern of J'J."""
    points = point_columns(instance, layout)
    if points:
        return map_figure(points, links(instance, layout))
    jacobian = instance.jacobian()
    return sparsity_figure(*hessian_pattern(jacobian), len(jacobian.names))


def point_columns(instance: Any, layout: Layout) -> dict[str, Array]:
    """Positions (n, 2 or 3) of every table with a plain parameter of that shape."""
    found: dict[str, Array] = {}
    for entity in layout.entities:
        for use in entity.params:
            if use.kind == "vec" and use.stored in (2, 3) and entity.table:
                rows = instance[entity.table]
                if entity.table not in found and len(rows):
                    found[entity.table] = np.array(rows[use.column].value, dtype=float)
    return found


def links(instance: Any, layout: Layout) -> list[tuple[str, NDArray[np.int64]]]:
    """Pairs of rows connected by a table with two refs into one table, by that table."""
    found = []
    for table in layout.tables:
        refs = [c for c in table.columns if c.role == "ref" and _is_of_root(c)]
        targets = {c.target.table for c in refs if c.target}
        if len(refs) == 2 and len(targets) == 1 and len(instance[table.path]):
            rows = instance[table.path]
            pairs = np.column_stack([np.asarray(rows[c.path].rows) for c in refs])
            found.append((targets.pop(), pairs[(pairs >= 0).all(axis=1)]))  # without null refs
    return found


def _is_of_root(column: Column) -> bool:
    """Whether a ref points into a collection of the root."""
    return column.target is not None and all(s.kind == "root" for s in column.target.base)


@styled
def map_figure(points: dict[str, Array], pairs: list[tuple[str, NDArray[np.int64]]]) -> Figure:
    """Draw points from above, each collection in its own colour, with the links between them."""
    # imported here: start-up time
    from matplotlib.collections import LineCollection

    figure, (axes,) = new_figure(8.0, 7.4)
    for table, rows in pairs:
        if table in points:
            segments = points[table][rows][:, :, :2]
            axes.add_collection(
                LineCollection(list(segments), colors=GREY, linewidths=0.5, alpha=0.6, zorder=1)
            )
    for (table, places), color in zip(points.items(), (BLUE, ORANGE, INK) * 9, strict=False):
        size = float(np.clip(300 / np.sqrt(len(places)), 1.0, 5.0))
        axes.plot(*places[:, :2].T, ".", color=color, markersize=size, label=table)
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(True)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    if len(points) > 1:
        axes.legend()
    axes.set_title(", ".join(f"{len(places)} {table}" for table, places in points.items()))
    return figure
