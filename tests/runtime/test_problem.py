"""Preparation and assembly: where contributions go, what is held, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from arael.analysis.jacobian import jacobian
from arael.config import LmConfig
from arael.runtime.assembly.structure import structure_of
from arael.runtime.failures import SolveError
from arael.runtime.layout import Place
from arael.runtime.linear.compiled import DenseSolver
from arael.runtime.problem import Problem
from arael.runtime.solve import minimise
from arael.runtime.store import Store
from tests.runtime import toy, toys
from tests.runtime.toy import ROOT, Raw, Slot, Step


def run(problem: Problem, **settings):
    linear = DenseSolver(problem.structure.pattern, problem.layout.precision == "f32")
    return minimise(problem, LmConfig.of(**settings), linear)


def chain_problem(**settings) -> Problem:
    layout = toys.chain()
    return Problem(layout, toys.chain_store(layout), **settings)


# --- gradient and Hessian --------------------------------------------------------------------


def central_gradient(problem: Problem, h: float = 1e-6):
    """Through the problem's own retraction."""
    n = problem.size
    found = np.zeros(n)
    for k in range(n):
        costs = []
        for sign in (1, -1):
            step = np.zeros(n)
            step[k] = sign * h
            fresh = Problem(problem.layout, problem.store)
            fresh.evaluation.moved_by(step)
            costs.append(fresh.cost())
        found[k] = (costs[0] - costs[1]) / (2 * h)
    return found


def test_gradient_agrees_with_central_differences():
    problem = chain_problem()
    expected = central_gradient(problem)
    np.testing.assert_allclose(problem.gradient(), expected, rtol=1e-6, atol=1e-7)


def test_gradient_and_hessian_are_those_of_the_jacobian():
    problem = chain_problem()
    found = jacobian(problem)
    j = found.dense()
    np.testing.assert_allclose(problem.gradient(), 2 * j.T @ found.residuals, rtol=1e-12)
    np.testing.assert_allclose(problem.hessian(), 2 * j.T @ j, rtol=1e-12, atol=1e-12)
    assert problem.cost() == pytest.approx(float(found.residuals @ found.residuals), rel=1e-14)


def two_ends(same: bool) -> tuple:
    """Springs between points; with `same`, one of them has both ends on one point."""
    root = toy.table("")
    points = toy.table("points", toy.param("pos", 2))
    springs = toy.table("springs", toy.ref("a", "points"), toy.ref("b", "points"))
    e = toy.entity(points)

    def formula(s, d, u):
        a, b = s
        return [a[0] * b[1] - 1.0, a[1] * a[1] + b[0], a[0] - b[0] * b[1] + 0.3]

    spring = toy.group(
        "Springs.pull",
        "springs",
        [Slot((Step("ref", "a"),), "points"), Slot((Step("ref", "b"),), "points")],
        [(0, 0), (1, 0)],
        [e],
        formula,
    )
    layout = toy.layout([root, points, springs], [e], [spring])
    store = Store(layout)
    store.tables["points"].extend(3, pos=[[0.3, 1.1], [-0.7, 0.4], [1.3, -0.2]])
    store.tables["springs"].extend(3, a=[0, 2, 1], b=[1, 0, 1 if same else 2])
    return layout, store


@pytest.mark.parametrize("same", [False, True])
def test_blocks_of_either_order_and_of_one_row_twice(same):
    """(0, 1) is transposed onto the lower triangle, (2, 0) is not, (1, 1) meets itself."""
    layout, store = two_ends(same)
    problem = Problem(layout, store)
    turns = set(problem.structure.placements[0].turn[:, 1].tolist())
    assert turns == ({0, 1, 2} if same else {0, 1})
    dense = np.zeros((9, 6))
    pos = store.tables["points"].column("pos")
    for k, (i, j) in enumerate([(0, 1), (2, 0), (1, 1 if same else 2)]):
        a, b = pos[i], pos[j]
        by_a = np.array([[b[1], 0], [0, 2 * a[1]], [1, 0]])
        by_b = np.array([[0, a[0]], [1, 0], [-b[1], -b[0]]])
        dense[3 * k : 3 * k + 3, 2 * i : 2 * i + 2] += by_a
        dense[3 * k : 3 * k + 3, 2 * j : 2 * j + 2] += by_b
    np.testing.assert_allclose(problem.hessian(), 2 * dense.T @ dense, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(jacobian(problem).dense(), dense, atol=1e-15)


def test_pairs_that_no_residual_reads_together_have_no_block():
    root = toy.table("")
    points = toy.table("points", toy.param("h"))
    links = toy.table("links", toy.ref("a", "points"), toy.ref("b", "points"))
    e = toy.entity(points)
    apart = toy.group(
        "Links.apart",
        "links",
        [Slot((Step("ref", "a"),), "points"), Slot((Step("ref", "b"),), "points")],
        [(0, 0), (1, 0)],
        [e],
        lambda s, d, u: [s[0][0] - 1.0, s[1][0] + 2.0],
    )
    layout = toy.layout([root, points, links], [e], [apart])
    store = Store(layout)
    store.tables["points"].extend(2)
    store.tables["links"].append(a=0, b=1)
    problem = Problem(layout, store)
    assert len(problem.structure.pattern.rows) == 2
    np.testing.assert_array_equal(problem.hessian(), 2 * np.eye(2))


# --- what is held ----------------------------------------------------------------------------


def test_partial_fixing_equals_elimination():
    layout = toys.chain()
    store = toys.chain_store(layout)
    poses = store.tables["poses"]
    poses.fixed("heading")[::2] = True
    before = poses.column("heading").copy()
    problem = Problem(layout, store)
    whole = Problem(layout, toys.chain_store(layout))
    free = np.ones(whole.size, dtype=bool)
    free[2::6] = False
    np.testing.assert_allclose(problem.hessian(), whole.hessian()[np.ix_(free, free)], rtol=1e-13)
    np.testing.assert_allclose(problem.gradient(), whole.gradient()[free], rtol=1e-13)

    hessian, gradient = problem.hessian(), problem.gradient()
    step = np.linalg.solve(hessian + 1e-4 * np.diag(np.diag(hessian)), -gradient)
    expected = np.zeros(whole.size)
    expected[free] = step
    start = problem.states[0].copy()
    run(problem, max_iters=1, damping="ladder")
    moved = problem.states[0][:, :3] - start[:, :3]
    np.testing.assert_allclose(moved[:, :2], expected.reshape(-1, 3)[:, :2], atol=1e-11)
    problem.write_back()
    np.testing.assert_array_equal(poses.column("heading")[::2], before[::2])
    assert (poses.column("heading")[1::2] != before[1::2]).all()


def test_fixed_rows_are_left_out_and_still_constrain():
    layout = toys.chain()
    store = toys.chain_store(layout)
    poses = store.tables["poses"]
    for path in ("pos", "heading"):
        poses.fixed(path)[3] = True
    problem = Problem(layout, store)
    assert problem.structure.pattern.block_count == 11
    whole = Problem(layout, toys.chain_store(layout))
    keep = np.delete(np.arange(36), [9, 10, 11])
    np.testing.assert_allclose(problem.hessian(), whole.hessian()[np.ix_(keep, keep)], rtol=1e-13)
    assert problem.cost() == pytest.approx(whole.cost(), rel=1e-14)
    assert problem.structure.system.name_of(9) == "poses[4].pos.x"


def test_frozen_paths_hold_parameters():
    problem = chain_problem(frozen=frozenset({"poses.heading"}))
    assert len(problem.free) == 24
    assert all("heading" not in name for name in problem.parameter_names())
    with pytest.raises(SolveError, match="nothing to solve for") as caught:
        chain_problem(frozen=frozenset({"poses"})).check_start()
    assert caught.value.diagnostics[0].code == "E1006"


def test_unwritten_until_asked():
    problem = chain_problem()
    before = problem.store.tables["poses"].column("pos").copy()
    run(problem)
    np.testing.assert_array_equal(problem.store.tables["poses"].column("pos"), before)
    problem.write_back()
    assert np.abs(problem.store.tables["poses"].column("pos") - before).max() > 1e-3


# --- guards, indices, structure --------------------------------------------------------------


def guarded_line() -> tuple:
    layout = toys.line()
    root, points = layout.tables
    points = toy.table(
        "data",
        *points.columns,
        toy.data("on", default=1.0),
        toy.Column("ci", "int", (), "constraint_index", "constraint_index", "toy:9:1"),
    )
    fit = toy.group(
        "Data.fit",
        "data",
        [Slot((), "data"), ROOT],
        [(1, 0)],
        layout.entities,
        lambda s, d, u: [s[0][0] * d[0] + s[0][1] - d[1]],
        raw=[Raw(0, "x"), Raw(0, "y")],
        index_column="ci",
        guard=([Raw(0, "on")], lambda g, x: g.call("lt", 0.5, x[0])),
    )
    layout = toy.layout([root, points], layout.entities, [fit])
    return layout, toys.line_store(layout)


def test_guard_chooses_instances_and_indices_follow():
    layout, store = guarded_line()
    on = store.tables["data"].column("on")
    on[...] = 0
    on[[3, 4, 11]] = 1
    problem = Problem(layout, store)
    assert problem.structure.active[0].tolist() == [3, 4, 11]
    index = store.tables["data"].column("ci")
    assert index[[3, 4, 11]].tolist() == [0, 1, 2]
    assert (np.delete(index, [3, 4, 11]) == -1).all()
    outcome = run(problem)
    data = store.tables["data"]
    expected = np.polyfit(data.column("x")[on > 0], data.column("y")[on > 0], 1)
    np.testing.assert_allclose(outcome.x, expected, rtol=1e-8)
    assert [row.constraint for row in jacobian(problem)] == [0, 1, 2]


def test_structure_is_taken_over_until_it_changes():
    _, store = guarded_line()
    first = structure_of(store)
    store.tables["data"].column("y")[0] = 7
    assert structure_of(store, known=first) is first
    store.tables["data"].column("on")[0] = 0
    second = structure_of(store, known=first)
    assert second is not first
    store.tables["data"].extend(1, x=[0.0], y=[0.0])
    third = structure_of(store, known=second)
    assert third is not second
    store.tables[""].fixed("a")[0] = True
    assert structure_of(store, known=third) is not third


def test_prepared_data_is_refreshed_when_the_structure_is_taken_over():
    layout = toys.line()
    store = toys.line_store(layout)
    first = Problem(layout, store)
    store.tables[""].column("sigma")[0] = 2.0
    second = Problem(layout, store, known=first.structure)
    assert second.structure is first.structure
    assert second.cost() == pytest.approx(first.cost() / 4, rel=1e-13)


# --- bounds ----------------------------------------------------------------------------------


def test_bounds_are_hard_limits():
    layout = toys.rosenbrock(low=(None, None), high=(0.5, None))
    seen = []
    problem = Problem(layout, toys.at(layout, -1.2, 1.0))
    outcome = run(
        problem,
        observer=lambda r: seen.append(problem.x[0]),
        abs_precision=1e-12,
        rel_precision=1e-10,
    )
    assert max(seen) <= 0.5 * (1 + 1e-15)
    # On the bound x = 0.5 the best y is x^2.
    assert outcome.status == "converged"
    np.testing.assert_allclose(outcome.x, [0.5, 0.25], atol=1e-6)
    assert outcome.end_cost == pytest.approx(0.25, rel=1e-6)


def test_a_bounded_scalar_leaves_its_bound_again():
    layout = toys.root_only(1, lambda x: [x[0] - 3.0], low=(0.0,), high=(10.0,))
    outcome = run(Problem(layout, toys.at(layout, 0.0)))
    np.testing.assert_allclose(outcome.x, [3], rtol=1e-6)


def test_bounds_that_do_not_bind_change_nothing():
    free, boxed = toys.rosenbrock(), toys.rosenbrock(low=(-50.0, -50.0), high=(50.0, 50.0))
    a = run(Problem(free, toys.at(free, -1.2, 1.0)))
    b = run(Problem(boxed, toys.at(boxed, -1.2, 1.0)))
    np.testing.assert_allclose(a.history["trial_cost"], b.history["trial_cost"], rtol=1e-10)


def test_start_outside_bounds_is_refused():
    layout = toys.rosenbrock(low=(None, 2.0))
    with pytest.raises(
        SolveError, match=r"`x\.y` starts at 1, outside its bounds 2 \.\."
    ) as caught:
        run(Problem(layout, toys.at(layout, -1.2, 1.0)))
    assert caught.value.diagnostics[0].code == "E1007"


# --- failures by name ------------------------------------------------------------------------


def test_unconstrained_parameter_is_named():
    layout = toys.chain()
    store = toys.chain_store(layout, loops=False)
    drift_free = toy.layout(layout.tables, layout.entities, layout.groups[:1])
    lonely = toys.chain_store(drift_free, loops=False)
    lonely.tables["poses"].append(pos=[1, 2], heading=0.0)
    with pytest.raises(SolveError) as caught:
        run(Problem(drift_free, lonely))
    error = caught.value.diagnostics[0]
    assert error.code == "E1003"
    assert "no constraint reads `poses[12].pos.x`, `poses[12].pos.y`" in error.message
    assert caught.value.best.status == "aborted"
    assert len(caught.value.best.x) == 39
    assert Problem(layout, store).size == 36


def test_flat_start_is_told_apart_from_an_untouched_parameter():
    layout = toys.root_only(2, lambda x: [x[0] * x[0], x[1] - 1.0])
    with pytest.raises(SolveError, match=r"no residual changes with `x\.x` at the start") as caught:
        run(Problem(layout, toys.at(layout, 0.0, 0.0)))
    assert caught.value.diagnostics[0].code == "E1004"
    outcome = run(Problem(layout, toys.at(layout, 0.0, 0.0)), min_diagonal=1e-6)
    np.testing.assert_allclose(outcome.x, [0, 1], atol=1e-9)


def spoiled(value: float) -> tuple:
    root = toy.table("", toy.param("a"))
    points = toy.table("data", toy.data("x"))
    e = toy.entity(root)
    fit = toy.group(
        "Data.fit",
        "data",
        [Slot((), "data"), ROOT],
        [(1, 0)],
        [e],
        lambda s, d, u: [toy.sqrt(d[0] + s[0][0])],
        raw=[Raw(0, "x")],
        places=[Place("toy.arael:7:9", "sqrt(x + root.a)")],
    )
    layout = toy.layout([root, points], [e], [fit])
    store = Store(layout)
    store.tables["data"].extend(4, x=[1.0, 2.0, 3.0, 4.0])
    store.tables["data"].column("x")[2] = value
    return layout, store


def test_non_finite_start_names_instance_expression_and_operands():
    with pytest.raises(SolveError) as caught:
        run(Problem(*spoiled(-9.0)))
    error = caught.value.diagnostics[0]
    assert error.code == "E1001"
    assert error.message == "`Data.fit[2]`: residual 0 is nan at the start"
    assert error.notes == (
        "it acts on `data[2]`",
        "in `sqrt(x + root.a)` at toy.arael:7:9",
        "`sqrt` of (-9) is nan",
        "`sqrt(x)` takes x >= 0",
    )


def test_non_finite_data_is_named():
    with pytest.raises(SolveError) as caught:
        run(Problem(*spoiled(np.nan)))
    assert "`data[2].x` is nan" in caught.value.diagnostics[0].notes


def test_non_finite_derivative_at_the_start():
    with pytest.raises(SolveError) as caught:
        run(Problem(*spoiled(0.0)))
    error = caught.value.diagnostics[0]
    assert error.code == "E1002"
    assert error.message == "`Data.fit[2]`: a derivative of residual 0 is inf at the start"


def test_overflow_says_so():
    layout = toys.root_only(1, lambda x: [x[0] * 1e200])
    with pytest.raises(SolveError, match="the sum of squares overflows"):
        run(Problem(layout, toys.at(layout, 1.0)))


@pytest.mark.parametrize("strategy", ["dogleg", "damped"])
def test_trial_that_is_not_finite_is_a_rejection(strategy):
    """From 1 the full step goes to 0.2, where the square root has no value."""
    layout = toys.root_only(1, lambda x: [toy.sqrt(x[0] - 0.8) + 0.45])
    outcome = run(Problem(layout, toys.at(layout, 1.0)), max_iters=30, strategy=strategy)
    first = outcome.history[0]
    assert np.isnan(first["trial_cost"]) and not first["accepted"]
    assert outcome.end_cost < outcome.start_cost


def test_wrong_capsule_is_refused():
    layout = toys.line()
    with pytest.raises(TypeError, match=r"expected a capsule `arael\.kernels`"):
        Problem(layout, toys.line_store(layout), object())
