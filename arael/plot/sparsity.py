"""The pattern of a Hessian, each kind of block in its own colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, GREEN, GREY, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_PIXELS = 1400
"""Larger patterns are reduced: a cell is drawn if any entry in it is not zero."""


def hessian_pattern(jacobian: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of the entries of J'J of a Jacobian (see `arael.Model.jacobian`)."""
    product = (abs(jacobian.matrix).T @ abs(jacobian.matrix)).tocoo()
    kept = product.data != 0
    return product.row[kept].astype(np.int64), product.col[kept].astype(np.int64)


@styled
def sparsity_figure(
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    size: int,
    groups: Sequence[tuple[str, int]] = (),
) -> Figure:
    """Draw the pattern of a symmetric matrix.

    Parameters
    ----------
    rows, columns : (k,) positions of the non-zero entries, at least of one triangle
    size : number of rows
    groups : names and sizes of consecutive ranges of parameters (``("poses", 360)``); entries
        within one group and between two are distinguished by colour
    """
    # imported here: start-up time
    from matplotlib.colors import ListedColormap

    figure, (axes,) = new_figure(7.2, 7.4)
    cells = min(size, MAX_PIXELS)
    image = np.zeros((cells, cells), dtype=np.uint8)
    kind = _kinds(rows, columns, groups)
    i, j = rows * cells // size, columns * cells // size
    image[i, j] = kind
    image[j, i] = kind
    colors = ListedColormap(["white", BLUE, GREEN, ORANGE])
    axes.imshow(
        image, cmap=colors, vmin=0, vmax=3, interpolation="nearest", extent=(0, size, size, 0)
    )
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    for spine in axes.spines.values():
        spine.set_color(GREY)

    edge = 0
    for name, count in groups:
        if 0 < edge < size:
            axes.axhline(edge, color=FAINT, linewidth=0.8)
            axes.axvline(edge, color=FAINT, linewidth=0.8)
        if count >= 0.04 * size:
            axes.annotate(
                name,
                (edge + count / 2, 0),
                xytext=(0, 4),
                textcoords="offset points",
                ha="center",
                color=INK,
            )
        edge += count
    filled = len(np.unique(np.concatenate([rows * size + columns, columns * size + rows])))
    axes.set_title("Hessian\n" if groups else "Hessian", color=INK, loc="left")
    axes.set_xlabel(f"{size} parameters, {filled} non-zero entries ({filled / size**2:.1%})")
    return figure


def _kinds(
    rows: NDArray[np.int64], columns: NDArray[np.int64], groups: Sequence[tuple[str, int]]
) -> NDArray[np.uint8]:
    """1 and 2: within the first and within any other group; 3: between groups."""
    if not groups:
        return np.ones(len(rows), dtype=np.uint8)
    edges = np.cumsum([count for _, count in groups])
    a = np.searchsorted(edges, rows, side="right")
    b = np.searchsorted(edges, columns, side="right")
    kinds: NDArray[np.uint8] = np.where(a != b, 3, np.where(a == 0, 1, 2)).astype(np.uint8)
    return kinds
