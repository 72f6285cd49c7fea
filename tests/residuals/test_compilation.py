"""Runtime residuals on compiled kernels: the same numbers as on the expression machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.analysis.gradients import check_gradients
from arael.compiler import build, cache
from arael.diagnostics.records import AraelError
from arael.residuals import compilation
from tests.residuals.test_against_compiled import RUNTIME, files, in_bulk

__all__ = ["files"]


@pytest.fixture(scope="module")
def part(files: list[Path]) -> dict[str, type]:
    """The model that lacks constraints, in both precisions."""
    return {p: arael.load(files[1], precision=p) for p in ("f64", "f32")}  # type: ignore[arg-type]


def numbers(model: Any) -> list[np.ndarray]:
    rows = [model.residuals[label].residuals for label in model.residuals]
    return [np.array([model.cost()]), model.gradient(), model.hessian(), *rows]


@pytest.mark.sweep(2)
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_same_numbers(part: dict[str, type], precision: str) -> None:
    model = in_bulk(part[precision])
    model.residuals["seen"].loss = "cauchy(2)"
    machine = numbers(model)
    assert not any(one.compiled for one in model.residuals.values())
    model.residuals.compile()
    assert all(one.compiled for one in model.residuals.values())
    tolerance = 1e-12 if precision == "f64" else 1e-5
    for a, b in zip(numbers(model), machine, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * np.abs(b).max())
    if precision == "f64":
        for check in check_gradients(model._problem()):
            assert check.agrees, check


def test_same_solution_and_labels(part: dict[str, type]) -> None:
    models = [in_bulk(part["f64"]) for _ in range(2)]
    models[0].residuals.compile("far", models[0].residuals["chain"])
    assert [models[0].residuals[k].compiled for k in RUNTIME] == [
        k in ("far", "chain") for k in RUNTIME
    ]
    results = [m.solve(abs_precision=0, rel_precision=0, max_iters=8) for m in models]
    assert results[0].end_cost == pytest.approx(results[1].end_cost, rel=1e-10)
    np.testing.assert_allclose(
        models[0].poses.pos.value, models[1].poses.pos.value, rtol=0, atol=1e-9
    )
    assert list(models[0].cost_table()) == list(models[1].cost_table())
    np.testing.assert_allclose(
        models[0].covariance().matrix, models[1].covariance().matrix, rtol=1e-6, atol=1e-9
    )


def fit(count: int = 1) -> Any:
    model = arael.runtime_model()
    x = np.linspace(0, 2, 37)
    for k in range(count):
        model.residuals.add(
            f"p{k} * exp(-x) + q{k}[0] * sin(c * x) - q{k}[1]",
            label=f"fit{k}",
            parameters={f"p{k}": 1.0 + k, f"q{k}": [0.3, 0.1]},
            data={"x": x, "c": 1.0 + 0.1 * k},
        )
    return model


def test_data_and_parameters_change_without_compiling_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model, machine = fit(), fit()
    model.residuals["fit0"].compile()
    built: list[Any] = []
    monkeypatch.setattr(build, "compile_c", lambda *a: built.append(a))
    for one in (model, machine):
        one.residuals["fit0"].set_data(c=2.5)
        one.residuals["fit0"].parameters["q0"] = [1.0, 2.0]
        one.solve()
        one.residuals["fit0"].set_data(x=np.linspace(0, 3, 5))
        one.solve()
    assert model.residuals["fit0"].compiled
    assert model.residuals.parameters["p0"] == pytest.approx(machine.residuals.parameters["p0"])
    assert not built


def test_a_new_text_goes_back_to_the_machine() -> None:
    model = fit(2)
    model.residuals.define("half", "c / 2", data={"c": 1})
    model.residuals["fit1"].text = "p1 * half - x"
    model.residuals.compile()
    model.residuals["fit0"].text = "p0 - x + q0[0] * q0[1]"
    assert [model.residuals[k].compiled for k in model.residuals] == [False, True]
    model.residuals.definitions["half"].text = "c / 4"
    assert not model.residuals["fit1"].compiled
    expected = ((1 + 1) / 4 - np.linspace(0, 2, 37)) ** 2
    assert model.residuals["fit1"].cost == pytest.approx(expected.sum())


def test_residuals_of_one_form_share_a_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    model = fit(6)
    before = numbers(model)
    seen: list[int] = []
    emit = compilation.emit

    def counted(program: Any, *args: Any, **more: Any) -> str:
        seen.append(len(program.kernels))
        return emit(program, *args, **more)

    monkeypatch.setattr(compilation, "emit", counted)
    model.residuals.compile()
    # Each brings parameters of its own along, which are entities of one shape.
    assert seen == [1]
    for a, b in zip(numbers(model), before, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * np.abs(b).max())


def test_compiled_once_for_all_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    fit().residuals.compile()
    names = [manifest.name for _, manifest, _ in cache.entries()]
    assert "runtime_residuals" in names
    monkeypatch.setattr(build, "find_compiler", lambda: None)
    model = fit()
    model.residuals.compile()  # found in the cache
    assert model.residuals["fit0"].compiled


def test_without_a_compiler_residuals_run_on(monkeypatch: pytest.MonkeyPatch) -> None:
    model = fit()
    model.residuals["fit0"].text = "p0 * 1.25 - x + q0[0] + q0[1] * 7.125"
    monkeypatch.setattr(build, "find_compiler", lambda: None)
    with pytest.raises(AraelError, match="E0801"):
        model.residuals.compile()
    assert not model.residuals["fit0"].compiled
    assert model.solve().converged


def test_who_is_not_there() -> None:
    model = fit()
    with pytest.raises(AraelError, match="no runtime residual or expression `fit1`"):
        model.residuals.compile("fit1")
    with pytest.raises(AraelError, match="E0763"):
        arael.runtime_residual("a", parameters={"a": 1}).compile()
    arael.runtime_model().residuals.compile()
