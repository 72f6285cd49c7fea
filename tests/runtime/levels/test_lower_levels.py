"""Soft rows and closeness to a state, below the exact rows: dragging and minimising."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import minimize

from arael.runtime.levels.compiled import Levels, PythonRows
from tests.runtime.levels.systems import chain, distances, linear, rectangles

Array = NDArray[np.float64]


def test_a_chain_dragged_out_and_back_returns() -> None:
    rows, home = chain(20)
    x = home.copy()
    levels = Levels(rows)
    for t in np.linspace(0, 1, 13)[1:]:
        target = home[40:] + np.array([-8 * np.sin(np.pi * t), 9 * np.sin(2 * np.pi * t)])
        outcome = levels.drag(x, [40, 41], target, home)
        assert outcome.solved
        assert np.abs(rows.evaluate(x)).max() <= 1e-10
        np.testing.assert_allclose(x[40:], target, atol=1e-9)
    np.testing.assert_allclose(x, home, atol=1e-9)


def test_a_cursor_out_of_reach_stretches_the_chain_and_it_returns() -> None:
    rows, home = chain(6)
    x = home.copy()
    levels = Levels(rows)
    for reach in (6.5, 20.0, 8.0):
        assert levels.drag(x, [12, 13], [reach, 0.0], home).solved
        assert np.abs(rows.evaluate(x)).max() <= 1e-10
        assert x[12] == pytest.approx(6, abs=1e-3)
    assert levels.drag(x, [12, 13], home[12:], home).solved
    np.testing.assert_allclose(x, home, atol=1e-9)


def test_a_cursor_that_changes_its_unknowns_moves_what_a_new_one_would() -> None:
    rows, home = chain(8)
    x = home.copy()
    kept = Levels(rows)
    cursors = [[16, 17], [16, 17], [8, 9], [16, 17], [17, 16], [16], [16, 17, 8], [8, 9]]
    for k, unknowns in enumerate(cursors):
        at = np.array(unknowns, dtype=np.int64 if k % 3 else np.int32)
        target = home[at] + 0.1 * (k + 1) * np.array([-1.0, 0.5, 0.25])[: len(at)]
        fresh, expected = x.copy(), Levels(rows)
        wanted = expected.drag(fresh, unknowns, target.tolist(), home)
        found = kept.drag(x, at, target, home)
        assert found.status == wanted.status == "solved"
        assert found.soft == pytest.approx(wanted.soft, abs=1e-9)
        np.testing.assert_allclose(x, fresh, atol=1e-9)


def test_home_may_be_the_array_that_is_solved() -> None:
    rows, home = chain(8)
    one, other = home.copy(), home.copy()
    target = home[16:] + np.array([-2.0, 1.0])
    Levels(rows).drag(one, [16, 17], target, one)
    Levels(rows).drag(other, [16, 17], target, home)
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("distance", [0.1, 0.9, 3.0, 100.0])
def test_a_point_on_a_circle_comes_closest_to_the_cursor(distance: float) -> None:
    rows = distances(1, [], [])
    rows = PythonRows(
        lambda x: np.array([np.hypot(*x) - 1]), lambda x: (x / np.hypot(*x))[None], n=2, m=1
    )
    x = np.array([1.0, 0.0])
    direction = np.array([np.cos(2.0), np.sin(2.0)])
    outcome = Levels(rows).drag(x, [0, 1], distance * direction)
    assert outcome.solved
    assert outcome.converged
    np.testing.assert_allclose(x, direction, atol=1e-6)
    assert outcome.soft == pytest.approx(abs(distance - 1), rel=1e-9)


def test_a_fully_defined_system_keeps_every_bit_when_dragged() -> None:
    rows, x = rectangles(4)
    before = x.tobytes()
    outcome = Levels(rows).drag(x, [6, 7], [9.0, 9.0], x.copy())
    assert outcome.solved
    assert x.tobytes() == before


def test_a_frame_of_linear_rows_is_factored_where_it_begins_and_where_it_ends() -> None:
    rng = np.random.default_rng(5)
    rows = linear(rng.normal(size=(3, 8)), rng.normal(size=3))
    levels, home = Levels(rows), np.zeros(8)
    assert levels.solve(home).solved
    x = home.copy()
    for target in (1.0, 2.0, -1.0):
        outcome = levels.drag(x, [7], [target], home)
        assert outcome.converged
        assert outcome.factors == 2
        assert x[7] == pytest.approx(target, abs=1e-9)


def test_what_is_not_connected_with_the_cursor_keeps_every_bit() -> None:
    x = np.array([0.0, 0, 1, 0, 5, 5, 6, 5 + 1e-13])
    rows = distances(4, [[0, 1], [2, 3]], [1.0, 1.0])
    before = x[4:].tobytes()
    assert Levels(rows).drag(x, [0, 1], [3.0, 1.0], x.copy()).solved
    np.testing.assert_allclose(x[:2], [3, 1], atol=1e-10)
    assert x[4:].tobytes() == before


def test_a_point_without_rows_follows_the_cursor() -> None:
    x = np.zeros(4)
    outcome = Levels(linear(np.array([[1.0, 0, 0, 0]]), [0.0])).drag(x, [2, 3], [1.0, 2.0], x)
    assert outcome.solved
    np.testing.assert_array_equal(x, [0, 0, 1, 2])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 4), st.integers(1, 4))
def test_levels_of_a_linear_system_are_strict(seed: int, m: int, k: int, more: int) -> None:
    """Against the three least-squares problems, one in the null space of the other."""
    rng = np.random.default_rng(seed)
    n = m + more
    j, right = rng.normal(size=(m, n)), rng.normal(size=m)
    soft, wanted, home = rng.normal(size=(k, n)), rng.normal(size=k), rng.normal(size=n)
    if np.linalg.cond(j) > 100 or np.linalg.cond(soft) > 100:
        return
    first = np.linalg.lstsq(j, right, rcond=None)[0]
    free = np.linalg.svd(j)[2][m:].T
    second = first + free @ np.linalg.lstsq(soft @ free, wanted - soft @ first, rcond=1e-10)[0]
    both = np.vstack([j, soft])
    _, sizes, directions = np.linalg.svd(both)
    if (sizes[sizes > 1e-12] < 1e-2).any():
        return
    left = directions[np.count_nonzero(sizes > 1e-12) :]
    third = second + left.T @ left @ (home - second)
    x = np.zeros(n)
    outcome = Levels(linear(j, right), linear(soft, wanted)).minimise(x, 1e-11, home=home)
    assert outcome.solved
    np.testing.assert_allclose(x, third, atol=1e-6)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 10**6))
def test_a_nonlinear_minimum_is_that_of_slsqp(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = PythonRows(
        lambda x: np.array([x @ x - 4, x[0] * x[1] + x[2] - 0.5]),
        lambda x: np.array([2 * x, [x[1], x[0], 1, 0]]),
        n=4,
        m=2,
    )
    matrix, right = rng.normal(size=(5, 4)), rng.normal(size=5)
    start = rng.normal(size=4)
    x = start.copy()
    outcome = Levels(rows, linear(matrix, right)).minimise(x)
    assert outcome.solved
    assert outcome.converged
    np.testing.assert_allclose(rows.evaluate(x), 0, atol=1e-10)
    # A stationary point: SLSQP finds nothing better next to it.
    found = minimize(
        lambda v: np.sum((matrix @ v - right) ** 2),
        x,
        jac=lambda v: 2 * matrix.T @ (matrix @ v - right),
        constraints={"type": "eq", "fun": rows.evaluate},
        method="SLSQP",
        options={"ftol": 1e-14},
    )
    assert outcome.soft**2 <= found.fun * (1 + 1e-6) + 1e-9
    normal = np.vstack([2 * x, [x[1], x[0], 1, 0]])
    gradient = matrix.T @ (matrix @ x - right)
    multipliers = np.linalg.lstsq(normal.T, gradient, rcond=None)[0]
    slope = np.abs(gradient - normal.T @ multipliers).max()
    assert slope <= 1e-5 * np.abs(gradient).max()


def test_closest_state_is_that_of_slsqp() -> None:
    rows, start = chain(4)
    home = start + np.random.default_rng(0).normal(size=len(start)) * 0.3
    x = start.copy()
    target = np.array([1.5, 2.0])
    assert Levels(rows).drag(x, [8, 9], target, home).converged
    found = minimize(
        lambda v: np.sum((v - home) ** 2),
        start,
        jac=lambda v: 2 * (v - home),
        constraints=[
            {"type": "eq", "fun": rows.evaluate},
            {"type": "eq", "fun": lambda v: v[8:] - target},
        ],
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert np.sum((x - home) ** 2) <= found.fun * (1 + 1e-6)


def test_home_may_be_far_and_unscaled() -> None:
    for scale in (1e-6, 1e6):
        home = chain(5)[1]
        rows = distances(6, [[k, k + 1] for k in range(5)], [scale] * 5, [(0, 0.0), (1, 0.0)])
        home, x = home * scale, home * scale
        levels = Levels(rows)
        target = home[10:] + scale * np.array([-1.0, 0.5])
        assert levels.drag(x, [10, 11], target, home, 1e-10 * scale).solved
        np.testing.assert_allclose(x[10:], target, atol=1e-9 * scale)
        assert levels.drag(x, [10, 11], home[10:], home, 1e-10 * scale).solved
        np.testing.assert_allclose(x, home, atol=1e-9 * scale)


def test_a_drag_that_cannot_hold_the_exact_rows_goes_back() -> None:
    rows = linear(np.array([[1.0, 1, 0], [1.0, 1, 0]]), [0.0, 1.0])
    x = np.array([0.5, 0.0, 3.0])
    before = x.copy()
    assert Levels(rows).drag(x, [0], [9.0], before).status == "stalled"
    np.testing.assert_array_equal(x, before)


def test_targets_must_fit() -> None:
    levels = Levels(linear(np.array([[1.0, 1.0]]), [1.0]))
    with pytest.raises(ValueError, match="expected 2 targets, found 1"):
        levels.drag(np.zeros(2), [0, 1], [1.0])
    with pytest.raises(ValueError, match="from 0 to 1"):
        levels.drag(np.zeros(2), [2], [1.0])
    with pytest.raises(ValueError, match="home of 2"):
        levels.drag(np.zeros(2), [1], [1.0], np.zeros(3))
    with pytest.raises(ValueError, match="soft="):
        levels.minimise(np.zeros(2))


@pytest.mark.parametrize("wanted", [-3.0, 0.3, 9.0])
def test_soft_rows_stop_at_bounds(wanted: float) -> None:
    """x0 + x1 = 1, 0 <= x0 <= 2: x0 as close to `wanted` as the bounds allow."""
    levels = Levels(linear(np.array([[1.0, 1.0]]), [1.0]), linear([[1.0, 0.0]], [wanted]))
    x = np.array([0.5, 0.5])
    outcome = levels.minimise(x, low=[0, -9.0], high=[2.0, 9])
    assert outcome.solved
    np.testing.assert_allclose(x, [np.clip(wanted, 0, 2), 1 - np.clip(wanted, 0, 2)], atol=1e-9)


def test_a_bound_is_left_again_when_the_cursor_comes_back() -> None:
    levels = Levels(linear(np.array([[1.0, 1.0, -1.0]]), [0.0]))
    x: Any = np.array([1.0, 1.0, 2.0])
    home = x.copy()
    low, high = np.array([-9.0, -9, 1.5]), np.full(3, 9.0)
    assert levels.drag(x, [0, 1], [0.0, 0.0], home, low=low, high=high).solved
    np.testing.assert_allclose(x, [0.75, 0.75, 1.5], atol=1e-9)
    assert levels.drag(x, [0, 1], [2.0, 2.0], home, low=low, high=high).solved
    np.testing.assert_allclose(x, [2, 2, 4], atol=1e-9)
