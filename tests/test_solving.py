"""The public solving face on hand-built layouts: passes, freezing, results, covariance."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

import arael
from arael.analysis.cost_table import cost_table
from arael.config import LmConfig
from arael.diagnostics.records import AraelError
from arael.result import Plan
from arael.runtime.failures import SolveError
from arael.runtime.layout import LayoutPass, PassSetting
from arael.runtime.store import Store
from arael.solving import cost, problem_of, solve
from arael.statuses import CONVERGED
from tests.runtime import toy, toys


def model_of(layout, store):
    return SimpleNamespace(_compiled=SimpleNamespace(layout=layout, kernels=None), _store=store)


def line(passes=()):
    layout = toys.line(passes=passes)
    return model_of(layout, toys.line_store(layout))


def chain(n: int = 12, **settings):
    layout = toys.chain(**settings)
    return model_of(layout, toys.chain_store(layout, n))


COARSE = LayoutPass("coarse", (PassSetting("sigma", (10.0,)),), {"max_iters": 50})
FINE = LayoutPass("fine", (PassSetting("sigma", (0.1,)),), {"rel_precision": 1e-9})
PASSES = (COARSE, FINE)


def code_of(caught) -> str:
    return caught.value.diagnostics[0].code


# --- passes ----------------------------------------------------------------------------------


def test_plain_solve_writes_the_solution_back():
    model = line()
    result = solve(model, solver="dense")
    root = model._store.tables[""]
    np.testing.assert_array_equal(result.x, [root.column("a")[0], root.column("b")[0]])
    assert result.converged and result.cost == pytest.approx(cost(model), rel=1e-12)
    assert [one.name for one in result.passes] == ["solve"]


def test_passes_run_in_order_and_their_root_data_stays():
    model = line(PASSES)
    result = solve(model, solver="dense")
    assert [one.name for one in result.passes] == ["coarse", "fine"]
    assert model._store.tables[""].column("sigma")[0] == 0.1
    first, second = result.passes
    assert second.start_cost == pytest.approx(first.end_cost * 1e4, rel=1e-9)
    assert result.start_cost == first.start_cost and result.end_cost == second.end_cost
    assert result.iterations == first.iterations + second.iterations == len(result.history)
    assert result.timing["total"] == pytest.approx(first.seconds + second.seconds)


def test_chosen_passes_run_alone_and_an_empty_list_is_one_plain_solve():
    model = line(PASSES)
    assert [one.name for one in solve(model, passes="fine").passes] == ["fine"]
    assert model._store.tables[""].column("sigma")[0] == 0.1
    assert [one.name for one in solve(model, passes=["fine", "coarse"]).passes] == [
        "fine",
        "coarse",
    ]
    assert [one.name for one in solve(model, passes=[]).passes] == ["solve"]
    mine = LayoutPass("mine", (PassSetting("sigma", (2.0,)),))
    assert solve(model, passes=mine).passes[0].name == "mine"
    assert model._store.tables[""].column("sigma")[0] == 2.0


def test_settings_of_the_call_go_over_those_of_a_pass():
    model = line(PASSES)
    result = solve(model, config=LmConfig(max_iters=7), max_iters=1, patience=1)
    assert [one.iterations for one in result.passes] == [1, 1]
    assert result.passes[0].status == "max_iterations"
    config = LmConfig(max_iters=1, patience=1)
    assert solve(line(PASSES), config=config).passes[0].status == "converged"


def test_interrupted_pass_ends_the_schedule_with_its_best_state():
    model = line(PASSES)

    def observer(record):
        raise KeyboardInterrupt

    result = solve(model, observer=observer)
    assert result.status == "aborted" and len(result.passes) == 1
    assert cost(model) == pytest.approx(result.end_cost, rel=1e-12)


def test_time_limit_is_for_all_passes_together():
    result = solve(line(PASSES), time_limit=0.0)
    assert result.status == "time_limit" and len(result.passes) == 1


def test_stored_values_are_those_of_the_start_of_each_pass():
    """`x.value` of a drift residual follows the passes: each starts with no drift."""
    layout = toys.chain()
    for _ in range(2):
        layout = toy.layout(
            layout.tables, layout.entities, layout.groups, passes=(LayoutPass("a"), LayoutPass("b"))
        )
    model = model_of(layout, toys.chain_store(layout))
    result = solve(model)
    assert result.passes[1].start_cost < result.passes[0].end_cost
    table = cost_table(problem_of(model))
    assert table["Poses.drift"] == 0


# --- freezing --------------------------------------------------------------------------------


def test_frozen_parameters_stay_and_are_free_again_afterwards():
    model = chain()
    before = model._store.tables["poses"].column("heading").copy()
    solve(model, freeze="poses.heading")
    poses = model._store.tables["poses"]
    np.testing.assert_array_equal(poses.column("heading"), before)
    solve(model)
    assert (poses.column("heading") != before).all()


def test_a_freeze_ends_with_its_pass():
    layout = toys.chain()
    passes = (
        LayoutPass("a", freeze=("poses.heading",)),
        LayoutPass("b"),
        LayoutPass("c", free=("poses.heading",)),
    )
    layout = toy.layout(layout.tables, layout.entities, layout.groups, passes=passes)
    model = model_of(layout, toys.chain_store(layout))
    result = solve(model, solver="dense")
    assert [len(one.x) for one in result.passes] == [36] * 3
    held = [one.plan for one in result.passes]
    assert held[0]["n"] == held[2]["n"]
    seen = []
    model = model_of(layout, toys.chain_store(layout))
    heading = model._store.tables["poses"].column("heading")
    for chosen in ("a", ["a", "b"], ["a", "b", "c"]):
        before = heading.copy()
        solve(model, passes=chosen)
        seen.append(bool((heading != before).any()))
    assert seen == [False, True, True]


# --- refusals --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings, code, message, help_text",
    [
        ({"passes": "corse"}, "E1011", "there is no pass `corse`", "did you mean `coarse`?"),
        ({"freeze": "aa"}, "E1012", "there is no parameter `aa`", "did you mean `a`?"),
        (
            {"max_iter": 3},
            "E1010",
            "there is no solver setting `max_iter`",
            "did you mean `max_iters`?",
        ),
        ({"max_iters": 0}, "E1010", "`max_iters` is 0", "it must be a whole number from 1 on"),
        (
            {"rel_precision": -1.0},
            "E1010",
            "`rel_precision` is -1.0",
            "it must be None or a number, zero or more",
        ),
        (
            {"abs_precision": float("nan")},
            "E1010",
            "`abs_precision` is nan",
            "it must be a number, zero or more",
        ),
        (
            {"damping": "newton"},
            "E1010",
            "`damping` is 'newton'",
            'it must be "gain", "ladder", "nielsen" or a callable',
        ),
        (
            {"strategy": "newton"},
            "E1010",
            "`strategy` is 'newton'",
            'it must be "auto", "dogleg", "damped"',
        ),
        ({"ending": 3}, "E1010", "`ending` is 3", 'it must be "promise", "small_steps"'),
        (
            {"strategy": "dogleg", "damping": "nielsen"},
            "E1010",
            "`strategy` is 'dogleg', which has no use for `damping` 'nielsen'",
            'set strategy="damped", or leave one of the two out',
        ),
        (
            {"lambda_ceiling": 1e-9},
            "E1010",
            "`lambda_ceiling` is 1e-09",
            "it must be above initial_lambda (0.0001)",
        ),
        (
            {"time_limit": -1},
            "E1010",
            "`time_limit` is -1",
            "it must be None or a number, zero or more",
        ),
        ({"verbose": 1}, "E1010", "`verbose` is 1", "it must be true or false"),
        (
            {"config": 3},
            "E1010",
            "`config` is an `arael.LmConfig`, found int",
            "write single settings by name, such as `solve(max_iters=50)`",
        ),
    ],
)
def test_bad_requests_are_refused_by_name(settings, code, message, help_text):
    model = line(PASSES)
    with pytest.raises(AraelError) as caught:
        solve(model, **settings)
    error = caught.value.diagnostics[0]
    assert (error.code, error.message, error.help) == (code, message, (help_text,))
    assert model._store.tables[""].column("a")[0] == 0


def test_missing_root_data_is_refused_before_anything_runs():
    root = toy.table("", toy.param("a"), toy.data("sigma"))
    e = toy.entity(root)
    only = toy.group(
        "Toy.a",
        "",
        [toys.SELF],
        [(0, 0)],
        [e],
        lambda s, d, u: [s[0][0] - d[0]],
        raw=[toy.Raw(0, "sigma")],
    )
    layout = toy.layout([root], [e], [only])
    with pytest.raises(AraelError) as caught:
        solve(model_of(layout, Store(layout)))
    assert code_of(caught) == "E0702"


def test_failure_leaves_the_model_as_the_passes_before_left_it():
    broken = LayoutPass("broken", (PassSetting("sigma", (float("nan"),)),))
    model = line((COARSE, broken))
    with pytest.raises(SolveError) as caught:
        solve(model)
    best = caught.value.best
    assert code_of(caught) == "E1001"
    assert [one.name for one in best.passes] == ["coarse", "broken"]
    root = model._store.tables[""]
    np.testing.assert_allclose(best.passes[0].x, [root.column("a")[0], root.column("b")[0]])


PRESETS = (
    LmConfig.well_conditioned,
    LmConfig.ill_conditioned,
    LmConfig.conservative,
    LmConfig.reference,
)


def test_presets_are_valid_and_take_settings():
    for preset in PRESETS:
        assert preset(max_iters=17).max_iters == 17
        assert preset() != LmConfig()
        assert solve(line(), config=preset()).converged


def test_the_reference_has_the_eight_fields_of_the_framework():
    found = LmConfig.reference()
    assert (found.abs_precision, found.rel_precision) == (1e-6, 1e-4)
    assert (found.max_iters, found.min_iters, found.patience) == (100, 5, 3)
    assert (found.initial_lambda, found.cost_threshold, found.verbose) == (1e-4, 0.0, False)
    assert (found.chosen_strategy(), found.damping, found.ending) == (
        "damped",
        "ladder",
        "small_steps",
    )


@pytest.mark.parametrize(
    "settings, chosen",
    [
        ({}, "dogleg"),
        ({"rel_precision": 1e-4, "max_iters": 7, "min_diagonal": 1.0}, "dogleg"),
        ({"initial_lambda": 1e-6}, "damped"),
        ({"lambda_floor": 1e-9}, "damped"),
        ({"lambda_ceiling": 1e9}, "damped"),
        ({"retry_budget": 3}, "damped"),
        ({"damping": "ladder"}, "damped"),
        ({"damping": lambda record: 1.0}, "damped"),
        ({"strategy": "dogleg", "lambda_floor": 1e-9}, "dogleg"),
        ({"strategy": "damped"}, "damped"),
    ],
)
def test_a_setting_of_damping_chooses_the_damped_strategy(settings, chosen):
    config = LmConfig.of(**settings)
    assert config.chosen_strategy() == chosen
    radius = solve(line(), config=config).history["radius"]
    assert np.isnan(radius).all() if chosen == "damped" else np.isfinite(radius).all()


# --- results ---------------------------------------------------------------------------------


def test_result_reads_as_json_and_as_text():
    result = solve(line(PASSES), solver="dense")
    plain = json.loads(json.dumps(result.to_dict()))
    assert plain["status"] == "converged" and plain["plan"]["solver"] == "dense"
    assert [one["name"] for one in plain["passes"]] == ["coarse", "fine"]
    assert set(plain) >= {"start_cost", "end_cost", "iterations", "accepted_iterations", "timing"}
    assert repr(result).startswith("<Result converged: cost ")
    lines = str(result).splitlines()
    assert lines[0].startswith("converged: cost ")
    assert lines[1].startswith("  coarse  converged: cost ")
    assert lines[3].startswith("  solver dense (n 2")


def test_result_carries_what_its_end_rests_on():
    result = solve(line(), solver="dense")
    assert 0 <= result.predicted_decrease <= max(1e-10 * result.end_cost, result.noise_floor)
    assert 0 < result.noise_floor < 1e-12 * result.start_cost
    assert result.gradient_norm**2 <= 2 * max(result.predicted_decrease, result.noise_floor)
    plain = result.to_dict()
    for name in ("predicted_decrease", "gradient_norm", "noise_floor"):
        assert plain[name] == getattr(result, name) == getattr(result.passes[-1], name)
    assert "predicted" not in str(result).splitlines()[0]


def test_status_line_says_what_an_unfinished_solve_still_promises():
    layout = toys.rosenbrock()
    model = model_of(layout, toys.at(layout, -1.2, 1.0))
    rejected = solve(model, max_iters=1)
    assert not rejected.history["accepted"][-1]
    share = 100 * rejected.predicted_decrease / rejected.end_cost
    assert (
        str(rejected)
        .splitlines()[0]
        .endswith(
            f"; a further decrease of {rejected.predicted_decrease:.3g} is predicted "
            f"({share:.3g} % of the cost)"
        )
    )
    whole = solve(model_of(layout, toys.at(layout, -1.2, 1.0)))
    stopped = solve(model, max_iters=int(np.argmax(whole.history["accepted"])) + 1)
    assert stopped.history["accepted"][-1]
    assert "; before the last step a decrease of" in str(stopped).splitlines()[0]
    nothing = solve(model, time_limit=0.0)
    assert nothing.to_dict()["predicted_decrease"] is None
    assert "predicted" not in str(nothing).splitlines()[0]


def test_predicted_decrease_is_that_of_the_undamped_step():
    layout = toys.rosenbrock()
    model = model_of(layout, toys.at(layout, -1.2, 1.0))
    problem = problem_of(model)
    gradient, hessian = problem.gradient() / 2, problem.hessian() / 2
    promised = gradient @ np.linalg.solve(hessian, gradient)
    scaled = np.sqrt((gradient**2 / np.diag(hessian)).sum())
    for settings in ({}, {"strategy": "damped"}, {"config": LmConfig.reference(max_iters=1)}):
        result = solve(model_of(layout, toys.at(layout, -1.2, 1.0)), max_iters=1, **settings)
        assert result.history["promise"][0] == result.predicted_decrease
        damped = gradient @ np.linalg.solve(
            hessian + result.history["damping"][0] * np.diag(np.diag(hessian)), gradient
        )
        assert result.predicted_decrease == pytest.approx(damped, rel=1e-9)
        assert result.predicted_decrease <= promised * (1 + 1e-9)
        assert result.gradient_norm == pytest.approx(scaled, rel=1e-12)


def test_statuses_that_count_as_solved():
    assert {
        "converged",
        "cost_threshold",
        "gradient_tolerance",
        "parameter_tolerance",
        "predicted_reduction",
    } == CONVERGED


def test_plan_reads_as_one_line():
    plan = Plan({"solver": "sparse", "n": 12, "nnz_l": 30_500, "why": "few couplings"})
    assert str(plan) == "sparse (n 12, nnz(L) 3.05e4): few couplings"


def test_the_plan_says_what_was_predicted_and_what_it_took():
    model = model_of(toys.chain(), toys.chain_store(toys.chain()))
    result = solve(model, solver="sparse")
    plan = result.plan
    again = result.timing["factor"] / (result.iterations - 1)
    assert plan["measured_ms"] == pytest.approx(1e3 * again, rel=0.05)
    assert plan["predicted_ms"] > 0
    assert f"it took {plan['measured_ms']:.3g} ms" in str(result)
    result = solve(model, solver="sparse", max_iters=1)
    assert result.plan["measured_ms"] == pytest.approx(1e3 * result.timing["first_factor"])
    result = solve(model, solver="schur_pcg")
    each = result.timing["solve"] / result.iterations
    assert result.plan["measured_ms"] > 1e3 * each


# --- derivatives that are too small ----------------------------------------------------------


@pytest.mark.parametrize(("slope", "text"), [(0.0, "zero there"), (1e-180, "than 1e-180, and its")])
def test_a_derivative_that_underflows_is_not_called_zero(tmp_path, slope, text):
    path = tmp_path / "tiny.arael"
    path.write_text(
        "root Tiny { param a: real; param b: real; slope: real\n"
        "constraint c { [a - 1, b * slope] } }\n"
    )
    tiny = arael.load(path, interpret=True)(a=0, b=0, slope=slope)
    with pytest.raises(SolveError, match=text) as caught:
        tiny.solve()
    assert code_of(caught) == "E1004" and "`b`" in str(caught.value)
