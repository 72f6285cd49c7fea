"""Pictures of docs/gallery.md: those of the examples, reduced to the width of a page.

Run ``python docs/figures/gallery.py`` after the picture of an example was drawn again. The examples
draw theirs themselves: ``python examples/slam_demo/slam_demo.py --plot FILE``.
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"
WIDTH = 640
COLORS = 64


def reduce_all() -> None:
    """Write a picture of at most `WIDTH` pixels for each of an example."""
    for path in sorted(EXAMPLES.glob("*/*.png")):
        picture = Image.open(path).convert("RGB")
        if picture.width > WIDTH:
            height = round(picture.height * WIDTH / picture.width)
            picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
        small = picture.quantize(COLORS, dither=Image.Dither.NONE)
        small.save(HERE / "gallery" / path.name, optimize=True)


if __name__ == "__main__":
    reduce_all()
