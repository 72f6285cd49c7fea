"""Differentiation of programs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import jacobian as derive
from tests.symbolic.programs import (
    between_factor,
    central,
    complex_step,
    inputs,
    jacobian,
    run,
)

Rows = list[dict[Any, int]]


class Method(NamedTuple):
    """Orders of the chain rule; the shortest program of them is taken."""

    orders: tuple[Any, ...]

    def __call__(self, g: Graph, outputs: list[int], seeds: Any) -> Rows:
        return derive(g, outputs, seeds, self.orders)


forward, eliminate = Method(("forward",)), Method(("eliminate",))
shortest = Method(("forward", "eliminate"))
methods = pytest.mark.parametrize("method", [forward, eliminate, shortest])

ANALYTIC = ("add", "sub", "mul", "div", "neg", "sin", "cos", "exp", "tanh", "atan", "sqrt", "log",
            "sinh", "cosh", "tan", "identity")  # fmt: skip
_ARITY = {"add": 2, "sub": 2, "mul": 2, "div": 2}

Step = tuple[str, int, int]
programs = st.lists(
    st.tuples(st.sampled_from(ANALYTIC), st.integers(0, 30), st.integers(0, 30)),
    min_size=1,
    max_size=20,
)
coordinates = st.sampled_from([-1.4, -0.7, 0.3, 0.55, 1.2, 1.9])


def _build(g: Graph, program: list[Step]) -> list[int]:
    nodes = [*inputs(g, 3), g.const(2.0), g.const(-0.5)]
    for name, first, second in program:
        picks = (first, second)[: _ARITY.get(name, 1)]
        nodes.append(g.op(name, *(nodes[p % len(nodes)] for p in picks)))
    return nodes


@pytest.mark.sweep(3)
@methods
@settings(max_examples=200, deadline=None)
@given(programs, st.tuples(coordinates, coordinates, coordinates))
def test_random_programs_against_the_complex_step(
    method: Method, program: list[Step], point: tuple[float, ...]
) -> None:
    g = Graph()
    nodes = _build(g, program)
    outputs = nodes[-3:]
    with np.errstate(all="ignore"):
        expected = complex_step(g, outputs, point)
        values = run(g, g.live(outputs), point)
    assume(np.isfinite(values).all() and np.isfinite(expected).all())
    assume(np.max(np.abs(values)) < 1e6 and np.max(np.abs(expected)) < 1e8)
    found = jacobian(g, outputs, inputs(g, 3), point, method.orders)
    scale = max(1.0, float(np.max(np.abs(expected))))
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * scale)


@methods
def test_structural_zeros_are_absent(method: Method) -> None:
    g = Graph()
    x, y, z = inputs(g, 3)
    one = g.const(1.0)
    seeds = {x: {"x": one}, y: {"y": one}, z: {"z": one}}
    out = [
        g.op("mul", x, x),
        g.op("add", x, g.op("floor", y)),
        g.op("sub", g.op("mul", x, y), g.op("mul", y, x)),
        g.op("lt", x, y),
        g.const(3.0),
    ]
    assert [list(row) for row in method(g, out, seeds)] == [["x"], ["x"], [], [], []]


@methods
def test_seeds_are_listed_in_their_first_order(method: Method) -> None:
    g = Graph()
    x, y = inputs(g, 2)
    one = g.const(1.0)
    (row,) = method(g, [g.op("add", x, y)], {y: {"late": one}, x: {"early": one, "late": one}})
    assert list(row) == ["late", "early"]
    assert g.value(row["late"]) == 2.0


@methods
def test_seeds_given_for_cached_values(method: Method) -> None:
    # sin and cos of an angle come in as inputs, with derivatives that refer to each other
    g = Graph()
    s, c, k = inputs(g, 3)
    out = g.op("mul", k, g.op("div", s, c))
    (row,) = method(g, [out], {s: {0: c}, c: {0: g.op("neg", s)}})
    angle = 0.4
    found = run(g, [row[0]], [np.sin(angle), np.cos(angle), 3.0])[0]
    assert found == pytest.approx(3.0 / np.cos(angle) ** 2, rel=1e-14)


@methods
def test_only_the_arm_taken_counts(method: Method) -> None:
    # if x > 0 then sqrt(x) else x: at -1 and 0 the root's derivative is NaN and infinite
    g = Graph()
    (x,) = inputs(g, 1)
    out = g.op("select", g.op("lt", g.const(0.0), x), g.op("sqrt", x), x)
    for at, slope in ((-1.0, 1.0), (0.0, 1.0), (4.0, 0.25)):
        assert jacobian(g, [out], [x], [at], method.orders)[0, 0] == slope


@methods
@pytest.mark.parametrize("name", ["min", "max"])
def test_the_other_argument_of_an_extremum_may_be_singular(name: str, method: Method) -> None:
    g = Graph()
    (x,) = inputs(g, 1)
    far = g.const(-1.0 if name == "max" else 1.0)
    inner = g.op("sqrt", x) if name == "min" else g.op("neg", g.op("sqrt", x))
    near = g.op(name, far, g.op("mul", g.const(2.0), inner))
    assert jacobian(g, [near], [x], [1.0], method.orders)[0, 0] == 0.0
    # nested: an infinite slope times a flat outer function in an arm that is not taken
    shielded = g.op("select", g.op("lt", x, g.const(0.0)), g.op("log", g.op("sqrt", x)), x)
    assert jacobian(g, [g.op("mul", shielded, shielded)], [x], [0.0], method.orders)[0, 0] == 0.0


@methods
def test_prescribed_derivatives_are_used_and_chained(method: Method) -> None:
    g = Graph()
    x, y = inputs(g, 2)
    inner = g.op("mul", x, y)
    out = g.op("exp", g.custom(g.op("sin", inner), [(inner, g.const(10.0))]))
    found = jacobian(g, [out], [x, y], [0.5, 0.4], method.orders)[0]
    slope = 10.0 * np.exp(np.sin(0.2))
    np.testing.assert_allclose(found, [0.4 * slope, 0.5 * slope], rtol=1e-14)


@methods
def test_derivatives_of_derivatives(method: Method) -> None:
    g = Graph()
    (x,) = inputs(g, 1)
    one = g.const(1.0)
    node = g.op("sin", g.op("mul", x, x))
    for _ in range(3):
        (row,) = method(g, [node], {x: {0: one}})
        node = row[0]
    x2 = 0.7**2
    expected = -12 * 0.7 * np.sin(x2) - 8 * 0.7**3 * np.cos(x2)
    assert run(g, [node], [0.7])[0] == pytest.approx(expected, rel=1e-13)


@methods
def test_derivatives_remember_the_place_of_what_they_derive(method: Method) -> None:
    g = Graph()
    x, y = inputs(g, 2)
    g.place = 5
    out = g.op("atan2", x, y)
    g.place = None
    (row,) = method(g, [out], {x: {0: g.const(1.0)}})
    assert g.places[row[0]] == 5
    assert g.place is None


@methods
def test_a_chain_carries_one_factor(method: Method) -> None:
    # sin(cos(exp(|x|^2))) by 8 seeds: the chain is multiplied once, not once per seed
    g = Graph()
    x = inputs(g, 8)
    node = g.const(0.0)
    for k in x:
        node = g.op("add", node, g.op("mul", k, k))
    out = g.op("sin", g.op("cos", g.op("exp", node)))
    (row,) = method(g, [out], {k: {i: g.const(1.0)} for i, k in enumerate(x)})
    before, after = g.operations([out]), g.operations([out, *row.values()])
    assert after - before <= 5 + 3 * 8


@methods
def test_between_factor_against_the_complex_step(method: Method) -> None:
    g, out, seeds = between_factor()
    rows = method(g, out, seeds)
    zero = g.const(0.0)
    rng = np.random.default_rng(3)
    point = rng.normal(size=len(g.inputs))
    by_input = complex_step(g, [n for n in out], point)
    for i, row in enumerate(rows):
        for seed in range(12):
            entering = [
                by_input[i, g.args[node][0]] * run(g, [entries[seed]], point)[0]
                for node, entries in seeds.items()
                if seed in entries
            ]
            found = run(g, [row.get(seed, zero)], point)[0]
            assert found == pytest.approx(sum(entering), rel=1e-12, abs=1e-13)
    assert sum(map(len, rows)) == 54  # of 72: the rest is zero by structure


@methods
def test_nested_branches(method: Method) -> None:
    """Arms within arms, shared between arms, under conditions that depend on each other."""
    g = Graph()
    x, y = inputs(g, 2)
    zero = g.const(0.0)
    positive, larger = g.op("lt", zero, x), g.op("lt", x, y)
    root, shared = g.op("sqrt", x), g.op("exp", y)
    inner = g.op("select", larger, g.op("mul", root, shared), g.op("log", y))
    outer = g.op("select", positive, g.op("sin", inner), g.op("mul", shared, shared))
    out = [outer, g.op("mul", outer, g.op("select", larger, x, y)), g.op("max", inner, y)]
    for at in ((0.5, 1.5), (1.5, 0.5), (-0.5, 0.7), (0.8, 0.9)):
        if at[0] < 0:
            # everything but the shared exponential is NaN there
            found = jacobian(g, out[:2], [x, y], at, method.orders)
            square = np.exp(2 * at[1])
            expected = [[0, 2 * square], [square, 2 * square * at[0]]]
        else:
            found = jacobian(g, out, [x, y], at, method.orders)
            expected = central(g, out, at)
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-8)


def test_the_shortest_program_is_taken() -> None:
    # one residual of many parameters, through a product of sums: elimination from above is shorter
    g = Graph()
    x, m = inputs(g, 3), inputs(g, 9, "m")
    from arael.manifolds import linear

    moved = linear.matvec(g, linear.matrix(m, 3, 3), x)
    out = [g.op("exp", linear.norm2(g, linear.matvec(g, linear.matrix(m, 3, 3), moved)))]
    seeds = {node: {k: g.const(1.0)} for k, node in enumerate([*x, *m])}
    counts = []
    for method in (forward, eliminate, shortest):
        mark = len(g)
        rows = method(g, out, seeds)
        counts.append(g.tape([*out, *rows[0].values()]).operations)
        g.rollback(mark)
    assert counts[1] < counts[0] and counts[2] == counts[1]
    assert len(g) == mark


@methods
def test_a_division_by_zero_has_the_place_of_the_divisor(method: Method) -> None:
    # (sqrt(x) - y) / 0.1 with the root at a place of its own
    g = Graph()
    x, y = inputs(g, 2)
    g.place = 1
    root = g.op("sqrt", x)
    g.place = 2
    out = g.op("div", g.op("sub", root, y), g.const(0.1))
    g.place = None
    (row,) = method(g, [out], {x: {0: g.const(1.0)}})
    divisions = [n for n in g.live([row[0]]) if g.ops[n] == "div"]
    assert divisions and {g.places[n] for n in divisions} == {1}


@methods
@pytest.mark.parametrize("singular", ["division", "root"])
def test_constants_without_a_real_value_are_not_finite(singular: str, method: Method) -> None:
    """SymPy goes on with 1/0 and the root of -2; derivatives are NaN or infinite, as values are."""
    g = Graph()
    (x,) = inputs(g, 1)
    number = g.op("div", g.const(1.0), g.const(0.0))
    if singular == "root":
        number = g.op("sqrt", g.const(-2.0))
    out = g.op("mul", g.op("mul", x, x), number)
    with np.errstate(all="ignore"):
        assert not np.isfinite(jacobian(g, [out], [x], [3.0], method.orders)[0, 0])
        power = g.op("div", g.op("mul", x, x), g.const(0.0))
        root = g.op("sqrt", g.op("add", x, power))
        assert not np.isfinite(jacobian(g, [root], [x], [3.0], method.orders)[0, 0])
