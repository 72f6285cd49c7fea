"""What a result reports about components: limits, records, statuses, the table."""

from __future__ import annotations

import json
import signal
from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.assembly.components import partition_of
from arael.runtime.levenberg.compiled import Minimiser
from arael.solving import problem_of
from tests.components.problems import (
    Load,
    Problem,
    compare,
    of,
    problems,
)


def test_limits_are_those_of_each_component(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] != "edges"]
    kind = load("f64", True)
    free = of(kind, chosen).solve(solver="sparse").components
    result = compare(kind, chosen, solver="sparse", max_iters=12)
    found = result.components
    slow = free.iterations > 12
    assert slow.any() and not slow.all()
    assert (found.status == np.where(slow, "max_iterations", "converged")).all()
    assert found.iterations.max() == 12 == result.iterations
    assert result.status == "max_iterations" and not result.converged
    first = np.flatnonzero(slow)[0]
    expected = f"{(~slow).sum()} of {len(slow)} components converged; {found.name(int(first))}: max"
    assert found.summary().startswith(expected)
    assert found.summary() in str(result)


def test_records_are_of_all_components(load: Load) -> None:
    result = of(load("f64", True), problems(2)).solve(solver="sparse")
    history, found = result.history, result.components
    assert history["cost"][0] == result.start_cost == pytest.approx(found.start_cost.sum())
    taken = history[history["accepted"] == 1]
    np.testing.assert_array_equal(taken["cost"][1:], taken["trial_cost"][:-1])
    assert taken["trial_cost"][-1] == pytest.approx(result.end_cost, rel=1e-12)
    assert (np.diff(taken["cost"]) <= 0).all()
    rejected = history[history["accepted"] == 0]
    assert not (rejected["trial_cost"] < rejected["cost"]).any()
    assert (history["retry"][1:] == np.where(
        history["accepted"][:-1] == 1, 0, history["retry"][:-1] + 1
    )).all()  # fmt: skip
    assert len(history) == result.iterations >= found.iterations.max()
    assert result.predicted_decrease == pytest.approx(np.nansum(found.predicted_decrease))


def test_what_ends_all_leaves_those_that_had_converged(load: Load) -> None:
    seen = []

    def observer(record: Any) -> bool:
        seen.append(int(record["iteration"]))
        return len(seen) < 8

    chosen = [one for one in problems(1) if one[0] != "edges"]
    result = of(load("f64", True), chosen).solve(solver="sparse", observer=observer)
    assert result.status == "observer_terminated" and len(seen) == 8
    assert result.components.counts().keys() == {"converged", "observer_terminated"}
    late = of(load("f64", True), chosen).solve(solver="sparse", time_limit=0.0)
    assert late.components.counts() == {"time_limit": len(chosen)}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a timer's signal")
def test_ctrl_c_keeps_what_components_have_reached(load: Load, narrowed: list[int]) -> None:
    """Sent while only the hard ones are left, without an observer: the loop looks for signals."""

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    model = load("f64", False)()
    # Boxes at their solution end at once; valleys would go on for minutes with steps this short.
    for _ in range(20):
        model.boxes.append(x=1.0, y=1.0, k=1.0)
        model.valleys.append(x=-1.2, y=1.0, s=1.0)
    start = model.valleys.x.value.copy()
    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.2, 1.0)  # again, should one come before the loop
    try:
        result = model.solve(
            solver="sparse", strategy="damped", lambda_floor=1e7, initial_lambda=1e7,
            max_iters=10**7, rel_precision=1e-6, time_limit=60.0,
        )  # fmt: skip
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    components = result.components
    assert narrowed == [40] and result.status == "aborted"
    assert components.status.tolist() == 20 * ["aborted"] + 20 * ["converged"]
    assert (components.end_cost <= components.start_cost).all()
    assert result.end_cost == pytest.approx(problem_of(model).cost(), rel=1e-9)
    assert (model.valleys.x.value != start).all()
    # The session is whole.
    assert model.solve(solver="sparse").converged


def test_a_threshold_is_one_of_the_whole_cost(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] == "valleys"]
    result = of(load("f64", True), chosen).solve(cost_threshold=1e-3)
    assert result.end_cost <= 1e-3 and result.converged
    assert "cost_threshold" in result.components.status


@pytest.mark.parametrize(
    "settings",
    [{"damping": lambda record: record["damping"]}, {"ending": "small_steps"}],
    ids=["driver", "small_steps"],
)
def test_what_needs_one_lambda_solves_as_one(load: Load, settings: Any) -> None:
    chosen = [one for one in problems(1, 1) if one[0] == "boxes"] * 2
    assert of(load("f64", True), chosen).solve(max_iters=5, **settings).components is None
    config = arael.LmConfig.reference(max_iters=5)
    assert of(load("f64", True), chosen).solve(config).components is None


def test_a_constant_cost_belongs_to_no_component(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] in ("valleys", "gates")]
    model = of(load("f64", False), chosen)
    # Held: what its constraints come to stays.
    model.boxes.append(x=1.0, y=0.0, k=9.0)
    result = model.solve(freeze="boxes")
    assert len(result.components) == len(chosen)
    assert result.end_cost == pytest.approx(64.0 + 81.0 + result.components.end_cost.sum())


def test_the_table_is_data_of_json(load: Load) -> None:
    result = of(load("f64", True), problems(2, 1)).solve()
    found = json.loads(json.dumps(result.to_dict()))["passes"][0]["components"]
    assert found["count"] == 8 == len(found["name"]) == len(found["status"])
    assert found["name"][0] == "decays[0]" and sum(found["statuses"].values()) == 8
    assert found["iterations"] == result.components.iterations.tolist()
    assert found["name"] == [one.name for one in result.components]


def test_what_has_ended_is_not_evaluated(load: Load) -> None:
    """Of 400 linear problems and a hard one, the hard one alone in the end."""
    model = load("f64", False)()
    for k in range(400):
        model.boxes.append(x=1.0, y=0.0, k=1.0 + k * 1e-4)
    model.boxes.append(x=1.9, y=0.0, k=1e-9)
    problem = problem_of(model)
    partition = partition_of(problem.structure, problem.layout.groups)
    seen = []

    class Watcher:
        def started(self, minimiser: Any) -> None: ...

        def stepped(self, minimiser: Any, record: Any) -> bool:
            seen.append(sum(minimiser.lanes.evaluated()))
            return True

    minimiser = Minimiser(
        problem.evaluation,
        problem.make_solver("sparse"),
        problem.box,
        arael.LmConfig(),
        Watcher(),
        True,
        partition,
    )
    assert minimiser.run() == "converged"
    assert seen[0] == 401 and 1 <= seen[-1] <= 32
    # What is not evaluated keeps its cost.
    assert minimiser.current_cost == pytest.approx(problem.cost(), rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("solver", ["dense", "sparse", "schur"])
def test_derivatives_that_are_not_finite_end_their_component_alone(load: Load, solver: str) -> None:
    chosen: list[tuple[str, Problem]] = [one for one in problems(1, 1) if one[0] == "valleys"]
    chosen += [("roots", lambda model: model.roots.append(x=4.0)), *chosen]
    result = of(load("f64", True), chosen).solve(solver=solver)
    assert result.components.status.tolist() == ["converged", "converged", "stalled"]
    assert result.components[2].end_cost == 9.0 and result.components[2].iterations < 20
    assert of(load("f64", True), chosen[1:2]).solve(solver=solver).status == "stalled"
