"""A planar figure and its free motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@styled
def motion_figure(
    points: Array, edges: Sequence[tuple[int, int]], moves: Sequence[Array], title: str
) -> Figure:
    """Draw `points` (n, 2) joined by `edges`, and each of `moves` (n, 2) as arrows."""
    figure, (axes,) = new_figure(6.0, 4.6)
    size = float(np.ptp(points, axis=0).max())
    for move, color in zip(moves, (ORANGE, BLUE) * len(moves), strict=False):
        step = 0.25 * size * move / np.abs(move).max()
        for a, b in edges:
            axes.plot(*(points + step)[[a, b]].T, color=FAINT, linewidth=1.5)
        axes.quiver(
            *points.T, *step.T, angles="xy", scale_units="xy", scale=1, color=color, width=0.006
        )
    for a, b in edges:
        axes.plot(*points[[a, b]].T, color=INK, linewidth=1.5)
    axes.plot(*points.T, "o", color=INK, markersize=5)
    axes.set_aspect("equal")
    axes.margins(0.15)
    axes.set_title(title, color=INK)
    axes.grid(True)
    return figure
