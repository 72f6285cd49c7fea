"""The fit of a curve given as text, against SciPy on the same data."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.optional import needs

TIGHT = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14}
DEMO = Path(__file__).parents[2] / "examples" / "runtime_fit_demo" / "runtime_fit_demo.py"


def test_runtime_fit_demo(capsys: pytest.CaptureFixture[str]) -> None:
    demo = runpy.run_path(str(DEMO))
    fits = demo["main"]([])
    x, y, wrong = demo["make_data"]()
    gamma = 2 / np.pi * np.sqrt(25)

    def residuals(p: np.ndarray) -> np.ndarray:
        return (p[0] * np.exp(-p[1] * x) + p[2] - y) / demo["SIGMA"]

    plain = least_squares(residuals, [1, 0.3, 0], **TIGHT)
    robust = least_squares(
        lambda p: gamma * np.arctan(residuals(p) / gamma), [2.5, 0.7, 0.3], **TIGHT
    )
    np.testing.assert_allclose(list(fits["least squares"].values()), plain.x, rtol=1e-5)
    np.testing.assert_allclose(list(fits["robust"].values()), robust.x, rtol=1e-4)
    np.testing.assert_allclose(list(fits["robust"].values()), [2.5, 0.7, 0.3], rtol=0.03)
    np.testing.assert_allclose(
        list(fits["robust by code"].values()), list(fits["robust"].values()), rtol=1e-6
    )
    assert wrong.sum() == 15
    assert "robust" in capsys.readouterr().out


@needs("matplotlib")
def test_another_equation_and_a_picture(tmp_path: Path) -> None:
    main = runpy.run_path(str(DEMO))["main"]
    picture = tmp_path / "fit.png"
    fits = main(["p / (1 + q * x) + r", "--start", "p=1", "q=1", "r=0", "--plot", str(picture)])
    assert set(fits["robust"]) == {"p", "q", "r"}
    assert picture.stat().st_size > 1000
