"""The elimination of a part against dense linear algebra."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.compiled_model import CompiledModel
from arael.distributed.parts.requests import PartRecipe, made, name_here
from arael.distributed.parts.solve import prepare
from arael.runtime.assembly.positions import dense_matrix

from .problems import PROBLEMS, arrays_of


def first_part(name: str, parts: int) -> Any:
    model: Any = PROBLEMS[name]()
    compiled: CompiledModel = model._compiled
    prepared = prepare(compiled, arrays_of(model), parts, None)
    recipe = PartRecipe("r", 0, name_here(compiled), prepared.shares[0], None, prepared.arrays[0])
    return made(recipe)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_reduced_system_is_the_schur_complement(name: str) -> None:
    part = first_part(name, 3)
    rng = np.random.default_rng(0)
    _, gradient, diagonal = part.linearise()
    i, b = part.interior, part.boundary
    h = dense_matrix(part.structure.pattern, part._values)
    damped = diagonal[i] * (1 + 1e-3 * rng.random(len(i)))
    h[i, i] = damped
    right = -gradient[i]
    assert part.eliminate(damped, right) == 0
    added = part.swept()
    inner = np.linalg.solve(h[np.ix_(i, i)], np.column_stack((h[np.ix_(i, b)], right)))
    schur = h[np.ix_(b, b)] - h[np.ix_(b, i)] @ inner[:, :-1]
    scale = np.abs(h[b, b]).max(initial=1)
    np.testing.assert_allclose(part.complement(), schur, rtol=0, atol=1e-11 * scale)
    swept = -h[np.ix_(b, i)] @ inner[:, -1]
    np.testing.assert_allclose(added, swept, atol=1e-9 * np.abs(swept).max(initial=1e-9))
    x = rng.normal(size=len(b))
    expected = np.linalg.solve(h[np.ix_(i, i)], right - h[np.ix_(i, b)] @ x)
    found = part.substituted(x)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
    # Another right-hand side with the same factor.
    part.sweep(2 * right)
    np.testing.assert_allclose(part.swept(), 2 * added, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        part.substituted(2 * x), 2 * found, rtol=1e-9, atol=1e-12 * np.abs(expected).max()
    )


def test_a_part_that_fixes_nothing_has_a_singular_complement() -> None:
    # The last part of the loop has relative measurements only: moving it whole costs nothing.
    model: Any = PROBLEMS["loop"]()
    prepared = prepare(model._compiled, arrays_of(model), 3, None)
    share = prepared.shares[2]
    part = made(PartRecipe("r", 0, name_here(model._compiled), share, None, prepared.arrays[2]))
    _, _, diagonal = part.linearise()
    assert part.eliminate(diagonal[part.interior], np.zeros(len(part.interior))) == 0
    matrix = part.complement()
    values = np.linalg.eigvalsh(matrix)
    assert values[2] < 1e-9 * values[-1]
    assert values[0] > -1e-9 * values[-1]


def test_a_failed_pivot_is_reported() -> None:
    part = first_part("grid", 3)
    _, _, diagonal = part.linearise()
    damped = diagonal[part.interior]
    damped[4] = -1
    assert part.eliminate(damped, np.zeros(len(damped))) == 1 + part.interior[4]
