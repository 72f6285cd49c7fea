"""Programs of the expression machine: tapes on arrays, whole models, threads, memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.assembly import shares
from arael.runtime.machine import compiled as program
from arael.runtime.machine.programs import evaluate, group_program
from arael.runtime.machine.tape import Tape
from arael.runtime.problem import Problem
from arael.scenes import SceneConfig, columns, fill, make_scene
from arael.symbolic.graph import Graph
from tests import oracle


def tape() -> Tape:
    """sin(x) y + 3, x, 3."""
    g = Graph()
    x, y = g.input("x"), g.input("y")
    three = g.const(3.0)
    return g.tape([g.op("add", g.op("mul", g.op("sin", x), y), three), x, three])


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(
    ("x", "y"),
    [
        (0.5, 2.0),
        (np.linspace(-1, 1, 70), 2.0),
        (np.linspace(-1, 1, 140)[::2], np.arange(70)),
        (np.zeros((3, 1)), np.arange(4.0)),
        (np.zeros(0), 1.0),
        (np.zeros(1), np.arange(40)),
    ],
    ids=["numbers", "column", "strided", "broadcast", "empty", "single row"],
)
def test_a_tape_on_arrays_of_any_shape(x: Any, y: Any, dtype: Any) -> None:
    found = evaluate(tape(), [x, y], dtype)
    shape = np.broadcast_shapes(np.shape(x), np.shape(y))
    values = oracle.evaluate(tape(), [np.asarray(x, dtype), np.asarray(y, dtype)], dtype)
    for one, node in zip(found, tape().outputs, strict=True):
        assert one.shape == shape
        assert one.dtype == dtype
        np.testing.assert_allclose(
            one, np.broadcast_to(values[node], shape), rtol=1e-6 if dtype == np.float32 else 1e-15
        )


def test_arrays_that_do_not_broadcast_are_refused() -> None:
    with pytest.raises(ValueError, match="broadcast"):
        evaluate(tape(), [np.zeros(3), np.zeros(4)])


def test_without_memory_a_tape_is_a_memory_error() -> None:
    program.limit_workspace(64)
    try:
        with pytest.raises(MemoryError, match="registers of a formula"):
            evaluate(tape(), [np.zeros(3), 1.0])
    finally:
        program.limit_workspace(None)


def slam(precision: str, interpret: bool) -> Any:
    scene = make_scene(SceneConfig(poses=8, seed=3))
    model = arael.load("slam", precision=precision, interpret=interpret)  # type: ignore[call-overload]
    instance = model()
    fill(instance, model.layout, columns(scene, "slam"))
    return instance


def problem_without_kernels(precision: str = "f64") -> Problem:
    store = slam(precision, True)._store
    return Problem(store.layout, store)


@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-11), ("f32", 3e-4)])
def test_slam_without_a_compiler_is_what_numpy_computes(precision: str, tolerance: float) -> None:
    problem = problem_without_kernels(precision)
    reference = oracle.Oracle(problem)
    step = 1e-3 * np.random.default_rng(2).normal(size=problem.size)
    problem.evaluation.moved_by(step.astype(problem.dtype))
    reference.moved_by(step.astype(problem.dtype))
    for found, expected in zip(problem.states, reference.states, strict=True):
        np.testing.assert_allclose(found[: len(expected)], expected, atol=tolerance)
    assert problem.cost() == pytest.approx(reference.cost(), rel=tolerance)
    gradient, hessian = reference.linearised()
    free = problem.free
    for found, expected in (
        (problem.gradient(), 2 * gradient[free]),
        (problem.hessian(), 2 * hessian[np.ix_(free, free)]),
    ):
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale)


def test_threads_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shares, "GRAIN", 1.0)
    monkeypatch.setattr(shares, "_ROOM", 100.0)
    problem = problem_without_kernels()
    assert problem.evaluation.shares > 1
    found = []
    for threads in (1, 3):
        problem.evaluation.threads = threads
        cost, gradient, values = problem.evaluation.linearised()
        found.append((cost, problem.cost(), gradient.copy(), values.copy()))
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


def test_components_are_solved_without_a_compiler(tmp_path: Path) -> None:
    """Costs of instances decide by component."""
    path = tmp_path / "many.arael"
    path.write_text(
        "struct P { param a: real = 1\n x: real\n constraint c { exp(a) - x } }\n"
        "root R { ps: list of P }\n"
    )
    solved = []
    for interpret in (False, True):
        model = arael.load(path, interpret=interpret)()
        model.ps.extend(x=np.linspace(0.5, 9, 70))
        solved.append((model.solve().iterations, model.ps.a.value.copy()))
    np.testing.assert_allclose(solved[0][1], np.log(np.linspace(0.5, 9, 70)), atol=1e-6)
    np.testing.assert_allclose(solved[1][1], solved[0][1], rtol=1e-12)
    assert solved[0][0] == solved[1][0]


def test_a_program_is_assembled_once() -> None:
    layout = arael.load("slam", interpret=True).layout
    assert group_program(layout, layout.groups[0]) is group_program(layout, layout.groups[0])
