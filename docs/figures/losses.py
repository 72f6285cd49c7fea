"""Figures of docs/robust.md: each robust loss with its weight.

Run ``python docs/figures/losses.py``.

Losses are functions of the squared residual; they are drawn over the residual of one instance, at
scale 1.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

Array = Any

# rho(s) and its slope rho'(s), the weight, at scale 1; in the order of the page.
LOSSES: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {
    "huber": (
        lambda s: np.where(s <= 1, s, 2 * np.sqrt(s) - 1),
        lambda s: 1 / np.sqrt(np.maximum(s, 1)),
    ),
    "soft_l1": (lambda s: 2 * (np.sqrt(1 + s) - 1), lambda s: 1 / np.sqrt(1 + s)),
    "fair": (
        lambda s: 2 * (np.sqrt(s) - np.log1p(np.sqrt(s))),
        lambda s: 1 / (1 + np.sqrt(s)),
    ),
    "cauchy": (np.log1p, lambda s: 1 / (1 + s)),
    "geman_mcclure": (lambda s: s / (1 + s), lambda s: 1 / (1 + s) ** 2),
    "dcs": (
        lambda s: np.where(s <= 1, s, (3 * s - 1) / (s + 1)),
        lambda s: np.minimum(1, 2 / (1 + s)) ** 2,
    ),
    "welsch": (lambda s: -np.expm1(-s), lambda s: np.exp(-s)),
    "tukey": (
        lambda s: (1 - np.maximum(1 - s, 0) ** 3) / 3,
        lambda s: np.maximum(1 - s, 0) ** 2,
    ),
}
COLOURS = plt.get_cmap("tab10").colors
GREY = "0.6"


def one(name: str, folder: Path) -> None:
    """Draw one loss: its cost and its weight beside those of least squares."""
    rho, slope = LOSSES[name]
    r = np.linspace(-5, 5, 201)
    figure, (left, right) = plt.subplots(1, 2, figsize=(5.2, 1.9), layout="constrained")
    left.plot(r, r**2, color=GREY, linestyle="--", linewidth=1)
    left.plot(r, rho(r**2), linewidth=2)
    left.set(title=f"{name}: cost", ylim=(0, 8), xlabel="residual / scale")
    right.plot(r, np.ones_like(r), color=GREY, linestyle="--", linewidth=1)
    right.plot(r, slope(r**2), linewidth=2)
    right.set(title="weight", ylim=(0, 1.1), xlabel="residual / scale")
    save(figure, folder / f"loss_{name}.svg")


def together(folder: Path) -> None:
    """Draw all losses in one figure."""
    r = np.linspace(0, 5, 151)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
    left.plot(r, r**2, color=GREY, linestyle="--", linewidth=1, label="least squares")
    for colour, (name, (rho, slope)) in zip(COLOURS, LOSSES.items(), strict=False):
        left.plot(r, rho(r**2), color=colour, label=name)
        right.plot(r, slope(r**2), color=colour, label=name)
    left.set(title="cost", ylim=(0, 8), xlabel="residual / scale")
    right.set(title="weight", ylim=(0, 1.05), xlabel="residual / scale")
    right.legend(fontsize=8, frameon=False)
    save(figure, folder / "losses.svg")


def save(figure: Any, path: Path) -> None:
    """Write `figure` without a date, so that an unchanged figure is an unchanged file."""
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8)
        axes.title.set_fontsize(10)
        axes.xaxis.label.set_fontsize(8)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    plt.rcParams.update({"svg.hashsalt": "arael", "svg.fonttype": "none"})
    here = Path(__file__).parent
    for loss in LOSSES:
        one(loss, here)
    together(here)
