"""The solvers that eliminate entities first reach the optimum of the others on whole models."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.scenes.columns import columns
from arael.scenes.config import benchmark_config
from arael.scenes.fill import fill
from arael.scenes.scene import make_scene
from tests.public_data import public

SOLVERS = [
    ("auto", {}),
    ("schur", {}),
    ("schur", {"reduced": "sparse"}),
    ("schur_pcg", {}),
    ("schur_pcg", {"formed": False, "preconditioner": "tridiagonal"}),
]


def scene(name: Literal["slam", "localization"]) -> Any:
    """A benchmark scene of 20 poses in the standard model `name`."""
    model = arael.load(name)
    instance = model()
    fill(instance, model.layout, columns(make_scene(benchmark_config(poses=20)), name))
    return instance


@pytest.mark.parametrize(("solver", "options"), SOLVERS)
@pytest.mark.parametrize("model", ["slam", "localization"])
def test_scene(
    model: Literal["slam", "localization"], solver: str, options: dict[str, Any]
) -> None:
    expected = scene(model).solve(solver="dense", rel_precision=1e-9)
    result = scene(model).solve(solver=solver, solver_options=options, rel_precision=1e-9)
    assert result.status == expected.status == "converged"
    assert result.end_cost == pytest.approx(expected.end_cost, rel=1e-6)


@pytest.mark.parametrize("solver", ["auto", "schur", "schur_pcg"])
def test_bundle(solver: str) -> None:
    """49 cameras and 7776 points; 26 688.5 is where all solvers end."""
    bundle = arael.load("bundle_adjustment")()
    bundle.read(public("bundle_adjustment/problem-49-7776-pre.txt"))
    result = bundle.solve(solver=solver)
    assert result.status == "converged" and result.iterations < 100
    assert 26688.4 < result.end_cost < 26688.6
    assert result.plan["eliminated"] == 7776


def test_approximate_steps_are_damped_by_the_ladder() -> None:
    """The dogleg relies on the Gauss-Newton step, which conjugate gradients stop short of."""
    history = scene("slam").solve(solver="schur_pcg").history
    assert np.isnan(history["radius"]).all()
    first, second = history["damping"][:2]
    assert second == pytest.approx(first * (0.2 if history["accepted"][0] else 10))
    asked = scene("slam").solve(solver="schur_pcg", strategy="dogleg").history
    assert np.isfinite(asked["radius"]).all()


def test_the_plan_says_what_happened() -> None:
    result = scene("slam").solve(solver="schur_pcg")
    assert result.plan["iterations"] >= result.plan["solves"] > 0
    assert result.plan["preconditioner"] == "cluster"
    assert result.plan["predicted_ms"] > 0


@pytest.mark.parametrize("named", ["landmarks", ["landmarks"]])
def test_collections_are_eliminated_by_name(named: Any) -> None:
    model = scene("slam")
    result = model.solve(solver="schur", solver_options={"eliminate": named}, max_iters=1)
    assert result.plan["eliminated"] == len(model.landmarks)


def test_eliminating_poses_by_name_says_who_is_coupled() -> None:
    with pytest.raises(AraelError) as caught:
        scene("slam").solve(solver="schur", solver_options={"eliminate": "poses"})
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E0842"
    assert "poses[0]." in diagnostic.message and "poses[1]." in diagnostic.message


def test_unknown_collection() -> None:
    with pytest.raises(AraelError) as caught:
        scene("slam").solve(solver="schur", solver_options={"eliminate": "landmark"})
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "E0842"
    assert diagnostic.help == ("did you mean `landmarks`?",)


def test_single_precision_reaches_the_same_optimum() -> None:
    costs = {}
    for precision in ("f32", "f64"):
        model = arael.load("slam", precision=precision)
        instance = model()
        fill(instance, model.layout, columns(make_scene(benchmark_config(poses=20))))
        costs[precision] = instance.solve(solver="schur").end_cost
    assert np.isclose(costs["f32"], costs["f64"], rtol=1e-3)
