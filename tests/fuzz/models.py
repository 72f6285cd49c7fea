"""A model's text: check, format, load without kernels, three iterations, gradient, Jacobian."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np

import arael
from arael import io
from arael.diagnostics.records import AraelError
from arael.syntax.files import read_source
from arael.syntax.fmt import format_source
from arael.syntax.parser import parse
from tests.fuzz.filling import scene
from tests.fuzz.verdict import unusable


def warm_up(folder: Path) -> None:
    """Import what the stages import, so that it is not counted as an input's memory."""
    text = "root R { param a: real\n constraint c { a - 1 } }\n"
    examine(text.encode(), "first.arael", random.Random(0), folder)
    np.linalg.svd(np.eye(3))


def examine(content: bytes, name: str, rng: random.Random, folder: Path) -> str:
    """Run all stages on a model; errors are raised."""
    path = folder / name
    path.write_bytes(content)
    loaded: Any = arael.load(path, interpret=True)
    source = read_source(path)
    once = format_source(source)
    again = type(source)(source.name, once)
    assert parse(again) == parse(source), "formatting changes the meaning"
    assert format_source(again) == once, "formatting twice is not formatting once"
    instance = loaded()
    data = folder / "data.json"
    data.write_text(json.dumps(scene(loaded.layout, rng)))
    try:
        io.read(instance, data)
    except AraelError as error:  # a bound or unit vector that random data misses
        return _refused("unfilled", error)
    return numbers(instance)


def numbers(instance: Any) -> str:
    """Three iterations, and the gradient against J'r where they ended."""
    before, layout = "", instance._compiled.layout
    try:
        result = instance.solve(max_iters=3)
    except AraelError as error:
        before = _refused("unsolved", error)
    else:
        before = f"solved {result.status}"
        if result.converged:
            assert np.isfinite(result.end_cost), f"{result.status} with cost {result.end_cost}"
        # Passes pose a problem each; what must hold costs something at first.
        if len(layout.passes) < 2 and result.required is None:
            assert not result.end_cost > result.start_cost * (1 + 1e-5), "the cost rose"
        assert np.isfinite(result.x).all(), "a parameter is not finite"
    try:
        jacobian, gradient, cost = instance.jacobian(), instance.gradient(), instance.cost()
    except AraelError as error:
        return before if before.startswith("unsolved") else _refused("undifferentiated", error)
    residuals, matrix = jacobian.residuals, jacobian.matrix.toarray()
    # The last accepted step may end where a derivative is singular, as that of a norm at 0.
    if not (np.isfinite(residuals).all() and np.isfinite(matrix).all()):
        finite = np.isfinite(residuals).all()
        assert finite or not before.startswith("solved converged"), (
            "converged where residuals are not finite"
        )
        return f"{before}, not finite"
    if np.abs(matrix).max(initial=0) > 1e100 or np.abs(residuals).max(initial=0) > 1e100:
        return f"{before}, huge"
    single = layout.precision == "f32"
    tolerance = 1e-3 if single else 1e-9
    # Residuals near 0 are differences of numbers around 1, the size of the data; where two refs
    # lead to one row, entries cancel.
    problem = instance._problem()
    groups = [k for k, active in enumerate(problem.structure.active) if len(active)]
    entries = [np.abs(problem.evaluation.group_rows(k)[1]).max(initial=0) for k in groups]
    size = len(residuals) * max(entries, default=0) * (1 + np.abs(residuals).max(initial=0))
    if single and size > 1e30:
        return f"{before}, huge"
    wrong = np.abs(gradient - 2 * matrix.T @ residuals) > tolerance * size + 1e-290
    assert not wrong.any(), f"the gradient is not 2 J'r: {np.flatnonzero(wrong)}"
    off = abs(cost - residuals @ residuals)
    assert off <= tolerance * (cost + 1e-6), f"the cost is not r'r: {cost}, off by {off}"
    return before


def _refused(stage: str, error: AraelError) -> str:
    why = unusable(error)
    assert not why, f"{stage}: {why}"
    return f"{stage} {error.diagnostics[0].code}"
