"""Every linear solver takes the same step."""

from __future__ import annotations

import numpy as np
import pytest

from arael.config import LmConfig
from arael.runtime.problem import Problem
from arael.runtime.solve import minimise
from tests.optional import solvers
from tests.runtime import toys

SOLVERS = ["dense", "band", "lapack_band", "sparse", "schur", "schur_pcg", "cholmod", "auto"]


EXACT = {"schur_pcg": {"tolerance": 1e-13, "floor": 1e-13}}


@pytest.mark.parametrize("name", solvers(SOLVERS))
@pytest.mark.parametrize("loops", [False, True])
@pytest.mark.parametrize("strategy", ["dogleg", "damped"])
def test_same_first_step(name, loops, strategy):
    layout = toys.chain()
    moved = []
    for solver in ("dense", name):
        problem = Problem(layout, toys.chain_store(layout, 25, loops))
        before = problem.x
        config = LmConfig.of(max_iters=1, strategy=strategy)
        minimise(problem, config, problem.make_solver(solver, **EXACT.get(solver, {})))
        moved.append(problem.x - before)
    scale = np.abs(moved[0]).max()
    np.testing.assert_allclose(moved[1], moved[0], rtol=1e-8, atol=1e-8 * scale)


@pytest.mark.parametrize("name", solvers(SOLVERS))
def test_single_precision_reaches_the_same_cost(name):
    layout = toys.chain("f32")
    problem = Problem(layout, toys.chain_store(layout, 25))
    outcome = minimise(problem, LmConfig(), problem.make_solver(name))
    double = toys.chain()
    expected = Problem(double, toys.chain_store(double, 25))
    best = minimise(expected, LmConfig(), expected.make_solver("dense")).end_cost
    assert outcome.end_cost == pytest.approx(best, rel=1e-3)
