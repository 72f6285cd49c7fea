"""What `optimize = False` excludes from solves is fixed in a file: it is the same problem."""

from __future__ import annotations

from pathlib import Path

import pytest

import arael

TEXT = """
struct P { param x: real = 0 }
root R {
    param a: real = 5
    ps: list of P
    fit ps as p { [p.x - 1, root.a - p.x] }
}
"""


@pytest.mark.parametrize("ending", ["json", "npz"])
def test_another_process_solves_the_same_problem(tmp_path: Path, ending: str) -> None:
    kind = arael.loads(TEXT, interpret=True)
    model = kind()
    model.ps.extend(x=[0.0, 0.0])
    model.a.optimize = False
    model.ps[1].x.optimize = False
    model.write(tmp_path / f"data.{ending}")
    again = kind()
    again.read(tmp_path / f"data.{ending}")
    model.solve()
    again.solve()
    assert float(again.a) == 5
    assert again.ps.x.value.tolist() == pytest.approx([3.0, 0.0])
    assert model.ps.x.value.tolist() == pytest.approx([3.0, 0.0])
