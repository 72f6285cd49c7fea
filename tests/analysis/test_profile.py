"""Intervals by profile likelihood, against direct minimisation with the parameter held."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation

import arael
from arael.diagnostics.records import AraelError
from tests.interpreted import Load, loader

X = np.array([0.5, 1.0, 2.0, 3.0, 5.0])
Y = np.array([0.9, 1.6, 2.4, 3.0, 3.6])
TEXT = """
struct Point { x: real
    y: real
    constraint fit { (root.v * x / (root.k + x) - y) / root.sigma } }
root Saturation { param v: real = 3
    param k: real in 0 .. = 2
    param pair: vec2 = [0, 0]
    param turn: quaternion = [1, 0, 0, 0]
    sigma: real = 0.1
    constraint pair { pair - [1, 2] }
    constraint turn { turn.rotation_matrix() * [1, 2, 3] - [1, 2, 3] }
    constraint turn2 { turn.rotation_matrix() * [1, 0, 0] - [1, 0, 0] }
    points: list of Point }
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("profiles"))


def solved(load: Load, **values: Any) -> Any:
    model = load(TEXT)(**values)
    model.points.extend(x=X, y=Y)
    model.solve()
    return model


def least(k: float) -> float:
    """The least cost over v with k held, at sigma 1: v is linear."""
    at = X / (k + X)
    return float(np.sum((at * (at @ Y) / (at @ at) - Y) ** 2))


def test_ends_are_those_of_direct_minimisation(load: Load) -> None:
    model = solved(load)
    found = model.profile("k", level=0.9)
    best = float(model.k.value)
    rise = stats.chi2.ppf(0.9, 1) * 0.1**2

    def over(k: float) -> float:
        return least(k) - least(best) - rise

    assert found.low == pytest.approx(brentq(over, 0.1, best), rel=1e-6)
    assert found.high == pytest.approx(brentq(over, best, 50), rel=1e-6)
    # Not symmetric, and on the curve all the way.
    assert found.high - best > 1.2 * (best - found.low)
    np.testing.assert_allclose(
        found.increase * 0.1**2, [least(k) - least(best) for k in found.values], atol=1e-7
    )


def test_the_scale_of_the_scatter_uses_students_t(load: Load) -> None:
    model = arael.fit("y = v * x / (k + x)", {"x": X, "y": Y}).curve.model
    found = model.profile("k", level=0.95, scale="residual")
    best = model["k"].value
    rise = stats.t.ppf(0.975, 3) ** 2 * least(best) / 3
    assert found.low == pytest.approx(brentq(lambda k: least(k) - least(best) - rise, 0.01, best))


def test_a_linear_model_has_the_symmetric_interval(load: Load) -> None:
    model = solved(load)
    found = model.profile("pair.y", level=0.95)
    z = stats.norm.ppf(0.975)
    assert (found.low, found.high) == pytest.approx((2 - z, 2 + z))
    assert str(found) == "pair.y = 2.00 in [0.04, 3.96] at 95 %"


def test_the_model_keeps_its_values_and_its_residuals(load: Load) -> None:
    model = solved(load)
    before, cost = model.serialize(), model.cost()
    model.profile("v")
    np.testing.assert_array_equal(model.serialize(), before)
    assert model.cost() == cost and len(model.residuals) == 0


def test_an_interval_ends_at_a_bound(load: Load) -> None:
    model = load(TEXT)(sigma=3.0)
    model.points.extend(x=X, y=Y)
    model.solve()
    assert model.profile("k").low == pytest.approx(0, abs=1e-12)


def test_a_cost_that_stays_low_gives_an_infinite_end() -> None:
    # Beyond some rate the curve is a step: all larger rates fit as well.
    x, y = np.array([0.0, 1, 2, 3, 4]), np.array([1.0, 0.06, -0.04, 0.03, -0.05])
    model = arael.fit("y = a * exp(-b * x)", {"x": x, "y": y}, sigma=0.1).curve.model
    found = model.profile("b", level=0.95)
    assert found.high == np.inf and 0.5 < found.low < found.value


def test_other_strategies_of_a_schedule_do_not_matter(load: Load, tmp_path: Path) -> None:
    path = tmp_path / "passes.arael"
    passes = "    solve { pass one { sigma = 5 }  pass two { sigma = 0.1 } }\n"
    text = TEXT.replace("    points: list", f"{passes}    points: list")
    path.write_text(text)
    model = arael.load(path, interpret=True)()
    model.points.extend(x=X, y=Y)
    model.solve()
    assert model.profile("k").low == pytest.approx(solved(load).profile("k").low, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "level", "text"),
    [
        ("kk", 0.95, "did you mean `k`?"),
        ("frames[1].d.u", 0.95, "directions have no profile"),
        ("k", 95, "the level is 95"),
        ("k", "high", "the level is 'high'"),
    ],
)
def test_mistakes(load: Load, name: str, level: Any, text: str) -> None:
    model = solved(load) if "frames" not in name else framed()
    with pytest.raises(AraelError, match="E1036") as caught:
        model.profile(name, level=level)
    assert text in str(caught.value)


FRAMES = """
struct Frame {
    param d: direction = [0, 0.6, 0.8]
    param ro: rotation = exp([0.3, 0, -0.2])
    param q: quaternion = exp([0.1, 0.2, 2])
    param T: transform = transform(exp([0.1, 0, 0.2]), [1, 2, 3])
    param S: similarity = similarity(exp([0, 0.1, 0]), [3, 2, 1], 2)
    prior d ~ normal([0, 0.6, 0.8], 0.2)
    prior ro ~ normal(exp([0.3, 0, -0.2]), 0.2)
    prior q ~ normal(exp([0.1, 0.2, 2]), 0.2)
    prior T ~ normal(transform(exp([0.1, 0, 0.2]), [1, 2, 3]), 0.2)
    prior S ~ normal(similarity(exp([0, 0.1, 0]), [3, 2, 1], 2), 0.2)
}
root World { frames: list of Frame }
"""


def framed() -> Any:
    model = arael.loads(FRAMES, interpret=True)()
    model.frames.extend(2)
    model.solve()
    return model


@pytest.mark.slow
def test_scalars_of_rotations_and_transforms_have_profiles() -> None:
    # The priors are quadratic in the tangent vector from the solution, so that the ends are known.
    model = framed()
    half = 0.2 * stats.norm.ppf(0.975)
    for name in ("ro.y", "q.z", "T.translation.x", "T.rotation.z", "S.translation.z", "S.scale"):
        found = model.profile(f"frames[1].{name}")
        assert found.value == 0
        assert (found.low, found.high) == pytest.approx((-half, half), rel=1e-6), name
    assert str(model.profile("frames[0].q.x")).startswith("frames[0].q.x = 0.00 in [-0.39, 0.39]")


@pytest.mark.slow
def test_profiles_of_rotations_are_those_of_direct_minimisation(load: Load) -> None:
    model = solved(load)
    found = model.profile("turn.x", level=0.5)
    arms = np.array([[1.0, 2, 3], [1, 0, 0]])

    def rise(x: float) -> float:
        def residuals(rest: Any) -> Any:
            turn = Rotation.from_rotvec([x, *rest])
            return (turn.apply(arms) - arms).ravel()

        return 2 * least_squares(residuals, [0.0, 0.0], xtol=1e-14).cost

    wanted = stats.chi2.ppf(0.5, 1)
    assert found.high == pytest.approx(brentq(lambda x: rise(x) - wanted, 0, 0.4), rel=1e-5)
    assert found.low == pytest.approx(brentq(lambda x: rise(x) - wanted, -0.4, 0), rel=1e-5)


def test_a_rotation_that_any_angle_fits_has_no_end() -> None:
    text = "root R { param q: quaternion = [1, 0, 0, 0]\nprior q ~ normal([1, 0, 0, 0], 4) }"
    model = arael.loads(text, interpret=True)()
    model.solve()
    found = model.profile("q.x")
    assert (found.low, found.high) == (-np.inf, np.inf)


def test_a_model_that_is_not_solved_has_no_profile(load: Load) -> None:
    model = load(TEXT)(v=1.0, k=8.0)
    model.points.extend(x=X, y=Y)
    with pytest.raises(AraelError, match=r"E1036.*has a lower cost"):
        model.profile("v")


def test_least_squares_agrees_with_the_elimination() -> None:
    """The reference of these tests itself."""
    found = least_squares(lambda p: p[0] * X / (1.3 + X) - Y, [1.0])
    assert least(1.3) == pytest.approx(2 * found.cost)
