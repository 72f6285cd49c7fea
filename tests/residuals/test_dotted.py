"""Expressions with dotted names, and what `value` gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

MODEL = """
const CORNER = 3

struct Point {
    param pos: vec2
    constraint keep { (pos - pos.value) * 1e-3 }
}
root Sketch {
    points: list of Point
}
"""


@pytest.fixture
def sketch(tmp_path: Path) -> Any:
    path = tmp_path / "sketch.arael"
    path.write_text(MODEL, encoding="utf-8")
    model = arael.load(path, interpret=True)()
    a = model.points.append(pos=[1, 1])
    b = model.points.append(pos=[4, 5])
    ends = {"a": a, "b": b}
    model.residuals.define("L0.length", "k * norm(b.pos - a.pos)", entities=ends, data={"k": 1})
    model.residuals.define("L0.middle", "(a.pos + b.pos) / 2", entities=ends)
    return model


def test_a_dotted_name_is_read_as_it_is_written(sketch: Any) -> None:
    residuals = sketch.residuals
    residuals.define("d1", "2 * L0.length + L0.middle.x")
    assert residuals.value("d1") == pytest.approx(12.5)
    residuals.add("L0.length - 8", label="dim")
    for check in sketch.check_gradients():
        assert check.difference < 1e-6
    sketch.solve(rel_precision=1e-12)
    a, b = sketch.points.pos.value
    assert np.hypot(*(b - a)) == pytest.approx(8, abs=1e-4)
    residuals.compile()
    residuals.definitions["L0.length"].set_data(k=2)
    sketch.solve(rel_precision=1e-12)
    a, b = sketch.points.pos.value
    assert np.hypot(*(b - a)) == pytest.approx(4, abs=1e-4)
    residuals.definitions["L0.length"].text = "k * (b.pos.x - a.pos.x)"
    sketch.solve(rel_precision=1e-12)
    a, b = sketch.points.pos.value
    assert b[0] - a[0] == pytest.approx(4, abs=1e-4)


def test_values_have_the_shape_of_what_they_are(sketch: Any) -> None:
    residuals = sketch.residuals
    residuals.define("scaled", "L0.length * x", data={"x": [1, 2, 3]})
    residuals.define("moved", "L0.middle + x", data={"x": [[0, 0], [1, 2], [0, 1]]})
    length = residuals.value("L0.length")
    assert isinstance(length, float)
    assert length == pytest.approx(5)
    assert residuals.value("L0.middle") == pytest.approx(np.array([2.5, 3]))
    assert residuals.value("scaled") == pytest.approx(np.array([5, 10, 15]))
    assert residuals.value("moved") == pytest.approx(np.array([[2.5, 3], [3.5, 5], [2.5, 4]]))


def test_what_a_formula_brings_along_shadows_dotted_names(sketch: Any) -> None:
    sketch.residuals.define("other", "L0.pos.x", entities={"L0": sketch.points[1]})
    assert sketch.residuals.value("other") == pytest.approx(4)


def test_a_dotted_name_is_taken_out_again(sketch: Any) -> None:
    sketch.residuals.add("L0.length - 8", label="dim")
    with pytest.raises(AraelError, match="is used by `dim`"):
        sketch.residuals.remove("L0.length")
    sketch.residuals.remove("dim")
    sketch.residuals.remove("L0.length")
    assert list(sketch.residuals.definitions) == ["L0.middle"]
    with pytest.raises(AraelError, match=r"unknown name `L0\.length`"):
        sketch.residuals.add("L0.length - 8", label="dim")


@pytest.mark.parametrize(
    "name",
    ["points.count", "CORNER.x", "L0", "L0.middle.x", "root.x", "L0.", ".x", "L0.1", "L0.let",
     "sin.x", "L0 .x", "L0." + "x" * 99],
)  # fmt: skip
def test_names_that_are_refused_leave_nothing(sketch: Any, name: str) -> None:
    with pytest.raises(AraelError) as caught:
        sketch.residuals.define(name, "1")
    assert [d.code for d in caught.value.diagnostics] == ["E0760"]
    assert list(sketch.residuals.definitions) == ["L0.length", "L0.middle"]
