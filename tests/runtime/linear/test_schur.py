"""Block elimination: the choice of the set, the reduced system, every build of the kernels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import instruction_sets, products, reduce, use_instruction_set
from arael.runtime.linear.planning import independent_set, named_set
from arael.runtime.linear.reduced import INNER, plan_reduced, product_count
from tests.runtime.linear.block_matrices import build, bundle, chain, dense, grid, positive, slam


@pytest.fixture(params=instruction_sets())
def instructions(request: pytest.FixtureRequest) -> Iterator[str]:
    """Use one instruction set, then go back to the best."""
    use_instruction_set(request.param)
    yield str(request.param)
    use_instruction_set(instruction_sets()[-1])


def residual(pattern: BlockPattern, single: bool = False, **options: object) -> float:
    """Largest entry of ``H x - b``."""
    values, diagonal = positive(pattern, 3, np.float32 if single else np.float64)
    solver = make_solver("schur", pattern, single, **options)
    assert solver.factorise(values, diagonal) == 0
    b = np.random.default_rng(0).standard_normal(pattern.size)
    return float(np.abs(dense(pattern, values, diagonal) @ solver.solved(b) - b).max())


@pytest.mark.sweep(5)
@pytest.mark.parametrize("single", [False, True], ids=["f64", "f32"])
@pytest.mark.parametrize("first", [False, True], ids=["points_last", "points_first"])
@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15, 17, 20, 33])
def test_every_size_of_kept_block(size: int, first: bool, single: bool, instructions: str) -> None:
    assert residual(bundle(8, 40, size, first), single) < (1e-4 if single else 1e-12)


@pytest.mark.parametrize("single", [False, True], ids=["f64", "f32"])
@pytest.mark.parametrize("size", range(1, 14))
def test_every_size_of_eliminated_block(size: int, single: bool, instructions: str) -> None:
    pattern = build([6] * 5 + [size] * 20, [(k % 5, 5 + k // 3) for k in range(60)])
    gone = list(range(5, 25))
    assert residual(pattern, single, eliminate=gone) < (1e-4 if single else 1e-12)


@pytest.mark.parametrize("inner", INNER)
@pytest.mark.parametrize("pattern", [slam(12, 60), bundle(9, 70), grid(7, 6, 3)])
def test_every_solver_of_the_rest(pattern: BlockPattern, inner: str) -> None:
    assert residual(pattern, reduced=inner) < 1e-12
    plan = make_solver("schur", pattern, reduced=inner).plan
    assert plan["reduced_solver"] == inner
    assert set(INNER) <= set(plan["reduced_costs"])


def test_kept_blocks_of_mixed_sizes_and_eliminated_ones_too() -> None:
    rng = np.random.default_rng(5)
    sizes = [6, 9, 3, 1, 7, 16] * 3 + [3, 2, 1, 5] * 20
    pairs = [(int(rng.integers(0, 18)), 18 + k // 4) for k in range(320)]
    pairs += [(k, k + 1) for k in range(17)]
    assert residual(build(sizes, pairs), eliminate=range(18, 98)) < 1e-12


def test_reduced_system_is_the_schur_complement() -> None:
    """A solve of the reduced system alone gives the kept part of the whole solution."""
    pattern = slam(6, 25)
    values, diagonal = positive(pattern, 8)
    whole = dense(pattern, values, diagonal)
    gone = np.repeat(independent_set(pattern), pattern.sizes)
    complement = whole[~gone][:, ~gone] - whole[~gone][:, gone] @ np.linalg.solve(
        whole[gone][:, gone], whole[gone][:, ~gone]
    )
    b = np.random.default_rng(2).standard_normal(pattern.size)
    b[gone] = 0
    solver = make_solver("schur", pattern)
    assert solver.factorise(values, diagonal) == 0
    assert np.allclose(solver.solved(b)[~gone], np.linalg.solve(complement, b[~gone]), atol=1e-13)


class TestChoiceOfTheSet:
    """Which entities `schur` eliminates."""

    @pytest.mark.parametrize("first", [False, True])
    def test_points_of_a_bundle(self, first: bool) -> None:
        pattern = bundle(20, 300, first=first)
        assert np.array_equal(independent_set(pattern), pattern.sizes == 3)

    def test_landmarks_and_not_the_poses_between(self) -> None:
        pattern = slam(20, 60)
        assert np.array_equal(independent_set(pattern), pattern.sizes == 3)

    def test_every_second_pose_of_a_chain(self) -> None:
        chosen = independent_set(chain(21, 6))
        assert not (chosen[1:] & chosen[:-1]).any()
        assert chosen.sum() >= 7

    def test_a_hub_is_kept(self) -> None:
        """A calibration as small as a landmark, coupled with all of them."""
        count = 500
        sizes = [3] + [3] * count + [6] * 50
        pairs = [(0, 501 + k) for k in range(50)]
        pairs += [(1 + k, 501 + (k * 7 + i) % 50) for k in range(count) for i in range(3)]
        pairs += [(0, 1 + count + k % 50) for k in range(200)]
        chosen = independent_set(build(sizes, pairs))
        assert chosen[1 : 1 + count].all()
        hub = independent_set(build([3] * 900, [(0, k) for k in range(1, 900)]))
        assert not hub[0] and hub[1:].all()

    def test_independent_on_random_graphs(self) -> None:
        rng = np.random.default_rng(0)
        for _ in range(50):
            n = int(rng.integers(1, 30))
            couples = rng.integers(0, n, (int(rng.integers(0, 60)), 2))
            pattern = build(rng.integers(0, 5, n).tolist(), couples.tolist())
            chosen = independent_set(pattern)
            columns = np.repeat(np.arange(n), np.diff(pattern.column_start))
            off = pattern.rows != columns
            assert not (chosen[pattern.rows[off]] & chosen[columns[off]]).any()
            assert not chosen[pattern.sizes == 0].any()

    def test_named(self) -> None:
        pattern = chain(9, 2)
        solver = make_solver("schur", pattern, eliminate=[1, 5])
        assert solver.plan["eliminated"] == 2
        assert solver.plan["reduced_n"] == 14

    def test_named_but_coupled_names_both(self) -> None:
        with pytest.raises(AraelError) as caught:
            make_solver("schur", chain(9, 2), eliminate=[1, 4, 5])
        (diagnostic,) = caught.value.diagnostics
        assert diagnostic.code == "E0842"
        assert diagnostic.message.startswith("e[4].0 and e[5].0 are coupled")
        assert "eliminate='auto'" in diagnostic.help[1]

    @pytest.mark.parametrize("bad", [[9], [-1]])
    def test_named_but_not_there(self, bad: list[int]) -> None:
        with pytest.raises(AraelError) as caught:
            named_set(chain(9, 2), bad)
        assert caught.value.diagnostics[0].code == "E0842"

    @pytest.mark.parametrize(
        "options", [{"eliminate": "landmarks"}, {"reduced": "cholmod"}, {"ordering": "magic"}]
    )
    def test_unknown_values(self, options: dict[str, str]) -> None:
        with pytest.raises(AraelError) as caught:
            make_solver("schur", chain(9, 2), **options)
        assert caught.value.diagnostics[0].code == "E0842"


def test_products_are_counted_and_partial_ones_are_those_near() -> None:
    pattern = bundle(12, 100)
    reduction = reduce(pattern, independent_set(pattern))
    everything = products(reduction)
    assert int(everything.tasks[:, 5].sum()) == product_count(reduction)
    part = products(reduction, reach=1)
    columns = np.repeat(np.arange(12), np.diff(part.pattern.column_start))
    assert set((part.pattern.rows - columns).tolist()) == {0, 1}
    grouped = products(reduction, group=np.arange(12) // 4)
    columns = np.repeat(np.arange(12), np.diff(grouped.pattern.column_start))
    assert np.array_equal(grouped.pattern.rows // 4, columns // 4)
    assert len(grouped.pattern.rows) > 12


def test_out_of_proportion_is_not_planned_by_auto(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.runtime.linear.reduced._TOO_MANY", 10)
    pattern = bundle(9, 70)
    reduction = reduce(pattern, independent_set(pattern))
    assert plan_reduced(reduction, False, patient=False) is None
    assert "schur" not in make_solver("auto", pattern).plan["costs"]
    assert make_solver("schur", pattern).plan["solver"] == "schur"


@pytest.mark.parametrize("scalar", [3 * 40 + 4, 3 * 7 + 1])
def test_first_bad_pivot_is_named_in_the_whole_system(scalar: int) -> None:
    """One in a camera, found in the reduced system, and one in a point, found before it."""
    pattern = bundle(8, 40, first=True)
    values, diagonal = positive(pattern, 1)
    diagonal[scalar] = -1e6
    assert make_solver("schur", pattern).factorise(values, diagonal) == 1 + scalar
