"""Times of the steps of an online solve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from arael.plot.figure import BLUE, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def times_figure(milliseconds: Sequence[float], title: str) -> Figure:
    """Draw the time of each step, and the mean of all so far, on a logarithmic axis."""
    figure, (axes,) = new_figure(8.0, 4.2)
    steps, times = np.arange(1, len(milliseconds) + 1), np.asarray(milliseconds)
    axes.plot(steps, times, ".", color=BLUE, markersize=3, label="step")
    axes.plot(
        steps, np.cumsum(times) / steps, "-", color=ORANGE, linewidth=1.5, label="mean so far"
    )
    axes.set_yscale("log")
    axes.set_xlabel("step")
    axes.set_ylabel("ms")
    axes.set_title(title, color=INK)
    axes.legend(frameon=False)
    axes.grid(True)
    return figure
