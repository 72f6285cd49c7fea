"""What runtime residuals do: parameters, expressions, data, changes, removal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

import arael
from arael.analysis.gradients import check_gradients
from arael.diagnostics.records import AraelError

X = np.linspace(0, 5, 73)
Y = 2.5 * np.exp(-0.7 * X) + 0.3 + 0.02 * np.sin(9 * X)
TIGHT = {"abs_precision": 1e-14, "rel_precision": 1e-12}


def decay(**more: Any) -> arael.Model:
    return arael.runtime_model(
        arael.runtime_residual(
            "a * exp(-b * x) + c - y",
            label="decay",
            parameters={"a": 1, "b": 0.3, "c": 0},
            data={"x": X, "y": Y},
        ),
        **more,
    )


def test_fit_without_a_model_file() -> None:
    model = decay()
    result = model.solve(**TIGHT)
    oracle = least_squares(lambda p: p[0] * np.exp(-p[1] * X) + p[2] - Y, [1, 0.3, 0], xtol=1e-15)
    np.testing.assert_allclose(list(model.residuals.parameters.values()), oracle.x, rtol=1e-7)
    assert result.end_cost == pytest.approx(2 * oracle.cost, rel=1e-10)
    covariance = model.covariance()
    np.testing.assert_allclose(covariance.matrix, np.linalg.inv(oracle.jac.T @ oracle.jac), 1e-5)
    assert model.parameter_names() == ["a", "b", "c"]
    assert covariance.marginal("b").shape == (1, 1)


def test_single_precision() -> None:
    model = decay(precision="f32")
    model.solve()
    np.testing.assert_allclose(list(model.residuals.parameters.values()), [2.5, 0.7, 0.3], rtol=0.1)
    assert model._problem().evaluation.dtype == np.float32


def test_robust_loss_in_the_formula() -> None:
    y = Y.copy()
    y[::9] += 5
    model = decay()
    fit = model.residuals["decay"]
    fit.set_data(y=y)
    model.solve(**TIGHT)
    plain = abs(fit.parameters["c"] - 0.3)
    fit.text = "starship((a * exp(-b * x) + c - y) / 0.05, starship_gamma(9))"
    model.solve(**TIGHT, max_iters=300)
    assert abs(fit.parameters["c"] - 0.3) < 0.02 < plain


def test_bounds_fixed_and_vectors() -> None:
    model = arael.runtime_model()
    fit = model.residuals.add(
        "[p.x + q * x - y, p.y - 2, norm2(p) * 1e-3]",
        label="line",
        parameters={"p": [0.0, 0.0], "q": {"value": 0.5, "low": 0, "high": 1}},
        data={"x": [0, 1, 2], "y": [1, 3, 5]},
    )
    assert model.parameter_names() == ["p.x", "p.y", "q"]
    model.solve(**TIGHT)
    assert fit.parameters["q"] == 1
    fit.parameters["q"] = 0.25
    fit.parameters.fix("q")
    assert fit.parameters.is_fixed("q")
    model.solve(**TIGHT)
    assert fit.parameters["q"] == 0.25
    assert "q" not in model.covariance().names
    fit.parameters.free("q")
    held = fit.parameters["p"]
    model.solve(**TIGHT, freeze="residuals/line.p")
    assert (fit.parameters["p"] == held).all()
    assert fit.parameters["q"] == pytest.approx((3 - held[0] + 2 * (5 - held[0])) / 5)


def test_parameters_of_other_residuals_are_visible() -> None:
    model = decay()
    model.residuals.add("(c - 1) * 100", label="prior")
    model.solve(**TIGHT)
    assert model.residuals.parameters["c"] == pytest.approx(1, abs=0.01)
    assert set(model.cost_table()) == {"decay", "prior"}
    with pytest.raises(AraelError):
        model.residuals.remove("decay")
    model.residuals.remove("prior")
    model.solve(**TIGHT)
    assert model.residuals.parameters["c"] == pytest.approx(0.3, abs=0.01)
    model.residuals.remove("decay")
    assert model.parameter_names() == []
    assert len(model.residuals) == 0


def test_named_expressions_follow_their_changes() -> None:
    model = arael.runtime_model()
    model.residuals.define("d0", "width", data={"width": 4})
    d1 = model.residuals.define("d1", "d0 * 2 + 3")
    model.residuals.add("[p - d1, q - p / d0]", label="dims", parameters={"p": 0, "q": 0})
    model.solve(**TIGHT)
    assert model.residuals.parameters == pytest.approx({"p": 11, "q": 2.75})
    model.residuals.definitions["d0"].set_data(width=5)
    model.solve(**TIGHT)
    assert model.residuals.parameters == pytest.approx({"p": 13, "q": 2.6})
    d1.text = "d0"
    model.solve(**TIGHT)
    assert model.residuals.parameters == pytest.approx({"p": 5, "q": 1})
    value = model.residuals.value("d1")
    assert isinstance(value, float)
    assert value == pytest.approx(5.0)
    with pytest.raises(AraelError):
        model.residuals.remove("d0")


def test_functions_given_by_the_caller() -> None:
    model = arael.runtime_model()
    model.residuals.functions("const k = 2\nfn line(x, a, b) = k * a * x + b")
    model.residuals.add(
        "line(x, a, b) - y",
        label="line",
        parameters={"a": 0, "b": 0},
        data={"x": [0, 1, 2], "y": [1, 5, 9]},
    )
    model.solve(**TIGHT)
    assert model.residuals.parameters == pytest.approx({"a": 2, "b": 1})


MODEL = """
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
    model.points.extend(pos=[[0, 0], [3.2, 0.1], [2.9, 4.1]])
    return model


def test_dimensions_of_a_sketch(sketch: Any) -> None:
    a, b, c = sketch.points
    add = sketch.residuals.add
    add("a.pos", label="origin", entities={"a": a})
    add("points[1].pos.y", label="horizontal")
    width = add("norm(b.pos - a.pos) - w", label="width", entities={"a": a, "b": b}, data={"w": 3})
    add("norm(c.pos - b.pos) - 4", label="height", entities={"b": b, "c": c})
    add("dot(b.pos - a.pos, c.pos - b.pos)", label="square", entities={"a": a, "b": b, "c": c})
    sketch.solve(**TIGHT)
    np.testing.assert_allclose(sketch.points.pos.value, [[0, 0], [3, 0], [3, 4]], atol=1e-4)
    width.set_data(w=6)
    sketch.solve(**TIGHT)
    np.testing.assert_allclose(sketch.points.pos.value, [[0, 0], [6, 0], [6, 4]], atol=1e-4)
    for check in check_gradients(sketch._problem()):
        assert check.agrees, check


def test_rows_are_followed_where_they_move(sketch: Any, tmp_path: Path) -> None:
    path = tmp_path / "arena.arael"
    path.write_text(MODEL.replace("list of", "arena of"), encoding="utf-8")
    model = arael.load(path, interpret=True)()
    model.points.extend(pos=[[0, 0], [3, 0], [2, 4]])
    last = model.points[2]
    model.residuals.add("points[2].pos - [7, 8]", label="goal")
    model.solve(**TIGHT)
    model.points.remove(model.points[0])
    last.pos.value = [0, 0]
    model.solve(**TIGHT)
    np.testing.assert_allclose(last.pos.value, [7, 8], atol=1e-4)


def test_a_residual_goes_from_one_model_to_another() -> None:
    first, second = arael.runtime_model(), arael.runtime_model()
    fit = first.residuals.add("a - 3", label="goal", parameters={"a": 0})
    with pytest.raises(AraelError):
        second.residuals.add(fit)
    first.residuals.clear()
    second.residuals.add(fit)
    second.solve(**TIGHT)
    assert fit.parameters["a"] == pytest.approx(3)
    assert fit.cost == pytest.approx(0, abs=1e-12)


def test_data_of_another_length(sketch: Any) -> None:
    model = decay()
    fit = model.residuals["decay"]
    model.solve(**TIGHT)
    with pytest.raises(AraelError):
        fit.set_data(x=X[:10])
    fit.set_data(x=X[:30], y=Y[:30])
    assert fit.residuals.shape == (30, 1)
    fit.set_data(x=np.zeros(0), y=np.zeros(0))
    assert model.cost() == 0


@pytest.mark.parametrize(
    "text",
    [
        "(" * 5000,
        "x" * 30_000,
        "+".join(["a"] * 400),
        "a" + "^2" * 300,
        "-" * 3000 + "a",
        "q" + ".conj().vec.exp()" * 60,
        "__import__('os').system('true')",
        "a.__class__.__base__",
        'root["x"]',
        "a\x00b",
        "",
        "a; b",
        "let b = 2",
        "f'{a}'",
        "1e400 * a",
        "a if a else a",
        "lambda: a",
        "[]",
        "exp(" * 63 + "a" + ")" * 63,
    ],
)
def test_hostile_texts(text: str) -> None:
    model = arael.runtime_model()
    try:
        model.residuals.add(text, label="bad", parameters={"a": 1})
    except AraelError as error:
        assert all(d.code[0] == "E" for d in error.diagnostics)
        assert len(model.residuals) == 0
    else:
        model.cost()
