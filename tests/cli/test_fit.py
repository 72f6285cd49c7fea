"""`arael fit`: a formula and a CSV file, against scipy.optimize.curve_fit."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import curve_fit

from arael.io.csv_numbers import readable_names
from tests.cli.conftest import Arael
from tests.optional import require

FORMULA = "a * exp(-b * t) + c"


@pytest.fixture
def points(tmp_path: Path) -> Path:
    t = np.linspace(0, 5, 40)
    y = 2.5 * np.exp(-0.7 * t) + 0.3 + 0.01 * np.random.default_rng(0).normal(size=40)
    path = tmp_path / "points.csv"
    np.savetxt(path, np.column_stack([t, y]), delimiter=",", header="t,y", comments="")
    return path


def test_agrees_with_scipy(arael: Arael, points: Path) -> None:
    done = arael("fit", FORMULA, points, "--json")
    assert done.code == 0
    t, y = np.loadtxt(points, delimiter=",", skiprows=1).T
    best, covariance = curve_fit(lambda t, a, b, c: a * np.exp(-b * t) + c, t, y, [1, 1, 1])
    found = done.json["parameters"]
    assert list(found) == ["a", "b", "c"]
    np.testing.assert_allclose([p["value"] for p in found.values()], best, rtol=1e-6)
    sigmas = np.sqrt(covariance.diagonal())
    np.testing.assert_allclose([p["sigma"] for p in found.values()], sigmas, rtol=1e-4)
    assert done.json["points"] == 40 and done.json["status"] == "converged"


def test_sigma_and_loss(arael: Arael, points: Path) -> None:
    plain = arael("fit", FORMULA, points, "--json", "--sigma", "0.01").json
    t, y = np.loadtxt(points, delimiter=",", skiprows=1).T
    model = lambda t, a, b, c: a * np.exp(-b * t) + c  # noqa: E731
    _, covariance = curve_fit(model, t, y, [1, 1, 1], np.full(40, 0.01), absolute_sigma=True)
    sigmas = [p["sigma"] for p in plain["parameters"].values()]
    np.testing.assert_allclose(sigmas, np.sqrt(covariance.diagonal()), rtol=1e-4)

    y[::8] += 1
    np.savetxt(points, np.column_stack([t, y]), delimiter=",", header="t,y", comments="")
    drawn = arael("fit", FORMULA, points, "--json", "--sigma", "0.01").json["parameters"]
    robust = arael("fit", FORMULA, points, "--json", "--sigma", "0.01", "--loss", "cauchy(2)")
    assert abs(drawn["c"]["value"] - 0.3) > 0.03
    assert abs(robust.json["parameters"]["c"]["value"] - 0.3) < 0.02


def test_text_start_and_target(arael: Arael, points: Path) -> None:
    done = arael("fit", "slope * y + offset", points, "--y", "t", "--start", "slope=-1", "-v")
    assert done.code == 0
    offset, slope, ended = done.out.splitlines()
    assert offset.startswith("offset = 4.53") and slope.startswith("slope  = -2.0")
    assert "+-" in slope and ended.startswith("converged after") and "1/0: " in done.err


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("a * sine(t)",), 2, "did you mean `sin`?"),
        (("t + y",), 2, "there is nothing to fit"),
        (("(a + b) * t",), 1, "free direction: +1 a -1 b"),
        (("a * t", "--start", "q=1"), 2, "'q' is not a parameter of the formula; it has a"),
        (("a * t", "--start", "a=one"), 2, "expected NAME=NUMBER"),
        (("a * t", "--start", "a=1_5"), 2, "expected NAME=NUMBER"),
        (("a * t", "--y", "z"), 2, "no column 'z'; it has t, y"),
        (("a * t + c - c",), 2, "the formula does not depend on 'c'"),
        (("a * t + 0 * c + sign(d)",), 2, "the formula does not depend on 'c', 'd'"),
        (("a * np.exp(t)",), 2, "write 'exp' for 'np.exp'"),
        (("a * math.fabs(t)",), 2, "write 'abs' for 'math.fabs'"),
        (("y = a * t - y",), 2, 'write a residual as "0 = a * t - y"'),
        (("y = a * t", "--y", "t"), 2, "'y' is on the left of FORMULA, and 't' is given with --y"),
        (("z = a * t",), 2, "no column 'z'; it has t, y"),
    ],
)
def test_mistakes(
    arael: Arael, points: Path, arguments: tuple[str, ...], code: int, text: str
) -> None:
    done = arael("fit", arguments[0], points, *arguments[1:])
    assert done.code == code
    assert text in done.err


def test_a_file_that_is_no_table_of_numbers(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text("t,y,t\n1,2,3\n1,two,inf\n1,2\n")
    done = arael("fit", "a * t", path)
    assert done.code == 2
    for part in (
        "error[E0718]: the column `t` is given twice",
        'error[E0703]: expected a number, found "two"\n --> bad.csv:3: y',
        'error[E0705]: expected a finite number, found "inf"\n --> bad.csv:3: t',
        "error[E0704]: expected 3 cells, found 2\n --> bad.csv:4",
    ):
        assert part in done.err
    path.write_text("t,y\n")
    assert "E0711" in arael("fit", "a * t", path).err


def test_rms_and_standard_deviation_are_what_they_are_called(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y\n0,0\n1,2\n2,1\n3,3\n")
    found = arael("fit", "a * x + b", path, "--json").json
    residuals = np.polyval(np.polyfit([0, 1, 2, 3], [0, 2, 1, 3], 1), [0, 1, 2, 3]) - [0, 2, 1, 3]
    assert found["rms"] == pytest.approx(np.sqrt(np.mean(residuals**2)))
    assert found["residual_sd"] == pytest.approx(np.sqrt(np.sum(residuals**2) / 2))
    text = arael("fit", "a * x + b", path).out
    assert "rms 0.671, residual standard deviation 0.949" in text
    assert "rms 6.71 sigmas" in arael("fit", "a * x + b", path, "--sigma", "0.1").out


def test_as_many_parameters_as_points_have_no_scatter(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y\n0,0\n1,2\n")
    done = arael("fit", "a * x + b", path)
    assert "a = 2 +- unknown" in done.out and "sigma cannot be estimated" in done.out
    assert arael("fit", "a * x + b", path, "--json").json["parameters"]["a"]["sigma"] is None
    known = arael("fit", "a * x + b", path, "--json", "--sigma", "1").json["parameters"]
    assert known["b"]["sigma"] == pytest.approx(1)


@pytest.mark.parametrize("formula", ["(a * t + b - y) / 0.1", "0 = (a * t + b - y) / 0.1"])
def test_a_formula_with_the_measured_column_is_a_residual(
    arael: Arael, points: Path, formula: str
) -> None:
    expected = arael("fit", "y = a * t + b", points, "--json").json
    found = arael("fit", formula, points, "--json").json
    assert found["predicts"] is None and expected["predicts"] == "y"
    for name in "ab":
        for what in ("value", "sigma"):
            assert found["parameters"][name][what] == pytest.approx(
                expected["parameters"][name][what], rel=1e-6
            )
    assert "minimised as a residual" in arael("fit", formula, points).out


def test_a_robust_residual(arael: Arael, points: Path) -> None:
    """The best starship fit of a line, found by SciPy."""
    from scipy.optimize import least_squares

    t, y = np.loadtxt(points, delimiter=",", skiprows=1).T
    best = least_squares(lambda p: 3 * np.arctan((p[0] * t + p[1] - y) / 0.1 / 3), [-0.3, 1.5]).x
    starts = ["--start", "a=-0.3", "--start", "b=1.5"]
    found = arael("fit", "starship((a*t+b-y)/0.1, 3)", points, *starts, "--json").json
    assert [p["value"] for p in found["parameters"].values()] == pytest.approx(best, rel=1e-4)


def test_columns_that_are_not_read_may_hold_text(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text(
        "# made by hand\nTime (s),wheel speed [m/s],note\n0,1,ok\n# half\n1,3,bad\n2,5,\n"
    )
    found = arael("fit", "wheel_speed = a * Time + b", path, "--json").json
    assert found["parameters"]["a"]["value"] == pytest.approx(2)
    by_title = arael("fit", "a * Time + b", path, "--y", "wheel speed [m/s]", "--json").json
    assert by_title["parameters"] == found["parameters"]
    wrong = arael("fit", "wheel_speed = a * note", path)
    assert 'expected a number, found "bad"\n --> points.csv:5: note' in wrong.err
    missing = arael("fit", "a * Time", path).err
    assert "no column 'y'" in missing and "0 = FORMULA; it has Time, wheel_speed, note" in missing


def test_names_of_columns_in_a_comment(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    table = np.array([[0, 1], [1, 3], [2, 5.0]])
    np.savetxt(path, table, delimiter=",", header="t,y")
    found = arael("fit", "a * t + b", path, "--json").json
    assert found["parameters"]["a"]["value"] == pytest.approx(2) and found["points"] == 3
    np.savetxt(path, table, delimiter=",")
    without = arael("fit", "a * t + b", path)
    assert without.code == 2
    assert "E0711" in without.err and "found numbers" in without.err
    assert "put a line such as `x,y` above them" in without.err
    path.write_text("# nothing\n")
    assert "there are no rows, only comments" in arael("fit", "a * t", path).err


def test_titles_that_differ_in_their_unit_only() -> None:
    titles = readable_names(["v (m)", "v (s)", "w (m)", "w", "2nd", "ok"])
    assert titles == {
        "v_m": "v (m)", "v_s": "v (s)", "w_m": "w (m)", "w": "w", "_2nd": "2nd", "ok": "ok"
    }  # fmt: skip


def test_bounds_and_fixed_parameters(arael: Arael, points: Path) -> None:
    done = arael("fit", FORMULA, points, "--bound", "c=0.35:", "--bound", "b=:5")
    assert "c = 0.35 (on its lower bound 0.35)" in done.out
    found = arael("fit", FORMULA, points, "--fix", "c=0.3", "--json").json
    assert found["parameters"]["c"]["value"] == 0.3
    assert "c = 0.3 (fixed)" in arael("fit", FORMULA, points, "--fix", "c=0.3").out


def test_a_column_of_sigmas(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x [m];y [V];dy [V]\n1;1,1;0,1\n2;2,3;0,2\n3;2,9;0,1\n4;4,2;0,4\n")
    found = arael("fit", "y = a * x", path, "--sigma", "dy", "--json").json["parameters"]["a"]
    x, y, s = (
        np.array([1, 2, 3, 4.0]),
        np.array([1.1, 2.3, 2.9, 4.2]),
        np.array([0.1, 0.2, 0.1, 0.4]),
    )
    weight = np.sum(x**2 / s**2)
    assert found["value"] == pytest.approx(np.sum(x * y / s**2) / weight)
    assert found["sigma"] == pytest.approx(weight**-0.5)
    relative = arael("fit", "y = a * x", path, "--sigma", "dy", "--relative-sigma", "--json").json
    reduced = np.sum(((y - found["value"] * x) / s) ** 2) / 3
    assert relative["parameters"]["a"]["sigma"] == pytest.approx((reduced / weight) ** 0.5)
    assert "no column 'dz'" in arael("fit", "y = a * x", path, "--sigma", "dz").err


def test_groups_of_a_column_and_of_files(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y,sample\n1,3,p\n2,5,p\n3,7,p\n1,4,q r\n2,7,q r\n3,10,q r\n")
    done = arael("fit", "y = a * x + b", path, "--group", "sample", "--shared", "b")
    assert done.code == 0
    assert "a[p]   = 2" in done.out and "a[q r] = 3" in done.out
    for name, slope in (("one", 2), ("two", 3)):
        (tmp_path / f"{name}.csv").write_text(f"x,y\n1,{slope + 1}\n2,{2 * slope + 1}\n")
    files = tmp_path / "one.csv", tmp_path / "two.csv"
    both = arael("fit", "y = a * x + b", *files, "--group", "file", "--shared", "b", "--json").json
    assert {k: round(p["value"], 9) for k, p in both["parameters"].items()} == {
        "b": 1, "a[one]": 2, "a[two]": 3
    }  # fmt: skip


def test_summary_and_intervals(arael: Arael, points: Path) -> None:
    done = arael("fit", FORMULA, points, "--summary", "--intervals", "--level", "0.9")
    for text in ("degrees of freedom       37", "R squared", "AIC", "BIC", "residual deviation"):
        assert text in done.out
    found = arael("fit", FORMULA, points, "--intervals", "--level", "0.9", "--json").json
    one = found["parameters"]["b"]
    low, high = found["intervals"]["b"]
    # Nearly linear: the profile is close to value +- t sigma.
    assert low == pytest.approx(one["value"] - 1.687 * one["sigma"], rel=1e-3)
    assert high == pytest.approx(one["value"] + 1.687 * one["sigma"], rel=1e-3)
    assert found["degrees_of_freedom"] == 37 and found["aic"] < 0 and found["r_squared"] > 0.999


def test_output_holds_points_curve_and_bands(arael: Arael, points: Path, tmp_path: Path) -> None:
    out = tmp_path / "fit.csv"
    done = arael("fit", FORMULA, points, "-o", out)
    assert f"wrote {out}" in done.out
    table = np.genfromtxt(out, delimiter=",", names=True)
    assert table.dtype.names == (
        "t", "y", "fit", "low", "high", "predicted_low", "predicted_high", "residual"
    )  # fmt: skip
    np.testing.assert_allclose(table["y"] - table["fit"], table["residual"], atol=1e-12)
    assert (table["predicted_low"] < table["low"]).all()
    written = tmp_path / "fit.json"
    assert arael("fit", FORMULA, points, "--output", written).code == 0
    assert '"predicts": "y"' in written.read_text()
    wrong = arael("fit", FORMULA, points, "-o", tmp_path / "fit.xlsx")
    assert wrong.code == 2 and "E0855" in wrong.err and "fit.csv" in wrong.err


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("--bound", "a=1"), "expected NAME=LOW:HIGH, found 'a=1'"),
        (("--bound", "a=x:1"), "expected NAME=LOW:HIGH"),
        (("--bound", "q=0:1"), "'q' is not a parameter of the formula; it has a, b, c"),
        (("--bound", "a=2:1"), "the bounds 2 .. 1 of 'a' are empty"),
        (("--fix", "a"), "expected NAME=NUMBER, found 'a'"),
        (("--shared", "a"), "shared parameters need groups"),
        (("--group", "q"), "no column 'q'"),
        (("--sigma", "-1"), "the standard deviation of point 0 is -1"),
        (("--level", "95"), "is not in the range"),
    ],
)
def test_mistakes_in_options(
    arael: Arael, points: Path, arguments: tuple[str, ...], text: str
) -> None:
    done = arael("fit", FORMULA, points, *arguments)
    assert done.code == 2 and text in done.err


def test_a_plot(arael: Arael, points: Path, tmp_path: Path) -> None:
    require("matplotlib")
    picture = tmp_path / "fit.svg"
    assert arael("fit", FORMULA, points, "--plot", picture).code == 0
    text = picture.read_text()
    assert "<svg" in text and "residuals" in text
    wrong = arael("fit", FORMULA, points, "--plot", tmp_path / "fit.bmp")
    assert "E0861" in wrong.err


@pytest.mark.parametrize(
    "text",
    [
        "x y\n1 3\n2 5\n3 7\n",
        "x [m]  y [V]\n1   3\n2\t5\n3   7\n",
        "x;y\n1,0;3,0\n2,0;5,0\n3,0;7,0\n",
        "x\ty\n1\t3\n2\t5\n3\t7\n",
        "x|y\n1|3\n2|5\n3|7\n",
        "% made by hand\nx,y,\n1,3,\n2,5,\n3,7,\n",
        "x,y\n1,3\nNA,4\n2,5\n2,\n3,7\n3,n/a\n",
        'x,"y [V, peak]"\n1,3\n2,5\n3,7\n',
        "# x y\n1 3\n2 5\n3 7\n",
    ],
    ids=["spaces", "units", "decimal comma", "tabs", "bars", "end", "missing", "quotes", "comment"],
)
def test_tables_as_instruments_write_them(arael: Arael, tmp_path: Path, text: str) -> None:
    path = tmp_path / "points.csv"
    path.write_text(text)
    found = arael("fit", "y = a * x + b", path, "--json").json
    values = {name: one["value"] for name, one in found["parameters"].items()}
    assert values == pytest.approx({"a": 2, "b": 1})
    assert found["points"] == 3
    assert found["skipped"] == (3 if "NA" in text else 0)


def test_rows_left_out_are_noted(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y\n1,3\n2,nan\n3,7\n4,9\n")
    assert "note: 1 points without a value are left out" in arael("fit", "y = a*x + b", path).err


def test_digits_follow_the_uncertainty(arael: Arael, tmp_path: Path) -> None:
    t = np.linspace(-1, 1, 41)
    y = 3 * np.exp(-0.5 * ((t - 0.2) / 0.4) ** 2)
    y += 0.05 * np.random.default_rng(5).normal(size=41)
    path = tmp_path / "peak.csv"
    rows = [f"{1700011 + a!r},{b!r}\n" for a, b in zip(t.tolist(), y.tolist(), strict=True)]
    path.write_text("x,y\n" + "".join(rows))
    command = ("fit", "a * exp(-0.5 * ((x - m) / s)^2)", path, "--start", "m=1700011")
    value, sigma = arael(*command, "--json").json["parameters"]["m"].values()
    assert 1e-3 < sigma < 1e-2 and abs(value - 1700011.2) < 4 * sigma
    line = next(one for one in arael(*command).out.splitlines() if one.startswith("m = "))
    assert line == f"m = {value:.4f} +- {sigma:.4f}"
    interval = re.search(r"m = [^\[]*\[(.*), (.*)\]", arael(*command, "--intervals").out)
    assert interval is not None
    assert float(interval[2]) - float(interval[1]) == pytest.approx(4 * sigma, rel=0.1)


def test_a_flat_direction_is_named_with_what_is_determined(arael: Arael, tmp_path: Path) -> None:
    path = tmp_path / "step.csv"
    y = [0.0, 0.1, -0.1, 0.0, 0.7, 1.1, 0.9, 1.0, 1.0]
    path.write_text("x,y\n" + "".join(f"{k},{one}\n" for k, one in enumerate(y)))
    done = arael("fit", "b / (1 + exp(-(c + d * x)))", path)
    assert done.code == 0
    sentence = done.out.splitlines()[-1]
    assert sentence.startswith("`c` and `d` are not determined, only -c/d = ")
    value, sigma = map(float, sentence.rpartition("= ")[2].split(" +- "))
    # c + 4 d is the logit of 0.7, so that -c/d is below 4 by its share of d
    assert 3.9 < value < 4 and 0 < sigma < 0.1
    assert sentence in arael("fit", "b / (1 + exp(-(c + d * x)))", path, "--json").json["findings"]
