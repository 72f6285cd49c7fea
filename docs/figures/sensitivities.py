"""Figure of docs/sensitivities.md: a curve, and what decides its parameter.

Run ``python docs/figures/sensitivities.py``.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import arael

MODEL = """
struct Point { x: real
    y: real
    constraint fit { (root.v * x / (root.k + x) - y) / 0.1 } }
root Rate { param v: real = 3
    param k: real = 2
    points: list of Point }
"""
X = np.array([0.5, 1.0, 2.0, 3.0, 5.0, 8.0])
Y = np.array([0.97, 1.58, 2.36, 2.98, 3.52, 3.91])


def solved() -> tuple[Any, Any]:
    """The model of the page, solved, and its result."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rate.arael"
        path.write_text(MODEL, encoding="utf-8")
        rate = arael.load(path, interpret=True)()
    rate.points.extend(x=X, y=Y)
    return rate, rate.solve()


def main() -> None:
    """Draw the curve, its points by their share of the variance of k, and dk/dy at each."""
    rate, result = solved()
    share = result.influence("k").share
    slope = np.asarray(result.sensitivity("k", "points.y"))
    figure, (left, right) = plt.subplots(1, 2, figsize=(7, 2.6), layout="constrained")
    x = np.linspace(0, 8.5, 200)
    left.plot(x, rate.v.value * x / (rate.k.value + x), color="0.6")
    left.scatter(X, Y, s=20 + 500 * share, alpha=0.7)
    left.set(title="share of the variance of k", xlabel="x", ylabel="y")
    right.axhline(0, color="0.6", linewidth=1)
    right.bar(X, slope, width=0.35)
    right.set(title="dk/dy of each point", xlabel="x")
    figure.savefig(Path(__file__).with_name("sensitivities.png"), dpi=110)


if __name__ == "__main__":
    main()
