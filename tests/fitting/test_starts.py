"""Starts found by the program, and the scales that they are drawn from."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.fitting.scales import exponents, quantiles
from arael.fitting.starts import _linear, _sequence


def test_exponents_of_units() -> None:
    found = exponents("a * exp(-b * x) / (c + d * x)", "y", ("a", "b", "c", "d"), ("x", "y"))
    # Only the ratio of a to c and d is known: the least exponents are taken.
    np.testing.assert_allclose(found[1], [-1, 0])
    np.testing.assert_allclose(found[3] - found[2], [-1, 0])
    np.testing.assert_allclose(found[0] - found[2], [0, 1])
    found = exponents("a + b * (x - c)^2 / d^2", "y", ("a", "b", "c", "d"), ("x", "y"))
    np.testing.assert_allclose(found[[0, 2]], [[0, 1], [1, 0]])
    found = exponents("a * sqrt(x - p)", "y", ("a", "p"), ("x", "y"))
    np.testing.assert_allclose(found, [[-0.5, 1], [1, 0]])


def test_candidates_of_a_place_are_in_the_range_of_its_column() -> None:
    u = np.linspace(0.01, 0.99, 99)
    columns = {"x": np.array([10.0, 20.0]), "y": np.array([0.0, 1.0])}
    places = quantiles(np.array([1.0, 0.0]), columns, -np.inf, np.inf)(u)
    assert ((places[:49] >= 10) & (places[:49] <= 20)).all()
    rates = quantiles(np.array([-1.0, 0.0]), columns, 0.0, np.inf)(u)
    assert (rates >= 0).all() and rates.min() < 1e-3 / 20 * 10 and rates.max() > 10
    bounded = quantiles(np.array([-1.0, 0.0]), columns, 2.0, 3.0)(u)
    assert ((bounded >= 2) & (bounded <= 3)).all()


def test_linear_parameters_are_found() -> None:
    x = np.linspace(1, 2, 20)
    curve = arael.fit(
        "y = a * b * x + c + x^d",
        {"x": x, "y": x},
        start=dict(zip("abcd", [1] * 4, strict=True)),
        fixed={"a": 1.0},
    ).curve
    searched = np.ones(4, dtype=bool)
    at = np.array([[1.0, 2, 3, 0.5], [2.0, 1, 0, 1.5]])
    # One of a and b, which have a product, and c; not d.
    assert _linear(curve, at, searched).tolist() in (
        [False, True, True, False], [True, False, True, False]
    )  # fmt: skip


def test_the_sequence_fills_the_square_evenly() -> None:
    points = _sequence(400, 2)
    counts, *_ = np.histogram2d(*points.T, bins=10, range=[[0, 1], [0, 1]])
    assert counts.min() >= 2 and counts.max() <= 6


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_peak_is_found_in_any_unit(scale: float) -> None:
    x = np.linspace(40, 60, 80) * scale
    y = 3e5 * np.exp(-((x / scale - 52.3) ** 2) / 0.8**2) + 1e5
    found = arael.fit("y = h * exp(-(x - m)^2 / w^2) + c", {"x": x, "y": y})
    assert found.parameters["m"] == pytest.approx(52.3 * scale)
    assert abs(found.parameters["w"]) == pytest.approx(0.8 * scale)


def test_two_frequencies_are_found() -> None:
    t = np.linspace(0, 30, 200)
    y = 2 * np.sin(2.2 * t + 0.3) + np.cos(0.71 * t) + 4
    found = arael.fit(
        "y = c + a1*cos(w1*t) + b1*sin(w1*t) + a2*cos(w2*t) + b2*sin(w2*t)", {"t": t, "y": y}
    )
    values = sorted(abs(found.parameters[name]) for name in ("w1", "w2"))
    assert values == pytest.approx([0.71, 2.2])


def test_given_starts_are_kept() -> None:
    x = np.linspace(0, 6, 60)
    data = {"x": x, "y": np.sin(3 * x)}
    # The nearest local minimum to w = 1 is not that of w = 3.
    near = arael.fit("y = a * sin(w * x)", data, start={"a": 1, "w": 1.0})
    assert abs(near.parameters["w"] - 3) > 0.1 and near.starts == {"a": 1.0, "w": 1.0}
    found = arael.fit("y = a * sin(w * x)", data)
    assert abs(found.parameters["w"]) == pytest.approx(3)


def test_a_search_gives_the_same_each_time() -> None:
    x = np.linspace(0, 5, 30)
    data = {"x": x, "y": 1 / (1 + np.exp(2 - 3 * x))}
    first, second = (arael.fit("y = a / (1 + exp(b - c * x))", data).starts for _ in range(2))
    assert first == second


def test_groups_with_different_nonlinear_parameters() -> None:
    x = np.tile(np.linspace(0, 10, 50), 2)
    g = np.repeat(["p", "q"], 50)
    y = np.where(g == "p", 2 * np.exp(-((x - 3) ** 2)), 5 * np.exp(-((x - 7) ** 2)))
    found = arael.fit(
        "y = h * exp(-(x - m)^2 / w^2)", {"x": x, "y": y, "g": g}, group="g", shared=["w"]
    )
    assert found.parameters["m[p]"] == pytest.approx(3)
    assert found.parameters["m[q]"] == pytest.approx(7)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("phase", "turn"), [("2 * pi * f * t + phi", 2 * np.pi), ("deg2rad(360 * f * t + phi)", 360.0)]
)
def test_frequencies_are_positive_and_phases_small(seed: int, phase: str, turn: float) -> None:
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 3, 120)
    y = 0.8 * np.exp(-0.6 * t) * np.cos(2 * np.pi * (2.3 * t + 0.06))
    y += 0.02 * rng.normal(size=120)
    found = arael.fit(f"y = A * exp(-d * t) * cos({phase})", {"t": t, "y": y})
    assert found["f"] == pytest.approx(2.3, abs=0.02)
    assert abs(found["phi"]) <= turn / 2
    at = np.exp(2j * np.pi * found["phi"] / turn)
    assert found["A"] * at == pytest.approx(0.8 * np.exp(0.12j * np.pi), abs=0.05)
    # Where a sign is known from the data, or bounded, it stays.
    y = -3 * np.exp(-0.5 * t)
    assert arael.fit("y = a * exp(b * t)", {"t": t, "y": y}).parameters == pytest.approx(
        {"a": -3, "b": -0.5}
    )
    both = arael.fit("y = w^2 * t^2", {"t": t, "y": 4 * t**2}, bounds={"w": (-9, -1)})
    assert both["w"] == pytest.approx(-2)
