"""Derivatives by named constants, against solutions of models with other constants."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.solution import Solution
from tests.analysis.test_sensitivities import solved
from tests.interpreted import Load, loader

TEXT = """
const G = 0.05 [1/m]
const WIDE = -(1 - 2 * G * 30 [m])
const A = [0.2, -0.5, G * 1 [m]]
fn lifted(x) = x * G
struct Point {
    x: real [m]
    y: real
    constraint fit loss cauchy(WIDE) {
        (root.v * x / (root.k * 1 [m] + x) + lifted(x) - A[1] * x * G - y - A.x - A.z) / 0.1
    }
}
root Rate {
    param v: real = 3
    param k: real = 2
    prior k ~ normal(-A.y + 1, 4 * G * 1 [m])
    points: list of Point
}
"""


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("constants"))


def rate(load: Load, text: str = TEXT) -> Any:
    model = load(text)()
    model.points.extend(x=[0.5, 1.0, 2.0, 3.0, 5.0, 8.0], y=[0.97, 1.58, 2.36, 2.98, 3.52, 3.91])
    return model


def difference(load: Load, before: str, value: float, read: Callable[[Any], float]) -> float:
    """Derivative by a number of the text, `value`, that stands once behind `before`."""

    def at(change: float) -> float:
        old = f"{before}{value!r}"
        assert TEXT.count(old) == 1
        model = rate(load, TEXT.replace(old, f"{before}{value + change!r}"))
        solved(model)
        return read(model)

    def central(h: float) -> float:
        return (at(h) - at(-h)) / (2 * h)

    h = 1e-3 * abs(value)
    return (4 * central(h / 2) - central(h)) / 3


def test_constants_in_residuals_losses_functions_priors_and_other_constants(load: Load) -> None:
    result = solved(rate(load))
    for name, entry, before, value in (
        ("G", (), "const G = ", 0.05),
        ("A", (0,), "const A = [", 0.2),
        ("A", (1,), "const A = [0.2, ", -0.5),
    ):
        k = result.sensitivity("k", name, exact=True)[name][entry]
        assert k == pytest.approx(
            difference(load, before, value, lambda m: float(m.k.value)), rel=1e-6
        )
    # A formula that reads the constant itself, directly and by another.
    found = result.sensitivity("v * G + k * A.z", "G", exact=True)
    expected = difference(
        load, "const G = ", 0.05, lambda m: float(Solution(m).values("v * G + k * A.z")[0])
    )
    assert float(found["G"]) == pytest.approx(expected, rel=1e-6)


def test_a_derivative_by_a_constant_holds_the_others_that_are_asked_for(load: Load) -> None:
    """`A` is data of its own in derivatives by it, and computed from `G` in those by `G`."""
    result = solved(rate(load))
    both = result.sensitivity("k", ["G", "A", "points.y"])
    assert both["A"].shape == (3,) and both["points.y"].shape == (6,)
    for name in ("G", "A"):
        assert both[name] == pytest.approx(result.sensitivity("k", name)[name])
    propagation = result.propagate({"G": 0.01, "A": [0.1, 0.0, 0.0]}, of=["k", "v"])
    assert propagation.by["G"][0, 0] == pytest.approx((0.01 * float(both["G"])) ** 2)
    assert propagation.by["A"][0, 0] == pytest.approx((0.1 * both["A"][0]) ** 2)


def test_all_data_does_not_include_constants(load: Load) -> None:
    result = solved(rate(load))
    assert set(result.sensitivity("k")) == {"points.x", "points.y"}


def test_a_constant_is_as_good_as_data_of_the_root(load: Load) -> None:
    """With rows of another table, refs, a guard over parameters, and a runtime residual."""
    text = """
    {item}
    struct Mark { param p: vec2 }
    struct Seen { mark: ref Mark in root.marks; at: vec2
        constraint seen when mark.p.x > -5 { (mark.p .* {name} - at) / 0.1 } }
    root Map { {field} marks: list of Mark; seen: list of Seen }
    """

    def solution(name: str, item: str, field: str) -> Any:
        filled = text.replace("{item}", item).replace("{field}", field).replace("{name}", name)
        model = load(filled)()
        model.marks.extend(p=np.arange(6.0).reshape(3, 2))
        rng = np.random.default_rng(0)
        model.seen.extend(mark=[0, 1, 2, 0, 1, 2], at=rng.normal(2, 1, (6, 2)))
        model.residuals.add(f"norm(marks[0].p - marks[1].p) - {name.removeprefix('root.')}.x")
        return solved(model)

    named = solution("C", "const C = [1.5, 0.5]", "")
    data = solution("root.c", "", "c: vec2 = [1.5, 0.5];")
    for of in ("marks[0].p.x", "marks[2].p", "norm(marks[0].p)"):
        for exact in (False, True):
            found = named.sensitivity(of, "C", exact)["C"]
            assert np.abs(found).max() > 0
            assert found == pytest.approx(data.sensitivity(of, "c", exact)["c"], rel=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "const C = 2\nroot R { param x: real = 1; y: real = C\nconstraint c { x - y } }",
            "no res",
        ),
        (
            "const C = 2\nfn f(x) derivs [C] = x * C\n"
            "root R { param x: real = 1\nconstraint c { f(x) - 3 } }",
            "`C` is read by `f`, whose `derivs`",
        ),
        (
            "const C = 2\nstruct A { y: real }\nroot R { param x: real = 1; all: list of A\n"
            "constraint c { x - sum(a in all) { a.y * C } } }",
            "in a sum over rows",
        ),
        (
            "const C = 2\ncomponent K { param d: real = 1; symbolic e = d * C }\n"
            "root R { param x: K\nconstraint c { x.e - 3 } }",
            "by the component `K`",
        ),
    ],
)
def test_constants_of_which_no_derivative_is_taken(load: Load, text: str, words: str) -> None:
    model = load(text)()
    if "list of" in text:
        model.all.extend(y=[1.0, 2.0])
    result = model.solve()
    of = model.parameter_names()[0]
    with pytest.raises(AraelError, match=rf"E1060(.|\n)*{words}"):
        result.sensitivity(of, "C")
