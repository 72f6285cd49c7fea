"""A fitted curve: points, curve, bands, residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from arael.plot.figure import BLUE, FAINT, GREEN, GREY, INK, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from arael.fitting.result import Fit

_COLORS = (BLUE, ORANGE, GREEN, GREY)
_ACROSS = 300
"""Points at which a curve is drawn."""
_MOST = 8
"""Most groups that are drawn with bands and a name."""


@styled
def curve_figure(fit: Fit, level: float) -> Figure:
    """Draw points and curve over the first column that the formula reads, and the residuals.

    With one such column the curve has a confidence band (dark) and a prediction band (light); with
    several, measured values are drawn over fitted ones. A residual formula has residuals alone.
    """
    points, formula = fit.curve.points, fit.formula
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
