"""`Model.update`: with tolerance 0 a Gauss-Newton step of the whole problem, after any edits.

The oracle is the dense normal equations of an independent copy of the model.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael import solving
from arael.online.result import UpdateResult
from arael.runtime.failures import SolveError
from tests.test_session_edits import EDITS, Edited, net

__all__ = ["net"]  # a fixture


def gauss_newton(model: Any, freeze: tuple[str, ...] = ()) -> tuple[Any, np.ndarray]:
    """A copy of a model after one step of the whole problem, and J'J before it."""
    copy = model.copy()
    problem = solving.problem_of(copy, solving.frozen_by(solving.layout_of(copy), (), freeze))
    hessian, step = problem.hessian(), np.zeros(problem.size)
    step[problem.free] = -np.linalg.solve(hessian, problem.gradient())
    problem.evaluation.moved_by(step)
    problem.write_back()
    return copy, hessian / 2


def product(model: Any) -> np.ndarray:
    """R'R of the factor of an online solve, over the free scalars in order of the system."""
    tracker = model.session.online
    tree = tracker.engine.tree
    columns: dict[tuple[int, int], int] = {}
    for e, entity in enumerate(tracker.layout.entities):
        for row, variable in enumerate(tracker.variables[e]):
            for k in range(entity.tangent):
                if not tracker.held[e][row, k]:
                    columns[int(variable), k] = len(columns)
    widths = {
        int(v): entity.tangent
        for e, entity in enumerate(tracker.layout.entities)
        for v in tracker.variables[e]
    }
    n = len(columns)
    factor = np.zeros((n + 1, n))
    for variables, eliminated, triangle, panel in tree.fronts_as_arrays():
        places = [columns.get((v, k), -1) for v in variables for k in range(widths[v])]
        own = sum(widths[v] for v in variables[:eliminated])
        stacked = np.vstack((triangle, panel[:-1]))
        for j in range(own):
            if places[j] >= 0:
                for i, to in enumerate(places):
                    if to >= 0:
                        factor[to, places[j]] = stacked[i, j]
    found: np.ndarray = factor[:n] @ factor[:n].T
    return found


def assert_a_step(edited: Edited, what: str) -> None:
    """An update with tolerance 0 is a step of the whole problem; so is its factor."""
    expected, normal = gauss_newton(edited.model, edited.freeze)
    result = edited.model.update(tolerance=0, freeze=edited.freeze)
    if result.full:  # the step raised the cost
        assert expected.cost() > edited.model.cost(), what
        return
    for name in ("pos", "scale"):
        np.testing.assert_allclose(
            getattr(edited.model.points, name).value,
            getattr(expected.points, name).value,
            rtol=1e-7,
            atol=1e-9,
            err_msg=what,
        )
    np.testing.assert_allclose(product(edited.model), normal, rtol=1e-7, atol=1e-9, err_msg=what)
    assert result.cost == pytest.approx(edited.model.cost(), rel=1e-9, abs=1e-12), what


@pytest.mark.parametrize("seed", range(10))
def test_any_edits(net: type, seed: int) -> None:
    """Rows, refs, values, data, guards, flags and residuals, in random order."""
    edited = Edited(net, 12, seed)
    edited.model.update()
    done: list[str] = []
    for _ in range(25):
        for _ in range(edited.rng.integers(1, 4)):
            done.append(str(edited.rng.choice(list(EDITS))))
            EDITS[done[-1]](edited)
        assert_a_step(edited, f"seed {seed}: {done}")


def test_a_window_whose_first_row_is_fixed(net: type) -> None:
    """Flags are the same at every step, but those of other rows."""
    edited = Edited(net, 8, 3)
    for _ in range(6):
        edited.points[0].pos.fixed = edited.points[0].scale.fixed = True
        assert_a_step(edited, "window")
        assert len(product(edited.model)) == 21
        gone = edited.points.pop(0)
        for link in [link for link in edited.links if gone in link[1:]]:
            edited.model.links.remove(link[0])
            edited.links.remove(link)
        edited.model.points.remove(gone)
        edited.append_point()


def robot(name: str, seed: int, poses: int, back: int | None = None) -> tuple[Any, Any]:
    """A model and a generator that appends a pose with its edges, from random walks with loops.

    Loops go at most `back` poses back.
    """
    rng = np.random.default_rng(seed)
    model = arael.load(name)()
    flat = name == "pose_graph_2d"
    truth: list[np.ndarray] = []
    refs: list[Any] = []

    def place() -> np.ndarray:
        return rng.normal(size=2 if flat else 3) * 3

    def steps() -> Any:
        for k in range(poses):
            truth.append(place() if k == 0 else truth[-1] + rng.normal(size=len(truth[0])))
            at = truth[-1] + 0.05 * rng.normal(size=len(truth[-1]))
            turn = {"th": 0.02 * rng.normal()} if flat else {"q": [1, *0.01 * rng.normal(size=3)]}
            if not flat:
                turn["q"] /= np.linalg.norm(turn["q"])
            pose = model.poses.append(t=at, **turn)
            refs.append(pose)
            if k == 0:
                model.anchors.append(pose=pose, t=at, **turn)
            near = (
                {k - 1} | {int(j) for j in rng.integers(max(0, k - (back or k)), k, 2)}
                if k
                else set()
            )
            for j in sorted(near):
                d = truth[k] - truth[j] + 0.02 * rng.normal(size=len(truth[k]))
                same = {"th": 0.0} if flat else {"q": [1, 0, 0, 0]}
                u = np.diag(rng.uniform(5, 20, 3 if flat else 6))
                model.edges.append(a=refs[j], b=pose, t=d, u=u, **same)
            for _ in range(rng.integers(0, 3)):
                sight(k)
            yield k

    def sight(k: int) -> None:
        count = len(model.landmarks)
        if count == 0 or rng.random() < 0.3:
            mark = model.landmarks.append(t=truth[k] + rng.normal(size=len(truth[k])))
        else:
            mark = model.landmarks[int(rng.integers(count))]
        d = mark.t.value - truth[k]
        u = np.eye(len(d)) * 10
        model.observations.append(a=refs[k], b=mark, t=d, u=u)

    return model, steps()


@pytest.mark.parametrize("name", ["pose_graph_2d", "pose_graph_3d"])
def test_graphs_with_loops_and_landmarks(name: str) -> None:
    """Poses one at a time: every step is that of the batch method."""
    model, steps = robot(name, 5, 40)
    turn = "th" if name == "pose_graph_2d" else "q"
    for k in steps:
        expected, normal = gauss_newton(model)
        result = model.update(tolerance=0)
        if result.full:
            assert expected.cost() > result.cost, k
            continue
        for path, name in (("poses", "t"), ("poses", turn), ("landmarks", "t")):
            found, wanted = getattr(model[path], name), getattr(expected[path], name)
            np.testing.assert_allclose(found.value, wanted.value, atol=1e-8)
        np.testing.assert_allclose(product(model), normal, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("name", ["pose_graph_2d", "pose_graph_3d"])
def test_stays_near_the_optimum(name: str) -> None:
    """With the default tolerance costs are those of a solve, and only what changed is taken up."""
    model, steps = robot(name, 3, 80)
    counts = []
    for _ in steps:
        counts.append(model.update())
        if len(counts) % 20 == 0:
            best = model.copy().solve(rel_precision=1e-12, abs_precision=0.0).end_cost
            assert model.cost() == pytest.approx(best, rel=1e-6)
    for _ in range(3):
        model.update()
    assert not any(one.full for one in counts)
    assert model.update().refactored == 0  # nothing is new
    assert model.update().moved == 0


def test_marginal_is_that_of_the_covariance() -> None:
    model, steps = robot("pose_graph_2d", 1, 30)
    for _ in steps:
        model.update()
    for _ in range(8):
        model.update(tolerance=0)
    for row in (model.poses[29], model.poses[0], model.poses[11], model.landmarks[0]):
        expected = model.covariance().marginal(row)
        np.testing.assert_allclose(model.marginal(row), expected, rtol=1e-6, atol=1e-9)


def test_marginal_without_an_update_is_that_of_the_covariance() -> None:
    model, steps = robot("pose_graph_2d", 1, 8)
    list(steps)
    model.solve()
    expected = model.covariance().marginal(model.poses[3])
    np.testing.assert_allclose(model.marginal(model.poses[3]), expected, rtol=1e-9)


def test_marginal_after_a_row_was_appended_knows_it() -> None:
    """The factor is of before: the covariance of all is asked."""
    model, steps = robot("pose_graph_2d", 2, 8)
    for k in steps:
        if k < 7:
            model.update()
    expected = model.covariance().marginal(model.poses[7])
    np.testing.assert_allclose(model.marginal(model.poses[7]), expected, rtol=1e-9)


def test_what_is_not_determined_keeps_its_value(net: type) -> None:
    """A landmark that is seen in one direction only: where iSAM2 throws."""
    model, steps = robot("pose_graph_2d", 4, 6)
    list(steps)
    lost = model.landmarks.append(t=[3.0, 4.0])
    result = model.update()
    assert result.undetermined == 2
    np.testing.assert_array_equal(lost.t.value, [3.0, 4.0])
    model.bearings.append(a=model.poses[0], b=lost, th=0.9, isigma=10.0)
    assert model.update().undetermined == 1
    for _ in range(5):
        model.update()
    copy = model.copy()
    assert model.cost() == pytest.approx(copy.solve().end_cost, rel=1e-4)


def test_what_is_not_taken_in_is_solved_in_full(net: type) -> None:
    edited = Edited(net, 6, 1)
    model = edited.model
    model.points.scale.low = 0.1
    result = model.update()
    assert result.full and result.reason == "parameters have bounds"
    copy = model.copy()
    assert result.cost == pytest.approx(copy.solve().end_cost, rel=1e-6)
    model.points[0].pos.value += 1
    assert model.update().cost == pytest.approx(result.cost, rel=1e-6)


def test_errors_are_those_of_a_solve(net: type) -> None:
    edited = Edited(net, 6, 1)
    edited.model.update()
    edited.model.points.goal[2] = [np.inf, 0.0]
    with pytest.raises(SolveError) as update:
        edited.model.update()
    with pytest.raises(SolveError) as solve:
        edited.model.solve()
    assert update.value.diagnostics[0].code == solve.value.diagnostics[0].code
    edited.points[2].goal = [2.0, 0.0]
    assert_a_step(edited, "after an error")


def test_an_interrupted_update_is_taken_up(net: type, monkeypatch: pytest.MonkeyPatch) -> None:
    from arael.online import tracker

    class Interrupted(tracker.Linearisations):
        when = 1

        def step(self, *args: Any) -> int:
            Interrupted.when -= 1
            if Interrupted.when == 0:
                super().step(*args)
                raise KeyboardInterrupt
            return int(super().step(*args))

    monkeypatch.setattr(tracker, "Linearisations", Interrupted)
    edited = Edited(net, 8, 2)
    for when in (1, 2, 1):
        Interrupted.when = when
        edited.append_point()
        before = edited.state()
        try:
            edited.model.update()
        except KeyboardInterrupt:
            for one, other in zip(edited.state(), before, strict=True):
                np.testing.assert_array_equal(one, other)
        Interrupted.when = 0
        assert_a_step(edited, "after an interruption")


def test_a_time_limit_leaves_the_rest_to_the_next() -> None:
    model, steps = robot("pose_graph_2d", 7, 60)
    for _ in steps:
        assert model.update(max_seconds=1e-9).steps <= 1
    for _ in range(8):
        result = model.update(max_seconds=1e-9)
    assert result.deferred == 0
    copy = model.copy()
    assert model.cost() == pytest.approx(copy.solve(rel_precision=1e-12).end_cost, rel=1e-4)


@pytest.mark.parametrize(
    "given", [{"tolerance": -1}, {"tolerance": "much"}, {"max_seconds": 0}, {"freeze": "nowhere"}]
)
def test_arguments_are_checked(net: type, given: dict[str, Any]) -> None:
    with pytest.raises(arael.AraelError):
        Edited(net, 4, 1).model.update(**given)


def test_the_result_is_readable(net: type) -> None:
    result = Edited(net, 4, 1).model.update()
    assert isinstance(result, UpdateResult)
    assert "4 rows moved" in str(result)
    assert set(result.moved_rows) == {"points"}
