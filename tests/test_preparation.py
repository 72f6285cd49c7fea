"""Preparation ahead of a solve: what it leaves to the solve, and that it changes no result."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.session import Counts

MODEL = """
struct Pose {
    param t: vec2
    param heading: angle
    goal: vec2
    sigma: real = 1
    seen: bool = true
    constraint near when seen { (t - goal) / sigma }
    constraint level { (heading - t.x * root.tilt) / sigma }
}
struct Step {
    start: ref Pose in root.poses
    to: ref Pose in root.poses
    move: vec2
    constraint step { (to.t - start.t - start.heading.rotation_matrix() * move) / 0.1 }
}
root Window {
    tilt: real = 0.05
    poses: deque of Pose
    steps: deque of Step
    solve {
        pass rough { tilt = 0.04  freeze poses.heading }
        pass fine { tilt = 0.06  free poses.heading }
    }
}
"""


@pytest.fixture(scope="module")
def window() -> Any:
    return arael.loads(MODEL, interpret=True)


def chain(window: Any, count: int = 30) -> Any:
    """A chain of poses, above the size up to which the dense solver is taken."""
    model = window()
    k = np.arange(count)
    goal = np.column_stack([k + 0.3, np.sin(k)])
    model.poses.extend(t=np.column_stack([k, 0.1 * k]), heading=0.02 * k, goal=goal)
    model.steps.extend(start=k[:-1], to=k[1:], move=[[1, 0.1]] * (count - 1))
    return model


def assert_same(prepared: Any, plain: Any, **settings: Any) -> None:
    """Both models solve in the same steps, bit for bit."""
    one, other = prepared.solve(**settings), plain.solve(**settings)
    assert one.status == other.status and one.plan["solver"] == other.plan["solver"]
    assert np.array_equal(one.x, other.x)
    for name in ("cost", "trial_cost", "predicted", "step_norm"):
        assert np.array_equal(one.history[name], other.history[name], equal_nan=True)
    assert np.array_equal(prepared.poses.t.value, plain.poses.t.value)


def work(model: Any, before: Counts) -> tuple[int, int, int, int]:
    """Counts of solves, problems, analyses and gathered groups since `before`."""
    now = model.session.counts
    return tuple(getattr(now, n) - getattr(before, n) for n in vars(before))  # type: ignore[return-value]


def test_the_solve_after_it_builds_nothing_and_has_the_same_bits(window: Any) -> None:
    prepared, plain = chain(window), chain(window)
    prepared.prepare(passes="fine")
    counts = Counts(**vars(prepared.session.counts))
    assert (counts.solves, counts.problems, counts.analyses) == (0, 1, 1)
    assert_same(prepared, plain, passes="fine")
    assert work(prepared, counts) == (1, 0, 0, 0)


def test_a_schedule_is_prepared_for_its_first_pass(window: Any) -> None:
    prepared, plain = chain(window), chain(window)
    prepared.prepare()
    earlier = prepared.session.earlier
    assert prepared.tilt == 0.05  # the pass sets it, the preparation does not
    assert earlier.structure.frozen >= {"poses.heading"}
    counts = Counts(**vars(prepared.session.counts))
    prepared.solve(passes="rough")
    plain.solve(passes="rough")
    assert work(prepared, counts) == (1, 0, 0, 0)
    assert np.array_equal(prepared.poses.t.value, plain.poses.t.value)
    assert_same(prepared, plain)


def test_the_analysis_can_be_left_to_the_solve(window: Any) -> None:
    prepared, plain = chain(window), chain(window)
    prepared.prepare(passes="fine", analyse=False)
    counts = Counts(**vars(prepared.session.counts))
    assert (counts.problems, counts.analyses) == (1, 0)
    assert prepared.session.earlier.structure.partition == []  # nor the components
    assert_same(prepared, plain, passes="fine")
    assert work(prepared, counts) == (1, 0, 1, 0)


def values(model: Any) -> None:
    model.poses.t.value[3] = [7.0, -2.0]


def data(model: Any) -> None:
    model.poses.goal[3] = [7.0, -2.0]


def root(model: Any) -> None:
    model.tilt = 0.07


def guard(model: Any) -> None:
    model.poses.seen[4] = False


def flag(model: Any) -> None:
    model.poses[5].t.fixed = True


def row(model: Any) -> None:
    pose = model.poses.append(t=[30, 3], heading=0, goal=[30, 0])
    model.steps.append(start=model.poses[29], to=pose, move=[1, 0.1])


def removed(model: Any) -> None:
    model.steps.popleft(1)
    model.poses.popleft(1)


@pytest.mark.parametrize("edit", [values, data, root, guard, row])
@pytest.mark.parametrize("analyse", [True, False])
def test_edits_after_it_are_seen(window: Any, edit: Any, analyse: bool) -> None:
    prepared, plain = chain(window), chain(window)
    prepared.prepare(passes=[], analyse=analyse)
    edit(prepared)
    edit(plain)
    before = chain(window).cost()
    assert plain.cost() != before
    assert_same(prepared, plain, passes=[])


@pytest.mark.parametrize("edit", [flag, removed])
def test_parameters_fixed_and_rows_removed_after_it_are_seen(window: Any, edit: Any) -> None:
    """The pattern of before is kept, so that the sums are those of a fresh model to rounding."""
    prepared, plain = chain(window), chain(window)
    prepared.prepare(passes=[])
    edit(prepared)
    edit(plain)
    start = plain.poses.t.value.copy()
    one, other = prepared.solve(passes=[]), plain.solve(passes=[])
    assert one.status == other.status == "converged"
    assert np.allclose(prepared.poses.t.value, plain.poses.t.value, rtol=0, atol=1e-9)
    if edit is flag:
        assert np.array_equal(prepared.poses.t.value[5], start[5])


def test_it_changes_no_value(window: Any) -> None:
    model = chain(window)
    before, cost = model.serialize(), model.cost()
    model.prepare()
    assert np.array_equal(model.serialize(), before)
    assert model.cost() == cost


def test_start_values_are_chosen_in_the_prepared_problem() -> None:
    graphs = [arael.load("pose_graph_2d")() for _ in range(2)]
    for graph in graphs:
        angle = 2 * np.pi * np.arange(12) / 12
        t = np.column_stack([np.cos(angle), np.sin(angle)])
        graph.poses.extend(t=np.zeros((12, 2)), th=np.zeros(12))
        graph.edges.extend(
            a=np.arange(11), b=np.arange(1, 12), t=np.diff(t, axis=0), th=np.full(11, 0.1),
            u=np.broadcast_to(np.eye(3), (11, 3, 3)),
        )  # fmt: skip
    prepared, plain = graphs
    prepared.prepare(passes="refine", analyse=False)
    problem = prepared.session.earlier
    one, other = arael.initialise(prepared), arael.initialise(plain)
    assert prepared.session.earlier is problem
    assert (one.chosen, one.costs) == (other.chosen, other.costs)
    assert prepared.solve(passes="refine").end_cost == plain.solve(passes="refine").end_cost


@pytest.mark.parametrize(
    ("settings", "code"),
    [
        ({"passes": "coarse"}, "E1011"),
        ({"freeze": "poses.speed"}, "E1012"),
        ({"solver": "fast"}, "E0840"),
        ({"solver_options": {"width": 2}}, "E0842"),
    ],
)
def test_mistakes_are_those_of_a_solve(window: Any, settings: Any, code: str) -> None:
    model = chain(window)
    found = []
    for call in (model.prepare, model.solve):
        with pytest.raises(arael.AraelError) as error:
            call(**settings)
        found.append(error.value.diagnostics[0])
    assert found[0].code == code
    assert (found[0].message, found[0].help) == (found[1].message, found[1].help)


def test_an_error_in_the_data_frees_the_session_and_restores_the_root(window: Any) -> None:
    model = chain(window)
    model.poses.popleft()  # a step refers to it
    with pytest.raises(arael.AraelError) as error:
        model.prepare()
    assert error.value.diagnostics[0].code == "E0709"
    assert model.tilt == 0.05
    model.steps.popleft()
    model.prepare()
    assert model.session.counts.problems == 1
