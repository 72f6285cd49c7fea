"""Newton steps of least norm on exact rows."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from arael.runtime.levels.compiled import Levels, PythonRows, Rows
from tests.runtime.levels.systems import chain, distances, linear, rectangles

Array = NDArray[np.float64]


def random(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def sparse_matrix(rng: Any, m: int, n: int) -> Array:
    """A matrix with three or so entries a row."""
    matrix = np.zeros((m, n))
    for row in matrix:
        at = rng.choice(n, size=min(3, n), replace=False)
        row[at] = rng.normal(size=len(at))
    return matrix


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 12), st.integers(0, 8))
def test_a_linear_system_gets_the_step_of_least_norm(seed: int, m: int, more: int) -> None:
    rng = random(seed)
    matrix, right = rng.normal(size=(m, m + more)), rng.normal(size=m)
    start = rng.normal(size=m + more)
    x = start.copy()
    outcome = Levels(linear(matrix, right)).solve(x, 1e-9)
    expected = np.linalg.lstsq(matrix, right - matrix @ start, rcond=None)[0]
    if np.linalg.cond(matrix) < 1e4:
        assert outcome.solved
        np.testing.assert_allclose(x - start, expected, atol=1e-7)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_scales_of_unknowns_weigh_the_norm(seed: int) -> None:
    rng = random(seed)
    matrix, right = rng.normal(size=(3, 7)), rng.normal(size=3)
    scales = np.exp(rng.normal(size=7) * 2)
    x = np.zeros(7)
    assert Levels(linear(matrix, right), scales=scales).solve(x, 1e-9).solved
    expected = scales * np.linalg.lstsq(matrix * scales, right, rcond=None)[0]
    np.testing.assert_allclose(x, expected, atol=1e-6 * np.abs(expected).max())


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 10), st.integers(1, 5))
def test_redundant_consistent_rows_hold_too(seed: int, m: int, redundant: int) -> None:
    rng = random(seed)
    matrix = sparse_matrix(rng, m, m + 3)
    matrix = np.vstack([matrix, rng.integers(-2, 3, size=(redundant, m)) @ matrix])
    solution = rng.normal(size=m + 3)
    start = rng.normal(size=m + 3)
    x = start.copy()
    levels = Levels(linear(matrix, matrix @ solution))
    outcome = levels.solve(x, 1e-8)
    assert outcome.solved
    assert np.abs(matrix @ (x - solution)).max() <= 1e-8
    singular = np.linalg.svd(matrix, compute_uv=False)
    if singular[singular > 1e-12].min() > 1e-3:
        assert len(levels.redundant()) == len(matrix) - np.linalg.matrix_rank(matrix)
        expected = np.linalg.lstsq(matrix, matrix @ (solution - start), rcond=1e-10)[0]
        np.testing.assert_allclose(x - start, expected, atol=1e-7)


def test_inconsistent_rows_are_reported_with_the_worst_one_and_x_is_put_back() -> None:
    matrix = np.array([[1.0, 0, 0], [0, 1, 1], [1, 1, 1]])
    x = np.array([0.25, 0.5, 0.5])
    before = x.copy()
    outcome = Levels(linear(matrix, [1, 1, 5.0])).solve(x)
    assert outcome.status == "stalled"
    assert abs(outcome.largest) > 0.1
    assert outcome.row in range(3)
    assert [part.row for part in outcome.open] == [outcome.row]
    np.testing.assert_array_equal(x, before)


def test_keep_leaves_the_least_squares_point_of_an_inconsistent_system() -> None:
    matrix = np.array([[1.0, 0], [1, 0]])
    x = np.array([5.0, 7.0])
    assert Levels(linear(matrix, [1.0, 2.0])).solve(x, keep=True).status == "stalled"
    assert x[0] == pytest.approx(1.5, abs=1e-3)
    assert x[1] == 7.0


def test_basic_rows_of_the_caller_are_used() -> None:
    matrix = np.array([[1.0, 0], [1.0, 1e-9], [0, 1.0]])
    x = np.zeros(2)
    levels = Levels(linear(matrix, matrix @ [1.0, 2.0]))
    assert levels.solve(x, basic=np.array([True, False, True])).solved
    assert levels.redundant().tolist() == [1]
    np.testing.assert_allclose(x, [1, 2])


def test_a_satisfied_component_keeps_every_bit_while_another_is_solved() -> None:
    rows, x0 = rectangles(3)
    matrix = np.zeros((1, rows.n + 2))
    matrix[0, -2:] = 1

    def residuals(x: Array) -> Array:
        return np.append(rows.evaluate(x[:-2]), x[-2] + x[-1] - 1)

    def entries(x: Array) -> Array:
        return np.concatenate([rows.jacobian(x[:-2])[1], [1, 1]])

    start = rows.indptr
    lists = [rows.indices[a:b] for a, b in pairwise(start)]
    both = PythonRows(
        residuals, entries, n=rows.n + 2, m=rows.m + 1, pattern=[*lists, [rows.n, rows.n + 1]]
    )
    x = np.append(x0, [0, 0])
    x[:-2] += 1e-12 * random(0).normal(size=rows.n)  # below the tolerance, not a solution exactly
    before = x.copy()
    levels = Levels(both)
    outcome = levels.solve(x)
    assert outcome.solved
    assert levels.components == 2
    assert x[:-2].tobytes() == before[:-2].tobytes()
    np.testing.assert_allclose(x[-2:], 0.5)


def test_a_satisfied_system_never_creeps() -> None:
    rows, x = rectangles(4)
    x = x + 1e-12
    before = x.tobytes()
    levels = Levels(rows)
    for _ in range(5):
        outcome = levels.solve(x)
        assert (outcome.status, outcome.steps) == ("solved", 0)
    assert x.tobytes() == before


def test_only_touched_components_are_solved() -> None:
    x = np.zeros(4)
    matrix = np.array([[1.0, 1, 0, 0], [0, 0, 1, 1]])
    levels = Levels(linear(matrix, [1.0, 1.0]))
    assert levels.solve(x, touched=[2]).solved
    np.testing.assert_allclose(x, [0, 0, 0.5, 0.5])


def test_fixed_unknowns_stay_and_off_rows_do_not_count() -> None:
    x = np.array([3.0, 0, 0])
    matrix = np.array([[1.0, 1, 0], [0, 1, 1], [1, 1, 1]])
    levels = Levels(linear(matrix, [1.0, 1.0, 99.0]))
    fixed, active = np.array([True, False, False]), np.array([True, True, False])
    assert levels.solve(x, fixed=fixed, active=active).solved
    np.testing.assert_allclose(x, [3, -2, 3])


def test_a_wrong_row_without_free_unknowns_is_reported() -> None:
    x = np.array([3.0])
    outcome = Levels(linear(np.array([[1.0]]), [1.0])).solve(x, fixed=np.array([True]))
    assert (outcome.status, outcome.row, outcome.largest) == ("stalled", 0, 2.0)
    assert x[0] == 3.0


def test_the_factor_of_the_last_solve_is_used_again() -> None:
    length = [5.0]

    def residuals(x: Array) -> Array:
        return np.array([np.hypot(x[0], x[1]) - length[0]])

    def jacobian(x: Array) -> Array:
        return (x / np.hypot(*x))[None, :]

    levels = Levels(PythonRows(residuals, jacobian, n=2, m=1))
    x = np.array([3.0, 4.1])
    assert levels.solve(x).factors == 1
    length[0] = 5.1
    assert levels.solve(x).factors == 0
    assert np.hypot(*x) == pytest.approx(5.1, abs=1e-14)


def test_results_are_at_rounding_level() -> None:
    rows, x0 = rectangles(20)
    x = x0 + 0.02 * random(1).normal(size=len(x0))
    assert Levels(rows).solve(x).solved
    np.testing.assert_allclose(x, x0, atol=1e-9)


def test_solves_from_far_away() -> None:
    for seed in range(20):
        rows, x0 = chain(8)
        x = x0 + random(seed).normal(size=len(x0)) * 3
        outcome = Levels(rows).solve(x)
        assert outcome.solved
        assert np.abs(rows.evaluate(x)).max() <= 1e-10


def test_damped_steps_pass_a_singular_jacobian() -> None:
    # At the centre of the circle its row is almost zero.
    rows = PythonRows(
        lambda x: np.array([x[0] ** 2 + x[1] ** 2 - 1, x[1] - 0.5]),
        lambda x: np.array([[2 * x[0], 2 * x[1]], [0, 1]]),
        n=2,
        m=2,
    )
    x = np.array([1e-9, 0.0])
    assert Levels(rows).solve(x).solved
    np.testing.assert_allclose(x, [np.sqrt(0.75), 0.5], atol=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_verdict_and_result_do_not_depend_on_scale(scale: float) -> None:
    rows, x0 = rectangles(6)
    start = x0 + 0.1 * random(2).normal(size=len(x0))
    scaled = PythonRows(
        lambda x: scale * rows.evaluate(x / scale),
        lambda x: rows.jacobian(x / scale)[1],
        n=rows.n,
        m=rows.m,
        pattern=[rows.indices[a:b] for a, b in pairwise(rows.indptr)],
    )
    plain, x = start.copy(), scale * start
    first, second = Levels(rows).solve(plain), Levels(scaled).solve(x, 1e-10 * scale)
    assert (first.status, first.steps) == (second.status, second.steps)
    np.testing.assert_allclose(x / scale, plain, atol=1e-11)


def test_renumbered_unknowns_give_the_same_result() -> None:
    matrix, right = sparse_matrix(random(3), 9, 14), random(4).normal(size=9)
    order = random(5).permutation(14)
    plain, other = np.zeros(14), np.zeros(14)
    assert Levels(linear(matrix, right)).solve(plain).solved
    assert Levels(linear(matrix[:, order], right)).solve(other).solved
    np.testing.assert_allclose(other, plain[order], atol=1e-10)


def test_a_rotated_drawing_gives_the_rotated_result() -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    pairs, lengths = [[0, 1], [1, 2], [2, 0], [2, 3]], [3.0, 4, 5, 1]
    start = random(6).normal(size=(4, 2)) * 3
    rows = distances(4, pairs, lengths)
    plain, turned = start.ravel().copy(), (start @ turn.T).ravel()
    assert Levels(rows).solve(plain).solved
    assert Levels(rows).solve(turned).solved
    np.testing.assert_allclose(turned.reshape(-1, 2), plain.reshape(-1, 2) @ turn.T, atol=1e-9)


def test_a_residual_that_is_not_finite_is_named() -> None:
    rows = PythonRows(lambda x: np.array([x[0], np.nan]), lambda x: np.eye(2), n=2, m=2)
    outcome = Levels(rows).solve(np.zeros(2))
    assert (outcome.status, outcome.row) == ("not_finite", 1)


def test_a_derivative_that_is_not_finite_is_named() -> None:
    rows = PythonRows(lambda x: np.ones(2), lambda x: np.array([[1, 0], [0, np.inf]]), n=2, m=2)
    outcome = Levels(rows).solve(np.zeros(2))
    assert (outcome.status, outcome.row) == ("not_finite", 1)


def test_a_trial_point_outside_of_the_domain_is_a_shorter_step() -> None:
    def residuals(x: Array) -> Array:
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.log(x) - 1

    rows = PythonRows(residuals, lambda x: np.diag(1 / x), n=1, m=1)
    x = np.array([20.0])  # the full step leads to a negative number
    assert Levels(rows).solve(x).solved
    assert x[0] == pytest.approx(np.e)


def test_the_step_limit_is_reported() -> None:
    rows, x0 = chain(8)
    x = x0 + random(1).normal(size=len(x0)) * 3
    before = x.copy()
    outcome = Levels(rows, step_limit=2).solve(x)
    assert outcome.status == "step_limit"
    np.testing.assert_array_equal(x, before)


def test_an_exception_of_a_row_is_raised_and_x_is_put_back() -> None:
    calls = []

    def residuals(x: Array) -> Array:
        calls.append(1)
        if len(calls) > 2:
            raise ZeroDivisionError("of the user")
        return x**2 - 2

    x = np.array([9.0])
    with pytest.raises(ZeroDivisionError, match="of the user"):
        Levels(PythonRows(residuals, lambda x: 2 * np.diag(x), n=1, m=1)).solve(x)
    assert x[0] == 9.0


def test_ctrl_c_ends_a_solve() -> None:
    import signal
    import time

    def residuals(x: Array) -> Array:
        time.sleep(0.03)
        return np.array([np.exp(-x[0])])  # no root: steps go on

    def interrupt(number: int, frame: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        x = np.array([0.0])
        rows = PythonRows(residuals, lambda x: np.array([[-np.exp(-x[0])]]), n=1, m=1)
        outcome = Levels(rows, step_limit=10000).solve(x, 1e-300)
    except KeyboardInterrupt:  # the signal came while a row was evaluated
        return
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert outcome.status == "interrupted"
    assert x[0] == 0.0


@pytest.mark.slow
def test_a_long_chain_of_rectangles() -> None:
    rows, x0 = rectangles(2500)  # 10,000 rows and four
    x = x0 + 1e-3 * random(7).normal(size=len(x0))
    outcome = Levels(rows).solve(x, 1e-7)
    assert outcome.solved
    assert np.abs(rows.evaluate(x)).max() <= 1e-7


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"x": np.zeros(3)}, "array of 2 float64"),
        ({"x": np.zeros(2, np.float32)}, "array of 2 float64"),
        ({"tolerance": -1.0}, "positive tolerance"),
        ({"tolerance": [1.0, 1, 1]}, "positive tolerance"),
        ({"fixed": np.zeros(3, bool)}, "fixed unknowns as 2 booleans"),
        ({"active": np.zeros(2)}, "active rows as 1 booleans"),
        ({"low": [1.0, 0], "high": [0.0, 0]}, "lower bounds"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    levels = Levels(linear(np.array([[1.0, 1.0]]), [1.0]))
    with pytest.raises(ValueError, match=message):
        levels.solve(arguments.pop("x", np.zeros(2)), **arguments)


def test_the_abstract_class_cannot_be_made() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Rows()


def test_numerical_derivatives_are_taken_where_none_are_given() -> None:
    rows = PythonRows(lambda x: np.array([np.sin(x[0]) * x[1]]), n=2, m=1)
    _, entries = rows.jacobian(np.array([0.3, 2.0]))
    np.testing.assert_allclose(entries, [2 * np.cos(0.3), np.sin(0.3)], rtol=1e-8)


def test_no_rows_are_solved() -> None:
    rows = PythonRows(lambda x: np.zeros(0), lambda x: np.zeros((0, 2)), n=2, m=0)
    outcome = Levels(rows).solve(np.ones(2))
    assert (outcome.status, outcome.row) == ("solved", -1)
