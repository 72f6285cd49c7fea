"""What is kept from one solve to the next, and that it changes nothing but the time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import arael
from arael.config import LmConfig
from arael.scenes import benchmark_config, columns, fill, make_scene
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
    from: ref Pose in root.poses
    to: ref Pose in root.poses
    move: vec2
    constraint step { (to.t - from.t - from.heading.rotation_matrix() * move) / 0.1 }
}
root Window {
    tilt: real = 0.1
    poses: deque of Pose
    steps: deque of Step
    solve {
        pass rough { tilt = 0.2 }
        pass fine { tilt = 0.1  rel_precision = 1e-9 }
    }
}
"""


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> type:
    path = tmp_path_factory.mktemp("models") / "window.arael"
    path.write_text(MODEL.replace("from:", "start:").replace("from.", "start."), encoding="utf-8")
    return arael.load(path)


def grow(model: Any, count: int = 1) -> None:
    """Append poses, each tied to the one before."""
    for _ in range(count):
        k = len(model.poses)
        pose = model.poses.append(t=[k, 0.1 * k], heading=0.02 * k, goal=[k + 0.3, np.sin(k)])
        if k:
            model.steps.append(start=model.poses[k - 1], to=pose, move=[1, 0.1])


def chain(window: type, count: int = 8) -> Any:
    model = window()
    grow(model, count)
    return model


def values(model: Any) -> np.ndarray:
    return np.column_stack([model.poses.t.value, model.poses.heading.value])


def since(model: Any, before: Counts) -> tuple[int, int, int, int]:
    """Counts of solves, problems, analyses and gathered groups since `before`."""
    now = model.session.counts
    return tuple(
        getattr(now, name) - getattr(before, name)
        for name in ("solves", "problems", "analyses", "gathered")
    )


def counts(model: Any) -> Counts:
    return Counts(**vars(model.session.counts))


def test_a_converged_scene_solves_again_without_preparation() -> None:
    slam = arael.load("slam")
    path = slam(gamma=arael_gamma())
    fill(path, slam.layout, columns(make_scene(benchmark_config(60))))
    path.solve()
    path.solve(passes="fine")
    before, problem = counts(path), path.session.earlier
    instances = problem.instances[-1]
    result = path.solve(passes="fine")
    assert path.session.earlier is problem
    assert problem.instances[-1] is instances
    # What reads stored values of parameters is gathered where they have moved.
    solves, problems, analyses, gathered = since(path, before)
    assert (solves, problems, analyses) == (1, 0, 0)
    assert gathered <= sum(g.constraint == "drift" for g in slam.layout.groups)
    assert result.timing["analyse"] == 0
    bearing = [g.label for g in slam.layout.groups].index("PointFrine.bearing")
    data = problem.instances[bearing]
    path.solve(passes="fine")
    assert problem.instances[bearing] is data


def arael_gamma() -> float:
    return float(2 * np.sqrt(25) / np.pi)


def test_passes_of_one_solve_share_structure_and_analysis(window: type) -> None:
    model = chain(window)
    model.solve()
    # Of the second pass only what reads `tilt` is gathered: one of three constraints.
    assert model.session.counts == Counts(solves=2, problems=1, analyses=1, gathered=4)
    model.solve()
    assert model.session.counts == Counts(solves=4, problems=1, analyses=1, gathered=6)


@pytest.mark.parametrize(
    ("change", "problems", "analyses", "gathered"),
    [
        (lambda m: None, 0, 0, 0),
        (lambda m: m.poses.t.value.__setitem__((2, 0), 7.0), 0, 0, 0),
        (lambda m: m.poses.goal.__setitem__((2, 0), 7.0), 0, 0, 1),
        (lambda m: m.poses.sigma.__setitem__(slice(None), 0.5), 0, 0, 2),
        (lambda m: m.poses[3].t.__setattr__("fixed", True), 0, 0, 0),
        (lambda m: m.poses[3].__setattr__("seen", False), 1, 0, 1),
        (lambda m: m.steps[3].__setattr__("start", m.poses[1]), 1, 1, 1),
        (lambda m: grow(m), 1, 1, 3),
    ],
    ids=["nothing", "value", "goal", "sigma", "fixed", "guard", "ref", "more"],
)
def test_only_what_changed_is_done_again(
    window: type, change: Any, problems: int, analyses: int, gathered: int
) -> None:
    model, cold = chain(window), chain(window)
    for one in (model, cold):
        one.solve(passes="fine")
        one.solve(passes="fine")
    before = counts(model)
    change(model)
    change(cold)
    cold.session.release()
    warm_result = model.solve(passes="fine")
    cold_result = cold.solve(passes="fine")
    assert since(model, before) == (1, problems, analyses, gathered)
    assert warm_result.start_cost == cold_result.start_cost
    np.testing.assert_array_equal(values(model), values(cold))


def test_a_sliding_window_is_analysed_once(window: type) -> None:
    """Retire one, add one: the blocks are coupled as before, only other rows stand behind them."""
    model, cold = chain(window), chain(window)
    for one in (model, cold):
        one.solve(passes="fine")
    before = counts(model)
    for _ in range(5):
        for one in (model, cold):
            one.steps.popleft()
            one.poses.popleft()
            grow(one)
        cold.session.release()
        model.solve(passes="fine")
        cold.solve(passes="fine")
        np.testing.assert_array_equal(values(model), values(cold))
    # Goals and the rows with steps are others; angles and moves are as they were.
    assert since(model, before) == (5, 5, 0, 5)
    # A step across the window couples what was not coupled: another pattern.
    model.steps.append(start=model.poses[0], to=model.poses[7], move=[7, 0])
    model.solve(passes="fine")
    assert since(model, before)[2] == 1


def test_another_solver_is_another_analysis_of_the_same_problem(window: type) -> None:
    model = chain(window)
    model.solve(passes="fine")
    before = counts(model)
    for solver in ("dense", "band", "band", "sparse"):
        assert model.solve(passes="fine", solver=solver).plan["solver"] == solver
    assert since(model, before) == (4, 0, 3, 0)
    model.solve(passes="fine", solver="band", solver_options={"half_bandwidth": 8})
    assert since(model, before)[2] == 4


def test_an_iterative_solver_starts_its_forcing_anew(window: type) -> None:
    model, cold = chain(window, 30), chain(window, 30)
    for _ in range(3):
        for one in (model, cold):
            one.poses.goal[5] += 1
        cold.session.release()
        results = [m.solve(passes="fine", solver="schur_pcg") for m in (model, cold)]
        plans = [dict(result.plan) for result in results]
        for plan in plans:
            assert plan.pop("measured_ms") > 0
        assert plans[0] == {**plans[1], "orderings": plans[0]["orderings"]}
        np.testing.assert_array_equal(values(model), values(cold))
    assert model.session.counts.analyses == 1


def test_an_observer_may_solve_and_look(window: type) -> None:
    model, other = chain(window), chain(window)
    seen = []

    def observer(record: Any) -> bool:
        seen.append((model.cost(), model.gradient().shape))
        if len(seen) == 1:
            other.solve(passes="fine")
        return True

    model.solve(passes="fine", observer=observer)
    np.testing.assert_array_equal(values(model), values(other))
    assert len({cost for cost, _ in seen}) == 1  # the model changes when the solve is over

    def nested(record: Any) -> bool:
        model.solve(passes="fine", max_iters=1)
        return False

    # From its solution the default would have converged with the first step.
    again = LmConfig.reference()
    assert model.solve(again, passes="fine", observer=nested).status == "observer_terminated"
    assert model.solve(passes="fine").converged


def test_a_failed_solve_leaves_nothing_behind(window: type) -> None:
    model, cold = chain(window), chain(window)
    model.solve()
    cold.solve()
    model.poses.goal[2] = np.nan
    with pytest.raises(arael.AraelError, match="E1001"):
        model.solve()
    assert model.session.earlier is None
    for one in (model, cold):
        one.poses.goal[2] = [2, 2]
    model.solve()
    cold.solve()
    np.testing.assert_array_equal(values(model), values(cold))


def test_what_is_stopped_early_starts_again_from_the_model(window: type) -> None:
    model, cold = chain(window), chain(window)
    for one in (model, cold):
        one.solve(passes="fine", max_iters=1)
        one.poses.t.value[:] = 0
    cold.session.release()
    for one in (model, cold):
        one.solve(passes="fine")
    np.testing.assert_array_equal(values(model), values(cold))


def test_looking_takes_over_from_the_last_solve(window: type) -> None:
    model = chain(window)
    model.solve()
    problem = model._problem()
    assert problem.structure is model.session.earlier.structure
    assert problem.gathered == 0
    model.poses.goal[0] += 1
    problem = model._problem()
    assert problem.gathered == 1
    fresh = chain(window)
    fresh.poses.t.value[:] = model.poses.t.value
    fresh.poses.heading.value[:] = model.poses.heading.value
    fresh.poses.goal[:] = model.poses.goal
    assert model.cost() == fresh.cost()
    np.testing.assert_array_equal(model.hessian(), fresh.hessian())


CHANGES = {
    "value": lambda m, k, x: m.poses.t.value.__setitem__((k, 0), x),
    "goal": lambda m, k, x: m.poses.goal.__setitem__((k, 1), x),
    "tilt": lambda m, k, x: setattr(m, "tilt", 0.1 * x),
    "seen": lambda m, k, x: setattr(m.poses[k], "seen", x > 0),
    "fixed": lambda m, k, x: setattr(m.poses[k].t, "fixed", x > 0),
    "move": lambda m, k, x: m.steps.move.__setitem__((k - 1 if k else 0, 0), x),
    "ref": lambda m, k, x: setattr(m.steps[k - 1 if k else 0], "start", m.poses[0]),
    "grow": lambda m, k, x: grow(m),
    "retire": lambda m, k, x: (m.steps.popleft(), m.poses.popleft()),
    "clear": lambda m, k, x: (m.steps.clear(), m.poses.clear(), grow(m, 4)),
}


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(CHANGES)), st.integers(0, 3), st.floats(-2, 2)),
        min_size=1,
        max_size=8,
    )
)
def test_warm_and_cold_solves_agree_to_the_bit(
    window: type, changes: list[tuple[str, int, float]]
) -> None:
    warm, cold = chain(window, 5), chain(window, 5)
    for name, row, x in changes:
        for model in (warm, cold):
            if name == "retire" and len(model.poses) < 5:
                continue
            CHANGES[name](model, row, x)
        cold.session.release()
        results = [model.solve(passes="fine", max_iters=6) for model in (warm, cold)]
        assert results[0].start_cost == results[1].start_cost
        np.testing.assert_array_equal(values(warm), values(cold))


def test_vectors_put_into_a_model_of_formulas_are_where_the_next_solve_starts() -> None:
    model = arael.runtime_model(
        arael.runtime_residual(
            "a * x + b - x^2", parameters={"a": 0, "b": 0}, data={"x": [0, 1, 2, 3]}
        )
    )
    first = model.solve()
    model.deserialize(model.serialize() + 1)
    # The optimum is (3, -1) with residuals (-1, 1, 1, -1); there, one more adds x + 1 to each.
    assert first.end_cost == pytest.approx(4)
    assert model.solve(max_iters=1).start_cost == pytest.approx(0 + 9 + 16 + 9)
