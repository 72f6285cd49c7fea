"""A fitted curve: points, curve, bands, residuals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, GREEN, GREY, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_COLORS = (BLUE, ORANGE, GREEN, GREY)
_ACROSS = 300
"""Points at which a curve is drawn."""
_MOST = 8
"""Most groups that are drawn with bands and a name."""


class Bands(Protocol):
    """A curve (m,) with its uncertainty."""

    @property
    def value(self) -> Array:
        """The curve."""

    @property
    def low(self) -> Array:
        """Lower end of the confidence band."""

    @property
    def high(self) -> Array:
        """Upper end of the confidence band."""

    @property
    def predicted_low(self) -> Array:
        """Lower end of the prediction band."""

    @property
    def predicted_high(self) -> Array:
        """Upper end of the prediction band."""


class Fitted(Protocol):
    """A fitted curve."""

    @property
    def residuals(self) -> Array:
        """(n,) measured minus fitted."""

    def bands(self, data: Mapping[str, Any], level: float, group: Any) -> Bands:
        """The curve at other points."""


class Formula(Protocol):
    """The names of a formula."""

    @property
    def text(self) -> str:
        """The formula of the predicted column."""

    @property
    def predicts(self) -> str | None:
        """Name of the predicted column; None of a residual."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns that it reads."""


class Points(Protocol):
    """The points of a fit, by columns (n,)."""

    @property
    def columns(self) -> Mapping[str, Array]:
        """Columns by name."""

    @property
    def group(self) -> NDArray[np.int64]:
        """Number of the group of each point."""

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups."""

    @property
    def size(self) -> int:
        """Number of points."""


@styled
def curve_figure(fit: Fitted, formula: Formula, points: Points, level: float) -> Figure:
    """Draw points and curve over the first column that the formula reads, and the residuals.

    With one such column the curve has a confidence band (dark) and a prediction band (light); with
    several, measured values are drawn over fitted ones. A residual formula has residuals alone.
    """
    read = [name for name in formula.columns if name != formula.predicts]
    figure, axes = new_figure(12.0, 4.8, columns=1 if formula.predicts is None else 2)
    residuals = axes[-1]
    across = points.columns[read[0]] if read else np.arange(float(points.size))
    groups = points.groups or ("",)
    for k, group in enumerate(groups):
        mine = points.group == k if points.groups else np.ones(points.size, dtype=bool)
        color = _COLORS[k % len(_COLORS)]
        residuals.plot(across[mine], fit.residuals[mine], ".", color=color, label=group or None)
        if formula.predicts is None:
            continue
        y, name = points.columns[formula.predicts][mine], group if points.groups else None
        if len(read) != 1:
            fitted = y - fit.residuals[mine]
            axes[0].plot(fitted, y, "o", color=color, markersize=4, label=group or None)
            continue
        dots = color if len(groups) > 1 else INK
        axes[0].plot(across[mine], y, "o", color=dots, markersize=4, label=group or "points")
        x = np.linspace(across[mine].min(), across[mine].max(), _ACROSS)
        bands = fit.bands({read[0]: x}, level, name)
        axes[0].plot(x, bands.value, color=color, label=None if group else "fit")
        if k < _MOST and np.isfinite(bands.low).all():
            axes[0].fill_between(
                x, bands.predicted_low, bands.predicted_high, color=color, alpha=0.12, linewidth=0
            )
            axes[0].fill_between(x, bands.low, bands.high, color=color, alpha=0.3, linewidth=0)
    residuals.axhline(0, color=FAINT, linewidth=1)
    residuals.set_title("residuals", color=INK)
    residuals.set_xlabel(read[0] if read else "point")
    if formula.predicts is not None:
        axes[0].set_title(f"{formula.predicts} = {formula.text}", color=INK)
        if len(read) == 1:
            axes[0].set_xlabel(read[0])
            axes[0].set_ylabel(formula.predicts)
        else:
            y = points.columns[formula.predicts]
            ends = np.array([y.min(), y.max()])
            axes[0].plot(ends, ends, color=FAINT, linewidth=1)
            axes[0].set_xlabel("fitted")
            axes[0].set_ylabel(f"measured {formula.predicts}")
        residuals.set_ylabel("measured - fitted")
        if len(groups) <= _MOST and axes[0].get_legend_handles_labels()[1]:
            axes[0].legend(fontsize=8)
    for one in axes:
        one.grid(True)
    return figure
