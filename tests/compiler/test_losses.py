"""Losses: cost, gradient, Hessian, rows and covariance against the formulas of the literature."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael.analysis.gradients import check_gradients
from arael.check.losses import LOSSES as NAMES
from arael.loading import load
from arael.model import Model
from arael.runtime.problem import Problem
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

Rho = Callable[[Any], Any]

# Clause, loss and slope as papers give them, with scale C.
C = 1.7
LOSSES: dict[str, tuple[str, Rho, Rho]] = {
    "cauchy": ("cauchy(root.c)", lambda s: C**2 * np.log1p(s / C**2), lambda s: 1 / (1 + s / C**2)),
    "geman_mcclure": (
        "geman_mcclure(root.c)",
        lambda s: C**2 * s / (C**2 + s),
        lambda s: (C**2 / (C**2 + s)) ** 2,
    ),
    "huber": (
        "huber(1.7)",
        lambda s: np.where(s <= C**2, s, 2 * C * np.sqrt(s) - C**2),
        lambda s: np.minimum(1, C / np.sqrt(np.maximum(s, 1e-300))),
    ),
    "tukey": (
        "tukey(root.c)",
        lambda s: C**2 / 3 * (1 - np.maximum(0, 1 - s / C**2) ** 3),
        lambda s: np.maximum(0, 1 - s / C**2) ** 2,
    ),
    "soft_l1": (
        "soft_l1(root.c)",
        lambda s: 2 * s / (np.sqrt(1 + s / C**2) + 1),
        lambda s: 1 / np.sqrt(1 + s / C**2),
    ),
    "welsch": (
        "welsch(root.c)",
        lambda s: -(C**2) * np.expm1(-s / C**2),
        lambda s: np.exp(-s / C**2),
    ),
    "fair": (
        "fair(root.c)",
        lambda s: 2 * C**2 * (np.sqrt(s) / C - np.log1p(np.sqrt(s) / C)),
        lambda s: 1 / (1 + np.sqrt(s) / C),
    ),
    "dcs": (
        "dcs(root.c)",
        lambda s: np.where(s <= C**2, s, C**2 * (3 * s - C**2) / (s + C**2)),
        lambda s: np.minimum(1, 2 * C**2 / (s + C**2)) ** 2,
    ),
    "own cauchy": (
        "|s| root.c^2 * log(1 + s / root.c^2)",
        lambda s: C**2 * np.log1p(s / C**2),
        lambda s: 1 / (1 + s / C**2),
    ),
    "rounded absolute": (
        "|s| 2 * (sqrt(1 + s) - 1)",
        lambda s: 2 * s / (np.sqrt(1 + s) + 1),
        lambda s: 1 / np.sqrt(1 + s),
    ),
    "bounded, of a function": (
        "|t| capped(t, root.c)",
        lambda s: (C * np.arctan(np.sqrt(s) / C)) ** 2,
        lambda s: (
            C
            * np.arctan(np.sqrt(s) / C)
            / np.where(s > 0, np.sqrt(np.maximum(s, 1e-300)), 1)
            / (1 + s / C**2)
        ),
    ),
}


MODEL = """
fn capped(x, k) = (k * atan(sqrt(x) / k))^2

struct Point {
    p: vec2
    w: real
    constraint near when w > 0.1 loss CLAUSE {
        let d = p - root.shift
        [d.x * w + sin(root.turn) * p.y, d.y * w - sin(root.turn) * p.x]
    }
}

root Cloud : PRECISION {
    param shift: vec2 = [0.2, -0.1]
    param turn: real = 0.3
    c: real = 1.7
    points: list of Point
}
"""


def model_of(tmp_path: Path, clause: str, precision: str = "f64") -> Model:
    """37 points with residuals from 1e-3 to 30, one of them guarded away."""
    path = tmp_path / "loss.arael"
    path.write_text(MODEL.replace("CLAUSE", clause).replace("PRECISION", precision))
    model = load(path)()
    rng = np.random.default_rng(4)
    size = np.geomspace(1e-3, 30, 37)[:, None]
    w = rng.uniform(0.2, 1.5, 37)
    w[5] = 0
    model.points.extend(p=[0.2, -0.1] + rng.normal(size=(37, 2)) * size, w=w)
    return model


def plain(model: Model, x: Any) -> tuple[Any, Any]:
    """Residuals (36, 2) and their derivatives (36, 2, 3) at x = (shift, turn), without the loss."""
    w = np.asarray(model.points["w"])
    p, w = np.asarray(model.points.p)[w > 0.1], w[w > 0.1]
    sin, cos = np.sin(x[2]), np.cos(x[2])
    d = p - x[:2]
    r = np.stack([d[:, 0] * w + sin * p[:, 1], d[:, 1] * w - sin * p[:, 0]], axis=1)
    j = np.zeros((len(w), 2, 3))
    j[:, 0, 0] = j[:, 1, 1] = -w
    j[:, 0, 2], j[:, 1, 2] = cos * p[:, 1], -cos * p[:, 0]
    return r, j


@pytest.mark.sweep(5)
@pytest.mark.parametrize("name", LOSSES)
def test_kernels_interpreter_and_differences_agree(name: str, tmp_path: Path) -> None:
    model = model_of(tmp_path, LOSSES[name][0])
    check_against_oracle(model)
    check_against_differences(model)
    assert all(check.agrees for check in check_gradients(model._problem()))


@pytest.mark.parametrize("name", LOSSES)
def test_cost_gradient_and_hessian_are_those_of_the_robust_cost(name: str, tmp_path: Path) -> None:
    clause, rho, slope = LOSSES[name]
    model = model_of(tmp_path, clause)
    x = np.array([0.2, -0.1, 0.3])

    def cost(at: Any) -> float:
        return float(rho((plain(model, at)[0] ** 2).sum(axis=1)).sum())

    assert model.cost() == pytest.approx(cost(x), rel=1e-9)
    assert model.cost_table() == {"Point.near": pytest.approx(cost(x), rel=1e-9)}
    r, j = plain(model, x)
    s = (r**2).sum(axis=1)
    gradient = 2 * np.einsum("n,nk,nki->i", slope(s), r, j)
    np.testing.assert_allclose(model.gradient(), gradient, rtol=1e-7)
    steps = 1e-5 * np.eye(3)
    differences = [(cost(x + h) - cost(x - h)) / 2e-5 for h in steps]
    np.testing.assert_allclose(model.gradient(), differences, rtol=1e-6)

    # The slope across the residual, or a hundredth of rho / s; rho'^2 s / rho along it.
    along = r / np.sqrt(s)[:, None]
    across = np.eye(2) - along[:, :, None] * along[:, None, :]
    weight = np.maximum(slope(s), 0.01 * rho(s) / s)[:, None, None] * across
    weight += (slope(s) ** 2 * s / rho(s))[:, None, None] * along[:, :, None] * along[:, None, :]
    hessian = 2 * np.einsum("nki,nkl,nlj->ij", j, weight, j)
    np.testing.assert_allclose(model.hessian(), hessian, rtol=1e-7)
    rows = model.jacobian()
    assert (rows.residuals**2).sum() == pytest.approx(cost(x), rel=1e-9)
    np.testing.assert_allclose(2 * rows.dense().T @ rows.dense(), hessian, rtol=1e-7)
    np.testing.assert_allclose(2 * rows.dense().T @ rows.residuals, gradient, rtol=1e-7)
    np.testing.assert_allclose(model.covariance().matrix, 2 * np.linalg.inv(hessian), rtol=1e-7)


@pytest.mark.sweep(6)
@pytest.mark.parametrize("name", LOSSES)
def test_single_precision(name: str, tmp_path: Path) -> None:
    clause, rho, slope = LOSSES[name]
    model = model_of(tmp_path, clause, "f32")
    check_against_oracle(model, 1e-5)
    r, j = plain(model, np.array([0.2, -0.1, 0.3]))
    s = (r**2).sum(axis=1)
    assert model.cost() == pytest.approx(rho(s).sum(), rel=1e-4)
    rows = model.jacobian()
    np.testing.assert_allclose((rows.residuals.reshape(-1, 2) ** 2).sum(axis=1), rho(s), rtol=1e-3)
    gradient = 2 * np.einsum("n,nk,nki->i", slope(s), r, j)
    np.testing.assert_allclose(model.gradient(), gradient, rtol=1e-3)


ONE = """
fn capped(x, k) = (k * atan(sqrt(x) / k))^2

root One : PRECISION {
    param a: vec2 = [0, 0]
    c: real = 1.7
    constraint near loss CLAUSE { 3 * a }
}
"""


@pytest.mark.sweep(9)
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("name", LOSSES)
def test_at_zero_and_close_to_it_a_loss_is_the_squared_residual(
    name: str, precision: str, tmp_path: Path
) -> None:
    """Value 0 and slope 1: cost 0, gradient 0, Hessian 2 J'J as without a loss."""
    path = tmp_path / "one.arael"
    path.write_text(ONE.replace("CLAUSE", LOSSES[name][0]).replace("PRECISION", precision))
    model = load(path)()
    for compiled in (type(model).compiled.kernels, None):  # type: ignore[attr-defined]
        for size in (0.0, 1e-15, 1e-6, 1e-4):
            model.a.value[...] = [size, 0]
            problem = Problem(type(model).compiled.layout, model._store, compiled)  # type: ignore[attr-defined]
            # The loss `fair` differs from s by a term in |r|^3.
            tolerance = 2e-3 if precision == "f32" or name == "fair" else 1e-6
            assert problem.cost() == pytest.approx(9 * size**2, rel=tolerance, abs=1e-30)
            gradient, hessian = problem.gradient(), problem.hessian()
            np.testing.assert_allclose(gradient, [18 * size, 0], rtol=tolerance, atol=1e-30)
            np.testing.assert_allclose(hessian, 18 * np.eye(2), rtol=0, atol=18 * tolerance)


LINE = """
struct Point { x: real; y: real }

root Line {
    param a: real = 0
    param b: real = 0
    c: real = 1
    points: list of Point
    fit points as e CLAUSE { a * e.x + b - e.y }
    solve {
        pass loose { c = 30 }
        pass closer { c = 8 }
        pass close { c = 3 }
        pass tight { c = 1 }
    }
}
"""


def line(tmp_path: Path, clause: str) -> Model:
    """Forty points on y = 2 x + 1 with noise 0.05, every fifth off by 20."""
    path = tmp_path / "line.arael"
    path.write_text(LINE.replace("CLAUSE", clause))
    model = load(path)()
    x = np.linspace(0, 5, 40)
    y = 2 * x + 1 + 0.05 * np.random.default_rng(1).normal(size=40)
    y[::5] += 20
    model.points.extend(x=x, y=y)
    return model


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    ("clause", "error"),
    [
        ("loss cauchy(c)", 0.1),
        ("loss geman_mcclure(c)", 0.05),
        ("loss huber(c)", 0.6),
        ("loss tukey(c)", 0.05),
        ("loss soft_l1(c)", 0.7),
        ("loss welsch(c)", 0.05),
        ("loss fair(c)", 0.7),
        ("loss dcs(c)", 0.1),
        ("loss |s| c^2 * (1 - exp(-s / c^2))", 0.05),
    ],
)
def test_a_loss_pulls_a_fit_out_of_outliers(clause: str, error: float, tmp_path: Path) -> None:
    plain_fit = line(tmp_path, "")
    plain_fit.solve()
    astray = abs(plain_fit.b.value - 1)
    assert astray > 3
    robust = line(tmp_path, clause)
    assert robust.solve().status == "converged"
    assert abs(robust.b.value - 1) < error
    assert abs(robust.a.value - 2) < error


def test_a_loss_fits_as_an_independent_minimiser_does(tmp_path: Path) -> None:
    from scipy.optimize import least_squares

    model = line(tmp_path, "loss cauchy(c)")
    x, y = np.array(model.points["x"]), np.array(model.points["y"])
    model.solve()
    start = [model.a.value + 0.1, model.b.value - 0.1]
    # SciPy's loss is of (r / f_scale)^2, times f_scale^2.
    peer = least_squares(
        lambda p: p[0] * x + p[1] - y, start, loss="cauchy", f_scale=1.0, xtol=1e-12, ftol=1e-12
    )
    np.testing.assert_allclose([model.a.value, model.b.value], peer.x, atol=1e-4)
    assert model.cost() == pytest.approx(2 * peer.cost, rel=1e-8)


@pytest.mark.parametrize("name", ["soft_l1", "welsch", "fair", "dcs"])
def test_a_named_loss_has_all_its_digits_from_zero_on(name: str, tmp_path: Path) -> None:
    """Against rho(s) / s in 50 digits, where the closed formulas cancel."""
    import mpmath as mp

    path = tmp_path / "one.arael"
    path.write_text(ONE.replace("CLAUSE", LOSSES[name][0]).replace("PRECISION", "f64"))
    model = load(path, interpret=True)()
    exact: dict[str, Rho] = {
        "soft_l1": lambda x: 2 * (mp.sqrt(1 + x) - 1) / x,
        "welsch": lambda x: (1 - mp.exp(-x)) / x,
        "fair": lambda x: 2 * (mp.sqrt(x) - mp.log(1 + mp.sqrt(x))) / x,
        "dcs": lambda x: 1 if x <= 1 else (3 - 1 / x) / (1 + x),
    }
    with mp.workdps(50):
        for size in np.geomspace(1e-9, 1e4, 80):
            model.a.value[...] = [size / 3, 0]
            s = mp.mpf(3 * (size / 3)) ** 2
            expected = s * exact[name](s / mp.mpf(C) ** 2)
            assert abs(model.cost() / expected - 1) < 2e-14


def test_each_named_loss_is_described_with_a_picture() -> None:
    page = Path(__file__).parents[2] / "docs" / "robust.md"
    text = page.read_text(encoding="utf-8")
    for name in NAMES:
        assert f"| `{name}(c)` |" in text
        assert f"](figures/loss_{name}.svg)" in text
        assert (page.parent / f"figures/loss_{name}.svg").stat().st_size < 30_000


def test_loss_and_guard_are_shown(tmp_path: Path) -> None:
    (group,) = type(model_of(tmp_path, "huber(1.7)")).compiled.layout.groups  # type: ignore[attr-defined]
    assert (group.guard_text, group.loss_text) == ("w > 0.1", "huber(1.7)")


@pytest.mark.parametrize("name", LOSSES)
def test_curvature_across_the_residual_is_that_of_the_cost(name: str, tmp_path: Path) -> None:
    """Second differences of the cost along shifts that turn a residual and keep its length."""
    path = tmp_path / "across.arael"
    path.write_text(
        "root One {\n    param p: vec2 = [0, 0]\n    c: real = 1.7\n    x: real = 1\n"
        f"    constraint at loss {LOSSES[name][0]} {{ p + [x, 0] }}\n}}\n"
        + "fn capped(x, k) = (k * atan(sqrt(x) / k))^2\n"
    )
    kind = load(path, interpret=True)
    for x in (0.01, 0.5, 1.2, 3.0, 6.0):
        model = kind(x=x)
        cost = model.cost()

        def moved(y: float, model: Model = model) -> float:
            model.p.value = [0.0, y]
            return model.cost()

        h = 1e-3 * x
        exact = (moved(h) - 2 * cost + moved(-h)) / h**2
        moved(0.0)
        least = 2 * 0.01 * cost / x**2
        assert model.hessian()[1, 1] == pytest.approx(max(exact, least), rel=1e-4, abs=1e-9)


def test_a_flat_loss_on_several_residuals_still_holds_what_nothing_else_does(
    tmp_path: Path,
) -> None:
    """All residuals of the point are beyond the loss: no gradient, and no singular system."""
    path = tmp_path / "flat.arael"
    path.write_text(
        "root One {\n    param p: vec2 = [9, 0]\n    param q: real = 0\n"
        "    constraint far loss tukey(1) { [p.x, 2 * p.y] }\n"
        "    constraint also loss tukey(1) { [p.y + 7, p.x] }\n"
        "    constraint near { q - 1 }\n}\n"
    )
    model = load(path, interpret=True)()
    result = model.solve()
    assert result.status == "converged"
    assert float(model.q.value) == pytest.approx(1)
    np.testing.assert_allclose(model.p.value, [9, 0], atol=1e-12)


def test_gradients_of_several_residuals_with_a_loss_are_checked(tmp_path: Path) -> None:
    """A derivative that is wrong is found behind a loss too."""
    path = tmp_path / "wrong.arael"
    path.write_text(
        "fn wrong(x) derivs [3 * x] = x^2\n"
        "root One {\n    param p: vec2 = [1, 2]\n"
        "    constraint at loss cauchy(1) { [wrong(p.x), p.y] }\n}\n"
    )
    (found,) = check_gradients(load(path, interpret=True)()._problem())
    assert not found.agrees and found.residual == 0
