"""Losses of runtime residuals: the same numbers everywhere as of a compiled constraint with one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.analysis.gradients import check_gradients
from arael.diagnostics.records import AraelError

MODEL = """
struct Point {
    x: real
    y: real
    c: real
    constraint near%s { [a * x + b - y, 0.3 * (a - b) * x] }
}
root Line {
    param a: real = 0.2
    param b: real = 0
    points: list of Point
}
"""
LOSSES = [
    "cauchy(c)",
    "huber(1.5)",
    "geman_mcclure(2)",
    "tukey(4)",
    "fair(c)",
    "dcs(2)",
    "|s| 2 * (sqrt(1 + s) - 1)",
    "|c| log(1 + c)",
]
X = np.linspace(-1, 3, 21)
Y = 1.5 * X - 0.4 + np.where(np.arange(21) % 5 == 2, 6.0, 0.01 * np.sin(7 * X))
C = 1 + 0.05 * np.arange(21)


def compiled(tmp_path: Any, loss: str, precision: Any) -> Any:
    path = tmp_path / "line.arael"
    clause = f" loss {loss}" if loss else ""
    path.write_text(MODEL.replace("a *", "root.a *").replace("a -", "root.a -").replace(
        "+ b", "+ root.b").replace("- b", "- root.b") % clause, encoding="utf-8")  # fmt: skip
    model = arael.load(path, precision=precision, interpret=True)()
    model.points.extend(x=X, y=Y, c=C)
    return model


def given(loss: str | None, precision: Any = "f64") -> Any:
    return arael.runtime_model(
        arael.runtime_residual(
            "[a * x + b - y, 0.3 * (a - b) * x]",
            label="near",
            parameters={"a": 0.2, "b": 0},
            data={"x": X, "y": Y, "c": C},
            loss=loss,
        ),
        precision=precision,
    )


@pytest.mark.sweep(3)
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("loss", ["", *LOSSES])
def test_like_a_compiled_constraint(tmp_path: Any, loss: str, precision: Any) -> None:
    expected, found = compiled(tmp_path, loss, precision), given(loss or None, precision)
    tolerance = 1e-12 if precision == "f64" else 2e-5
    assert found.cost() == pytest.approx(expected.cost(), rel=tolerance)
    for a, b in (
        (found.gradient(), expected.gradient()),
        (found.hessian(), expected.hessian()),
        (found.jacobian().dense(), expected.jacobian().dense()),
        (found.jacobian().residuals, expected.jacobian().residuals),
    ):
        np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * np.abs(b).max())
    assert found.cost_table()["near"] == pytest.approx(expected.cost_table()["Point.near"], 1e-5)
    if precision == "f64":
        for model in (expected, found):
            model.solve(abs_precision=0, rel_precision=1e-12)
        a = found.residuals.parameters
        np.testing.assert_allclose(
            [a["a"], a["b"]], [expected.a.value, expected.b.value], atol=1e-9
        )
        np.testing.assert_allclose(
            found.covariance().matrix, expected.covariance().matrix, rtol=1e-6
        )


@pytest.mark.parametrize("loss", LOSSES)
def test_everything_agrees_with_everything(loss: str) -> None:
    model = given(loss)
    rows = model.jacobian()
    assert (rows.residuals**2).sum() == pytest.approx(model.cost(), rel=1e-12)
    np.testing.assert_allclose(2 * rows.dense().T @ rows.dense(), model.hessian(), rtol=1e-12)
    np.testing.assert_allclose(2 * rows.dense().T @ rows.residuals, model.gradient(), rtol=1e-12)
    assert model.residuals["near"].cost == pytest.approx(model.cost(), rel=1e-12)
    for check in check_gradients(model._problem()):
        assert check.agrees, check
    plain = (given(None).residuals["near"].residuals ** 2).sum(axis=1)
    if loss == "cauchy(c)":
        assert model.cost() == pytest.approx((C**2 * np.log(1 + plain / C**2)).sum(), rel=1e-12)


def test_a_loss_is_exchanged_like_a_text() -> None:
    model = given(None)
    fit = model.residuals["near"]
    least = model.cost()
    fit.loss = "cauchy(c)"
    robust = model.cost()
    assert robust < least / 2
    fit.set_data(c=1e6)
    assert model.cost() == pytest.approx(least, rel=1e-6)
    fit.set_data(c=C)
    for wrong in ("cauchy(a)", "huber", "|s| s + 1", "tukey(0)", "b)", "andrews(1)", "", "1", 7):
        with pytest.raises(AraelError):
            fit.loss = wrong  # type: ignore[assignment]
        assert fit.loss == "cauchy(c)"
        assert model.cost() == robust
    fit.loss = None
    assert model.cost() == least


def test_its_argument_hides_what_bears_its_name() -> None:
    """`c` names a data column, a parameter `s` is solved for; behind `|c|`, `|s|` it is s."""
    model = arael.runtime_model(
        arael.runtime_residual("s - 3", parameters={"s": 0}, data={"c": 2}, loss="|s| log(1 + s)"),
    )
    assert model.cost() == pytest.approx(np.log(10))
    model.residuals["residual"].loss = "|c| log(1 + c)"
    assert model.cost() == pytest.approx(np.log(10))
    model.residuals["residual"].loss = "|s| c * log(1 + s)"
    assert model.cost() == pytest.approx(2 * np.log(10))
