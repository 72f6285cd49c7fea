"""An optional scalar from the text to the solution: presence and value are two things."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import arael

MODEL = """
struct P {
    param x: real
    h: real?
    constraint seen when h { x - h }
    constraint prior { 1e-3 * x }
}
root R { ps: list of P }
"""


def test_value_is_read_where_it_is_there(tmp_path: Path) -> None:
    path = tmp_path / "heights.arael"
    path.write_text(MODEL)
    model = arael.load(path, interpret=True)()
    for fields in ({"h": 5.0}, {}, {"h": 7.0}):
        model.ps.append(x=1.0, **fields)
    model.solve()
    expected = np.array([5.0, 0.0, 7.0]) / (1 + 1e-6)
    np.testing.assert_allclose(model.ps.x.value, expected, atol=1e-6)
