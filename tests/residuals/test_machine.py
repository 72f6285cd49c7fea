"""The expression machine against NumPy and against central differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import arael
from arael.analysis.gradients import check_gradients
from arael.runtime.machine import compiled as machine
from arael.runtime.machine.assembling import INSTRUCTIONS
from arael.runtime.machine.tape import PRIMITIVES
from tests.oracle import Oracle

LEAVES = st.sampled_from(["a", "b", "v.x", "v.y", "x", "y", "0.5", "2", "pi"])
SMOOTH = ("sin", "cos", "atan", "tanh", "safe_sqrt")
BINARY = ("+", "-", "*")


def grow(inner: Any) -> Any:
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from(BINARY), inner),
        st.builds("{}({})".format, st.sampled_from(SMOOTH), inner),
        st.builds("({} / (1 + ({})^2))".format, inner, inner),
        st.builds("starship({}, 1.5)".format, inner),
        st.builds("(if {} < {} then {} else {})".format, inner, inner, inner, inner),
        st.builds("max({}, {})".format, inner, inner),
        st.builds("hypot({}, 1 + abs({}))".format, inner, inner),
    )


EXPRESSIONS = st.recursive(LEAVES, grow, max_leaves=12)


def posed(text: str, precision: Any = "f64", rows: int = 70) -> Any:
    rng = np.random.default_rng(1)
    model = arael.runtime_model(precision=precision)
    model.residuals.add(
        f"[{text}, a + b * 0.1 + v.x * 0.2 - x]",
        label="any",
        parameters={"a": 0.7, "b": -1.3, "v": [0.4, 1.9]},
        data={"x": rng.normal(size=rows), "y": rng.normal(size=rows)},
    )
    return model._problem()


@settings(max_examples=60)
@given(EXPRESSIONS)
def test_machine_and_oracle_agree(text: str) -> None:
    problem = posed(text)
    oracle = Oracle(problem)
    for ours, theirs in zip(problem.evaluation.group_rows(0), oracle.rows(0), strict=True):
        scale = np.nanmax(np.abs(theirs), initial=1.0)
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-13 * scale)
    assert problem.cost() == pytest.approx(oracle.cost(), rel=1e-12)
    assert problem.evaluation.linearised()[0] == pytest.approx(oracle.cost(), rel=1e-12)
    for ours, theirs in (
        (problem.gradient(), oracle.gradient()),
        (problem.hessian(), oracle.hessian()),
    ):
        scale = max(1.0, np.abs(theirs).max())
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * scale)


@settings(max_examples=40)
@given(st.recursive(LEAVES, lambda s: st.one_of(
    st.builds("({} {} {})".format, s, st.sampled_from(BINARY), s),
    st.builds("{}({})".format, st.sampled_from(SMOOTH[:4]), s),
    st.builds("({} / (1 + ({})^2))".format, s, s),
    st.builds("starship({}, 1.5)".format, s),
), max_leaves=8))  # fmt: skip
def test_derivatives_by_differences(text: str) -> None:
    for check in check_gradients(posed(text, rows=5)):
        assert check.difference < 1e-4, (text, check)


WRITTEN = {
    "add": "x + y", "sub": "x - y", "mul": "x * y", "div": "x / y", "neg": "-x", "pow": "x^y",
    "lt": "if x < y then 1 else 2", "le": "if x <= y then 1 else 2",
    "eq": "if x == y then 1 else 2", "ne": "if x != y then 1 else 2",
    "and": "if x < y and x > 0 then 1 else 2", "or": "if x < y or x > 0 then 1 else 2",
    "not": "if not x < y then 1 else 2", "select": "if x > 0 then x else y",
}  # fmt: skip


@pytest.mark.sweep(4)
@pytest.mark.parametrize("name", INSTRUCTIONS)
@pytest.mark.parametrize("single", [False, True])
def test_every_operation_on_every_kind_of_number(name: str, single: bool) -> None:
    """Run the operation on parameters, so that nothing is worked out before the machine sees it."""
    arity = PRIMITIVES[name][0]
    arguments = ("p.x", "p.y", "p.z")[:arity]
    text = WRITTEN.get(name, f"{name}({', '.join(arguments)})")
    text = text.replace("x", "p.x").replace("p.p.x", "p.x") if name in WRITTEN else text
    text = text.replace("y", "p.y").replace("p.p.y", "p.y") if name in WRITTEN else text
    model = arael.runtime_model(precision="f32" if single else "f64")
    residual = model.residuals.add(
        f"[{text}, p.x]", label="operation", parameters={"p": [0.5, 0.25, 2]}
    )
    for x, y in ((0.5, 0.25), (-0.5, 2.0), (0.0, 0.0), (1e30, -3.0), (-7.5, 0.5), (2.0, 2.0)):
        residual.parameters["p"] = [x, y, 1.0]
        problem = model._problem()
        expected = Oracle(problem).rows(0)
        found = problem.evaluation.group_rows(0)
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, rtol=3e-6 if single else 1e-14, atol=0)


def test_without_memory_for_registers_a_solve_ends_in_memory_error() -> None:
    x = np.linspace(0, 1, 70)
    model = arael.runtime_model(
        arael.runtime_residual("exp(a * x) - 2", parameters={"a": 0.5}, data={"x": x})
    )
    problem = model._problem()
    machine.limit_workspace(64)
    try:
        for use in (
            model.solve,
            model.cost,
            problem.evaluation.linearised,
            lambda: problem.evaluation.group_rows(0),
            lambda: problem.evaluation.group_cost(0),
        ):
            with pytest.raises(MemoryError, match="no memory for the registers"):
                use()
    finally:
        machine.limit_workspace()
    assert model.solve().status == "converged"
