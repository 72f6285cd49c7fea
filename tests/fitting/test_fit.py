"""`arael.fit` against SciPy, and against data whose truth is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import curve_fit, least_squares

import arael
from arael.diagnostics.records import AraelError
from arael.display.measured import measured

FORMULA = "y = a * exp(-b * x) + c"
X = np.linspace(0, 5, 40)
Y = 2.5 * np.exp(-0.7 * X) + 0.3 + 0.01 * np.random.default_rng(0).normal(size=40)
DATA = {"x": X, "y": Y}


def curve(x: Any, a: float, b: float, c: float) -> Any:
    return a * np.exp(-b * x) + c


def test_values_and_covariance_are_those_of_scipy() -> None:
    found = arael.fit(FORMULA, DATA)
    best, covariance = curve_fit(curve, X, Y, [1, 1, 1], xtol=1e-14, ftol=1e-14)
    np.testing.assert_allclose(list(found.parameters.values()), best, rtol=1e-7)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-4)
    sigma = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        found.correlation, covariance / np.outer(sigma, sigma), atol=1e-5, rtol=1e-5
    )


@pytest.mark.parametrize("absolute", [True, False])
def test_a_sigma_for_each_point(absolute: bool) -> None:
    deviation = np.linspace(0.005, 0.03, 40)
    best, covariance = curve_fit(
        curve, X, Y, [1, 1, 1], deviation, absolute, xtol=1e-14, ftol=1e-14
    )
    by_array = arael.fit(FORMULA, DATA, sigma=deviation, absolute_sigma=absolute)
    by_name = arael.fit(FORMULA, {**DATA, "s": deviation}, sigma="s", absolute_sigma=absolute)
    for found in (by_array, by_name):
        np.testing.assert_allclose(list(found.parameters.values()), best, rtol=1e-6)
        np.testing.assert_allclose(found.covariance, covariance, rtol=1e-4)


def test_bounds_hold_and_are_reported() -> None:
    found = arael.fit(FORMULA, DATA, bounds={"c": (0.35, None), "b": (None, 5)})
    best = least_squares(
        lambda p: curve(X, *p) - Y, [2, 0.5, 0.4], bounds=([-9, -9, 0.35], [9, 5, 9]), xtol=1e-14
    ).x
    np.testing.assert_allclose(list(found.parameters.values()), best, rtol=1e-5)
    assert found.on_bound == {"c": "its lower bound 0.35"}
    assert found.sigma["c"] == 0
    assert "`c` is on its lower bound 0.35" in str(found.report())
    free = arael.fit(FORMULA, DATA, bounds={"c": (0, 10)})
    assert not free.on_bound


def test_fixed_parameters_are_not_fitted() -> None:
    found = arael.fit(FORMULA, DATA, fixed={"c": 0.25})
    best, covariance = curve_fit(lambda x, a, b: curve(x, a, b, 0.25), X, Y, [1, 1], xtol=1e-14)
    assert found.parameters["c"] == 0.25 and found.sigma["c"] == 0
    np.testing.assert_allclose(list(found.parameters.values())[:2], best, rtol=1e-6)
    np.testing.assert_allclose(found.covariance[:2, :2], covariance, rtol=1e-4)
    assert "c = 0.25 (fixed)" in str(found)


def test_a_robust_loss_resists_outliers() -> None:
    wrong = Y.copy()
    wrong[::8] += 1
    plain = arael.fit(FORMULA, {"x": X, "y": wrong}, sigma=0.01)
    robust = arael.fit(FORMULA, {"x": X, "y": wrong}, sigma=0.01, loss="cauchy(2)")
    assert abs(plain.parameters["c"] - 0.3) > 0.03
    assert abs(robust.parameters["c"] - 0.3) < 0.02
    # The cost is not a likelihood of normal errors.
    assert robust.r_squared is None and np.isnan(robust.estimates.statistics.aic)


def test_groups_have_parameters_of_their_own_and_share_others() -> None:
    rng = np.random.default_rng(3)
    sample = np.repeat(["left", "right", "top"], 30)
    x = np.tile(np.linspace(0, 4, 30), 3)
    amplitude = np.repeat([1.0, 2.0, 5.0], 30)
    y = amplitude * np.exp(-0.8 * x) + 0.01 * rng.normal(size=90)
    found = arael.fit(
        "y = a * exp(-b * x)", {"x": x, "y": y, "sample": sample}, group="sample", shared=["b"]
    )
    assert found.names == ("b", "a[left]", "a[right]", "a[top]")

    def off(p: Any) -> Any:
        return p[np.repeat([1, 2, 3], 30)] * np.exp(-p[0] * x) - y

    best = least_squares(off, [1, 1, 2, 5], xtol=1e-15, ftol=1e-15, method="lm")
    np.testing.assert_allclose(found.values, best.x, rtol=1e-7)
    variance = np.linalg.inv(best.jac.T @ best.jac) * (best.fun @ best.fun) / 86
    np.testing.assert_allclose(found.covariance, variance, rtol=1e-4)
    np.testing.assert_allclose(
        found.predict({"x": 1.0}, "top"), best.x[3] * np.exp(-best.x[0]), rtol=1e-7
    )
    each = arael.fit("y = a * exp(-b * x)", {"x": x, "y": y, "sample": sample}, group="sample")
    assert each.names == tuple(f"{p}[{g}]" for g in ("left", "right", "top") for p in "ab")


def test_groups_by_a_column_of_numbers_and_parameters_named_as_methods() -> None:
    """A parameter may have the name of a method of models or collections."""
    data = {"x": [1.0, 2, 3, 1, 2, 3], "y": [2.0, 4, 6, 3, 6, 9], "run": [1, 1, 1, 2, 2, 2]}
    found = arael.fit("y = size * x + report", data, group="run", shared=["report"])
    assert found.parameters == pytest.approx({"report": 0, "size[1]": 2, "size[2]": 3}, abs=1e-9)


def test_bands_are_those_of_linear_regression() -> None:
    """The textbook formulas for a line."""
    x, y = np.array([1.0, 2, 4, 7, 8]), np.array([1.2, 1.9, 4.5, 6.6, 8.4])
    bands = arael.fit("y = a * x + b", {"x": x, "y": y}).bands({"x": [0.0, 5.0]}, level=0.9)
    slope, offset = np.polyfit(x, y, 1)
    s2 = np.sum((y - slope * x - offset) ** 2) / 3
    at = np.array([0.0, 5.0])
    share = 1 / 5 + (at - x.mean()) ** 2 / np.sum((x - x.mean()) ** 2)
    t = stats.t.ppf(0.95, 3)
    np.testing.assert_allclose(bands.value, slope * at + offset)
    np.testing.assert_allclose(bands.low, bands.value - t * np.sqrt(s2 * share))
    np.testing.assert_allclose(bands.predicted_high, bands.value + t * np.sqrt(s2 * (1 + share)))


def test_known_sigmas_give_bands_of_the_normal_distribution() -> None:
    found = arael.fit("y = a * x", {"x": [1.0, 2], "y": [1.0, 2.3]}, sigma=0.5)
    bands = found.bands({"x": 2})
    z, sigma = stats.norm.ppf(0.975), 0.5 / np.sqrt(5)
    np.testing.assert_allclose(bands.high - bands.value, z * 2 * sigma)
    np.testing.assert_allclose(bands.predicted_high - bands.value, z * np.sqrt(4 * sigma**2 + 0.25))


def test_figures_of_the_report() -> None:
    found = arael.fit(FORMULA, DATA)
    of, n = found.estimates.statistics, 40
    cost = float(np.sum(found.residuals**2))
    assert of.cost == pytest.approx(cost)
    assert of.freedom == 37 and of.reduced == pytest.approx(cost / 37)
    assert found.r_squared == pytest.approx(1 - cost / np.sum((Y - Y.mean()) ** 2))
    # The log likelihood of normal errors with the variance cost / n.
    likelihood = stats.norm.logpdf(found.residuals, scale=np.sqrt(cost / n)).sum()
    assert of.aic == pytest.approx(-2 * likelihood + 2 * 4)
    assert of.bic == pytest.approx(-2 * likelihood + np.log(n) * 4)
    text = str(found.report())
    for line in ("degrees of freedom       37", "R squared", "AIC", "BIC"):
        assert line in text
    known = arael.fit(FORMULA, DATA, sigma=0.01)
    assert known.estimates.statistics.aic == pytest.approx(cost / 1e-4 + 2 * 3)
    wrong = arael.fit(FORMULA, DATA, sigma=1.0)
    assert "the reduced chi-square is 6.18e-05" in str(wrong) and "too large" in str(wrong)


def test_correlated_parameters_are_listed() -> None:
    far = {"x": X + 1000, "y": Y}
    found = arael.fit("y = a * x + b", far).report()
    ((a, b, rho),) = found.correlations
    assert {a, b} == {"a", "b"} and rho < -0.999
    assert any("hardly be distinguished" in text for text in found.findings)


def test_points_without_a_value_are_left_out() -> None:
    x, y = X.copy(), Y.copy()
    x[3] = y[7] = np.nan
    found = arael.fit(FORMULA, {"x": x, "y": y})
    whole = np.isfinite(x) & np.isfinite(y)
    without = arael.fit(FORMULA, {"x": X[whole], "y": Y[whole]})
    assert found.skipped == 2 and found.parameters == without.parameters
    assert "2 points without a value are left out" in str(found)


def test_data_frames_and_records() -> None:
    records = np.rec.fromarrays([X, Y], names=["x", "y"])

    class Frame:
        columns = ("x", "y")

        def __getitem__(self, name: str) -> Any:
            return DATA[name]

    expected = arael.fit(FORMULA, DATA).parameters
    assert arael.fit(FORMULA, records).parameters == expected
    assert arael.fit(FORMULA, Frame()).parameters == expected


def test_several_files_and_the_group_of_each(tmp_path: Path) -> None:
    for name, slope in (("one", 2), ("two", 3)):
        rows = "\n".join(f"{x},{slope * x + 1}" for x in range(4))
        (tmp_path / f"{name}.csv").write_text(f"x,y\n{rows}\n")
    files = [tmp_path / "one.csv", tmp_path / "two.csv"]
    together = arael.fit("y = a * x + b", files)
    assert together.curve.points.size == 8
    assert together.parameters["a"] == pytest.approx(2.5)
    found = arael.fit("y = a * x + b", files, group="file", shared=["b"])
    assert found.parameters == pytest.approx({"b": 1, "a[one]": 2, "a[two]": 3})


def test_a_residual_formula() -> None:
    found = arael.fit("0 = (a * x + b - y) / 0.1", DATA)
    assert found.formula.predicts is None and found.r_squared is None
    slope, offset = np.polyfit(X, Y, 1)
    assert found.parameters == pytest.approx({"a": slope, "b": offset})
    with pytest.raises(AraelError, match="E0874"):
        found.bands({"x": 1})


@pytest.mark.parametrize(
    ("formula", "same"),
    [
        ("hypot(x - a, y - b) = r", "0 = hypot(x - a, y - b) - r"),
        ("x * (1 + a) = y - b", "0 = x * (1 + a) - y + b"),
        ("-y = a * x + b", "y = -(a * x + b)"),
    ],
)
def test_an_equation_is_the_difference_of_its_sides(formula: str, same: str) -> None:
    angle = np.arange(9.0)
    data = {"x": 3 + 2 * np.cos(angle), "y": 2 * np.sin(angle) - 1 + 0.01 * (-1) ** angle}
    found = arael.fit(formula, data)
    assert found.parameters == pytest.approx(arael.fit(same, data).parameters, rel=1e-6)
    assert found.formula.predicts is None
    if "r" in found.parameters:
        assert [*found.parameters.values()] == pytest.approx([3, -1, 2], abs=0.02)


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("log(y) = a -* b", "`-` is followed by `*`"),
        ("hypot(x - a, y = r", "expected an operator, `\\)` or `,`"),
        ("z = a * x", "no column 'z'"),
    ],
)
def test_mistakes_in_an_equation_are_named(formula: str, said: str) -> None:
    with pytest.raises(AraelError, match=said):
        arael.fit(formula, DATA)


def test_two_arrays_are_the_columns_x_and_y() -> None:
    found = arael.fit("a * exp(-b * x) + c", X, list(Y))
    assert found.parameters == arael.fit(FORMULA, DATA).parameters
    assert found["b"] == found.parameters["b"] == pytest.approx(0.7, abs=0.02)
    with pytest.raises(AraelError, match="did you mean 'b'"):
        found["B"]


def test_the_model_of_a_fit_is_an_ordinary_model() -> None:
    model = arael.fit(FORMULA, DATA).curve.model
    assert model.parameter_names() == ["a", "b", "c"]
    assert model.diagnose().cost == pytest.approx(model.cost())
    assert model.residual_values("formula").raw.shape == (40, 1)


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        ({"formula": "y = a * z"}, "", ""),
        ({"formula": "q = a * x"}, "E0871", "data has no column 'q'; it has x, y"),
        ({"formula": "y = 2 * x"}, "E0870", "there is nothing to fit"),
        ({"formula": "y = 3"}, "E0870", "nothing to fit"),
        ({"start": {"d": 1}}, "E0872", "'d' is not a parameter of the formula; it has a, b, c"),
        ({"bounds": {"a": (2, 1)}}, "E0872", "the bounds 2 .. 1 of 'a' are empty"),
        ({"bounds": {"a": 3}}, "E0872", "the bounds of 'a' are 3"),
        ({"bounds": {"a": (0, 1)}, "start": {"a": 2}}, "E0872", "is beyond 0 .. 1"),
        ({"start": {"a": "one"}}, "E0872", "expected a number for 'a', found 'one'"),
        ({"shared": ["a"]}, "E0872", "shared parameters need groups"),
        ({"fixed": {"a": 1, "b": 1, "c": 1}}, "E0872", "all parameters are fixed"),
        ({"sigma": 0}, "E0873", "the standard deviation of point 0 is 0"),
        ({"sigma": [1, 2]}, "E0873", "expected a number or 40 numbers"),
        ({"sigma": "s"}, "E0871", "no column 's'"),
        ({"data": {"x": [1, 2], "y": [1]}}, "E0873", "differ in length: x: 2, y: 1"),
        ({"data": {"x": ["p"], "y": [1]}}, "E0873", "the column 'x' is not numbers"),
        ({"data": {"x": [np.inf], "y": [1]}}, "E0873", "is infinite in row 0"),
        ({"data": {"x": [[1]], "y": [1]}}, "E0873", "has shape (1, 1)"),
        ({"data": {"x": [np.nan], "y": [1]}}, "E0873", "no point has all the values"),
        ({"data": 3}, "E0873", "expected columns by name or a file, found int"),
        ({"data": {}}, "E0873", "there are no points"),
        ({"data": X}, "E0873", "found ndarray"),
        ({"measured": Y}, "E0873", "two arrays are the columns"),
        ({"data": X, "measured": [[1.0]]}, "E0873", "two arrays are the columns"),
        ({"data": X, "measured": Y, "y": "v"}, "E0873", "give columns by name"),
        ({"data": X, "measured": Y[:3]}, "E0873", "differ in length"),
        ({"formula": curve}, "E0870", "`Model.add_residuals` takes functions"),
        ({"loss": "cauchi(2)"}, "E0640", "cauchi"),
        ({"max_iter": 3}, "E1010", "did you mean `max_iters`?"),
        ({"formula": 3}, "E0870", "a formula is text, found int"),
        ({"formula": "a * x + q.b"}, "E0870", "'q.b' is neither a column nor a name"),
        ({"formula": "a * x.__class__"}, "E0870", "write a plain name"),
        ({"formula": "a * x + self"}, "E0870", "'self' is neither a column nor a name"),
        ({"formula": "a * x + root.b"}, "E0870", "'root.b' is neither a column nor a name"),
        ({"y": 2}, "E0871", "expected the name of a column, found int"),
        ({"group": [0, 1]}, "E0871", "expected the name of a column, found list"),
        ({"start": [1, 2]}, "E0872", "write start={"),
        ({"start": {1: 1}}, "E0872", "'1' is not a parameter"),
        ({"fixed": "a"}, "E0872", "write fixed={"),
        ({"bounds": [(0, 1)]}, "E0872", 'write bounds={"a": (0, 1)}'),
        ({"bounds": {"a": "01"}}, "E0872", "the bounds of 'a' are '01'"),
        ({"bounds": {"a": (0, 1)}, "fixed": {"a": 2}}, "E0872", "fixed value 2 of 'a' is beyond"),
        ({"start": {"a": 1}, "fixed": {"a": 2}}, "E0872", "'a' is fixed at 2 and starts at 1"),
        ({"shared": 3, "group": "x"}, "E0872", "expected names of parameters, found int"),
        ({"sigma": np.nan}, "E0873", "the standard deviation is nan"),
        ({"data": {"x": [1j], "y": [1]}}, "E0873", "the column 'x' is complex128"),
        ({"data": {"x": np.array(["2020"], "M8[s]"), "y": [1]}}, "E0873", "is datetime64[s]"),
    ],
)  # fmt: skip
def test_mistakes(arguments: dict[str, Any], code: str, text: str) -> None:
    given = {"formula": FORMULA, "data": DATA, **arguments}
    if not code:  # an unknown name is a parameter
        found = arael.fit("y = a * x + z", DATA)
        assert set(found.parameters) == {"a", "z"}
        return
    with pytest.raises(AraelError) as caught:
        arael.fit(given.pop("formula"), given.pop("data"), **given)
    (first, *_) = caught.value.diagnostics
    assert text in str(caught.value)
    assert first.code == code


def test_a_comment_is_no_part_of_the_formula() -> None:
    assert set(arael.fit("y = a * x + z  # a line", DATA).parameters) == {"a", "z"}


def test_one_shared_parameter_may_be_given_as_text() -> None:
    data = {"x": [0.0, 1.0, 2.0, 0.0, 1.0], "y": [1.0, 3.0, 5.0, 2.0, 4.0], "g": [0, 0, 0, 1, 1]}
    found = arael.fit("y = slope * x + b", data, group="g", shared="slope")
    assert list(found.parameters) == ["slope", "b[0]", "b[1]"]


def test_files_of_one_name_are_groups_of_their_own(tmp_path: Path) -> None:
    paths = [tmp_path / folder / "run.csv" for folder in "pq"]
    for k, path in enumerate(paths):
        path.parent.mkdir()
        path.write_text(f"x,y\n0,{k}\n1,{k + 2}\n2,{k + 4}\n")
    found = arael.fit("y = a * x + b", paths, group="file", shared="a")
    assert list(found.parameters) == ["a", f"b[{paths[0]}]", f"b[{paths[1]}]"]
    with pytest.raises(AraelError, match="the file is given twice"):
        arael.fit("y = a * x + b", [paths[0], paths[0]])


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((None,), "expected columns by name, found NoneType"),
        (({"x": "a"},), "the columns ['x'] are not all numbers"),
        (({"x": [1.0]}, "left"), "the fit has no groups"),
    ],
)
def test_mistakes_of_a_prediction(arguments: tuple[Any, ...], text: str) -> None:
    found = arael.fit("y = a * x + b", {"x": [0.0, 1.0, 2.0], "y": [0.0, 1.0, 2.1]})
    with pytest.raises(AraelError) as caught:
        found.predict(*arguments)
    assert text in str(caught.value)


def test_what_the_points_do_not_determine_is_named() -> None:
    with pytest.raises(arael.SolveError, match="E1008") as caught:
        arael.fit("y = (a + b) * x", DATA)
    assert "+1 a -1 b" in str(caught.value)


def test_a_constant_and_its_table() -> None:
    found = arael.fit("y = a", {"y": Y})
    assert found.parameters["a"] == pytest.approx(Y.mean())
    assert found.sigma["a"] == pytest.approx(Y.std(ddof=1) / np.sqrt(40))
    assert {len(column) for column in found.table().values()} == {40}


def test_as_many_parameters_as_points() -> None:
    found = arael.fit("y = a * x + b", {"x": [1, 2], "y": [1, 2]})
    assert np.isnan(found.sigma["a"]) and "AIC" not in str(found)
    assert "standard errors cannot be estimated" in str(found)
    assert np.isnan(found.bands({"x": 1}).high).all()


def test_too_few_points_are_reported_with_their_group() -> None:
    data = {"x": [0, 1, 2, 0], "y": [1, 2, 3, 4], "sample": ["p", "p", "p", "q"]}
    with pytest.raises(AraelError) as caught:
        arael.fit("y = a * x + b", data, group="sample")
    assert caught.value.diagnostics[0].code == "E0873"
    assert "the group 'q' of 'sample' has 1 point for 2 parameters: a, b" in str(caught.value)
    found = arael.fit("y = a * x + b", data, group="sample", shared=["a"])
    assert found.parameters["b[q]"] == pytest.approx(4)
    with pytest.raises(AraelError, match="the data have 1 point for 2 parameters: a, b"):
        arael.fit("y = a * x + b", {"x": [1], "y": [1]})
    arael.fit("y = a * x + b", {"x": [1], "y": [1]}, fixed={"a": 2})


@pytest.mark.parametrize(
    ("formula", "sentence", "same"),
    [
        ("a * b * x + c", "`a` and `b` are not determined, only a*b = {} +- {}", "a"),
        ("a * b^2 * x + c", "`a` and `b` are not determined, only a*b^2 = {} +- {}", "a"),
        ("a / b * x + c", "`a` and `b` are not determined, only a/b = {} +- {}", "a"),
        ("a * b * d * x + c", "`a`, `b` and `d` are not determined, only a*b*d = {} +- {}", "a"),
        ("a * x + (b + c)", "`b` and `c` are not determined, only b + c = {} +- {}", "c"),
        ("a * x + b - 4 * c", "`b` and `c` are not determined, only b - 4 c = {} +- {}", "c"),
    ],
)
def test_what_is_determined_in_place_of_parameters(formula: str, sentence: str, same: str) -> None:
    x = np.linspace(1, 5, 30)
    y = 2 * x + 1 + np.random.default_rng(3).normal(0, 0.05, 30)
    with pytest.raises(arael.SolveError, match="E1008") as caught:
        arael.fit("y = " + formula, {"x": x, "y": y}, sigma=0.05)
    line = arael.fit("y = a * x + c", {"x": x, "y": y}, sigma=0.05)
    texts = measured(line.parameters[same], line.sigma[same])
    assert sentence.format(*texts) in str(caught.value)


def test_parameters_that_change_together_otherwise() -> None:
    x = np.linspace(1, 5, 30)
    data = {"x": x, "y": np.exp(-x) + 0.01 * np.cos(9 * x)}
    for start, sentence in (
        (1.0, "`b` and `c` are not determined: they can change together"),
        (75.0, "`b` is not determined: others make up for it"),
    ):
        with pytest.raises(arael.SolveError, match="E1008") as caught:
            arael.fit("y = c * exp(b - a * x)", data, start={"b": start})
        assert sentence in str(caught.value)


def test_a_parameter_on_which_the_curve_hardly_depends() -> None:
    x = np.linspace(1, 5, 30)
    y = 2 * x + 0.01 * np.cos(9 * x)
    with pytest.raises(arael.SolveError, match="E1008") as caught:
        arael.fit("y = a * x + exp(-b * x)", {"x": x, "y": y}, start={"a": 2.0, "b": 300.0})
    assert "`b` is not determined: the curve hardly depends on it" in str(caught.value)


def test_values_far_below_their_standard_errors_are_determined() -> None:
    x = np.linspace(-1, 1, 20)
    found = arael.fit("y = a + b * x", {"x": x, "y": np.tile([0.1, -0.1, -0.1, 0.1], 5)})
    assert abs(found.parameters["a"]) < 1e-6 * found.sigma["a"]
    assert found.estimates.flat == ()
