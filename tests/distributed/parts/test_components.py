"""Several connected components in parts: each is solved as on one machine, and ends by itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.distributed import solve
from arael.distributed.parts import requests, team
from arael.distributed.parts.executors import Call, InProcess
from arael.distributed.parts.solve import prepare, run
from arael.distributed.parts.split import BOUNDARY, by_separators
from arael.runtime.linear import narrowing

from .problems import arrays_of, fields, fleet, tracks, with_arrays
from .test_equal import assert_equal, in_parts
from .test_split import Graph, path


def assert_components_equal(found: Any, alone: Any) -> None:
    assert_equal(found, alone)
    mine, other = found.result.components, alone.components
    assert len(mine) == len(other) > 1
    assert mine.names == other.names
    for one, expected in zip(mine, other, strict=True):
        assert (one.rows, one.status) == (expected.rows, expected.status)
        assert one.iterations == expected.iterations
        assert one.accepted_iterations == expected.accepted_iterations
        assert one.start_cost == pytest.approx(expected.start_cost, rel=1e-9)
        assert one.end_cost == pytest.approx(expected.end_cost, rel=1e-9)


@pytest.mark.parametrize("parts", [1, 2, 3, 5])
@pytest.mark.parametrize("strategy", ["auto", "damped"])
def test_each_component_is_solved_as_on_one_machine(parts: int, strategy: str) -> None:
    model = fleet()
    found = in_parts(model, parts, strategy=strategy)
    assert found.split.parts == parts
    alone = model.solve(solver="sparse", strategy=strategy)
    assert len(set(alone.components.iterations.tolist())) == 3
    assert_components_equal(found, alone)


@pytest.mark.parametrize("make", [tracks, fields])
@pytest.mark.parametrize("parts", [2, 3, 5])
@pytest.mark.parametrize("strategy", ["auto", "damped"])
def test_components_of_receivers_and_grids_end_apart(
    make: Callable[[], Any], parts: int, strategy: str
) -> None:
    model = make()
    found = in_parts(model, parts, strategy=strategy)
    assert_components_equal(found, model.solve(solver="sparse", strategy=strategy))
    assert len(set(found.result.components.iterations.tolist())) > 2


def test_the_limit_of_attempts_ends_the_slow_components_alone() -> None:
    model: Any = tracks()
    found = in_parts(model, 3, max_iters=20)
    assert_components_equal(found, model.solve(solver="sparse", max_iters=20))
    assert {"converged", "max_iterations"} <= set(found.result.components.status.tolist())


def test_components_in_parts_by_a_column() -> None:
    # Sessions divide loops, and have poses of several.
    model = fleet()
    found = in_parts(model, None, "session")
    assert found.split.parts == 10 and found.split.between > 0
    assert_components_equal(found, model.solve(solver="sparse"))


def test_bounds_of_components_hold() -> None:
    model = fleet()
    for k in range(0, 80, 3):
        model.poses[k].t.high = [float(model.poses[k].t.value[0]) + 0.01, None]
    found = in_parts(model, 3)
    assert_components_equal(found, model.solve(solver="sparse"))


def test_many_small_components_are_in_one_part_each() -> None:
    model = fleet((4,) * 12)
    found = in_parts(model, 3)
    assert found.split.parts == 3 and found.split.between == 0
    assert_components_equal(found, model.solve(solver="sparse"))


def test_custom_damping_solves_all_components_as_one() -> None:
    def driver(record: Any) -> float:
        return float(record["damping"]) * (0.3 if record["accepted"] else 10)

    model = fleet()
    found = in_parts(model, 3, damping=driver)
    alone = model.solve(solver="sparse", damping=driver)
    assert found.result.components is None is alone.components
    assert_equal(found, alone)


SHARED = """
struct Level { param x: real; at: real
    constraint near { exp(0.3 * x * root.scale) - at } }
root Levels { param scale: real = 1; levels: list of Level; prior scale ~ normal(1, 0.1) }
"""


def test_what_a_frozen_parameter_no_longer_joins_are_components() -> None:
    model: Any = arael.loads(SHARED, interpret=True)()
    model.levels.extend(x=[0.0, 1, -3, 5, 2], at=[1.0, 4, 2, 1.5, 7])
    found = in_parts(model, 2, freeze="scale")
    other = with_arrays(model, arrays_of(model))
    alone = other.solve(solver="sparse", freeze="scale")
    assert len(alone.components) == 5
    assert_components_equal(found, alone)
    assert in_parts(model, 2).result.components is None


@pytest.mark.parametrize("small", [0, 10**9])
def test_marginals_of_each_component(small: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(team, "_SMALL", small)
    model = fleet()
    found = in_parts(model, 3)
    rows = np.array([[0, 2, 7], [1, 50, 70]]).ravel()
    covariance = found.covariance()
    model.solve(solver="sparse")
    alone = model.covariance()
    for row in (*rows.tolist(), int(found.team.scalars[0]) // 3):
        np.testing.assert_allclose(
            covariance.marginal("poses", row), alone.marginal(("poses", row)), rtol=1e-6, atol=1e-15
        )


def test_components_that_have_ended_stay_in_the_vectors_of_the_caller(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # On one machine the system is restricted to those that are left: here with every end.
    monkeypatch.setattr(narrowing, "CONSTANT", 0)
    monkeypatch.setattr(narrowing, "MULTIPLE", 0)
    model = fleet()
    found = in_parts(model, 3)
    assert_components_equal(found, model.solve(solver="sparse"))


class Counting(InProcess):
    """Counts the requests of each part."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: dict[str, Counter[int]] = {}

    def ask(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        counter = self.asked.setdefault(function.__name__, Counter())
        counter.update(call.part for call in calls)
        return super().ask(function, calls)


def test_parts_whose_components_have_ended_are_asked_no_more() -> None:
    model = fleet((30, 30), unused=False)
    prepared = prepare(model._compiled, arrays_of(model), 2, None)
    assert prepared.split.between == 0
    executor = Counting()
    iterations = run(prepared, executor).result.components.iterations
    assert len(set(iterations.tolist())) == 2
    for name in ("costs", "linearise", "sweep", "substitute"):
        counts = sorted(executor.asked[name].values())
        assert counts[0] <= min(iterations) + 2, name
        assert counts[1] >= max(iterations), name


class ForgetfulOnce(InProcess):
    """After some requests, parts are kept by no process any more."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self._left = after

    def start(self, function: Callable[..., Any], *args: Any) -> Any:
        self._left -= 1
        if self._left == 0:
            requests._PARTS.clear()
            requests._SYSTEMS.clear()
        return super().start(function, *args)


@pytest.mark.parametrize("small", [0, 10**9])
def test_a_worker_lost_at_any_request_changes_no_bit(
    small: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(team, "_SMALL", small)
    model = fleet((20, 9, 3))
    arrays = arrays_of(model)

    def solved(executor: InProcess) -> Any:
        return run(prepare(model._compiled, arrays, 2, None), executor).result

    counting = Counting()
    expected = solved(counting)
    total = sum(sum(one.values()) for one in counting.asked.values())
    for after in range(1, total, 5):
        found = solved(ForgetfulOnce(after))
        np.testing.assert_array_equal(found.x, expected.x)
        assert found.components.iterations.tolist() == expected.components.iterations.tolist()


def test_a_solve_goes_on_when_some_components_have_ended(tmp_path: Path) -> None:
    file = tmp_path / "state.npz"
    model = fleet()
    arrays = arrays_of(model)
    alone = model.solve(solver="sparse")
    ends = np.sort(alone.components.iterations)
    seen = []

    def observe(record: Any) -> bool:
        seen.append(record)
        return len(seen) < (ends[1] + ends[2]) // 2  # the second has ended, the last has not

    broken = solve(
        with_arrays(model, arrays), partition=2, workers=0, checkpoint=file, observer=observe
    )
    assert sorted(broken.result.components.status) == [
        "converged",
        "converged",
        "observer_terminated",
    ]
    found = solve(with_arrays(model, arrays), partition=3, workers=0, checkpoint=file, resume=True)
    assert found.result.status == "converged"
    assert found.result.start_cost == pytest.approx(seen[-1]["trial_cost"], rel=1e-12)
    np.testing.assert_allclose(
        found.result.components.end_cost, alone.components.end_cost, rtol=1e-9
    )


def together(*graphs: Graph) -> Graph:
    """Several graphs that have nothing to do with each other, as one."""
    firsts = np.cumsum([0, *(one.size for one in graphs)])
    entries = np.cumsum([0, *(len(one.neighbours) for one in graphs)])
    starts = [one.start[:-1] + n for one, n in zip(graphs, entries[:-1], strict=True)]
    return Graph(
        np.concatenate([*starts, entries[-1:]]),
        np.concatenate([one.neighbours + n for one, n in zip(graphs, firsts[:-1], strict=True)]),
        np.concatenate([one.weights for one in graphs]),
        np.concatenate([one.sizes for one in graphs]),
        (),
    )


def test_only_components_larger_than_a_share_are_split() -> None:
    parts = by_separators(together(path(90), path(30), path(20), path(10)), 3)
    assert len(np.unique(parts[90:120])) == len(np.unique(parts[120:140])) == 1
    assert len(np.unique(parts[140:])) == 1
    assert 1 <= (parts == BOUNDARY).sum() <= 4
    loads = np.bincount(parts[parts >= 0])
    assert len(loads) == 3 and loads.max() < 1.3 * 150 / 3


def test_components_of_a_share_or_less_need_no_boundary() -> None:
    parts = by_separators(together(*[path(10)] * 7, *[path(3)] * 30), 4)
    assert (parts >= 0).all()
    loads = np.bincount(parts)
    assert len(loads) == 4 and loads.max() < 1.3 * 160 / 4
    # Small ones of a part follow each other.
    small = parts[70:]
    assert (np.diff(small) != 0).sum() <= 3
