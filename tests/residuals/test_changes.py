"""Many small expressions, changed often: only what changed is done again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.residuals import collection

MODEL = """
struct Point {
    param pos: vec2
    constraint keep { (pos - pos.value) * 1e-3 }
}
root Sketch {
    param size: real = 1
    grid: real = 0.5
    points: list of Point
    constraint near { (size - 1) * 0.01 }
}
"""
COUNT = 30


@pytest.fixture
def sketch(tmp_path: Path) -> Any:
    path = tmp_path / "sketch.arael"
    path.write_text(MODEL, encoding="utf-8")
    model = arael.load(path, interpret=True)()
    model.points.extend(pos=np.stack([np.arange(COUNT + 1.0), np.zeros(COUNT + 1)], axis=1))
    model.residuals.define("module", "w", data={"w": 1})
    for k in range(COUNT):
        text = f"norm(points[{k + 1}].pos - points[{k}].pos) - w{' * module' * (k % 10 == 3)}"
        model.residuals.add(text, label=f"d{k}", data={"w": 1.0})
    model.solve()
    return model


@pytest.fixture
def derived(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Labels of the residuals that are derived from here on."""
    found: list[str] = []
    derive = collection.derive

    def noted(residual: Any, *args: Any, **more: Any) -> Any:
        found.append(residual.label)
        return derive(residual, *args, **more)

    monkeypatch.setattr(collection, "derive", noted)
    return found


def since(model: Any, done: Any) -> tuple[int, int, int]:
    """Problems, analyses and gathered groups of the solve after a change."""
    counts = model.session.counts
    before = counts.problems, counts.analyses, counts.gathered
    done()
    model.solve()
    now = counts.problems, counts.analyses, counts.gathered
    return tuple(b - a for a, b in zip(before, now, strict=True))  # type: ignore[return-value]


def test_other_data_derive_and_analyse_nothing(sketch: Any, derived: list[str]) -> None:
    residuals = sketch.residuals
    assert since(sketch, lambda: residuals["d7"].set_data(w=1.5)) == (0, 0, 1)
    # Besides the three, `keep` reads the stored positions that the last solve has moved.
    assert since(sketch, lambda: residuals.definitions["module"].set_data(w=2)) == (0, 0, 4)
    assert derived == []
    lengths = np.linalg.norm(np.diff(sketch.points.pos.value, axis=0), axis=1)
    expected = np.where(np.arange(COUNT) % 10 == 3, 2.0, 1.0)
    expected[7] = 1.5
    np.testing.assert_allclose(lengths, expected, atol=1e-3)


def test_one_expression_among_many_is_derived_alone(sketch: Any, derived: list[str]) -> None:
    residuals = sketch.residuals
    found = since(sketch, lambda: setattr(residuals["d7"], "text", "points[8].pos.y - w"))
    assert derived == ["d7"]
    # Blocks are coupled by other residuals as before? No: d7 alone tied points 7 and 8.
    assert found[:2] == (1, 1)
    derived.clear()
    same = "norm2(points[10].pos - points[9].pos) - w"
    found = since(sketch, lambda: setattr(residuals["d9"], "text", same))
    assert derived == ["d9"]
    assert found[:2] == (1, 0)  # the same pattern, the same analysis
    assert found[2] == 3  # itself and the two constraints of the model
    derived.clear()
    found = since(sketch, lambda: residuals.add("points[4].pos.x - 4", label="pin"))
    assert (derived, found[:2]) == (["pin"], (1, 0))
    derived.clear()
    assert since(sketch, lambda: residuals.remove("pin"))[:2] == (1, 0)
    assert derived == []
    sketch.residuals.definitions["module"].text = "w * 1.25"
    assert derived == ["d3", "d13", "d23"]


def test_warm_is_what_a_fresh_model_is(sketch: Any, tmp_path: Path) -> None:
    sketch.residuals["d3"].set_data(w=1.5)
    sketch.residuals["d4"].text = "points[5].pos.y - points[4].pos.y - w / 4"
    sketch.residuals.remove("d20")
    start = sketch.points.pos.value.copy()
    fresh = arael.load(tmp_path / "sketch.arael", interpret=True)(size=sketch.size.value)
    fresh.points.extend(pos=start)
    fresh.residuals.define("module", "w", data={"w": 1})
    for label, one in sketch.residuals.items():
        fresh.residuals.add(one.text, label=label, data=one.data)
    sketch.solve()
    fresh.solve()
    np.testing.assert_array_equal(sketch.points.pos.value, fresh.points.pos.value)


def test_names_reach_the_model_and_other_expressions(sketch: Any) -> None:
    """Parameters, data and rows of the model; parameters and values of other expressions."""
    residuals = sketch.residuals
    residuals.clear()
    residuals.add("size - 3 * scale", label="a", parameters={"scale": 1.0})
    residuals.define("twice", "2 * scale")
    residuals.add("offset - twice - grid", label="b", parameters={"offset": 0.0})
    residuals.add("[points[2].pos.x - offset, root.size - 6]", label="c")
    sketch.solve(abs_precision=0, rel_precision=1e-14, max_iters=60)
    assert residuals.parameters["scale"] == pytest.approx(2, abs=1e-2)
    assert residuals.parameters["offset"] == pytest.approx(4.5, abs=2e-2)
    assert sketch.size.value == pytest.approx(6, abs=1e-2)
    assert sketch.points.pos.value[2, 0] == pytest.approx(4.5, abs=2e-2)
    assert residuals.value("twice") == pytest.approx(2 * residuals.parameters["scale"])
    assert {"size", "scale", "offset", "points[2].pos.x"} <= set(sketch.parameter_names())
    assert "a" not in sketch.parameter_names()
