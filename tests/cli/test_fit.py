"""`arael fit`: a formula and a CSV file, against scipy.optimize.curve_fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import curve_fit

from tests.cli.conftest import Arael

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
        (("a * t", "--start", "q=1"), 2, "'q' is no parameter of the formula; it has a"),
        (("a * t", "--start", "a=one"), 2, "expected NAME=NUMBER"),
        (("a * t", "--start", "a=1_5"), 2, "expected NAME=NUMBER"),
        (("a * t", "--y", "z"), 2, "no column 'z'; it has t, y"),
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
    path.write_text("t,y,t\n1,2,3\n1,two,nan\n1,2\n")
    done = arael("fit", "a * t", path)
    assert done.code == 2
    for part in (
        "error[E0718]: the column `t` is given twice",
        'error[E0703]: expected a number, found "two"\n --> bad.csv:3: y',
        'error[E0705]: expected a finite number, found "nan"\n --> bad.csv:3: t',
        "error[E0704]: expected 3 cells, found 2\n --> bad.csv:4",
    ):
        assert part in done.err
    path.write_text("t,y\n")
    assert "E0711" in arael("fit", "a * t", path).err
