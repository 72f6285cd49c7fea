"""The same bits on any number of threads: pool, evaluation, linear solvers, whole solves."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.config import LmConfig
from arael.runtime.assembly import shares
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.levenberg.compiled import Vectors
from arael.runtime.linear import parts, subtrees
from arael.runtime.linear.auto import SOLVERS, make_solver
from arael.runtime.parallel import compiled as pool
from arael.runtime.parallel import vector_parts
from arael.runtime.problem import Problem
from arael.runtime.solve import minimise
from arael.scenes import SceneConfig, columns, fill, make_scene
from arael.solving import problem_of
from tests.optional import solvers
from tests.runtime import toys
from tests.runtime.linear.block_matrices import build, chain, dense, grid, positive, slam

COUNTS = (1, 2, 3, 4)


@pytest.fixture
def finely(monkeypatch: pytest.MonkeyPatch) -> None:
    """Split everything as if it took long, so that small problems use every thread."""
    monkeypatch.setattr(shares, "GRAIN", 1.0)
    monkeypatch.setattr(shares, "_ROOM", 100.0)
    monkeypatch.setattr(parts, "GRAIN", 100.0)
    monkeypatch.setattr(parts, "_ROOM", 100.0)
    monkeypatch.setattr(subtrees, "GRAIN", 100.0)
    monkeypatch.setattr(vector_parts, "GRAIN", 20)


def test_only_long_linearisations_may_have_more_shares_than_eight(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shares, "MOST_SHARES", 8)
    assert shares._count(1e12) == 8
    monkeypatch.setattr(shares, "MOST_SHARES", 64)
    found = [shares._count(1e6 * ms) for ms in (0.1, 1, 7, 15.9, 16, 33, 64, 500)]
    assert found == [1, 5, 8, 8, 16, 32, 64, 64]


def test_shares_grow_with_the_processors_of_the_machine() -> None:
    found = [shares.shares_for(processors) for processors in (1, 2, 8, 9, 16, 48, 64, 256)]
    assert found == [8, 8, 8, 16, 16, 64, 64, 64]


class TestPool:
    """Every item of a job is done once."""

    @pytest.mark.parametrize("threads", [1, 2, 3, 7, 1000])
    @pytest.mark.parametrize("items", [0, 1, 2, 50])
    def test_each_item_once(self, threads: int, items: int) -> None:
        for _ in range(20):
            times, inner = pool.tally(threads, items, 3)
            assert (times == 1).all()
            assert (inner == 1).all()

    def test_callers_side_by_side(self) -> None:
        wrong = []

        def call() -> None:
            for _ in range(100):
                times, _ = pool.tally(3, 20)
                if not (times == 1).all():
                    wrong.append(times)

        callers = [threading.Thread(target=call) for _ in range(4)]
        for one in callers:
            one.start()
        for one in callers:
            one.join()
        assert not wrong

    @pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
    def test_child_of_a_fork(self) -> None:
        pool.tally(3, 20)
        child = os.fork()
        if child == 0:
            times, _ = pool.tally(3, 20)
            os._exit(0 if (times == 1).all() and pool.helpers() <= 2 else 1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0

    def test_threads_for(self) -> None:
        most = pool.threads_for(10**6)
        assert pool.threads_for(1) == 1
        assert pool.threads_for(0) == (pool.cores() if pool.supported() else 1)
        assert 1 <= most < 10**6


def scene(precision: str | None = None, model: str = "slam", poses: int = 20):
    """A small scene, filled in."""
    instance = arael.load(model, precision=precision)(gamma=3.0)
    fill(instance, instance.layout, columns(make_scene(SceneConfig(poses=poses)), model))
    return instance


TRIMMED = """
struct Reading { x: real
    constraint near when abs(root.a - x) < root.reach { root.a - x }
}
root Mean { param a: real; reach: real = 1.5; readings: list of Reading }
"""


@pytest.mark.usefixtures("finely")
class TestEvaluation:
    """Cost, gradient and blocks of a problem that is split."""

    @pytest.mark.sweep(4)
    @pytest.mark.parametrize("precision", ["f64", "f32"])
    @pytest.mark.parametrize("model", ["slam", "localization"])
    def test_same_bits(self, precision: str, model: str, monkeypatch: pytest.MonkeyPatch) -> None:
        instance = scene(precision, model)
        split = problem_of(instance).evaluation
        assert split.shares > 1
        first = None
        for threads in COUNTS:
            split.threads = threads
            for _ in range(3):
                found = (*split.linearised(), split.total_cost())
                first = first or found
                for a, b in zip(found, first, strict=True):
                    np.testing.assert_array_equal(a, b)
        # What is not split is the reference.
        monkeypatch.setattr(shares, "GRAIN", 1e30)
        whole = problem_of(instance).evaluation
        assert whole.shares == 1
        tolerance = 1e-4 if precision == "f32" else 1e-12
        for a, b in zip(first, (*whole.linearised(), whole.total_cost()), strict=True):
            np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance * np.abs(b).max())

    def test_more_shares_than_eight_have_the_same_bits(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        instance = scene()
        monkeypatch.setattr(shares, "MOST_SHARES", 8)
        eight = problem_of(instance).evaluation.linearised()
        monkeypatch.setattr(shares, "MOST_SHARES", 64)
        monkeypatch.setattr(shares, "WIDE_GRAIN", 1.0)
        monkeypatch.setattr(shares, "_WIDE_ROOM", 100.0)
        split = Problem(instance._compiled.layout, instance._store, instance._compiled.kernels)
        assert split.evaluation.shares > shares.SHARES
        found = []
        for threads in (1, 2, 3, 8, 16, 64):
            split.evaluation.threads = threads
            found.append((*split.evaluation.linearised(), split.evaluation.total_cost()))
        for one in found:
            for a, b in zip(one, found[0], strict=True):
                np.testing.assert_array_equal(a, b)
        for a, b in zip(found[0], eight, strict=False):
            np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12 * np.abs(b).max())

    @pytest.mark.sweep(3)
    @pytest.mark.parametrize("way", ["guarded", "machine", "compiled"])
    def test_other_constraints(
        self, way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Guards over parameters; residuals of run time, on the machine and on kernels."""
        x = np.random.default_rng(0).normal(size=500)
        if way == "guarded":
            (tmp_path / "trimmed.arael").write_text(TRIMMED)
            instance = arael.load(tmp_path / "trimmed.arael")(a=0.1)
            instance.readings.extend(x=x)
        else:
            start = {"a": 0.1, "b": 0.5}
            fit = arael.runtime_residual("a - exp(b * x)", parameters=start, data={"x": x})
            instance = arael.runtime_model(fit)
            if way == "compiled":
                instance.residuals.compile()
        parts = [problem_of(instance).evaluation]
        monkeypatch.setattr(shares, "GRAIN", 1e30)
        parts.append(problem_of(instance).evaluation)
        assert parts[0].shares > 1 == parts[1].shares
        found = []
        for threads in COUNTS:
            parts[0].threads = threads
            found.append((*parts[0].linearised(), parts[0].total_cost()))
            if way == "guarded":
                np.testing.assert_array_equal(parts[0].acting(0), np.abs(x - 0.1) < 1.5)
        whole = (*parts[1].linearised(), parts[1].total_cost())
        for one in found:
            for a, b, c in zip(one, found[0], whole, strict=True):
                np.testing.assert_array_equal(a, b)
                np.testing.assert_allclose(a, c, rtol=1e-12)

    def test_group_by_group(self) -> None:
        instance = scene()
        evaluation = problem_of(instance).evaluation
        _, gradient, values = evaluation.linearised()
        g, v = evaluation.workspace()
        cost = sum(evaluation.group_linearised(k, g, v) for k in range(len(instance.layout.groups)))
        assert cost == pytest.approx(evaluation.total_cost(), rel=1e-12)
        np.testing.assert_allclose(g[: len(gradient)], gradient, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(v[: len(values)], values, rtol=1e-9, atol=1e-6)


def blocky(width: int, height: int, size: int) -> BlockPattern:
    """A grid whose last columns are all coupled: wide fronts above many subtrees."""
    pairs = [(i, i + 1) for i in range(width * height - 1)]
    pairs += [(i, i + width) for i in range(width * (height - 1))]
    last = range(width * height - 70, width * height)
    pairs += [(i, j) for i in last for j in last if j < i]
    return build([size] * (width * height), pairs)


PATTERNS: dict[str, Callable[[], BlockPattern]] = {
    "pair": lambda: build([2, 3], [(0, 1)]),
    "chain": lambda: chain(200, 3),
    "grid": lambda: grid(20, 12, 3),
    "slam": lambda: slam(40, 200),
    "wide": lambda: blocky(30, 10, 6),
    "full": lambda: build([6] * 90, [(i, j) for i in range(90) for j in range(i)]),
    "forest": lambda: build([3] * 90, [(3 * (i // 3), i) for i in range(90) if i % 3]),
}


@pytest.mark.usefixtures("finely")
class TestLinearSolvers:
    """Each solver, precision and pattern."""

    @pytest.mark.sweep(
        5,
        slow=(
            "lapack_band-wide-f32",
            "lapack_band-wide-f64",
            "lapack_band-slam-f64",
            "dense-wide-f64",
            "cholmod-wide-f64",
        ),
    )
    @pytest.mark.parametrize("single", [False, True], ids=["f64", "f32"])
    @pytest.mark.parametrize("pattern", sorted(PATTERNS))
    @pytest.mark.parametrize("name", solvers(sorted(SOLVERS)))
    def test_same_bits(self, name: str, pattern: str, single: bool) -> None:
        blocks = PATTERNS[pattern]()
        values, diagonal = positive(blocks, 3, np.float32 if single else np.float64)
        b = np.random.default_rng(0).standard_normal(blocks.size)
        first = None
        for threads in COUNTS:
            # A new one each: iterative solvers go by what they met before.
            solver = make_solver(name, blocks, single)
            solver.use_threads(threads)
            for _ in range(2):
                assert solver.factorise(values, diagonal) == 0
            x = solver.solved(b), solver.step(values, diagonal, b)[1]
            first = x if first is None else first
            np.testing.assert_array_equal(x, first)
        exact = name != "schur_pcg"
        if exact:
            for x in first:
                residual = dense(blocks, values, diagonal) @ x - b
                assert np.abs(residual).max() < (2e-4 if single else 1e-11)

    @pytest.mark.sweep(3)
    @pytest.mark.parametrize("name", ["dense", "sparse", "schur", "band"])
    @pytest.mark.parametrize("pattern", ["grid", "slam", "wide", "full"])
    def test_same_failure(self, name: str, pattern: str) -> None:
        blocks = PATTERNS[pattern]()
        values, diagonal = positive(blocks, 4)
        bad = np.random.default_rng(1).choice(blocks.size, 5, replace=False)
        for poison in (np.nan, -1.0, np.inf):
            wrong = diagonal.copy()
            wrong[bad] = poison
            found = []
            for threads in COUNTS:
                solver = make_solver(name, blocks)
                solver.use_threads(threads)
                found.append(solver.factorise(values, wrong))
                # It is ready for the next attempt.
                assert solver.factorise(values, diagonal) == 0
            assert found[0] > 0
            assert len(set(found)) == 1

    def test_bundles_cover_the_tree(self) -> None:
        rng = np.random.default_rng(0)
        for count in (1, 2, 3, 50, 400):
            parent = np.array(
                [
                    rng.integers(s + 1, min(count, s + 9)) if s + 1 < count else -1
                    for s in range(count)
                ],
                dtype=np.int64,
            )
            cost = rng.uniform(10.0, 1000.0, count)
            alone = rng.random(count) < 0.02
            bundle, bundles = subtrees.bundle_subtrees(parent, cost, alone)
            assert set(bundle[bundle >= 0]) == set(range(bundles))
            assert (bundle[alone] == -1).all()
            inside = np.flatnonzero(bundle >= 0)
            above = parent[inside]
            # What is above a bundled front is in its bundle, or at the top.
            stays = above >= 0
            same = bundle[above[stays]] == bundle[inside[stays]]
            assert (same | (bundle[above[stays]] == -1)).all()
            top = np.flatnonzero((bundle == -1) & (parent >= 0))
            assert (bundle[parent[top]] == -1).all()


class TestVectors:
    """How vectors are cut, and where they are."""

    @pytest.mark.parametrize(
        ("scalars", "parts"), [(0, 1), (32767, 1), (32768, 4), (100_000, 12), (10**7, 16)]
    )
    def test_parts(self, scalars: int, parts: int) -> None:
        assert vector_parts.count_parts(scalars) == parts

    def test_solves_keep_their_arrays(self) -> None:
        totals = problem_of(scene()).evaluation.totals
        first, second = (Vectors(7, totals, 1) for _ in range(2))
        assert first.value_array is second.value_array
        assert first.step_array is not second.step_array


@pytest.mark.usefixtures("finely")
class TestSolve:
    """Whole solves."""

    @pytest.mark.sweep(4)
    @pytest.mark.parametrize("precision", ["f64", "f32"])
    @pytest.mark.parametrize("name", solvers(sorted(SOLVERS)))
    def test_same_steps(self, name: str, precision: str) -> None:
        layout = toys.chain(precision)
        found = []
        for threads in COUNTS:
            problem = Problem(layout, toys.chain_store(layout, 60, name != "band"))
            config = LmConfig.of(num_threads=threads, max_iters=6)
            outcome = minimise(problem, config, problem.make_solver(name))
            found.append((outcome.x, outcome.end_cost, list(outcome.history["trial_cost"])))
        for x, cost, history in found[1:]:
            np.testing.assert_array_equal(x, found[0][0])
            assert cost == found[0][1]
            assert history == found[0][2]

    @pytest.mark.sweep(4)
    @pytest.mark.parametrize("precision", ["f64", "f32"])
    @pytest.mark.parametrize("name", ["auto", "sparse", "schur", "schur_pcg", "dense"])
    def test_compiled_model(self, name: str, precision: str) -> None:
        found = []
        for threads in COUNTS:
            instance = scene(precision)
            result = instance.solve(solver=name, num_threads=threads, max_iters=5, passes=[])
            found.append((result.cost, instance.poses.pos.value.copy(), result.x))
        for cost, pos, x in found[1:]:
            assert cost == found[0][0]
            np.testing.assert_array_equal(pos, found[0][1])
            np.testing.assert_array_equal(x, found[0][2])

    def test_failure_is_named_alike(self) -> None:
        messages = []
        for threads in COUNTS:
            instance = scene()
            instance.poses.pos.value[3, 0] = np.nan
            with pytest.raises(arael.SolveError) as caught:
                instance.solve(num_threads=threads)
            messages.append(str(caught.value))
        assert "Pose.gps[3]" in messages[0]
        assert len(set(messages)) == 1

    def test_interrupted(self) -> None:
        problem = problem_of(scene())
        before, solver = problem.cost(), problem.make_solver("schur")

        def interrupt(*_: object) -> None:
            raise KeyboardInterrupt

        # Steps too short to converge: this would go on for hours.
        config = LmConfig.of(
            num_threads=3,
            max_iters=10**6,
            min_iters=10**6,
            initial_lambda=1e9,
            lambda_floor=1e9,
            time_limit=60.0,
        )
        previous = signal.signal(signal.SIGALRM, interrupt)
        signal.setitimer(signal.ITIMER_REAL, 0.3, 1.0)
        try:
            outcome = minimise(problem, config, solver)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, previous)
        assert outcome.status == "aborted"
        assert outcome.end_cost == problem.cost() <= before

    def test_solves_side_by_side(self) -> None:
        alone = scene()
        expected = alone.solve(num_threads=2, passes=[], max_iters=5).x
        found: list[np.ndarray] = []

        def run(instance) -> None:
            found.append(instance.solve(num_threads=2, passes=[], max_iters=5).x)

        threads = [threading.Thread(target=run, args=(scene(),)) for _ in range(3)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        assert len(found) == 3
        for x in found:
            np.testing.assert_array_equal(x, expected)
