"""The solvers that eliminate entities first reach the optimum of the others on whole models."""

from __future__ import annotations

from typing import Any, Literal

import pytest

import arael
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
    """49 cameras and 7776 points; 26 688.5 is where all solvers end, if they are given time."""
    bundle = arael.load("bundle_adjustment")()
    bundle.read(public("bundle_adjustment/problem-49-7776-pre.txt"))
    result = bundle.solve(solver=solver, max_iters=40)
    assert 26688.4 < result.end_cost < 26690
    assert result.plan["eliminated"] == 7776


def test_the_plan_says_what_happened() -> None:
    result = scene("slam").solve(solver="schur_pcg")
    assert result.plan["iterations"] >= result.plan["solves"] > 0
    assert result.plan["preconditioner"] == "cluster"
    assert result.plan["predicted_ms"] > 0
