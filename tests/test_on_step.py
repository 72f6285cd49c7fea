"""The function that a solve calls after each accepted step, with a model of the values then."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

VALLEY = """
root Valley {
    param at: vec2 = [-1, 1.5]
    constraint valley { [10 * (at.y - at.x^2), 1 - at.x] }
}
"""
APART = """
struct Valley {
    param at: vec2
    constraint valley { [10 * (at.y - at.x^2), 1 - at.x] }
}
root Valleys { valleys: list of Valley }
"""
LINKED = """
root Linked {
    param a: real = 3
    param b: real = 0
    constraint drift { a - 2 }
    constraint bent { b^3 + b - a.value }
}
"""


def test_the_model_has_the_values_of_each_accepted_step() -> None:
    model = arael.loads(VALLEY, interpret=True)()
    seen: list[tuple[float, float]] = []

    def look(now: Any, record: Any) -> None:
        assert now is not model
        seen.append((now.cost(), float(record["trial_cost"])))
        np.testing.assert_array_equal(model.at.value, [-1, 1.5])

    result = model.solve(on_step=look)
    assert len(seen) == result.accepted_iterations < result.iterations
    np.testing.assert_allclose(*np.transpose(seen), rtol=1e-9, atol=1e-20)


def test_values_that_constraints_read_stay_those_of_the_start() -> None:
    """`a.value` is 3 throughout: a solve that is looked at finds the same."""
    alone, seen = (arael.loads(LINKED, interpret=True)() for _ in range(2))
    at: list[float] = []
    alone.solve()
    seen.solve(on_step=lambda now, _: at.append(float(now.b.value)))
    assert seen.b.value == alone.b.value == at[-1]
    assert alone.b.value**3 + alone.b.value == pytest.approx(3.0)


def test_parts_that_are_solved_apart_are_all_there() -> None:
    model = arael.loads(APART, interpret=True)()
    model.valleys.extend(at=[[-1, 1.5], [0.5, 0.5], [2, 2]])
    costs: list[tuple[float, float]] = []
    result = model.solve(on_step=lambda now, _: costs.append(now.cost()))
    assert result.components is not None and len(result.components) == 3
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] == pytest.approx(0, abs=1e-20)


def test_what_must_hold_exactly_and_what_is_frozen() -> None:
    text = VALLEY.replace("[-1, 1.5]", "[-1, 1.5]\n    require circle { at.x^2 + at.y^2 == 1 }")
    found = arael.loads(text, interpret=True)()
    places: list[Any] = []
    found.solve(on_step=lambda now, _: places.append(np.array(now.at.value)))
    np.testing.assert_allclose(places[-1], found.at.value, rtol=1e-9)
    assert np.linalg.norm(places[-1]) == pytest.approx(1)
    linked = arael.loads(LINKED, interpret=True)()
    linked.solve(freeze="a", on_step=lambda now, _: places.append(now.a.value))
    assert places[-1] == 3


@pytest.mark.parametrize("answer", [False, np.False_])
def test_false_ends_the_solve(answer: Any) -> None:
    model = arael.loads(VALLEY, interpret=True)()
    result = model.solve(on_step=lambda now, record: answer)
    assert (result.status, result.accepted_iterations) == ("observer_terminated", 1)
    both = model.solve(observer=lambda record: answer, on_step=lambda now, record: None)
    assert both.status == "observer_terminated"


def test_what_is_no_function_is_refused() -> None:
    with pytest.raises(AraelError, match=r"(?s)E0828.*on_step"):
        arael.loads(VALLEY, interpret=True)().solve(on_step="print")
