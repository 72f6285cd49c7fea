"""Covariances against the dense inverse, and against what noise really does."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.analysis import normal
from arael.analysis.scalars import tangent_units
from arael.diagnostics.records import AraelError
from tests.analysis.maps import planar


@pytest.fixture
def solved(tmp_path):
    model = planar(tmp_path)
    model.solve(rel_precision=1e-12, abs_precision=1e-12)
    return model


def test_every_query_against_the_dense_inverse(solved) -> None:
    j = solved.jacobian().dense()
    inverse = np.linalg.inv(j.T @ j)
    found = solved.covariance()
    np.testing.assert_allclose(found.sigma(), np.sqrt(np.diag(inverse)), rtol=1e-8)
    names = found.names
    a = [names.index(f"poses[2].{n}") for n in ("t.x", "t.y", "th")]
    b = [names.index(f"poses[5].{n}") for n in ("t.x", "t.y", "th")]
    aa, ab, bb = (inverse[np.ix_(i, j)] for i, j in ((a, a), (a, b), (b, b)))
    pose, other = solved.poses[2], solved.poses[5]
    np.testing.assert_allclose(found.marginal(pose), aa, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(found.cross(pose, other), ab, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(
        found.relative(pose, other), aa + bb - ab - ab.T, rtol=1e-7, atol=1e-15
    )
    np.testing.assert_allclose(
        found.conditional(pose, other), aa - ab @ np.linalg.solve(bb, ab.T), rtol=1e-7, atol=1e-15
    )
    np.testing.assert_allclose(
        found.conditional(pose), np.linalg.inv((j.T @ j)[np.ix_(a, a)]), rtol=1e-8, atol=1e-15
    )
    np.testing.assert_allclose(found.marginal("poses[2].th"), aa[2:, 2:], rtol=1e-8)
    whole = found.marginals("poses")
    assert whole.shape == (8, 3, 3)
    np.testing.assert_allclose(whole[2], aa, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(found.marginals("poses.t")[2], aa[:2, :2], rtol=1e-8, atol=1e-15)
    axes, directions = found.ellipsoid("poses[2].t")
    np.testing.assert_allclose(directions @ np.diag(axes**2) @ directions.T, aa[:2, :2], atol=1e-12)
    np.testing.assert_allclose(found.matrix, inverse, rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(found.marginal(pose), aa, rtol=1e-8, atol=1e-15)


def test_units_are_those_of_the_scalars(solved) -> None:
    found = solved.covariance()
    assert found.units == ["m", "m", "rad"] * 8
    assert len(found.units) == len(found.names)


def test_what_is_fixed_has_no_variance(solved) -> None:
    solved.poses[3].t.fixed = True
    found = solved.covariance()
    assert found.units[9:12] == ["rad", "m", "m"]
    assert found.marginals("poses.t")[3] == pytest.approx(0)
    j = solved.jacobian().dense()
    inverse = np.linalg.inv(j.T @ j)
    np.testing.assert_allclose(found.marginals("poses")[3][2, 2], inverse[9, 9], rtol=1e-8)
    np.testing.assert_allclose(found.sigma(), np.sqrt(np.diag(inverse)), rtol=1e-8)


def test_monte_carlo(tmp_path) -> None:
    """The spread of solutions under fresh noise of the stated sigmas is what is promised."""
    found = []
    for seed in range(160):
        model = planar(tmp_path, count=5, seed=seed)
        model.solve()
        found.append(np.concatenate([model.poses.t.value[3], model.poses.t.value[1]]))
    promised = planar(tmp_path, count=5, seed=0)
    promised.solve()
    covariance = promised.covariance()
    rows = ["poses[3].t", "poses[1].t"]
    expected = np.block([[covariance.cross(a, b) for b in rows] for a in rows])
    spread = np.cov(np.array(found).T)
    # Whitened by what is promised, the sample covariance is the identity within 1/sqrt(160).
    half = np.linalg.inv(np.linalg.cholesky(expected))
    assert half @ spread @ half.T == pytest.approx(np.eye(4), abs=0.36)


def test_single_precision_models(tmp_path) -> None:
    single, double = planar(tmp_path, precision="f32"), planar(tmp_path)
    for model in (single, double):
        model.solve()
    np.testing.assert_allclose(single.covariance().sigma(), double.covariance().sigma(), rtol=1e-4)


def test_large_systems_take_the_sparse_way(solved, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = solved.covariance().sigma()
    monkeypatch.setattr(normal, "_DENSE", 0)
    np.testing.assert_allclose(solved.covariance().sigma(), expected, rtol=1e-9)


def test_refusals(solved) -> None:
    found = solved.covariance()
    for ask, message in (
        (lambda: found.marginal("poses[99]"), r"`poses\[99\]` is not solved for"),
        (lambda: found.marginals("edges"), "`edges` holds no parameters"),
        (lambda: found.conditional("poses[1]", "poses[1].t"), "they overlap"),
        (lambda: found.relative("poses[1].t", "poses[1].th"), "no parameter of the same name"),
    ):
        with pytest.raises(AraelError, match=message) as error:
            ask()
        assert error.value.diagnostics[0].code == "E1009"


FRAMES = """
struct Frame {
    param T: transform [m]
    param S: similarity [km]
    x: vec3 [m]
    y: vec3 [km]
    constraint near { [(T * x - x) / 0.1, (S * y - y) / 0.1] }
}
root Frames { frames: list of Frame }
"""


def test_units_of_a_transform_are_those_of_its_parts(tmp_path) -> None:
    path = tmp_path / "frames.arael"
    path.write_text(FRAMES, encoding="utf-8")
    layout = arael.load(path, interpret=True).layout
    own = tangent_units(layout, layout.entities[0])
    names = layout.entities[0].tangent_names
    assert len(own) == len(names) == 13
    assert own == ["m"] * 3 + ["rad"] * 3 + ["km"] * 3 + ["rad"] * 3 + [""]


def test_relative_to_what_is_fixed_takes_it_as_exact(solved) -> None:
    solved.poses[3].t.fixed = True
    solved.poses[3].th.fixed = True
    solved.poses[6].th.fixed = True
    found = solved.covariance()
    pose, fixed = solved.poses[1], solved.poses[3]
    np.testing.assert_array_equal(found.relative(pose, fixed), found.marginal(pose))
    np.testing.assert_array_equal(found.relative(fixed, pose), found.marginal(pose))
    np.testing.assert_array_equal(
        found.relative("poses[1].t", "poses[3].t"), found.marginal("poses[1].t")
    )
    turned = found.relative("poses[1].th", "poses[3].th")
    np.testing.assert_allclose(turned, [[found.sigma()[5] ** 2]], rtol=1e-12)
    np.testing.assert_array_equal(found.relative(fixed, fixed), np.zeros((3, 3)))
    axes, _ = found.ellipsoid("poses[1].t", relative_to="poses[3].t")
    np.testing.assert_allclose(axes, found.ellipsoid("poses[1].t")[0])
    # fixed in part: the angle of poses[6] is exact, its position is not
    half = found.relative(pose, solved.poses[6])
    assert half[2, 2] == found.marginal(pose)[2, 2]
    ab = found.cross("poses[1].t", "poses[6].t")
    expected = found.marginal("poses[1].t") + found.marginal("poses[6].t") - ab - ab.T
    np.testing.assert_allclose(half[:2, :2], expected, atol=1e-15)
    with pytest.raises(AraelError, match=r"`poses\[99\]` is not solved for"):
        found.relative(pose, "poses[99]")


BOUNDED = """
struct Point {
    x: real
    y: real
    constraint c { root.slope * x + root.offset - y }
}
root Line {
    param slope: real in 0 .. 1
    param offset: real
    points: list of Point
}
"""


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_parameter_on_its_bound_is_not_free(tmp_path, precision: str) -> None:
    path = tmp_path / "bounded.arael"
    path.write_text(BOUNDED, encoding="utf-8")
    model = arael.load(path, interpret=True, precision=precision)(slope=0.5, offset=0)
    model.points.extend(x=[0.0, 1, 2, 3], y=[0.0, 2, 4, 6])
    free = model.covariance()
    assert free.names == ["slope", "offset"] and free.on_bound == {}
    model.solve()
    assert model.slope.value == 1
    held = model.covariance()
    assert held.names == ["offset"] and held.units == [""]
    assert held.on_bound == {"slope": "its upper bound 1"}
    np.testing.assert_allclose(held.sigma(), [0.5], rtol=1e-6)
    np.testing.assert_allclose(held.matrix, [[0.25]], rtol=1e-6)
    np.testing.assert_allclose(held.marginals("slope"), [[[0]]])
    assert repr(held) == "<Covariance of 1 parameters, 1 more on bounds>"
    with pytest.raises(AraelError, match="`slope` is not solved for") as caught:
        held.marginal("slope")
    assert caught.value.diagnostics[0].notes == ("`slope` is on its upper bound 1",)
    # On a bound from which the cost leads inwards, it is free.
    model.slope = 0
    assert model.covariance().names == ["slope", "offset"]


def test_a_solution_exactly_on_a_bound_is_on_it(tmp_path) -> None:
    path = tmp_path / "bounded.arael"
    path.write_text(BOUNDED, encoding="utf-8")
    model = arael.load(path, interpret=True)(slope=1, offset=0.1)
    model.points.extend(x=[0.1, 1.3, 2, 3], y=[0.2, 1.4, 2.1, 3.1])
    model.solve()
    model.slope = 1.0
    assert model.covariance().names == ["offset"]


def test_a_vector_of_more_than_three_numbers_by_its_name() -> None:
    text = """
        struct Lens { param k: vec<4>; seen: vec<4>; constraint c { (k - seen) .* [1, 2, 4, 5] } }
        root R { param v: vec<5>; lenses: list of Lens; constraint c { 2 * v } }
    """
    model = arael.loads(text, interpret=True)(v=[0] * 5)
    model.lenses.extend(2, k=[0, 0, 0, 0], seen=[1, 2, 3, 4])
    covariance = model.covariance()
    assert covariance.names_of("lenses[1].k") == [f"lenses[1].k[{i}]" for i in range(4)]
    assert np.allclose(np.diag(covariance.marginal("lenses[1].k")), [1, 0.25, 0.0625, 0.04])
    assert np.allclose(covariance.marginal("v"), np.eye(5) / 4)
    both = covariance.marginal(["lenses[0].k", "v"])
    assert both.shape == (9, 9)
    with pytest.raises(arael.AraelError, match="E1009"):
        covariance.marginal("lenses")  # a collection is not an entity
