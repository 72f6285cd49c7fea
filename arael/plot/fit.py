"""A line fit: least squares and robust fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import FAINT, GREY, INK, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """A line ``y = slope x + offset`` with its name and colour."""

    name: str
    slope: float
    offset: float
    color: str


@styled
def fit_figure(x: Array, y: Array, wrong: NDArray[np.bool_], lines: Sequence[Line]) -> Figure:
    """Draw points and fitted lines, and the residuals of the right points."""
    figure, (points, residuals) = new_figure(12.0, 4.8, columns=2)
    points.plot(x[~wrong], y[~wrong], "o", color=INK, markersize=4, label="right points")
    points.plot(x[wrong], y[wrong], "x", color=GREY, markersize=6, label="wrong points")
    ends = np.array([x.min(), x.max()])
    residuals.axhline(0, color=FAINT, linewidth=1)
    for line in lines:
        label = f"{line.name}: {line.slope:.4f} x {line.offset:+.4f}"
        points.plot(ends, line.slope * ends + line.offset, color=line.color, label=label)
        off = y - line.slope * x - line.offset
        residuals.plot(x[~wrong], off[~wrong], ".", color=line.color, markersize=7, label=line.name)
    points.set_title("line fit", color=INK)
    residuals.set_title("residuals of the right points", color=INK)
    for axes in (points, residuals):
        axes.grid(True)
        axes.set_xlabel("x")
        axes.legend(fontsize=8)
    points.set_ylabel("y")
    residuals.set_ylabel("y - fit")
    return figure
