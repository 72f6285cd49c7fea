"""What must hold, given at run time as text or by a function."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError


def fit() -> arael.Model:
    return arael.runtime_model(
        arael.runtime_residual("[a - 3, b - 4]", label="near", parameters={"a": 1, "b": 1})
    )


def test_comparisons_hold() -> None:
    model = fit()
    model.residuals.add("hypot(a, b) == 1", label="circle")
    model.residuals.add("0 <= a <= 0.5", label="box")
    result = model.solve()
    assert result.converged
    parameters = model.residuals["near"].parameters
    assert parameters["a"] == pytest.approx(0.5, abs=1e-12)
    assert parameters["b"] == pytest.approx(np.sqrt(0.75), rel=1e-12)
    assert set(model.cost_table()) == {"near"}
    assert result.multipliers["box"].shape == (1, 2)
    copied = model.copy()
    assert copied.solve().cost == pytest.approx(result.cost)
    model.residuals.remove("circle")
    model.residuals["box"].text = "a == 0"
    assert model.solve().converged
    assert parameters["b"] == pytest.approx(4)


def test_what_must_hold_takes_no_loss() -> None:
    with pytest.raises(AraelError, match="E0760"):
        fit().residuals.add("a == 1", loss="huber(1)")


@pytest.mark.parametrize("kind", ["equal", "at_least"])
def test_functions_hold(kind: str) -> None:
    model = arael.loads(
        "root R { param x: vec2; constraint near { x - [0.3, 0.4] } }", interpret=True
    )(x=[1, 0.1])
    model.add_residuals(
        lambda x: (x**2).sum(-1, keepdims=True) - 4, [model.x], kind=kind, name="circle"
    )
    result = model.solve()
    assert result.converged
    assert model.x.value == pytest.approx([1.2, 1.6], rel=1e-7)
    copied = model.residuals.code["circle"].kind
    assert copied == kind


def test_kinds_and_losses_are_checked() -> None:
    model = arael.loads("root R { param x: vec2; constraint near { x } }", interpret=True)(x=[1, 1])
    with pytest.raises(AraelError, match="`kind` is"):
        model.add_residuals(lambda x: x, [model.x], 2, kind="exact")
    with pytest.raises(AraelError, match="takes no loss"):
        model.add_residuals(lambda x: x, [model.x], 2, kind="equal", loss="huber(1)")
