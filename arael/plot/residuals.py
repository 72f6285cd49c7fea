"""Whitened residuals by constraint: over the rows or time, and as a histogram with the weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.plot.figure import BLUE, FAINT, GREEN, GREY, INK, ORANGE, new_figure, styled
from arael.runtime.layout import Layout

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MAX_CONSTRAINTS = 5
"""Most constraints of a figure: those of largest cost."""
MAX_DOTS = 20_000
"""Most residuals drawn as dots, of a constraint; every k-th row of more."""
MAX_SIGMAS = 6.0
"""Reach of the histograms; residuals beyond are counted in their ends."""


@dataclass(frozen=True)
class Residuals:
    """Residuals of one constraint.

    Attributes
    ----------
    label : of the constraint
    whitened : (n, m) before the loss
    weight : (n,) share of its squared residual that each row costs
    at : (n,) where a row is drawn: its number, or time
    along : what `at` is: ``row`` or ``time [s]``
    """

    label: str
    whitened: Array
    weight: Array
    at: Array
    along: str = "row"


def residuals_of(instance: Any, layout: Layout) -> list[Residuals]:
    """Residuals of the constraints that act, those of largest cost first."""
    table = instance.cost_table()
    labels = [label for label in table if table.residuals[label]]
    found = []
    for label in sorted(labels, key=lambda one: -table[one]):
        values = instance.residual_values(label)
        at, along = _place(instance, layout, label, len(values))
        found.append(Residuals(label, values.whitened, values.weight, at, along))
    return found


def _place(instance: Any, layout: Layout, label: str, rows: int) -> tuple[Array, str]:
    """Times of the rows, where the model has them in seconds, or their numbers."""
    # Residuals that were added at run time have no group in the layout of the model.
    group = next((one for one in layout.groups if one.label == label), None)
    tables = {t.path: t for t in layout.tables if t.path and not t.parent}
    if group is not None and group.table in tables and len(instance[group.table]) == rows:
        for column in tables[group.table].columns:
            if column.unit == "s" and not column.shape and column.role == "data":
                times = np.asarray(instance[group.table][column.path], dtype=float)
                if np.isfinite(times).all():
                    return times, f"{column.path} [s]"
    return np.arange(rows, dtype=float), "row"


@styled
def residual_figure(constraints: list[Residuals], title: str = "") -> Figure:
    """Draw the whitened residuals of each constraint, in sigmas.

    On the left by row or over time, on the right as a histogram, beside the normal distribution
    and, on the axis at the right, the weights of its loss.
    """
    drawn = constraints[:MAX_CONSTRAINTS]
    figure, axes = new_figure(11.0, 0.9 + 2.3 * max(len(drawn), 1), 2, max(len(drawn), 1))
    for one, (left, right) in zip(drawn, zip(axes[::2], axes[1::2], strict=True), strict=False):
        _over_rows(left, one)
        _histogram(right, one)
    text = title or "residuals"
    if len(constraints) > len(drawn):
        text += f" ({len(drawn)} of {len(constraints)} constraints, those of largest cost)"
    figure.suptitle(text, x=0.01, ha="left", color=INK, fontsize=11)
    return figure


def _over_rows(axes: Axes, one: Residuals) -> None:
    every = max(1, -(-one.whitened.size // MAX_DOTS))
    dot = float(np.clip(120 / np.sqrt(len(one.whitened[::every])), 1.0, 5.0))
    for values, color in zip(
        one.whitened[::every].T, (BLUE, ORANGE, GREEN, INK) * 99, strict=False
    ):
        axes.plot(one.at[::every], values, ".", color=color, markersize=dot)
    axes.axhspan(-2, 2, color=FAINT, alpha=0.4, zorder=0, linewidth=0)
    axes.set_xlabel(one.along)
    axes.set_ylabel("residual / sigma")
    rms = float(np.sqrt(np.mean(one.whitened**2)))
    axes.set_title(f"{one.label}: {one.whitened.size} residuals, rms {rms:.3g}", color=INK)


def _histogram(axes: Axes, one: Residuals) -> None:
    values = one.whitened.ravel()
    values = values[np.isfinite(values)]
    reach = float(np.clip(1.05 * np.abs(values).max(initial=0.0), 3.0, MAX_SIGMAS))
    bins = int(np.clip(np.sqrt(len(values)), 11, 61))
    beyond = int((np.abs(values) > reach).sum())
    axes.hist(np.clip(values, -reach, reach), bins=bins, range=(-reach, reach), density=True,
              color=BLUE, alpha=0.45)  # fmt: skip
    x = np.linspace(-reach, reach, 201)
    axes.plot(x, np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi), color=GREY, label="normal")
    axes.set_xlabel("residual / sigma")
    axes.set_yticks([])
    text = f"{beyond} beyond {reach:g}" if beyond else ""
    robust = np.abs(one.weight - 1).max(initial=0.0) > 1e-6
    if robust:
        size = np.sqrt((one.whitened**2).sum(axis=1))
        order = np.argsort(size)
        order = order[:: max(1, -(-len(order) // 400))]
        other = axes.twinx()
        other.plot(size[order], one.weight[order], ".-", color=ORANGE, markersize=3, linewidth=1)
        other.set_ylim(0, 1.05)
        other.set_ylabel("weight", color=ORANGE)
        low = int((one.weight < 0.5).sum())
        text = ", ".join(t for t in (text, f"{low} of {len(size)} have weight below 0.5") if t)
    axes.set_xlim(-reach, reach)
    axes.set_title(text, color=INK)
