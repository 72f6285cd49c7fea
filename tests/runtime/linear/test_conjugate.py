"""Conjugate gradients on the reduced system: preconditioners, forcing terms, breakdown."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.clusters import visibility_clusters
from arael.runtime.linear.compiled import instruction_sets, reduce, use_instruction_set
from arael.runtime.linear.iterative import PRECONDITIONERS
from arael.runtime.linear.planning import independent_set
from tests.runtime.linear.block_matrices import build, bundle, dense, positive, slam

EXACT = {"tolerance": 1e-14, "floor": 1e-14}


@pytest.mark.parametrize("instructions", instruction_sets())
@pytest.mark.parametrize("formed", [True, False])
@pytest.mark.parametrize("kind", PRECONDITIONERS)
@pytest.mark.parametrize("pattern", [bundle(9, 70), bundle(9, 70, 6, True), slam(12, 60)])
def test_solution(pattern, kind: str, formed: bool, instructions: str) -> None:  # type: ignore[no-untyped-def]
    use_instruction_set(instructions)
    try:
        values, diagonal = positive(pattern, 0)
        solver = make_solver("schur_pcg", pattern, formed=formed, preconditioner=kind, **EXACT)
        assert solver.factorise(values, diagonal) == 0
        b = np.random.default_rng(0).standard_normal(pattern.size)
        assert np.abs(dense(pattern, values, diagonal) @ solver.solved(b) - b).max() < 1e-12
    finally:
        use_instruction_set(instruction_sets()[-1])


def ill_conditioned(pattern, seed: int = 0):  # type: ignore[no-untyped-def]
    """Values of J'J on the pattern, barely damped, so that iterations are needed."""
    values, _ = positive(pattern, seed)
    whole = dense(pattern, values, np.zeros(pattern.size))
    low = np.linalg.eigvalsh(whole)[0]
    return values, np.full(pattern.size, 1e-3 - low)


def test_forcing_bounds_what_is_left() -> None:
    """Residual in the norm of the preconditioner, here close to the Euclidean one."""
    pattern = bundle(12, 90)
    values, diagonal = ill_conditioned(pattern)
    b = np.random.default_rng(1).standard_normal(pattern.size)
    left, steps = [], []
    for tolerance in (0.5, 1e-2, 1e-6):
        solver = make_solver(
            "schur_pcg", pattern, tolerance=tolerance, floor=1e-9, preconditioner="jacobi"
        )
        assert solver.factorise(values, diagonal) == 0
        x = solver.solved(b)
        left.append(np.linalg.norm(dense(pattern, values, diagonal) @ x - b))
        report = solver.report()
        steps.append(report["iterations"])
        assert report["solves"] == 1
    assert left[0] > 10 * left[1] > 100 * left[2]
    assert steps[0] < steps[1] < steps[2]


def test_an_unfinished_step_has_the_predicted_decrease_of_a_finished_one() -> None:
    """``x' H x = x' b``, by which Levenberg-Marquardt computes what a step promises."""
    pattern = bundle(12, 90)
    values, diagonal = ill_conditioned(pattern)
    solver = make_solver("schur_pcg", pattern, tolerance=0.5, floor=0.4, preconditioner="jacobi")
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(1).standard_normal(pattern.size)
    x = solver.solved(b)
    whole = dense(pattern, values, diagonal)
    assert np.linalg.norm(whole @ x - b) > 1e-3 * np.linalg.norm(b)
    assert x @ whole @ x == pytest.approx(x @ b, rel=1e-9)
    assert x @ b > 0


def test_forcing_terms_follow_the_gradient() -> None:
    pattern = bundle(12, 90)
    values, diagonal = positive(pattern, 0)
    solver = make_solver("schur_pcg", pattern, tolerance=0.1, floor=1e-8)
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(1).standard_normal(pattern.size)
    terms = []
    for scale in (1.0, 0.9, 0.9, 0.09, 0.009, 0.009e-6, 1.0):
        solver.solved(scale * b)
        terms.append(solver.forcing)  # type: ignore[attr-defined]
    expected = [0.1, 0.1, 0.01, 0.9e-2, 0.9e-2, 1e-8, 0.1]
    assert np.allclose(terms, expected, rtol=1e-6)


def test_an_indefinite_part_gives_way_to_the_diagonal_blocks() -> None:
    """Dropping far couplings of a definite matrix can leave an indefinite one."""
    rng = np.random.default_rng(0)
    count = 40
    pairs = [(i, j) for i in range(count) for j in range(i)]
    pattern = build([1] * count + [1], [*pairs, (0, count)])
    # Strong ties in all directions: J'J of few rows, with a little on the diagonal.
    rows = rng.standard_normal((3, count + 1))
    rows[:, count] = 0
    whole = rows.T @ rows + 1e-3 * np.eye(count + 1)
    tridiagonal = np.tril(np.triu(whole[:count, :count], -1), 1)
    assert np.linalg.eigvalsh(whole)[0] > 0 > np.linalg.eigvalsh(tridiagonal)[0]
    values = np.zeros(pattern.value_count)
    for j in range(count + 1):
        for k in range(pattern.column_start[j], pattern.column_start[j + 1]):
            values[pattern.value_start[k]] = whole[pattern.rows[k], j]
    solver = make_solver(
        "schur_pcg", pattern, preconditioner="tridiagonal", eliminate=[count], **EXACT
    )
    assert solver.factorise(values, np.diag(whole).copy()) == 0
    b = rng.standard_normal(count + 1)
    assert np.abs(whole @ solver.solved(b) - b).max() < 1e-9


def test_most_iterations() -> None:
    pattern = bundle(12, 90)
    values, diagonal = ill_conditioned(pattern)
    solver = make_solver("schur_pcg", pattern, iterations=3, preconditioner="jacobi", **EXACT)
    assert solver.factorise(values, diagonal) == 0
    assert np.isfinite(solver.solved(np.ones(pattern.size))).all()
    assert solver.report()["iterations"] == 3


def test_clusters_are_bounded_and_follow_the_ties() -> None:
    """Two rooms with cameras that see points of their own room only."""
    pairs = [(room * 5 + camera, 10 + room * 30 + point)
             for room in range(2) for point in range(30) for camera in range(5)]  # fmt: skip
    pattern = build([9] * 10 + [3] * 60, pairs)
    reduction = reduce(pattern, independent_set(pattern))
    found = visibility_clusters(reduction)
    assert len(set(found[:5])) == len(set(found[5:])) == 1 and found[0] != found[5]
    small = visibility_clusters(reduction, largest=3)
    assert max(np.bincount(small)) <= 3


def test_auto_iterates_only_where_factorising_is_out_of_reach() -> None:
    """Cameras that all see the same things; few of them, and very many."""
    rng = np.random.default_rng(0)
    plans = []
    for cameras, points in ((40, 400), (1200, 6000)):
        seen = rng.integers(0, cameras, (points, 8))
        pairs = [(int(c), cameras + p) for p in range(points) for c in seen[p]]
        plans.append(make_solver("auto", build([9] * cameras + [3] * points, pairs)).plan)
    assert [plan["solver"] for plan in plans] == ["schur", "schur_pcg"]
    assert plans[1]["costs"]["schur"]["predicted_ms"] > plans[1]["predicted_ms"] * 4
    assert "too large to factorise" in plans[1]["why"]


@pytest.mark.parametrize(
    "options",
    [
        {"preconditioner": "ilu"},
        {"formed": "maybe"},
        {"tolerance": 0},
        {"tolerance": 1.5},
        {"floor": -1e-3},
        {"iterations": 0},
    ],
)
def test_bad_options(options: dict[str, object]) -> None:
    with pytest.raises(AraelError) as caught:
        make_solver("schur_pcg", slam(4, 9), **options)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E0842"
    assert str(next(iter(options.values()))) in diagnostic.message
