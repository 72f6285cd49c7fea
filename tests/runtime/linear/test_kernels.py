"""The dense kernels in every build this processor can run, through the solvers above them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import instruction_sets, use_instruction_set
from tests.runtime.linear.block_matrices import arrow, build, chain, dense, grid, positive, slam

PATTERNS = [
    chain(30, 1),
    chain(20, 5),
    arrow(20, 3),
    grid(7, 11, 3),
    grid(8, 6, 6),
    slam(12, 40),
    build([20, 13, 1, 9, 17], [(0, 1), (1, 2), (2, 3), (3, 4), (0, 4)]),
]


@pytest.fixture(params=instruction_sets())
def instructions(request: pytest.FixtureRequest) -> Iterator[str]:
    """Use one instruction set, then go back to the best."""
    use_instruction_set(request.param)
    yield str(request.param)
    use_instruction_set(instruction_sets()[-1])


@pytest.mark.sweep(4)
@pytest.mark.parametrize("single", [False, True], ids=["f64", "f32"])
@pytest.mark.parametrize("name", ["dense", "band", "sparse"])
@pytest.mark.parametrize("index", range(len(PATTERNS)))
def test_residual(index: int, name: str, single: bool, instructions: str) -> None:
    pattern = PATTERNS[index]
    values, diagonal = positive(pattern, index, np.float32 if single else np.float64)
    solver = make_solver(name, pattern, single)
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(index).standard_normal(pattern.size)
    for x in (solver.solved(b), solver.step(values, diagonal, b)[1]):
        residual = dense(pattern, values, diagonal) @ x - b
        assert np.abs(residual).max() < (2e-5 if single else 1e-13)


@pytest.mark.sweep(5)
@pytest.mark.parametrize("single", [False, True], ids=["f64", "f32"])
@pytest.mark.parametrize("rows", [*range(1, 20), 24, 31, 32, 33, 47, 48])
@pytest.mark.parametrize("columns", [1, 5, 6, 13])
def test_every_front(rows: int, columns: int, single: bool, instructions: str) -> None:
    """Sizes around the multiples of a vector, with a right-hand side below each panel."""
    pattern = build([columns, rows, columns, 70], [(0, 1), (1, 2), (1, 3)])
    values, diagonal = positive(pattern, rows, np.float32 if single else np.float64)
    solver = make_solver("sparse", pattern, single, ordering="natural")
    b = np.random.default_rng(rows).standard_normal(pattern.size)
    status, x = solver.step(values, diagonal, b)
    assert status == 0
    for found in (x, solver.solved(b)):
        residual = dense(pattern, values, diagonal) @ found - b
        assert np.abs(residual).max() < (2e-5 if single else 1e-13)


@pytest.mark.parametrize("size", [*range(1, 30), 47, 48, 49, 100])
def test_every_remainder(size: int, instructions: str) -> None:
    """Sizes around the multiples of a tile's rows and columns."""
    pattern = build([size], [])
    values, diagonal = positive(pattern, size)
    solver = make_solver("dense", pattern)
    assert solver.factorise(values, diagonal) == 0
    matrix = dense(pattern, values, diagonal)
    assert np.abs(matrix @ solver.solved(matrix.sum(axis=1)) - matrix.sum(axis=1)).max() < 1e-12


@pytest.mark.sweep(
    slow=(
        "base-dense-1537",
        "base-sparse-1537",
        "base-band-1537",
        "avx512-band-1537",
        "avx2-band-1537",
    )
)
@pytest.mark.parametrize("size", [1537, pytest.param(1600, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["dense", "sparse", "band"])
def test_large(size: int, name: str, instructions: str) -> None:
    """Matrices that go block by block, or to LAPACK; NaN is still found."""
    pattern = build([size - 20, 20], [(0, 1)])
    values, diagonal = positive(pattern, 0)
    solver = make_solver(name, pattern)
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(0).standard_normal(size)
    assert np.abs(dense(pattern, values, diagonal) @ solver.solved(b) - b).max() < 1e-11
    for bad in (np.nan, np.inf, -1.0):
        spoilt = diagonal.copy()
        spoilt[900] = bad
        assert solver.factorise(values, spoilt) == 1 + 900


@pytest.mark.sweep(3)
@pytest.mark.parametrize("size", [450, pytest.param(1540, marks=pytest.mark.slow)])
@pytest.mark.parametrize("below", [10, 300])
def test_large_fronts_with_rows_below(size: int, below: int, instructions: str) -> None:
    pattern = build([size, size, below], [(0, 2), (1, 2)])
    values, diagonal = positive(pattern, 0)
    solver = make_solver("sparse", pattern)
    assert solver.plan["supernodes"] > 1
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(0).standard_normal(pattern.size)
    for x in (solver.solved(b), solver.step(values, diagonal, b)[1]):
        assert np.abs(dense(pattern, values, diagonal) @ x - b).max() < 1e-11


def test_unknown_instruction_set() -> None:
    with pytest.raises(ValueError, match="instruction set 'mmx'"):
        use_instruction_set("mmx")
