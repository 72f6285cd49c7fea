"""The verbose trace, to the letter; times are masked."""

from __future__ import annotations

import re

import numpy as np
import pytest

from arael.config import LmConfig
from arael.runtime.levenberg.trace import shown_cost, shown_lambda
from arael.runtime.linear.compiled import DenseSolver
from arael.runtime.problem import Problem
from arael.runtime.solve import minimise
from tests.runtime import toy, toys


def traced(layout, store, **settings) -> list[str]:
    problem = Problem(layout, store)
    lines: list[str] = []
    linear = DenseSolver(problem.structure.pattern, False)
    minimise(problem, LmConfig.of(**settings), linear, lines.append)
    return [re.sub(r"step=\d+", "step=*", line) for line in "\n".join(lines).split("\n")]


def test_attempts_of_a_solve_by_the_reference():
    layout = toys.rosenbrock()
    assert traced(layout, toys.at(layout, -1.2, 1.0), damping="ladder", max_iters=5) == [
        "1/0: 24.2000->1543.0091 / -1518.8091, lambda=1e-4 (step=*)",
        "1/1: 24.2000->132.4133 / -108.2133, lambda=0.001 (step=*)",
        "1/2: 24.2000->4.1968 / 20.0032, lambda=0.01 (step=*)",
        "2/0: 4.1968->44.7610 / -40.5642, lambda=0.002 (step=*)",
        "2/1: 4.1968->3.2491 / 0.9478, lambda=0.02 (step=*)",
    ]


def test_attempts_of_a_dogleg_say_the_radius():
    layout = toys.rosenbrock()
    lines = traced(layout, toys.at(layout, -1.2, 1.0), max_iters=3)
    assert lines == [
        "1/0: 24.2000->95.4584 / -71.2584, radius=31 (step=*)",
        "1/1: 24.2000->4.3313 / 19.8687, radius=7.6 (step=*)",
        "2/0: 4.3313->9.3085 / -4.9773, radius=15 (step=*)",
    ]


def test_more_regularisation_than_the_least_is_shown_beside_the_radius():
    layout = toys.root_only(2, lambda x: [x[0] + x[1] - 3.0])
    lines = traced(
        layout, toys.at(layout, 1.0, 0.5), strategy="dogleg", lambda_floor=0.0, max_iters=2
    )
    assert lines[:2] == [
        "1/0: Cholesky failed (damped matrix not positive-definite), lambda=0 -> 1e-15 (step=*) "
        "[non-finite: grad=0 diag=0 x=0 matrix=0] [diag<=0: 0]",
        "    pivot not positive at `x.y`",
    ]
    assert lines[2].startswith("1/1: 2.2500->")
    assert lines[2].endswith(", radius=1.1 lambda=1e-15 (step=*)")


def test_failed_factorisation_names_who_is_to_blame():
    """Where x falls to 1 or below, nothing depends on y any more."""
    layout = toys.root_only(
        2, lambda x: [x[0] * 1.0, toy.where_at_most(x[0], 1.0, x[0] * 0.0, x[1] * 0.1)]
    )
    lines = traced(layout, toys.at(layout, 3.0, 1.0), damping="ladder", max_iters=2)
    assert lines[1:] == [
        "2/0: Cholesky failed (damped matrix not positive-definite), lambda=2e-5 -> 2e-4 (step=*) "
        "[non-finite: grad=0 diag=0 x=0 matrix=0] [diag<=0: 1]",
        "    diagonal <= 0 of `x.y`",
    ]


UNDAMPED = {
    "initial_lambda": 0.0,
    "lambda_floor": 0.0,
    "damping": "ladder",
    "ending": "small_steps",
    "min_iters": 5,
    "max_iters": 3,
}


def test_non_finite_derivative_on_the_way_is_counted_and_named():
    layout = toys.root_only(1, lambda x: [toy.sqrt(x[0] * x[0]) - 0.0])
    lines = traced(layout, toys.at(layout, 1.0), **UNDAMPED)
    assert lines[0].startswith("1/0: 1.0000->0.0000 / 1.0000, lambda=0 ")
    assert "[non-finite: grad=1 diag=1 x=0 matrix=1]" in lines[1]
    assert lines[2:4] == [
        "    non-finite derivative in Toy.all[0]",
        "    non-finite gradient of `x`",
    ]


def test_verbose_goes_to_stderr(capsys):
    layout = toys.rosenbrock()
    problem = Problem(layout, toys.at(layout, -1.2, 1.0))
    linear = DenseSolver(problem.structure.pattern, False)
    minimise(problem, LmConfig.reference(verbose=True, max_iters=1), linear)
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.startswith("1/0: 24.2000->1543.0091 / -1518.8091, lambda=1e-4 (step=")


@pytest.mark.parametrize(
    "cost, text",
    [
        (44.56789, "44.5679"),
        (0.0276, "0.0276"),
        (0.0, "0.0000"),
        (1.30214e-7, "1.3021e-7"),
        (-1518.8091, "-1518.8091"),
        (2.5e12, "2.5000e12"),
        (np.nan, "nan"),
    ],
)
def test_costs_read_well(cost, text):
    assert shown_cost(cost) == text


@pytest.mark.parametrize(
    "damping, text",
    [
        (2e-5, "2e-5"),
        (1.6e-7, "1.6e-7"),
        (0.01, "0.01"),
        (1e-4, "1e-4"),
        (6.4, "6.4"),
        (1e12, "1e12"),
    ],
)
def test_lambda_reads_as_in_the_reference(damping, text):
    assert shown_lambda(damping) == text
