"""The font of the page is that of the package."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path

import pytest

import arael.sketch
from arael.sketch.geometry import Circle
from arael.sketch.text import GLYPHS, box_of, lettering, width_of
from arael.sketch.text.module import source
from tests import optional

PAGE = Path(arael.sketch.__file__).parent / "page" / "geometry" / "font.js"


def test_the_font_of_the_page_is_that_of_the_package(update: bool) -> None:
    made = source()
    if update:
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "run pytest --update"


SCRIPT = """
import { boxOfText, isInText, traceText, widthOf } from "%s";
const texts = JSON.parse(process.argv[1]);
const found = texts.map((text) => {
  const steps = [];
  const pen = {
    moveTo: (x, y) => steps.push([x, y]),
    lineTo: (x, y) => steps.push([x, y]),
    arc: (cx, cy, r, from, to, back) => {
      steps.push([cx + r * Math.cos(to), cy + r * Math.sin(to)]);
      if (back !== to < from) throw new Error("an arc runs the other way");
    },
  };
  traceText(pen, text, [3, -1], [40, -30]);
  return [widthOf(text), boxOfText(text, [3, 1], [40, 30]), steps,
    isInText(text, [3, 1], [40, 30], [3.1, 1.1]),
    isInText(text, [3, 1], [40, 30], [42, 30])];
});
console.log(JSON.stringify(found));
"""


def test_the_page_letters_as_the_package_does() -> None:
    node = optional.program("node")
    texts = ["Ø8 ±0.1", "quick (brown) {fox} @ 50%?", "→ ש", "MRBS&8", "".join(GLYPHS)]
    script = SCRIPT % (PAGE.parent / "lettering.js").as_uri()
    done = subprocess.run(
        [node, "--input-type=module", "-e", script, "--", json.dumps(texts)],
        capture_output=True, text=True, encoding="utf-8", timeout=60, check=True,
    )  # fmt: skip
    a, b = (3.0, 1.0), (40.0, 30.0)
    for text, (width, box, steps, inside, outside) in zip(
        texts, json.loads(done.stdout), strict=True
    ):
        assert width == pytest.approx(width_of(text))
        for p, q in zip(box, box_of(text, a, b), strict=True):
            assert p == pytest.approx(q)
        mine = []
        for stroke in lettering(text, a, b):
            first = stroke[0]
            if isinstance(first, Circle):
                x, y = b[0] - a[0], b[1] - a[1]
                far = first.radius / math.hypot(x, y)
                mine += [
                    (first.center[0] + k * far * x, first.center[1] + k * far * y)
                    for k in (1, -1, 1)
                ]
                continue
            mine += [first.start, *(piece.end for piece in stroke)]
        # the canvas points down
        assert [[x, -y] for x, y in steps] == [pytest.approx(p, abs=1e-9) for p in mine]
        assert inside and not outside
