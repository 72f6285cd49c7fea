"""The Levenberg-Marquardt loop on problems with known optima, and every way a solve can end."""

from __future__ import annotations

import signal
import time
from dataclasses import fields

import numpy as np
import pytest

from arael.config import LmConfig
from arael.runtime.layout import Layout
from arael.runtime.levenberg.compiled import STATUSES
from arael.runtime.linear.compiled import DenseSolver
from arael.runtime.problem import Problem
from arael.runtime.solve import Outcome, minimise
from tests.runtime import toy, toys


def solved(layout, store, frozen=(), **settings) -> tuple[Outcome, Problem]:
    problem = Problem(layout, store, frozen=frozenset(frozen))
    linear = DenseSolver(problem.structure.pattern, layout.precision == "f32")
    return minimise(problem, LmConfig.of(**settings), linear), problem


def rosenbrock(**settings) -> Outcome:
    layout = toys.rosenbrock()
    return solved(layout, toys.at(layout, -1.2, 1.0), **settings)[0]


def referred(layout, store, **settings) -> tuple[Outcome, Problem]:
    """Solve by the loop of the reference framework."""
    return solved(layout, store, **reference(**settings))


def reference(**settings) -> dict:
    """Settings of `LmConfig.reference`, those given going over them."""
    config = LmConfig.reference()
    return {**{f.name: getattr(config, f.name) for f in fields(config)}, **settings}


# --- known optima ----------------------------------------------------------------------------


@pytest.mark.parametrize("precision, tolerance", [("f64", 1e-9), ("f32", 1e-5)])
def test_line_is_the_linear_least_squares_fit(precision, tolerance):
    layout = toys.line(precision)
    store = toys.line_store(layout)
    outcome, _ = solved(layout, store)
    x, y = store.tables["data"].column("x"), store.tables["data"].column("y")
    expected = np.polyfit(x.astype(float), y.astype(float), 1)
    assert outcome.status == "converged"
    np.testing.assert_allclose(outcome.x, expected, rtol=tolerance)
    residual = expected[0] * x + expected[1] - y
    assert outcome.end_cost == pytest.approx(float(residual @ residual), rel=tolerance)


def test_rosenbrock_reaches_its_minimum():
    outcome = rosenbrock()
    assert outcome.status == "converged"
    np.testing.assert_allclose(outcome.x, [1, 1], atol=1e-6)
    assert outcome.end_cost < 1e-12


def test_powell_singular_function_converges_to_the_origin():
    layout = toys.powell()
    outcome, _ = solved(
        layout,
        toys.at(layout, 3, -1, 0, 1),
        abs_precision=0.0,
        rel_precision=0.0,
        cost_threshold=1e-16,
    )
    assert outcome.status == "cost_threshold"
    np.testing.assert_allclose(outcome.x, 0, atol=1e-3)


@pytest.mark.parametrize("damping", ["gain", "ladder", "nielsen"])
def test_pose_chain_ends_at_a_stationary_point(damping):
    layout = toys.chain()
    outcome, problem = solved(
        layout, toys.chain_store(layout), damping=damping, rel_precision=1e-12, abs_precision=0.0
    )
    assert outcome.status == "converged"
    assert np.abs(problem.gradient()).max() < 1e-8
    assert outcome.end_cost == pytest.approx(4.8333e-4, rel=1e-4)


def test_angle_ends_wrapped():
    layout = toys.chain()
    _, problem = solved(layout, toys.chain_store(layout, 30))
    heading = problem.states[0][:, 2]
    assert np.abs(heading).max() <= np.pi
    np.testing.assert_allclose(np.sin(heading), problem.states[0][:, 3])


def test_unit_quaternion_entity_finds_the_rotation():
    """Vectors before and after a rotation; the tangent is a rotation vector on the right."""
    root = toy.table("", toy.param("q", kind="quaternion"))
    pairs = toy.table("pairs", toy.data("a", (3,)), toy.data("b", (3,)))

    def refresh(g, q, v):
        angle2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + 1e-30
        half = toy.sqrt(angle2) * 0.5
        scale = toy.sin(half) / (half * 2.0)
        w, x, y, z = toy.cos(half), v[0] * scale, v[1] * scale, v[2] * scale
        return [
            q[0] * w - q[1] * x - q[2] * y - q[3] * z,
            q[0] * x + q[1] * w + q[2] * z - q[3] * y,
            q[0] * y - q[1] * z + q[2] * w + q[3] * x,
            q[0] * z + q[1] * y - q[2] * x + q[3] * w,
        ]

    def along(q):
        w, x, y, z = q
        return [
            [x * -0.5, w * 0.5, z * 0.5, y * -0.5],
            [y * -0.5, z * -0.5, w * 0.5, x * 0.5],
            [z * -0.5, y * 0.5, x * -0.5, w * 0.5],
        ]

    def formula(s, d, u):
        w, x, y, z = s[0]
        rows = [
            [w * w + x * x - y * y - z * z, (x * y - w * z) * 2.0, (x * z + w * y) * 2.0],
            [(x * y + w * z) * 2.0, w * w - x * x + y * y - z * z, (y * z - w * x) * 2.0],
            [(x * z - w * y) * 2.0, (y * z + w * x) * 2.0, w * w - x * x - y * y + z * z],
        ]
        return [r[0] * d[0] + r[1] * d[1] + r[2] * d[2] - d[3 + k] for k, r in enumerate(rows)]

    e = toy.entity(root, refresh, names=("q.x", "q.y", "q.z"))
    fit = toy.group(
        "Toy.fit",
        "pairs",
        [toy.Slot((), "pairs"), toy.ROOT],
        [(1, 0)],
        [e],
        formula,
        raw=[toy.Raw(0, n, k) for n in "ab" for k in range(3)],
        chain={0: along},
    )
    layout = toy.layout([root, pairs], [e], [fit])
    store = toys.Store(layout)
    store.tables[""].column("q")[0] = [1, 0, 0, 0]
    a = np.eye(3)
    c, s = np.cos(2.5), np.sin(2.5)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    store.tables["pairs"].extend(3, a=a, b=a @ turn.T)
    outcome, _ = solved(layout, store)
    assert outcome.end_cost < 1e-20
    np.testing.assert_allclose(np.linalg.norm(outcome.x), 1, rtol=1e-12)
    np.testing.assert_allclose(outcome.x, [np.cos(1.25), 0, 0, np.sin(1.25)], atol=1e-9)


# --- semantics of a step ---------------------------------------------------------------------


def test_ladder_multiplies_by_a_fifth_and_by_ten_and_keeps_its_floor():
    history = rosenbrock(**reference(lambda_floor=1e-6)).history
    for record in history:
        factor = 0.2 if record["accepted"] else 10
        expected = max(record["damping"] * factor, 1e-6)
        assert record["next_damping"] == pytest.approx(expected, rel=1e-12)
    assert history["next_damping"].min() == 1e-6


def test_accepted_steps_lower_the_cost_and_rejected_ones_keep_the_state():
    history = rosenbrock().history
    assert (~history["accepted"].astype(bool)).any()
    cost = history["cost"][0]
    for record in history:
        assert record["cost"] == cost
        if record["accepted"]:
            assert record["trial_cost"] < cost
            cost = record["trial_cost"]
        else:
            assert not record["trial_cost"] < cost
    retries = history["retry"]
    assert (retries[1:][history["accepted"][:-1] == 1] == 0).all()
    assert (retries[1:][history["accepted"][:-1] == 0] > 0).all()


def test_first_step_solves_the_system_with_the_multiplied_diagonal():
    layout = toys.chain()
    store = toys.chain_store(layout)
    problem = Problem(layout, store)
    before = problem.states[0].copy()
    gradient, hessian = problem.gradient(), problem.hessian()
    damped = hessian + 0.3 * np.diag(np.diag(hessian))
    step = np.linalg.solve(damped, -gradient)
    linear = DenseSolver(problem.structure.pattern, False)
    outcome = minimise(problem, LmConfig.of(initial_lambda=0.3, max_iters=1), linear)
    moved = problem.states[0][:, :3] - before[:, :3]
    moved[:, 2] = np.angle(np.exp(1j * moved[:, 2]))
    np.testing.assert_allclose(moved.ravel(), step, rtol=1e-8, atol=1e-12)
    predicted = -(gradient @ step + 0.5 * step @ hessian @ step)
    assert outcome.history[0]["predicted"] == pytest.approx(predicted, rel=1e-9)
    assert outcome.history[0]["gradient"] == pytest.approx(np.abs(gradient).max(), rel=1e-12)


def test_nielsen_follows_the_gain_ratio():
    history = rosenbrock(damping="nielsen").history
    growth = 2.0
    for record in history:
        if record["accepted"]:
            gain = (record["cost"] - record["trial_cost"]) / record["predicted"]
            factor, growth = max(1 / 3, 1 - (2 * gain - 1) ** 3), 2.0
        else:
            factor, growth = growth, 2 * growth
        expected = max(record["damping"] * factor, 1e-12)
        assert record["next_damping"] == pytest.approx(expected, rel=1e-9)


def test_min_diagonal_is_a_floor_under_the_undamped_diagonal():
    layout = toys.root_only(1, lambda x: [x[0] - 5.0])
    outcome, _ = solved(
        layout, toys.at(layout, 1.0), min_diagonal=9.0, initial_lambda=1.0, max_iters=1
    )
    # J'J = 1, so the system is 9 (1 + 1) step = 4.
    assert outcome.x[0] == pytest.approx(1 + 4 / 18)


# --- every way to end ------------------------------------------------------------------------


def status_cases() -> dict[str, dict]:
    return {
        "converged": {},
        "cost_threshold": {"cost_threshold": 1.0},
        "max_iterations": {"max_iters": 4},
        "gradient_tolerance": {"gradient_tolerance": 5.0},
        "parameter_tolerance": {"parameter_tolerance": 0.2},
        "predicted_reduction": {"predicted_reduction_tolerance": 0.9},
        "time_limit": {"time_limit": 0.0},
        "driver_terminated": {"damping": lambda record: None},
        "observer_terminated": {"observer": lambda record: record["iteration"] < 3},
        "lambda_ceiling": {"lambda_ceiling": 1e-3},
        "retry_budget": {"retry_budget": 1},
    }


def jump(precision: str = "f64") -> Layout:
    """A residual that jumps: no step from 1, however short, lowers the cost."""
    return toys.root_only(
        1, lambda x: [toy.where_at_most(x[0], 1.0, x[0] - 3.0, x[0] + 9.0)], precision
    )


@pytest.mark.parametrize("status", status_cases())
def test_status(status):
    outcome = rosenbrock(**status_cases()[status])
    assert outcome.status == status
    assert outcome.end_cost <= outcome.start_cost


def test_all_statuses_are_covered_here():
    assert {*status_cases(), "stalled", "aborted", "running"} == set(STATUSES)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_stalled_at_a_jump(precision):
    layout = jump(precision)
    outcome, _ = solved(layout, toys.at(layout, 1.0))
    assert outcome.status == "stalled"
    assert outcome.x[0] == 1.0 and outcome.accepted_iterations == 0
    assert outcome.predicted_decrease == pytest.approx(4, rel=1e-6)


def test_max_iterations_counts_retries():
    outcome = rosenbrock(max_iters=4)
    assert outcome.iterations == 4 == len(outcome.history)
    assert outcome.accepted_iterations == outcome.history["accepted"].sum() < 4


def test_retry_budget_is_the_number_of_retries():
    outcome = rosenbrock(retry_budget=1)
    last = outcome.history[-1]
    assert last["retry"] == 1 and not last["accepted"]


def test_start_below_the_threshold_takes_no_step():
    outcome = rosenbrock(cost_threshold=100.0)
    assert outcome.status == "cost_threshold" and outcome.iterations == 0


def test_patience_and_min_iters_decide_when_small_steps_end_a_solve():
    """From far up a quartic every step is alike: the cost falls by 16/81 each time."""
    layout = toys.root_only(1, lambda x: [x[0] * x[0]])
    for patience, least, expected in [(0, 0, 1), (0, 4, 4), (2, 0, 3), (3, 5, 5)]:
        outcome, _ = referred(
            layout, toys.at(layout, 1e-1), abs_precision=1.0, patience=patience, min_iters=least
        )
        assert outcome.status == "converged"
        assert outcome.accepted_iterations == expected


def test_a_step_is_small_by_either_measure():
    layout = toys.root_only(1, lambda x: [x[0] * x[0]])
    settings = {"patience": 0, "min_iters": 0}
    for abs_precision, rel_precision in [(0.0, 0.99), (1.0, 0.0)]:
        outcome, _ = referred(
            layout,
            toys.at(layout, 1e-1),
            abs_precision=abs_precision,
            rel_precision=rel_precision,
            **settings,
        )
        assert (outcome.status, outcome.accepted_iterations) == ("converged", 1)


def test_machine_floor_ends_a_solve_before_min_iters():
    layout = toys.line()
    outcome, _ = referred(layout, toys.line_store(layout), min_iters=50, patience=50)
    assert outcome.status == "converged"
    assert outcome.accepted_iterations < 10


def test_perfect_start_converges_without_moving():
    outcome, _ = solved(toys.rosenbrock(), toys.at(toys.rosenbrock(), 1.0, 1.0))
    assert outcome.status == "converged" and outcome.end_cost == 0
    np.testing.assert_array_equal(outcome.x, [1, 1])


def test_nielsen_gives_up_when_its_growth_overflows():
    layout = jump()
    outcome, _ = solved(
        layout, toys.at(layout, 1.0), damping="nielsen", lambda_ceiling=1e300, max_iters=1000
    )
    assert outcome.status == "driver_terminated"
    assert outcome.x[0] == 1.0


# --- interruption ----------------------------------------------------------------------------


def interrupting(after: int):
    def observer(record):
        if record["iteration"] == after and record["accepted"]:
            raise KeyboardInterrupt
        return None

    return observer


def test_interrupted_solve_keeps_the_best_state():
    full = rosenbrock()
    outcome = rosenbrock(observer=interrupting(3))
    assert outcome.status == "aborted"
    assert outcome.accepted_iterations == 3
    accepted = full.history[full.history["accepted"] == 1]
    assert outcome.end_cost == accepted["trial_cost"][2]


def test_ctrl_c_ends_a_solve_without_an_observer():
    """The loop itself looks for signals."""
    layout = toys.chain()
    store = toys.chain_store(layout, 40)

    def interrupt(*_):
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1, 1.0)  # again, should one come before the loop
    try:
        # Steps too short to converge: this would go on for hours.
        outcome, problem = solved(
            layout,
            store,
            max_iters=10**6,
            min_iters=10**6,
            initial_lambda=1e9,
            lambda_floor=1e9,
            time_limit=60.0,
        )
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    assert outcome.status == "aborted"
    assert outcome.accepted_iterations > 0
    assert outcome.end_cost == pytest.approx(problem.cost(), rel=1e-12)


def test_exception_of_the_observer_passes_through():
    def observer(record):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        rosenbrock(observer=observer)


def test_time_limit_returns_the_state_reached():
    def slow(record):
        time.sleep(0.02)

    outcome = rosenbrock(observer=slow, time_limit=0.05)
    assert outcome.status == "time_limit"
    assert 1 <= outcome.iterations <= 5
