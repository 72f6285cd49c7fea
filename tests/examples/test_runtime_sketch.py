"""The sketch with dimensions as formulas, against the formulas worked out by hand."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from tests.optional import needs

DEMO = Path(__file__).parents[2] / "examples" / "runtime_sketch" / "runtime_sketch.py"


@needs("matplotlib")
def test_runtime_sketch(tmp_path: Path) -> None:
    picture = tmp_path / "sketch.png"
    found = runpy.run_path(str(DEMO))["main"](["--plot", str(picture)])
    expected = []
    for d0, d1 in ((40, 20), (60, 30), (60, 25)):
        expected.append({"width": d0, "height": d1, "hole": min(d0, d1) / 4 + 3})
    assert len(found) == len(expected)
    for now, right in zip(found, expected, strict=True):
        # The sketch's own points pull with a weight of 1e-4.
        assert now == pytest.approx(right, abs=1e-5)
    assert picture.stat().st_size > 1000
