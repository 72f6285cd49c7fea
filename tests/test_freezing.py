"""Passes that freeze a whole and free a part of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import arael
from arael.runtime.layout import LayoutPass

MODEL = """
struct P { param x: real; param y: real; constraint c { [x - 1, y - 2] } }
root R { ps: list of P }
"""


@pytest.mark.parametrize(
    ("passes", "expected"),
    [
        ([LayoutPass("a", freeze=("ps",), free=("ps.x",))], [1, 0]),
        (
            [LayoutPass("a", freeze=("ps.x",)), LayoutPass("b", freeze=("ps",), free=("ps.x",))],
            [1, 2],
        ),
        ([LayoutPass("a", freeze=("ps.y",))], [1, 0]),
    ],
)
def test_parts(tmp_path: Path, passes: list[LayoutPass], expected: list[float]) -> None:
    path = tmp_path / "m.arael"
    path.write_text(MODEL)
    model = arael.load(path, interpret=True)(ps=[{"x": 0.0, "y": 0.0}])
    model.solve(passes=passes)
    assert [model.ps.x.value[0], model.ps.y.value[0]] == pytest.approx(expected, abs=1e-6)
