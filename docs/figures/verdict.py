"""Figure of docs/verdict.md: uncertainty of projection of a camera, well and poorly calibrated.

Run ``python docs/figures/verdict.py``.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from arael.plot.figure import save
from arael.plot.projection import projection_figure

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "examples" / "camera_calibration"))

from camera_calibration import SIZE, Pictures, problem, simulate  # noqa: E402


def middle(pictures: Pictures, part: float) -> Pictures:
    """The corners in the middle of the pictures, of views that have at least twelve of them."""
    inside = (np.abs(pictures.pixel - SIZE / 2) < SIZE / 2 * part).all(axis=1)
    good = np.bincount(pictures.view[inside], minlength=pictures.views) >= 12
    kept = inside & good[pictures.view]
    view = (np.cumsum(good) - 1)[pictures.view[kept]]
    return Pictures(
        pictures.camera[kept], view, pictures.on[kept], pictures.pixel[kept], int(good.sum())
    )


def main() -> None:
    """Draw the narrow camera of the example, with all corners and with those in the middle."""
    pictures = simulate()
    found: list[Any] = []
    for title, used in (("all corners", pictures), ("the middle", middle(pictures, 0.5))):
        rig = problem(used)
        rig.solve(rel_precision=1e-9)
        width, height = SIZE
        first = rig.projection_uncertainty((float(width), float(height)))[0]
        found.append(replace(first, camera=f"{first.camera}, {title}"))
    print("wrote", save(projection_figure(found), HERE / "verdict.png"))


if __name__ == "__main__":
    main()
