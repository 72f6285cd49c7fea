"""Figures of docs/constraints.md: a path around obstacles with multipliers, an arm on a curve.

Run ``python docs/figures/constraints.py`` in a checkout.
"""

from __future__ import annotations

import runpy
from pathlib import Path

import matplotlib.pyplot as plt

import arael
from benchmarks.constrained import path as around

EXAMPLE = Path(__file__).parents[2] / "examples" / "arm_on_curve" / "arm_on_curve.py"


def arm() -> None:
    """Solve the example and draw it."""
    example = runpy.run_path(str(EXAMPLE))
    model = example["problem"](interpret=True)
    example["plot"](model, model.solve(), Path(__file__).with_name("constraints_arm.png"))


def main() -> None:
    """Solve the path of the benchmark and draw it."""
    model = around.build(arael.loads(around.TEXT, name="path", interpret=True), 60)
    begin = model.knots.p.value.copy()
    result = model.solve()
    points = model.knots.p.value
    multipliers = result.multipliers["Near.clear"].reshape(60, -1).sum(axis=1)
    figure, axes = plt.subplots(figsize=(7, 2.6), layout="constrained")
    for centre, radius in around.OBSTACLES:
        axes.add_patch(plt.Circle(centre, radius, color="0.85"))
    axes.plot(*begin.T, "--", color="0.6", linewidth=1, label="start")
    axes.plot(*points.T, linewidth=2, label="solution")
    acts = multipliers > 0
    axes.scatter(
        *points[acts].T, s=6 * multipliers[acts] ** 0.5, color="C3", zorder=3,
        label="a clearance acts; area by its multiplier",
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.legend(loc="lower left", fontsize=8, frameon=False)
    plt.rcParams["svg.hashsalt"] = "arael"
    figure.savefig(Path(__file__).with_name("constraints.svg"), metadata={"Date": None})


if __name__ == "__main__":
    main()
    arm()
