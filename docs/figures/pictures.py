"""Pictures of docs/pictures.md: a map and residuals, as `Model.plot` draws them.

Run ``python docs/figures/pictures.py``; `ARAEL_DATA` names the folder of public data.
"""

from __future__ import annotations

import io
import os
from pathlib import Path

from PIL import Image

import arael

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
WIDTH, COLORS = 720, 64


def keep(figure: object, name: str) -> None:
    """Write a figure, reduced to the width of a page."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=150)  # type: ignore[attr-defined]
    picture = Image.open(buffer).convert("RGB")
    size = (WIDTH, round(picture.height * WIDTH / picture.width))
    small = picture.resize(size, Image.Resampling.LANCZOS)
    small.quantize(COLORS, dither=Image.Dither.NONE).save(HERE / name, optimize=True)


def main() -> None:
    """Write ``map.png`` and ``residuals.png``."""
    data = Path(os.environ.get("ARAEL_DATA", ROOT.parent / "shared" / "data"))
    graph = arael.load("pose_graph_3d")()
    arael.read(graph, data / "pose_graph_3d" / "parking-garage.g2o")
    arael.initialise(graph)
    graph.solve()
    keep(graph.plot("map"), "map.png")
    slam = arael.load(ROOT / "examples" / "range_slam" / "range_slam.arael")()
    arael.read(slam, ROOT / "docs" / "notebooks" / "data" / "range_slam.npz")
    slam.solve()
    keep(slam.plot("residuals"), "residuals.png")


if __name__ == "__main__":
    main()
