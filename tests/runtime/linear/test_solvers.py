"""Every linear solver in both precisions against an independent dense solution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.linalg
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear import auto
from arael.runtime.linear.auto import SOLVERS
from arael.runtime.linear.compiled import LinearSolver
from tests.optional import solvers
from tests.runtime.linear.block_matrices import arrow, build, chain, dense, grid, positive, slam

PATTERNS: dict[str, Callable[[], BlockPattern]] = {
    "single": lambda: build([1], []),
    "one_block": lambda: build([7], []),
    "pair": lambda: build([2, 3], [(0, 1)]),
    "uncoupled": lambda: build([3, 1, 20, 1, 6], []),
    "tridiagonal": lambda: chain(60, 1),
    "chain": lambda: chain(40, 6),
    "arrow": lambda: arrow(40, 3),
    "grid": lambda: grid(12, 9, 3),
    "grid_spatial": lambda: grid(9, 8, 6),
    "slam": lambda: slam(30, 80),
    "mixed": lambda: build([1, 6, 3, 2, 9, 3, 20, 1], [(0, 4), (1, 4), (2, 6), (3, 1), (5, 0)]),
    "held": lambda: build([3, 0, 2, 0, 6, 0], [(0, 1), (1, 2), (3, 4), (4, 0), (5, 1)]),
    "full": lambda: build([4] * 12, [(i, j) for i in range(12) for j in range(i)]),
    "wide": lambda: build([20, 17, 19, 20, 13], [(0, 1), (1, 2), (2, 3), (3, 4), (0, 4)]),
}


# Iterated to rounding, so that its solutions are those of the others.
EXACT = {"schur_pcg": {"tolerance": 1e-15, "floor": 1e-15, "iterations": 1000}}


def make_solver(name: str, pattern: BlockPattern, single: bool = False) -> LinearSolver:
    """Solver `name`, as exact as it can be."""
    return auto.make_solver(name, pattern, single, **EXACT.get(name, {}))


@st.composite
def patterns(draw: st.DrawFn) -> BlockPattern:
    """Draw a small random pattern of mixed block sizes."""
    sizes = draw(st.lists(st.integers(1, 9), min_size=1, max_size=14))
    index = st.integers(0, len(sizes) - 1)
    pairs = draw(st.lists(st.tuples(index, index), max_size=30))
    return build(sizes, pairs)


@pytest.fixture(params=solvers(sorted(SOLVERS)))
def name(request: pytest.FixtureRequest) -> str:
    """Name of a solver."""
    return str(request.param)


@pytest.fixture(params=[False, True], ids=["f64", "f32"])
def single(request: pytest.FixtureRequest) -> bool:
    """Whether to work in single precision."""
    return bool(request.param)


def error_of(pattern: BlockPattern, name: str, single: bool, seed: int = 0) -> float:
    """Largest relative error of a solution against LAPACK on the whole matrix in f64."""
    values, diagonal = positive(pattern, seed, np.float32 if single else np.float64)
    solver = make_solver(name, pattern, single)
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(seed).standard_normal(pattern.size)
    expected = scipy.linalg.solve(dense(pattern, values, diagonal), b, assume_a="sym")
    return float(np.abs(solver.solved(b) - expected).max() / np.abs(expected).max())


class TestEverySolver:
    """What holds for each solver, each precision and each pattern."""

    @pytest.mark.sweep(5)
    @pytest.mark.parametrize("pattern", sorted(PATTERNS))
    def test_solution(self, pattern: str, name: str, single: bool) -> None:
        assert error_of(PATTERNS[pattern](), name, single) < (1e-4 if single else 1e-11)

    @pytest.mark.sweep(3)
    @settings(
        max_examples=25,
        deadline=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture],
    )
    @given(pattern=patterns(), seed=st.integers(0, 1000))
    def test_random_patterns(
        self, pattern: BlockPattern, seed: int, name: str, single: bool
    ) -> None:
        assert error_of(pattern, name, single, seed) < (1e-4 if single else 1e-11)

    def test_no_unknowns(self, name: str, single: bool) -> None:
        solver = make_solver(name, build([], []), single)
        assert solver.factorise([], []) == 0
        assert solver.solved(np.zeros(0)).shape == (0,)

    def test_several_right_hand_sides(self, name: str, single: bool) -> None:
        pattern = grid(5, 4, 3)
        values, diagonal = positive(pattern, 1)
        solver = make_solver(name, pattern, single)
        assert solver.factorise(values, diagonal) == 0
        b = np.random.default_rng(0).standard_normal((pattern.size, 4))
        x = solver.solved(b)
        assert x.dtype == solver.dtype
        assert np.allclose(dense(pattern, values, diagonal) @ x, b, atol=1e-4 if single else 1e-12)

    def test_arguments_are_left_alone(self, name: str, single: bool) -> None:
        pattern = slam(8, 20)
        values, diagonal = positive(pattern, 2, np.float32 if single else np.float64)
        before = values.copy(), diagonal.copy()
        make_solver(name, pattern, single).factorise(values, diagonal)
        assert np.array_equal(values, before[0], equal_nan=True)
        assert np.array_equal(diagonal, before[1])

    def test_new_damping(self, name: str, single: bool) -> None:
        pattern = slam(10, 30)
        values, diagonal = positive(pattern, 3)
        solver = make_solver(name, pattern, single)
        b = np.random.default_rng(0).standard_normal(pattern.size)
        for damping in (0.0, 1e-4, 10.0, 0.0):
            damped = diagonal * (1 + damping)
            assert solver.factorise(values, damped) == 0
            residual = dense(pattern, values, damped) @ solver.solved(b) - b
            assert np.abs(residual).max() < (1e-4 if single else 1e-12)

    def test_recovers_after_failure(self, name: str, single: bool) -> None:
        pattern = grid(6, 6, 3)
        values, diagonal = positive(pattern, 4)
        solver = make_solver(name, pattern, single)
        poisoned = values.copy()
        poisoned[:] = np.nan
        assert solver.factorise(poisoned, diagonal) > 0
        assert solver.factorise(values, diagonal) == 0
        b = np.ones(pattern.size)
        residual = dense(pattern, values, diagonal) @ solver.solved(b) - b
        assert np.abs(residual).max() < (1e-4 if single else 1e-12)

    @pytest.mark.sweep(4)
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0, 0.0])
    @pytest.mark.parametrize("scalar", [0, 7, 44])
    def test_bad_pivot_is_named(self, bad: float, scalar: int, name: str, single: bool) -> None:
        # Uncoupled entities: the failing pivot is the bad one in any order of elimination.
        pattern = build([3] * 15, [])
        values, diagonal = positive(pattern, 5)
        for block in range(15):
            values[9 * block : 9 * block + 9] = 0
        diagonal[scalar] = bad
        assert make_solver(name, pattern, single).factorise(values, diagonal) == 1 + scalar

    @pytest.mark.parametrize("bad", [np.nan, np.inf, 1e30])
    def test_bad_coupling_is_noticed(self, bad: float, name: str, single: bool) -> None:
        # The coupling of the two last entities is overwritten; one of their scalars must be named.
        pattern = chain(12, 3)
        values, diagonal = positive(pattern, 6)
        block = pattern.find(np.array([11]), np.array([10]))[0]
        values[block + 4] = bad
        status = make_solver(name, pattern, single).factorise(values, diagonal)
        assert 1 + 30 <= status <= 36

    def test_singular(self, name: str, single: bool) -> None:
        # Two unknowns of which only the sum matters, in numbers that do not round.
        pattern = build([1, 1, 1], [(0, 1), (1, 2)])
        values = np.array([0.0, 4.0, 0.0, 0.0, 0.0])
        assert make_solver(name, pattern, single).factorise(values, [4.0, 4.0, 1.0]) in (1, 2)

    def test_indefinite(self, name: str, single: bool) -> None:
        pattern = grid(4, 4, 3)
        values, diagonal = positive(pattern, 7)
        diagonal -= np.linalg.eigvalsh(dense(pattern, values, diagonal))[0] + 1e-2
        solver = make_solver(name, pattern, single)
        status = solver.factorise(values, diagonal)
        assert 0 <= status <= pattern.size
        if status == 0:
            # An iterative solver finds out while it iterates.
            assert name == "schur_pcg"
            assert np.isnan(solver.solved(np.ones(pattern.size))).all()

    @pytest.mark.sweep(5)
    @pytest.mark.parametrize("pattern", sorted(PATTERNS))
    def test_step(self, pattern: str, name: str, single: bool) -> None:
        blocks = PATTERNS[pattern]()
        values, diagonal = positive(blocks, 8, np.float32 if single else np.float64)
        solver = make_solver(name, blocks, single)
        rng = np.random.default_rng(8)
        tolerance = 1e-4 if single else 1e-11
        for damping in (0.0, 0.1):
            damped = diagonal * (1 + damping)
            b, other = rng.standard_normal((2, blocks.size))
            matrix = dense(blocks, values, damped)
            status, x = solver.step(values, damped, b)
            assert status == 0
            assert np.abs(matrix @ x - b).max() < tolerance
            # The factor is there for right-hand sides that come later.
            assert np.abs(matrix @ solver.solved(other) - other).max() < tolerance

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_bad_right_hand_side_leaves_nothing(self, bad: float, name: str, single: bool) -> None:
        pattern = slam(10, 30)
        values, diagonal = positive(pattern, 9, np.float32 if single else np.float64)
        solver = make_solver(name, pattern, single)
        b = np.ones(pattern.size)
        spoilt = b.copy()
        spoilt[[0, 31, -1]] = bad
        status, x = solver.step(values, diagonal, spoilt)
        assert status == 0
        assert not np.isfinite(x).all()
        solver.restart()
        tolerance = 1e-4 if single else 1e-11
        matrix = dense(pattern, values, diagonal)
        assert np.abs(matrix @ solver.solved(b) - b).max() < tolerance
        assert np.abs(matrix @ solver.step(values, diagonal, b)[1] - b).max() < tolerance

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
    def test_step_fails_as_factorise_does(self, bad: float, name: str, single: bool) -> None:
        pattern = grid(6, 6, 3)
        values, diagonal = positive(pattern, 4)
        spoilt = diagonal.copy()
        spoilt[[17, 50]] = bad
        solver = make_solver(name, pattern, single)
        expected = make_solver(name, pattern, single).factorise(values, spoilt)
        assert expected > 0
        b = np.ones(pattern.size)
        assert solver.step(values, spoilt, b) == (expected, None)
        status, x = solver.step(values, diagonal, b)
        assert status == 0
        residual = dense(pattern, values, diagonal) @ x - b
        assert np.abs(residual).max() < (1e-4 if single else 1e-11)

    def test_wrong_lengths(self, name: str) -> None:
        pattern = chain(4, 2)
        solver = make_solver(name, pattern)
        with pytest.raises(ValueError, match="expected"):
            solver.factorise(np.zeros(3), np.ones(pattern.size))
        with pytest.raises(ValueError, match="right-hand side"):
            solver.solved(np.ones(3))
        values, diagonal = positive(pattern, 0)
        with pytest.raises(ValueError, match="right-hand side"):
            solver.step(values, diagonal, np.ones(3))
        with pytest.raises(ValueError, match="expected"):
            solver.step(values[1:], diagonal, diagonal)


@pytest.mark.parametrize("pattern", ["slam", "grid_spatial", "mixed"])
def test_solvers_agree(pattern: str, name: str) -> None:
    shape = PATTERNS[pattern]()
    values, diagonal = positive(shape, 11)
    b = np.random.default_rng(1).standard_normal(shape.size)
    answers = []
    for solver in (make_solver("dense", shape), make_solver(name, shape)):
        assert solver.factorise(values, diagonal) == 0
        answers.append(solver.solved(b))
    reference, x = answers
    assert np.abs(x - reference).max() <= 1e-8 * np.abs(reference).max()
