"""The picture at the top of the README: a pose graph before and after, and the sketch editor.

Run ``python docs/figures/front.py``; `ARAEL_DATA` names the folder of ``pose_graph_2d/M3500.g2o``.
"""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import arael
from arael.plot.map import map_figure, map_of

HERE = Path(__file__).parent
HEIGHT = 430
COLORS = 96


def picture(figure: Figure, width: float) -> Image.Image:
    """A figure of `width` inches at the common height."""
    figure.set_size_inches(width, HEIGHT / 100)
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=100)
    return Image.open(buffer).convert("RGB")


def drawn(model: arael.Model, title: str, subtitle: str) -> Figure:
    """The map of a pose graph, without the number of its poses."""
    found = map_of(model, type(model).layout, uncertain=bool(subtitle))
    figure = map_figure(found, title, subtitle)
    for line in figure.axes[0].lines:
        line.set_markersize(min(line.get_markersize(), 2.0))
    figure.suptitle(f"{title}\n{subtitle}", x=0.01, ha="left", fontsize=11)
    return figure


def main() -> None:
    """Write ``front.png``."""
    data = Path(os.environ.get("ARAEL_DATA", HERE.parents[2] / "shared" / "data"))
    graph = arael.load("pose_graph_2d")()
    arael.read(graph, data / "pose_graph_2d" / "M3500.g2o")
    before = drawn(graph, "M3500.g2o: start in the file", "")
    arael.initialise(graph)
    result = graph.solve()
    after = drawn(graph, "arael solve M3500.g2o --plot", f"solved in {result.iterations} steps")
    editor = Image.open(HERE / "sketch" / "defined.png").convert("RGB")
    editor = editor.resize((round(editor.width * HEIGHT / editor.height), HEIGHT))
    parts = [picture(before, 4.4), picture(after, 5.4), editor]
    row = Image.new("RGB", (sum(p.width for p in parts) + 20, HEIGHT), "white")
    for part, left in zip(parts, np.cumsum([0, parts[0].width, parts[1].width + 20]), strict=True):
        row.paste(part, (int(left), 0))
    row.quantize(COLORS, dither=Image.Dither.NONE).save(HERE / "front.png", optimize=True)


if __name__ == "__main__":
    main()
