"""Sides that a solve keeps, bounds on unknowns, continuation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arael.runtime.levels.compiled import Levels, PythonRows
from arael.runtime.levels.follow import follow
from tests.runtime.levels.systems import distances, linear

Array = NDArray[np.float64]


def turn(a: int, b: int, c: int, points: int) -> PythonRows:
    """Twice the signed area of the triangle a b c."""

    def area(x: Array) -> Array:
        p = x.reshape(-1, 2)
        u, v = p[b] - p[a], p[c] - p[a]
        return np.array([u[0] * v[1] - u[1] * v[0]])

    pattern = [[2 * k + i for k in (a, b, c) for i in (0, 1)]]
    return PythonRows(area, n=2 * points, m=1, pattern=pattern)


def triangle(lengths: list[float]) -> PythonRows:
    held = [(0, 0.0), (1, 0.0), (3, 0.0)]
    return distances(3, [[0, 1], [1, 2], [2, 0]], lengths, held)


def test_a_guard_keeps_its_side() -> None:
    """A start just above the base of a triangle, pulled below it, solves above."""
    side = turn(0, 1, 2, 3)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        x = np.array([0, 0, 4, 0, *rng.uniform([-2, 0.01], [6, 6])])
        outcome = Levels(triangle([4.0, 3.0, 3.0]), guards=side).solve(x)
        assert outcome.solved
        np.testing.assert_allclose(x[4:], [2, np.sqrt(5)], atol=1e-9)


def test_a_solution_on_the_other_side_only_is_refused_with_the_guard() -> None:
    rows = linear(np.array([[1.0]]), [-1.0])
    guards = PythonRows(lambda x: np.array([1.0, x[0]]), n=1, m=2, pattern=[[], [0]])
    x = np.array([1.0])
    outcome = Levels(rows, guards=guards).solve(x)
    assert (outcome.status, outcome.guard) == ("side", 1)
    assert x[0] == 1.0


def test_a_guard_that_is_zero_at_the_start_may_take_any_sign() -> None:
    rows = linear(np.array([[1.0]]), [-1.0])
    guards = PythonRows(lambda x: x.copy(), n=1, m=1)
    x = np.array([0.0])
    assert Levels(rows, guards=guards).solve(x).solved


def test_components_joined_by_a_guard_are_one() -> None:
    matrix = np.eye(2)
    guards = PythonRows(lambda x: np.array([x[0] - x[1]]), n=2, m=1)
    levels = Levels(linear(matrix, [1.0, 2.0]), guards=guards)
    x = np.array([3.0, 0.0])
    assert levels.solve(x).status == "side"
    assert levels.components == 1


def test_a_drag_stops_at_a_guard_and_comes_back() -> None:
    guards = PythonRows(lambda x: x[:1].copy(), n=2, m=1, pattern=[[0]])
    levels = Levels(linear(np.array([[0.0, 1.0]]), [0.0]), guards=guards)
    x = np.array([1.0, 0.0])
    home = x.copy()
    assert levels.drag(x, [0], [-2.0], home).solved
    assert 0 < x[0] < 1
    assert levels.drag(x, [0], [1.0], home).solved
    np.testing.assert_allclose(x, home, atol=1e-10)


@pytest.mark.parametrize(("length", "slack"), [(1.0, 0.0), (3.0, 1.0)])
def test_a_slack_makes_an_inequality_exact(length: float, slack: float) -> None:
    """x0 - 2 - s = 0 with s >= 0: at least 2; a start that holds it does not move."""
    rows = linear(np.array([[1.0, -1.0]]), [2.0])
    x = np.array([length, slack])
    assert Levels(rows).solve(x.copy()).solved
    outcome = Levels(rows).solve(x, low=[-np.inf, 0.0])
    assert outcome.solved
    assert x[0] - 2 - x[1] == pytest.approx(0, abs=1e-12)
    assert x[1] >= 0
    if length == 1.0:
        np.testing.assert_allclose(x, [2, 0], atol=1e-12)
    else:
        assert x.tolist() == [3.0, 1.0]


def test_a_bound_is_left_if_the_rows_ask_for_it() -> None:
    right = np.array([2.0, 1.0])
    matrix = np.array([[1.0, -1.0], [1.0, 0.0]])
    rows = linear(matrix, right)
    levels = Levels(rows)
    x = np.array([2.0, 0.0])
    outcome = levels.solve(x, low=[-np.inf, 0.0])  # x0 = 1 and x0 >= 2
    assert outcome.status == "stalled"
    moving = [1.0]
    rows = PythonRows(lambda x: matrix @ x - [2.0, moving[0]], lambda x: matrix, n=2, m=2)
    levels = Levels(rows)
    for value in (2.0, 5.0, 2.5, 2.0, 4.0):
        moving[0] = value
        assert levels.solve(x, low=[-np.inf, 0.0]).solved
        np.testing.assert_allclose(x, [value, value - 2], atol=1e-10)


def test_bounds_on_both_sides_with_many_unknowns() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        matrix = rng.normal(size=(3, 9))
        inside = rng.uniform(0.1, 0.9, size=9)
        x = rng.uniform(-1, 2, size=9)
        outcome = Levels(linear(matrix, matrix @ inside)).solve(x, low=np.zeros(9), high=np.ones(9))
        assert outcome.solved
        assert (x >= 0).all()
        assert (x <= 1).all()
        np.testing.assert_allclose(matrix @ x, matrix @ inside, atol=1e-9)


def four_bar(angle: list[float]) -> PythonRows:
    """Crank 1, coupler 3, rocker 2.5, ground 3; the crank's angle is data."""

    def residuals(x: Array) -> Array:
        a, b = x[:2], x[2:]
        return np.array(
            [
                a[0] - np.cos(angle[0]),
                a[1] - np.sin(angle[0]),
                np.hypot(*(b - a)) - 3,
                np.hypot(b[0] - 3, b[1]) - 2.5,
            ]
        )

    return PythonRows(residuals, n=4, m=4, pattern=[[0], [1], [0, 1, 2, 3], [2, 3]])


def test_a_four_bar_linkage_runs_through_its_range_on_one_branch() -> None:
    angle = [0.0]
    levels = Levels(four_bar(angle))
    x = np.array([1.0, 0, 2.0, 2.5])
    assert levels.solve(x).solved

    def turn_crank(t: float) -> None:
        angle[0] = 4 * np.pi * t

    before = x.copy()
    outcome = follow(levels, x, turn_crank, furthest=0.5)
    assert outcome.solved
    assert outcome.fraction == 1.0
    np.testing.assert_allclose(x, before, atol=1e-9)  # two turns later, not the other assembly


def test_a_four_bar_linkage_keeps_its_branch_in_every_position() -> None:
    angle = [0.0]
    rows = four_bar(angle)
    # The crank's end, the coupler's and the rocker's pivot never pass through one line.
    guards = PythonRows(
        lambda x: np.array([(x[2] - x[0]) * (0 - x[1]) - (x[3] - x[1]) * (3 - x[0])]), n=4, m=1
    )
    levels = Levels(rows, guards=guards)
    x = np.array([1.0, 0, 2.0, 2.5])
    assert levels.solve(x).solved
    sign = np.sign(guards.evaluate(x))
    for angle[0] in np.linspace(0, 2 * np.pi, 25):
        assert levels.solve(x).solved
        assert np.sign(guards.evaluate(x)) == sign


def test_following_a_path_that_ends_returns_the_fraction_that_was_reached() -> None:
    """A triangle's side grows from 4 to 8 while the others are 3: flat at 6."""
    size = [4.0]
    rows = PythonRows(
        lambda x: np.array(
            [x[2] - size[0], np.hypot(x[0], x[1]) - 3, np.hypot(x[0] - x[2], x[1]) - 3]
        ),
        n=3,
        m=3,
    )
    levels = Levels(rows)
    x = np.array([2.0, 2.0, 4.0])
    assert levels.solve(x).solved

    def grow(t: float) -> None:
        size[0] = 4 + 4 * t

    outcome = follow(levels, x, grow)
    assert not outcome.solved
    assert outcome.fraction == pytest.approx(0.5, abs=1e-2)
    assert outcome.fraction <= 0.5 + 1e-9
    assert np.abs(rows.evaluate(x)).max() <= 1e-10
    assert x[1] > 0
