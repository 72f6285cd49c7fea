"""The public solving face on hand-built layouts: passes, freezing, results, covariance."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

import arael
from arael.analysis.cost_table import cost_table
from arael.analysis.covariance import covariance
from arael.analysis.jacobian import jacobian
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


def test_passes_freeze_until_a_later_one_frees():
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
    assert seen == [False, False, True]


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
            'it must be "auto", "dogleg", "subspace", "gauss_newton", "damped"',
        ),
        ({"ending": 3}, "E1010", "`ending` is 3", 'it must be "promise", "small_steps"'),
        (
            {"strategy": "dogleg", "damping": "nielsen"},
            "E1010",
            "`strategy` is 'dogleg', which has no use for `damping` 'nielsen'",
            'set strategy="damped", or leave one of the two out',
        ),
        (
            {"strategy": "subspace", "damping": "ladder"},
            "E1010",
            "`strategy` is 'subspace', which has no use for `damping` 'ladder'",
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
    broken = LayoutPass("broken", (PassSetting("sigma", (0.0,)),))
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
        ({"strategy": "subspace"}, "subspace"),
        ({"strategy": "gauss_newton", "lambda_floor": 1e-9}, "gauss_newton"),
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


# --- diagnosis -------------------------------------------------------------------------------


def test_cost_table_lists_every_constraint():
    model = chain()
    table = cost_table(problem_of(model))
    assert list(table) == ["Pairs.odometry", "Poses.drift"]
    assert table["Poses.drift"] == 0 and table.instances == {
        "Pairs.odometry": 12,
        "Poses.drift": 12,
    }
    assert table.total == pytest.approx(cost(model), rel=1e-12)
    empty = toys.chain()
    assert cost_table(problem_of(model_of(empty, Store(empty)))) == {
        "Pairs.odometry": 0,
        "Poses.drift": 0,
    }
    assert str(table).splitlines()[0].split() == ["constraint", "cost", "instances", "rms"]
    assert table.rms("Pairs.odometry") == pytest.approx(
        (table["Pairs.odometry"] / table.residuals["Pairs.odometry"]) ** 0.5
    )


def test_jacobian_counts_degrees_of_freedom():
    layout = toys.chain()
    layout = toy.layout(layout.tables, layout.entities, layout.groups[:1])
    found = jacobian(problem_of(model_of(layout, toys.chain_store(layout))))
    s = found.singular_values()
    assert found.shape == (36, 36)
    assert (s[:-3] > 1e-3).all() and (s[-3:] < 1e-12).all()
    u, s, v = found.svd()
    np.testing.assert_allclose((u * s) @ v.T, found.dense(), atol=1e-12)
    # The free directions move all poses alike.
    assert np.abs(found.dense() @ v[:, -3:]).max() < 1e-12
    row = found[4]
    assert (row.label, row.constraint) == ("Pairs.odometry", 1)
    assert [c for c, _ in row.entries] == sorted(c for c, _ in row.entries)
    assert found.names[3] == "poses[1].pos.x"
    with pytest.raises(IndexError):
        found[36]


def test_covariance_of_a_line_is_the_textbook_one():
    model = line()
    solve(model)
    x = np.asarray(model._store.tables["data"].column("x"))
    design = np.stack([x, np.ones_like(x)], axis=1)
    expected = np.linalg.inv(design.T @ design)
    found = covariance(problem_of(model))
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)
    np.testing.assert_allclose(found.marginal("a"), expected[:1, :1], rtol=1e-9)
    np.testing.assert_allclose(found.cross("a", "b"), expected[:1, 1:], rtol=1e-9)
    np.testing.assert_allclose(found.marginal(("", 0)), expected, rtol=1e-9)


def test_relative_covariance_is_that_of_the_difference():
    model = chain()
    solve(model)
    found = covariance(problem_of(model))
    a, b = ("poses", 2), ("poses", 7)
    select = np.zeros((3, 36))
    select[:, 6:9], select[:, 21:24] = np.eye(3), -np.eye(3)
    expected = select @ found.matrix @ select.T
    np.testing.assert_allclose(found.relative(a, b), expected, rtol=1e-9)
    np.testing.assert_allclose(
        found.relative("poses[2].pos", "poses[7].pos"), expected[:2, :2], rtol=1e-9
    )


def test_singular_system_names_free_directions():
    layout = toys.chain()
    layout = toy.layout(layout.tables, layout.entities, layout.groups[:1])
    with pytest.raises(SolveError) as caught:
        covariance(problem_of(model_of(layout, toys.chain_store(layout))))
    error = caught.value.diagnostics[0]
    assert error.code == "E1008"
    assert error.message == "the system is singular: 3 of 36 directions are free"
    assert error.notes == (
        "free direction: `poses.pos` move together along x",
        "free direction: `poses.pos` move together along y",
        "free direction: `poses.pos` turn together",
    )


def test_covariance_of_what_is_fixed_is_refused():
    model = chain()
    poses = model._store.tables["poses"]
    poses.fixed("pos")[0] = poses.fixed("heading")[0] = True
    found = covariance(problem_of(model))
    assert found.matrix.shape == (33, 33)
    with pytest.raises(AraelError, match=r"`poses\[0\]` is not solved for") as caught:
        found.marginal(("poses", 0))
    assert code_of(caught) == "E1009"


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


# --- numbers of NumPy as settings ------------------------------------------------------------


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint8, np.array])
def test_whole_numbers_of_numpy_are_settings(kind):
    counts = {"max_iters": 5, "min_iters": 2, "patience": 1, "retry_budget": 3, "num_threads": 1}
    config = LmConfig(**{name: kind(value) for name, value in counts.items()})
    config.validate()
    assert {name: getattr(config, name) for name in counts} == counts
    assert all(type(getattr(config, name)) is int for name in counts)
    assert len(solve(line(), max_iters=kind(2), min_iters=kind(9)).history) == 2


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16])
def test_numbers_of_numpy_are_settings(kind):
    numbers = {"abs_precision": 0.5, "lambda_floor": 0.25, "time_limit": 8.0, "min_diagonal": 1.0}
    config = LmConfig.of(**{name: kind(value) for name, value in numbers.items()})
    assert {name: getattr(config, name) for name in numbers} == numbers
    assert all(type(getattr(config, name)) is float for name in numbers)
    assert LmConfig.of(verbose=np.bool_(True)).verbose is True
    assert LmConfig.of(lambda_ceiling=kind(4.0)).lambda_ceiling == 4.0


@pytest.mark.parametrize("value", [np.float64(5), 5.0, np.array([5]), "5", True, np.bool_(True)])
def test_what_is_no_whole_number_is_refused(value):
    with pytest.raises(AraelError, match="`max_iters` is"):
        LmConfig.of(max_iters=value)


def test_an_array_as_damping_is_refused():
    with pytest.raises(AraelError, match="`damping` is"):
        LmConfig.of(damping=np.ones(3))


# --- solvers and options of the wrong type ---------------------------------------------------


@pytest.mark.parametrize("solver", [3, None, ["dense"], b"dense", 1.5])
def test_a_solver_that_is_no_name_is_refused(solver):
    with pytest.raises(AraelError, match="there is no linear solver") as caught:
        solve(line(), solver=solver)
    assert code_of(caught) == "E0840"
    assert "schur_pcg" in caught.value.diagnostics[0].notes[0]


@pytest.mark.parametrize(
    ("solver", "options"),
    [
        ("sparse", 3),
        ("sparse", [("ordering", "natural")]),
        ("sparse", {3: 1}),
        ("sparse", {"ordering": 3}),
        ("sparse", {"ordering": None}),
        ("sparse", {"ordering": np.arange(3)}),
        ("band", {"half_bandwidth": "x"}),
        ("band", {"block_half_bandwidth": 1.5}),
        ("schur", {"eliminate": 3}),
        ("schur", {"eliminate": None}),
        ("schur", {"eliminate": [1.5]}),
        ("schur", {"eliminate": [0, "nodes"]}),
        ("schur", {"reduced": 3}),
        ("schur_pcg", {"tolerance": "x"}),
        ("schur_pcg", {"floor": None}),
        ("schur_pcg", {"iterations": "x"}),
        ("schur_pcg", {"iterations": 2.5}),
        ("schur_pcg", {"formed": np.ones(3)}),
        ("schur_pcg", {"preconditioner": ["jacobi"]}),
    ],
)
def test_options_of_the_wrong_type_are_refused_by_name(solver, options):
    with pytest.raises(AraelError) as caught:
        solve(chain(), solver=solver, solver_options=options)
    assert code_of(caught) == "E0842"
    name = next(iter(options)) if isinstance(options, dict) else "solver_options"
    assert (name if isinstance(name, str) else "solver_options") in str(caught.value)


def test_options_may_be_numbers_of_numpy():
    assert solve(
        chain(), solver="band", solver_options={"block_half_bandwidth": np.int64(11)}
    ).converged
    assert solve(chain(), solver="schur", solver_options={"eliminate": np.array([0, 5])}).converged


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


def test_the_same_settings_give_the_same_configuration_and_bad_ones_never_pass() -> None:
    base = arael.LmConfig()
    assert base.with_(max_iters=1) is base.with_(max_iters=1)
    assert base.with_(max_iters=1) is not base.with_(max_iters=2)
    for bad in (1.0, True):  # equal to 1, and no whole number of attempts
        with pytest.raises(arael.AraelError, match="max_iters"):
            base.with_(max_iters=bad)

    def observe(record: object) -> None: ...

    assert base.with_(observer=observe) is not base.with_(observer=observe)
