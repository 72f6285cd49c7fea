"""Columns of numbers, each over the first one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, INK, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_COLUMNS = 6
"""Most columns drawn."""


@styled
def table_figure(columns: Mapping[str, NDArray[np.float64]], title: str = "") -> Figure:
    """Draw every column over the first; a single one over its rows.

    Parameters
    ----------
    columns : (n,) each, by name
    """
    (first, across), *others = columns.items()
    if not others:
        others, first, across = [(first, across)], "row", np.arange(len(across), dtype=float)
    drawn = others[:MAX_COLUMNS]
    figure, axes = new_figure(9.0, 1.2 + 2.2 * len(drawn), rows=len(drawn))
    for one, (name, values) in zip(axes, drawn, strict=True):
        one.plot(across, values, ".", color=BLUE, markersize=4)
        one.set_ylabel(name)
        one.grid(True)
    axes[-1].set_xlabel(first)
    more = f" ({len(drawn)} of {len(others)} columns)" if len(drawn) < len(others) else ""
    figure.suptitle(title + more, x=0.01, ha="left", color=INK, fontsize=11)
    return figure
