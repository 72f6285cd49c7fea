"""Generated kernels and the expression machine against NumPy and against central differences."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from arael.loading import load
from arael.model import Model
from arael.runtime.assembly.positions import dense_matrix
from arael.runtime.problem import Problem
from tests.compiler.random_models import RandomModel, fill, models
from tests.oracle import Oracle

# Relative to the largest entry of the array at hand.
KERNEL_TOLERANCE = 1e-12
DIFFERENCE_TOLERANCE = 1e-6


def problems(model: Model) -> tuple[Problem, Problem]:
    """The same instance on kernels and on the expression machine."""
    compiled = type(model).compiled  # type: ignore[attr-defined]
    assert compiled.kernels is not None
    store = model._store
    return Problem(compiled.layout, store, compiled.kernels), Problem(compiled.layout, store)


def assert_close(found: Any, expected: Any, tolerance: float) -> None:
    scale = max(float(np.max(np.abs(expected), initial=0.0)), 1e-300)
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale)


def check_against_oracle(model: Model, tolerance: float = KERNEL_TOLERANCE) -> None:
    """Kernels and machine: states, residuals, J, J'r, J'J, cost, at the start and after a step."""
    for problem in problems(model):
        oracle = Oracle(problem)
        step = 0.1 * np.random.default_rng(5).normal(size=problem.size)
        for moves in range(2):
            if moves:
                problem.evaluation.moved_by(step)
                oracle.moved_by(step)
            for found, expected in zip(problem.states, oracle.states, strict=True):
                assert_close(found[: len(expected)], expected, tolerance)
            for number in range(len(problem.layout.groups)):
                np.testing.assert_array_equal(
                    problem.evaluation.acting(number), oracle.acting(number)
                )
                rows = problem.evaluation.group_rows(number)
                for found, expected in zip(rows, oracle.rows(number), strict=True):
                    assert_close(found, expected, tolerance)
            assert problem.cost() == pytest.approx(oracle.cost(), rel=10 * tolerance)
            cost = problem.evaluation.linearised()[0]
            assert cost == pytest.approx(problem.cost(), rel=10 * tolerance)
            assert_close(problem.gradient(), oracle.gradient(), tolerance)
            assert_close(problem.hessian(), oracle.hessian(), tolerance)
            check_in_used_workspace(problem, oracle, tolerance)


def check_in_used_workspace(problem: Problem, oracle: Oracle, tolerance: float) -> None:
    """Nothing is left of what the arrays held, though some of it is stored over, not emptied."""
    workspace = problem.evaluation.workspace()
    for array in workspace:
        array[:] = np.nan
    _, gradient, values = problem.evaluation.linearised(workspace)
    free = problem.free
    assert_close(2 * np.asarray(gradient)[free], oracle.gradient(), tolerance)
    found = 2 * dense_matrix(problem.structure.pattern, values)[np.ix_(free, free)]
    assert_close(found, oracle.hessian(), tolerance)


def check_against_differences(model: Model) -> None:
    """Every column of the Jacobian, and the gradient with it, by central differences."""
    compiled, _ = problems(model)
    layout, h = compiled.layout, 1e-5
    base = [np.array(state) for state in compiled.states]

    def residuals(step: np.ndarray) -> list[np.ndarray]:
        for state, saved in zip(compiled.states, base, strict=True):
            state[...] = saved
        compiled.evaluation.moved_by(step)
        return [compiled.evaluation.group_rows(g)[0] for g in range(len(layout.groups))]

    start = [compiled.evaluation.group_rows(g) for g in range(len(layout.groups))]
    derived = []
    for number, group in enumerate(layout.groups):
        placement = compiled.structure.placements[number]
        entries = start[number][1]
        dense = np.zeros((*start[number][0].shape, compiled.size + compiled.structure.trash))
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            at = placement.gradient_at[:, use] + tangent
            np.add.at(dense[:, residual], (np.arange(len(at)), at), entries[:, k])
        derived.append(dense)
    for scalar in range(compiled.size):
        step = np.zeros(compiled.size)
        step[scalar] = h
        ahead, behind = residuals(step), residuals(-step)
        for number, (dense, group) in enumerate(zip(derived, layout.groups, strict=True)):
            right, left = ahead[number], behind[number]
            if group.loss_text and group.residuals > 1:
                # Only the gradient of several residuals with a loss is a derivative.
                right, left = (
                    np.square(side).sum(axis=1, keepdims=True) / 2 for side in (right, left)
                )
                dense = np.einsum("nr,nrx->nx", start[number][0], dense)[:, None]
            difference = (right - left) / (2 * h)
            scale = max(1.0, float(np.max(np.abs(dense), initial=0.0)))
            np.testing.assert_allclose(
                dense[..., scalar], difference, rtol=0, atol=DIFFERENCE_TOLERANCE * scale
            )


SUPPRESSED = [HealthCheck.too_slow, HealthCheck.data_too_large]


@settings(max_examples=1, suppress_health_check=SUPPRESSED)
@given(drawn=models())
def test_a_random_model(drawn: RandomModel, tmp_path_factory: pytest.TempPathFactory) -> None:
    check_random_model(drawn, tmp_path_factory)


@pytest.mark.slow(reason="compiles five large models")
@settings(max_examples=5, suppress_health_check=SUPPRESSED)
@given(drawn=models())
def test_random_models(drawn: RandomModel, tmp_path_factory: pytest.TempPathFactory) -> None:
    check_random_model(drawn, tmp_path_factory)


def check_random_model(drawn: RandomModel, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("random") / "random.arael"
    path.write_text(drawn.text)
    model = load(path)()
    fill(model, drawn.seed)
    check_against_oracle(model)
    check_against_differences(model)


def test_random_model_in_single_precision(tmp_path: Path) -> None:
    drawn = RandomModel(
        HEAD_OF_ONE + "\nroot R : f32 { param a: vec3; data: list of D\n"
        "    fit data as e { [sin(a.x * e.x) + a.y, atan2(a.z + 3, 2 + cos(a.y)) * e.x] }\n}\n",
        3,
    )
    path = tmp_path / "single.arael"
    path.write_text(drawn.text)
    model = load(path)()
    model.data.extend(x=np.linspace(-1, 1, 37))
    model.a.value[...] = [0.3, -0.2, 0.9]
    check_against_oracle(model, 2e-6)


HEAD_OF_ONE = "struct D { x: real }"


@pytest.mark.slow
def test_products_by_loops_agree_with_products_spelled_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (
        "struct N { param p: vec<9> }\n"
        "struct E { a: ref N in root.n; b: ref N in root.n; k: vec<9>\n"
        "    constraint c { a.p .* b.p - k }\n}\nroot R { n: list of N; e: list of E }\n"
    )
    found = []
    for limit in (0, 10**9):
        monkeypatch.setattr("arael.compiler.products.UNROLLED_PRODUCTS", limit)
        monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / f"cache{limit}"))
        path = tmp_path / f"m{limit}.arael"
        path.write_text(text)
        model = load(path)()
        rng = np.random.default_rng(1)
        model.n.extend(p=rng.normal(size=(4, 9)))
        for i in range(11):
            model.e.append(a=model.n[i % 4], b=model.n[(i * i) % 4], k=rng.normal(size=9))
        check_against_oracle(model)
        found.append(problems(model)[0].hessian())
        source = next((tmp_path / f"cache{limit}").rglob("*.pyx")).read_text()
        assert ("add_products(" in source) == (limit == 0)
    assert_close(found[0], found[1], 1e-13)


def test_nan_survives_into_the_kernel(tmp_path: Path) -> None:
    path = tmp_path / "nan.arael"
    path.write_text(
        "struct D { x: real }\nroot R { param a: real; data: list of D\n"
        "    fit data as e { max(sqrt(a * e.x), 0.5) }\n}\n"
    )
    model = load(path)()
    model.a.value = -1.0
    model.data.extend(x=[1.0, -4.0])
    compiled, interpreted = problems(model)
    for problem in (compiled, interpreted):
        residuals = problem.evaluation.group_rows(0)[0].ravel()
        assert np.isnan(residuals[0])
        assert residuals[1] == pytest.approx(2)
        assert np.isnan(problem.cost())
