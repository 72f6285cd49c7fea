"""Times of solvers, by the size of a problem or by phase."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from arael.plot.figure import BLUE, GREEN, GREY, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = (GREY, BLUE, ORANGE, GREEN, INK)


@styled
def growth_figure(
    lines: Sequence[tuple[str, Sequence[float], Sequence[float]]], title: str, sizes: str
) -> Figure:
    """Draw time against size, both logarithmic.

    Parameters
    ----------
    lines : name, sizes and seconds of each
    sizes : axis label of the size
    """
    figure, (axes,) = new_figure(6.4, 4.2)
    for color, (name, size, seconds) in zip(COLORS, lines, strict=False):
        axes.loglog(size, [1e3 * s for s in seconds], "o-", color=color, markersize=4, label=name)
    axes.set_title(title, color=INK)
    axes.set_xlabel(sizes)
    axes.set_ylabel("ms per iteration")
    axes.grid(True, which="major")
    axes.legend(fontsize=8)
    return figure


@styled
def phases_figure(
    names: Sequence[str], phases: Sequence[tuple[str, Sequence[float]]], title: str
) -> Figure:
    """Draw a stacked bar for each of `names` with its `phases` (name, seconds of each bar)."""
    figure, (axes,) = new_figure(6.4, 4.2)
    bottom = [0.0] * len(names)
    for color, (phase, seconds) in zip(COLORS[1:], phases, strict=False):
        heights = [1e3 * s for s in seconds]
        axes.bar(names, heights, 0.6, bottom=bottom, color=color, label=phase)
        bottom = [b + h for b, h in zip(bottom, heights, strict=True)]
    axes.set_title(title, color=INK)
    axes.set_ylabel("ms per iteration")
    axes.grid(True, axis="y")
    axes.legend(fontsize=8)
    return figure
