"""Problems with rows that hold exactly: those of the benchmark, small."""

from __future__ import annotations

import pytest

import arael
from benchmarks.chapters import SUITES
from benchmarks.constrained import path
from benchmarks.constrained.formulas import Formulas
from benchmarks.constrained.geometry import GEOMETRY
from benchmarks.constrained.infeasible import variants
from benchmarks.constrained.metrology import METROLOGY


@pytest.mark.parametrize("problem", (*GEOMETRY, *METROLOGY), ids=lambda p: p.name)
def test_linkages_chains_and_lines(problem: Formulas) -> None:
    model = arael.loads(problem.text(), name=problem.name, interpret=True)(**problem.data())
    result = model.solve()
    assert result.converged
    assert result.violation <= 1e-9
    assert abs(result.cost - problem.cost) <= problem.tolerance * max(1.0, problem.cost)


@pytest.mark.parametrize("problem, conflict", variants(), ids=lambda p: getattr(p, "name", ""))
def test_what_contradicts_each_other_is_named(problem: Formulas, conflict: frozenset[str]) -> None:
    model = arael.loads(problem.text(), name=problem.name, interpret=True)(**problem.data())
    result = model.solve()
    assert result.status == "infeasible"
    assert {name.removeprefix("Problem.") for name in result.conflict} == conflict


def test_a_path_around_obstacles() -> None:
    model = path.build(arael.loads(path.TEXT, name="path", interpret=True), 40)
    result = model.solve()
    assert result.converged
    assert result.violation <= 1e-9
    required = result.required["Near.clear"]
    assert (required.values >= -1e-8).all()
    assert (required.multipliers >= 0).all()
    assert required.active.any()


def test_it_is_a_suite() -> None:
    assert "constrained" in SUITES
