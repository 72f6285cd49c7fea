"""Pictures of a report, as PNG files beside it; without matplotlib there are none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.systems import Measured

COLOURS = {
    "arael": "#1b6ca8",
    "rust": "#c1502e",
    "gtsam": "#7a9e3f",
    "ceres": "#8d6cab",
    "g2o": "#8c8c8c",
}


def bars(path: Path, suite: str, measured: Sequence[Measured]) -> bool:
    """Time per iteration of all systems, a group of bars a problem; whether it was drawn."""
    pyplot = _pyplot()
    shown = [m for m in measured if m.threads == 1 and any(o.slopes for o in m.found.values())]
    if pyplot is None or not shown:
        return False
    names = [n for n in shown[0].found if any(m.found[n].slopes for m in shown)]
    figure, axes = pyplot.subplots(figsize=(1.6 + 1.7 * len(shown), 3.4), layout="constrained")
    width = 0.8 / len(names)
    for k, name in enumerate(names):
        places = [i + (k - (len(names) - 1) / 2) * width for i in range(len(shown))]
        heights = [1e3 * m.found[name].median for m in shown]
        heights = [h if math.isfinite(h) and h > 0 else math.nan for h in heights]
        axes.bar(places, heights, 0.92 * width, label=name, color=COLOURS.get(name))
    labels = [m.case.name.replace(", ", "\n") for m in shown]
    axes.set_xticks(range(len(shown)), labels, fontsize=8)
    axes.set_yscale("log")
    axes.set_ylabel("ms per iteration")
    axes.set_title(suite, loc="left")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")
    figure.legend(loc="outside upper right", frameon=False, fontsize=8, ncols=len(names))
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return True


def lines(
    path: Path, title: str, across: str, up: str, found: Mapping[str, Sequence[tuple[float, float]]]
) -> bool:
    """Lines of points on two logarithmic axes; whether they were drawn."""
    pyplot = _pyplot()
    if pyplot is None or not any(found.values()):
        return False
    figure, axes = pyplot.subplots(figsize=(5.2, 3.6), layout="constrained")
    for name, points in found.items():
        axes.plot(*zip(*points, strict=True), marker="o", markersize=4, label=name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, loc="left")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return True


def _pyplot() -> Any:
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot
