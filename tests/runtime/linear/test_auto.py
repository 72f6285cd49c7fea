"""Choice of a linear solver by name and by predicted cost, and what is said about it."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
import scipy.sparse

from arael.diagnostics.records import AraelError
from arael.runtime.linear.auto import CANDIDATES, SOLVERS, make_solver
from tests.optional import solvers
from tests.runtime.linear.block_matrices import (
    branches,
    build,
    bundle,
    chain,
    dense,
    grid,
    positive,
)


@pytest.mark.parametrize("name", solvers(sorted(SOLVERS)))
def test_plan_reports_every_solver(name: str) -> None:
    plan = make_solver(name, grid(6, 5, 3)).plan
    assert plan["asked"] == name
    eliminating = {"schur", "schur_pcg"} if name == "auto" else set()  # not planned: see below
    assert set(plan["costs"]) == set(SOLVERS) - {"auto"} - eliminating
    for cost in plan["costs"].values():
        assert cost["flops"] > 0 and cost["nnz_l"] > 0 and cost["predicted_ms"] > 0
    assert plan["predicted_ms"] == plan["costs"][plan["solver"]]["predicted_ms"]
    assert plan["solver"] in plan["why"]


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        (build([6] * 20, [(i, j) for i in range(20) for j in range(i)]), "dense"),
        (chain(500, 6), "band"),
        (branches(30, 30, 6), "sparse"),
        (bundle(30, 2000), "schur"),
    ],
)
def test_auto_takes_the_fitting_one(pattern: object, expected: str) -> None:
    plan = make_solver("auto", pattern).plan  # type: ignore[arg-type]
    assert plan["solver"] == expected
    able = [name for name in CANDIDATES if name in plan["costs"]]
    assert min(able, key=lambda s: plan["costs"][s]["predicted_ms"]) == expected


def test_flops_of_a_chain_are_exact() -> None:
    # Block tridiagonal, natural order, 6 x 6: band of half-width 11.
    plan = make_solver("band", chain(3, 6)).plan
    columns = [min(12, 18 - j) for j in range(18)]
    assert plan["flops"] == sum(c * c for c in columns)


def test_unknown_solver() -> None:
    with pytest.raises(AraelError) as caught:
        make_solver("sprase", chain(3, 2))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E0840"
    assert diagnostic.help == ("did you mean 'sparse'?",)
    assert all(name in diagnostic.notes[0] for name in SOLVERS)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("dense", {"ordering": "natural"}),
        ("sparse", {"orderng": "natural"}),
        ("sparse", {"ordering": "magic"}),
        ("band", {"half_bandwidth": -1}),
    ],
)
def test_bad_options(name: str, options: dict[str, object]) -> None:
    with pytest.raises(AraelError) as caught:
        make_solver(name, chain(3, 2), **options)
    assert caught.value.diagnostics[0].code == "E0842"


@pytest.mark.parametrize("name", ["band", "lapack_band"])
@pytest.mark.parametrize("option", [{"half_bandwidth": 7}, {"block_half_bandwidth": 2}])
def test_entry_outside_the_band_names_both(name: str, option: dict[str, int]) -> None:
    pattern = build([3] * 8, [(i, i + 1) for i in range(7)] + [(2, 6)])
    with pytest.raises(AraelError) as caught:
        make_solver(name, pattern, **option)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E1020"
    assert "e[2].0" in diagnostic.message and "e[6].0" in diagnostic.message


@pytest.mark.parametrize("name", ["band", "lapack_band"])
@pytest.mark.parametrize("declared", [{"half_bandwidth": 30}, {"half_bandwidth": 500}])
def test_wider_band_than_needed(name: str, declared: dict[str, int]) -> None:
    pattern = chain(20, 3)
    values, diagonal = positive(pattern, 0)
    solver = make_solver(name, pattern, **declared)
    assert solver.factorise(values, diagonal) == 0
    b = np.arange(60.0)
    assert np.allclose(dense(pattern, values, diagonal) @ solver.solved(b), b)


def test_cholmod_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", None)
    with pytest.raises(AraelError) as caught:
        make_solver("cholmod", chain(3, 2))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E0841"
    assert diagnostic.help[0] == 'pip install "arael[cholmod]"'
    assert "SuiteSparse" in diagnostic.notes[0]


@pytest.mark.parametrize("sizes", [[1], [2], [1, 1], [3, 3, 3], [2] * 10, [8] * 8])
def test_small_systems_are_dense_and_nothing_is_compared(sizes: list[int]) -> None:
    for edges in ([], [(k + 1, k) for k in range(len(sizes) - 1)]):
        pattern = build(sizes, edges)
        plan = make_solver("auto", pattern).plan
        assert plan["solver"] == "dense"
        assert list(plan["costs"]) == ["dense"]
        unknowns = f"{sum(sizes)} unknown{'s' if sum(sizes) > 1 else ''} in"
        assert f"dense is predicted to factorise {unknowns}" in plan["why"]
        assert "up to 64 unknowns it is taken without comparing others" in plan["why"]
        compared = make_solver("dense", pattern).plan["costs"]
        assert plan["costs"]["dense"] == compared["dense"]


def test_above_64_unknowns_and_with_options_solvers_are_compared() -> None:
    assert len(make_solver("auto", chain(13, 5)).plan["costs"]) > 3
    assert len(make_solver("auto", chain(3, 2), ordering="natural").plan["costs"]) > 3


class _NotPositiveDefiniteError(Exception):
    pass


class _CholeskyFactor:
    """Stands in for `CholeskyFactor` of scikit-sparse 0.5: same calls, dense inside."""

    def __init__(self, matrix: scipy.sparse.csc_matrix, *, lower: bool, supernodal_mode: str):
        assert lower and supernodal_mode == "supernodal"
        self.size = matrix.shape[0]

    def factorize(self, matrix: scipy.sparse.csc_matrix, ldl: bool, beta: float) -> None:
        assert ldl is False and beta == 0
        lower = matrix.toarray()
        assert np.array_equal(lower, np.tril(lower))
        # Eliminated backwards, so that the permutation matters.
        self.matrix = (lower + np.tril(lower, -1).T)[::-1, ::-1]
        for k in range(1, self.size + 1):
            if np.linalg.det(self.matrix[:k, :k]) <= 0:
                raise _NotPositiveDefiniteError(f"Failed at column {k - 1}.")

    def get_perm(self) -> np.ndarray:
        return np.arange(self.size)[::-1]

    def solve(self, b: np.ndarray) -> np.ndarray:
        return np.linalg.solve(self.matrix, b[::-1])[::-1]


def test_cholmod_through_the_interface_of_0_5(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = SimpleNamespace(
        CholeskyFactor=_CholeskyFactor,
        CholmodNotPositiveDefiniteError=_NotPositiveDefiniteError,
    )
    module = ModuleType("sksparse.cholmod")
    module.__dict__.update(parts.__dict__)
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", module)
    pattern = chain(4, 2)
    values, diagonal = positive(pattern, 0)
    solver = make_solver("cholmod", pattern)
    assert solver.factorise(values, diagonal) == 0
    b = np.arange(8.0)
    assert np.allclose(dense(pattern, values, diagonal) @ solver.solved(b), b)
    diagonal[5] = -100.0
    assert solver.factorise(values, diagonal) == 1 + 5


def test_no_elimination_is_planned_for_entities_that_are_coupled_with_their_like() -> None:
    side = 30
    pairs = [(i, i + 1) for i in range(side * side - 1)]
    pairs += [(i, i + side) for i in range(side * side - side)]
    pattern = build([3] * (side * side), pairs)
    plan = make_solver("auto", pattern).plan
    assert plan["solver"] == "sparse"
    assert "schur" not in plan["costs"]
    eliminated = make_solver("schur", pattern).plan
    assert plan["predicted_ms"] < 1.1 * eliminated["predicted_ms"]


def test_the_elimination_of_a_kind_is_planned_even_if_there_are_few() -> None:
    plan = make_solver("auto", bundle(12, 40)).plan
    assert plan["solver"] == "schur"


def test_orderings_are_compared_only_where_a_solve_repays_it() -> None:
    quick, long = (make_solver("auto", grid(rows, 40, 6)).plan for rows in (2, 20))
    assert list(quick["orderings"]) == ["minimum_degree"]
    assert len(long["orderings"]) > 1


def test_options_are_compared_as_asked() -> None:
    plan = make_solver("auto", grid(6, 5, 3), eliminate=[0, 2]).plan
    assert "schur" in plan["costs"]
    assert list(make_solver("auto", grid(6, 5, 3), ordering="natural").plan["orderings"]) == [
        "natural"
    ]
