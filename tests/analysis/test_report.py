"""Reports, scaled covariances, correlations: against SciPy and NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import arael
from arael.analysis.report import Statistics
from arael.diagnostics.records import AraelError
from tests.interpreted import Load, loader

LINE = """
struct Point {
    x: real
    y: real
    constraint fit { (root.a * x + root.b - y) / root.sigma }
}
root Line { param a: real [V] in -5 .. 5 = 0
    param b: real = 0
    sigma: real = 1
    points: list of Point }
"""
POSES = """
struct Pose { param pos: vec2 [m]
    param ea: euler = [0, 0, 0]
    constraint gps { [pos - root.at, ea] * 2 } }
root Path { poses: list of Pose
    at: vec2 = [1, 2]
    param drift: vec2 = [0, 0]
    constraint none { [drift.x - 1, drift.x + drift.y] } }
"""
X = np.array([0.0, 1, 2, 3, 4, 6])
Y = np.array([0.1, 0.9, 2.2, 2.8, 4.1, 6.2])


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("reports"))


def line(load: Load, **values: Any) -> Any:
    model = load(LINE)(**values)
    model.points.extend(x=X, y=Y)
    model.solve()
    return model


def test_covariance_scaled_by_the_scatter_is_that_of_polyfit(load: Load) -> None:
    model = line(load)
    covariance = model.covariance(scale="residual")
    expected = np.polyfit(X, Y, 1, cov=True)[1]
    np.testing.assert_allclose(covariance.matrix, expected)
    np.testing.assert_allclose(covariance.sigma(), np.sqrt(np.diag(expected)))
    np.testing.assert_allclose(covariance.marginal("a"), expected[:1, :1])
    np.testing.assert_allclose(covariance.cross("a", "b"), expected[:1, 1:])
    np.testing.assert_allclose(
        covariance.conditional("a"), expected[0, 0] - expected[0, 1] ** 2 / expected[1, 1]
    )
    # The unit of the residuals does not matter.
    other = line(load, sigma=17.0).covariance(scale="residual")
    np.testing.assert_allclose(other.matrix, expected)


def test_a_scale_that_is_unknown_or_cannot_be_estimated(load: Load) -> None:
    model = line(load)
    with pytest.raises(AraelError, match="E1035"):
        model.covariance(scale="scatter")
    exact = load(LINE)()
    exact.points.extend(x=[0, 1], y=[0, 1])
    exact.solve()
    with pytest.raises(AraelError, match="2 residuals and 2 parameters"):
        exact.covariance(scale="residual")
    assert "their scatter is not known" in str(exact.report(scale="residual"))


def test_covariance_of_lists_and_of_the_root(load: Load) -> None:
    model = load(POSES)()
    model.poses.extend(pos=[[0, 0], [1, 1]])
    model.solve()
    covariance = model.covariance()
    both = covariance.marginal([model.poses[1], "poses[0].pos", model])
    names = covariance.names_of([model.poses[1], "poses[0].pos", model])
    assert names == [
        *(f"poses[1].{n}" for n in ("pos.x", "pos.y", "ea.x", "ea.y", "ea.z")),
        "poses[0].pos.x", "poses[0].pos.y", "drift.x", "drift.y",
    ]  # fmt: skip
    at = [covariance.names.index(name) for name in names]
    np.testing.assert_allclose(both, covariance.matrix[np.ix_(at, at)])
    np.testing.assert_allclose(covariance.marginal(model), [[1, -1], [-1, 2]], atol=1e-12)
    np.testing.assert_allclose(
        covariance.correlation(model), [[1, -(0.5**0.5)], [-(0.5**0.5), 1]], atol=1e-12
    )
    assert covariance.correlation().shape == (12, 12)
    with pytest.raises(AraelError, match=r"E1009.*name a parameter twice"):
        covariance.marginal([model.poses[1], "poses[1].pos"])


def test_a_report_has_values_errors_and_units(load: Load) -> None:
    report = line(load).report(scale="residual")
    slope, offset = np.polyfit(X, Y, 1)
    expected = np.sqrt(np.diag(np.polyfit(X, Y, 1, cov=True)[1]))
    a, b = report.parameters
    assert (a.name, a.unit, b.name) == ("a", "V", "b")
    assert (a.value, b.value) == pytest.approx((slope, offset))
    assert (a.sigma, b.sigma) == pytest.approx(expected)
    data = report.to_dict()
    assert data["degrees_of_freedom"] == 4
    assert data["reduced_chi_square"] == pytest.approx(np.var(Y - slope * X - offset) * 6 / 4)
    text = str(report)
    assert text.splitlines()[1].startswith("  a = 1.0") and " V (" in text


def test_parameters_on_bounds_and_bad_sigmas_are_suspicious(load: Load) -> None:
    model = load(LINE)(sigma=1e-3)
    model.points.extend(x=X, y=20 * Y)
    model.solve()
    report = model.report()
    assert (
        report.parameters[0].note == "on its upper bound 5" and report.parameters[0].sigma is None
    )
    assert any("`a` is on its upper bound 5" in text for text in report.findings)
    assert any("reduced chi-square" in text and "too small" in text for text in report.findings)


def test_a_singular_problem_is_reported_not_raised(load: Load) -> None:
    model = load(LINE)()
    model.points.extend(x=[1, 1, 1], y=[1, 2, 3])
    model.solve(min_diagonal=1e-9)
    report = model.report()
    assert all(one.sigma is None for one in report.parameters)
    assert any("directions are free" in text for text in (*report.notes, *report.findings))


def test_scalars_of_rotations_have_no_value(load: Load) -> None:
    text = "root A { param q: quaternion = [1, 0, 0, 0]\n param p: vec3 = [0, 0, 0]\n"
    text += " constraint c { [q.rotation_matrix() * [1, 2, 3] - [1, 2, 3.1], p, "
    text += "q.rotation_matrix() * [1, 0, 0] - [1, 0, 0]] } }"
    model = load(text)()
    model.solve()
    report = model.report()
    parts = {one.name: one for one in report.parameters}
    assert len(parts) == 6
    lines = [line.split() for line in str(report).splitlines()]
    assert ["q.x", "+-"] in [line[:2] for line in lines]
    assert ["p.x", "="] in [line[:2] for line in lines]
    rotation = [one for name, one in parts.items() if name.startswith("q")]
    assert all(one.value is None and one.sigma is not None for one in rotation)
    assert parts["p.x"].value == pytest.approx(0)


def test_statistics_of_known_and_unknown_deviations() -> None:
    known = Statistics(12.0, 10, 3, scatter=False)
    assert (known.freedom, known.reduced, known.variance) == (7, 12 / 7, 1.0)
    assert known.aic == 12 + 6 and known.bic == pytest.approx(12 + 3 * np.log(10))
    unknown = Statistics(12.0, 10, 3, scatter=True)
    likelihood = 10 * stats.norm.logpdf(np.sqrt(1.2), scale=np.sqrt(1.2))
    assert unknown.aic == pytest.approx(-2 * likelihood + 8)
    assert np.isnan(Statistics(12.0, 10, 3, scatter=False, robust=True).aic)
    assert np.isnan(Statistics(1.0, 2, 2, scatter=True).reduced)
    assert Statistics(1.0, 2, 2, scatter=True).to_dict()["reduced_chi_square"] is None


def test_the_chi_square_of_a_right_model_is_not_suspicious(load: Load) -> None:
    model = line(load, sigma=0.15)
    assert not model.report().findings


def test_a_loss_leaves_no_likelihood(tmp_path: Path) -> None:
    residual = arael.runtime_residual(
        "a * x - y", parameters={"a": 1}, data={"x": X, "y": Y}, loss="huber(1)"
    )
    model = arael.runtime_model(residual)
    model.solve()
    report = model.report()
    assert np.isnan(report.statistics.aic) and "AIC" not in str(report)
    assert report.to_dict()["aic"] is None


def test_many_rows_are_summarised_by_collection(load: Load) -> None:
    model = load(POSES)()
    model.poses.extend(pos=np.zeros((40, 2)))
    model.solve()
    report = model.report()
    assert [one.name for one in report.collections["poses"]][:2] == [
        "poses[*].pos.x",
        "poses[*].pos.y",
    ]
    (x, *_) = report.collections["poses"]
    assert x.values == (pytest.approx(1), pytest.approx(1)) and len(x.estimates) == 40
    median, largest, _ = x.sigmas
    assert median == pytest.approx(0.5) == largest
    text = str(report)
    assert "poses[*].pos.y = 40 values; 2 to 2; standard error 0.5 at the median" in text
    assert "drift.x" in text and "poses[3]" not in text.replace("poses[39]", "")
    rows = report._repr_html_()
    assert "poses[*].pos.x" in rows and "40 values" in rows


def test_few_rows_are_listed_one_by_one(load: Load) -> None:
    model = load(POSES)()
    model.poses.extend(pos=np.zeros((2, 2)))
    model.solve()
    assert "poses[1].pos.x = 1.00 +- 0.50" in str(model.report())
