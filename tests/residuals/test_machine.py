"""The expression machine against the NumPy interpreter and against central differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import arael
from arael.analysis.gradients import check_gradients
from arael.runtime.machine import program
from arael.runtime.machine.assembling import OPERATIONS
from arael.runtime.machine.interpreter import GroupInterpreter
from arael.runtime.machine.tape import PRIMITIVES

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


def interpreted(problem: Any) -> tuple[float, Any, Any]:
    """Cost, J'r and values of J'J by NumPy."""
    gradient, values = problem.evaluation.room()
    total = 0.0
    for number, group in enumerate(problem.layout.groups):
        one = GroupInterpreter(
            group,
            problem.layout.entities,
            problem.instances[number],
            problem.structure.placements[number],
            problem.dtype,
        )
        total += one.linearise(problem.states, gradient, values)
        ours, theirs = problem.evaluation.group_rows(number), one.rows(problem.states)
        for a, b in zip(ours, theirs, strict=True):
            scale = np.nanmax(np.abs(b), initial=1.0)
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-13 * scale)
    return total, gradient[: problem.size], values[: problem.structure.pattern.value_count]


@settings(max_examples=60)
@given(EXPRESSIONS)
def test_machine_and_interpreter_agree(text: str) -> None:
    problem = posed(text)
    total, gradient, values = interpreted(problem)
    cost, ours, blocks = problem.evaluation.linearised()
    assert cost == pytest.approx(total, rel=1e-12)
    assert problem.cost() == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(ours, gradient, rtol=0, atol=1e-12 * max(1, np.abs(gradient).max()))
    np.testing.assert_allclose(blocks, values, rtol=0, atol=1e-12 * max(1, np.abs(values).max()))


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


@pytest.mark.parametrize("name", OPERATIONS)
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
        one = problem.evaluation.interpreters[0]
        with np.errstate(all="ignore"):
            expected = one.rows(problem.states)
        found = problem.evaluation.group_rows(0)
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, rtol=3e-6 if single else 1e-14, atol=0)


def test_without_memory_for_registers_a_solve_ends_in_memory_error() -> None:
    x = np.linspace(0, 1, 70)
    model = arael.runtime_model(
        arael.runtime_residual("exp(a * x) - 2", parameters={"a": 0.5}, data={"x": x})
    )
    problem = model._problem()
    program.limit_workspace(64)
    try:
        for use in (
            model.solve,
            model.cost,
            problem.evaluation.linearised,
            lambda: problem.evaluation.group_rows(0),
            lambda: problem.evaluation.group_cost(0),
        ):
            with pytest.raises(MemoryError, match="registers of runtime residuals"):
                use()
    finally:
        program.limit_workspace()
    assert model.solve().status == "converged"
