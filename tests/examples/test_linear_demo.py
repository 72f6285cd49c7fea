"""The figures of linear_demo against NumPy and SciPy."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import least_squares

from arael.demo.linear import make_points
from tests.examples.scripts import printed

GAMMA = 2 * np.sqrt(25) / np.pi


def test_both_lines(monkeypatch, capsys) -> None:
    text = printed("linear_demo", [], monkeypatch, capsys)
    found = {
        name: (float(slope), float(offset))
        for name, slope, offset in re.findall(r"  (\w+ \w+) +([\d.]+) x ([-+][\d.]+)", text)
    }
    x, y, wrong = make_points(100, 0.3, 42)
    assert found["least squares"] == pytest.approx(np.polyfit(x, y, 1), abs=1e-4)

    def robust(line: np.ndarray) -> np.ndarray:
        return GAMMA * np.arctan((line[0] * x + line[1] - y) / 0.01 / GAMMA)

    right = np.polyfit(x[~wrong], y[~wrong], 1)
    best = least_squares(robust, right, xtol=1e-12, ftol=1e-14)
    assert found["robust fit"] == pytest.approx(best.x, abs=2e-4)
