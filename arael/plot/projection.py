"""Uncertainty of projection over the pictures of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.plot.figure import INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_POINTS = 800
"""Most measured pixels that are drawn."""
_BEYOND = 0.97
"""Quantile of the standard deviations at which colours end: outside of what was seen they grow
without bound."""


@styled
def projection_figure(pictures: Sequence[Any]) -> Figure:
    """Draw the standard deviation of projection of each camera, with what was measured.

    Parameters
    ----------
    pictures : of `arael.Model.projection_uncertainty`, at least one; colours are the same in all
    """
    # imported here: start-up time
    from matplotlib.colors import BoundaryNorm

    figure, axes = new_figure(5.6 * len(pictures) + 1.0, 4.2, columns=len(pictures))
    levels = _levels(np.concatenate([one.sigma.ravel() for one in pictures]))
    for one, place in zip(pictures, axes, strict=True):
        shown = place.contourf(
            one.x,
            one.y,
            one.sigma,
            levels=levels,
            extend="max",
            cmap="viridis",
            norm=BoundaryNorm(levels, 256, extend="max"),
        )
        seen = one.seen[:: max(1, len(one.seen) // _POINTS)]
        place.plot(*seen.T, ".", ms=1.5, color=ORANGE)
        place.set(xlim=(0, one.x[-1] + one.x[0]), ylim=(one.y[-1] + one.y[0], 0), aspect="equal")
        place.set(xlabel="x [px]", ylabel="y [px]")
        place.set_title(f"{one.camera} (dots: measured)", color=INK)
    bar = figure.colorbar(shown, ax=axes, label="standard deviation of a projection [px]")
    bar.set_ticks(levels, labels=[f"{level:g}" for level in levels])
    return figure


def _levels(sigma: Any) -> Any:
    """Numbers 1, 2, 5 times powers of ten that enclose what is finite."""
    known = sigma[np.isfinite(sigma) & (sigma > 0)]
    if not len(known):
        return np.array([0.1, 1.0])
    low, high = float(known.min()), float(np.quantile(known, _BEYOND))
    first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1
    series = np.array([m * 10.0**e for e in range(first, last + 1) for m in (1, 2, 5)])
    begin = int(np.searchsorted(series, low, side="right")) - 1
    end = max(int(np.searchsorted(series, high)), begin + 1)
    return series[begin : end + 1]
