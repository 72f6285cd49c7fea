"""The graph: interning, rewriting, tapes."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numpy as np
import pytest

from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.graph import Graph
from arael.symbolic.simplify import fold
from tests.oracle import evaluate
from tests.symbolic.programs import between_factor, inputs, run


def test_equal_expressions_are_one_node() -> None:
    g = Graph()
    x, y = inputs(g, 2)
    assert g.op("sin", g.op("add", x, y)) == g.op("sin", g.op("add", y, x))
    assert g.input(("x", 0)) == x
    assert g.const(2) == g.const(2.0)
    assert g.const(-0.0) == g.const(0.0)
    assert g.const(math.nan) == g.const(float("nan"))


def test_shared_operations_are_counted_once_and_trees_in_full() -> None:
    # (x + y)^2 sin((x + y)^2): add, mul, sin, mul against 3 + 3 adds, muls, sin and the last mul
    g = Graph()
    x, y = inputs(g, 2)
    square = g.op("pow", g.op("add", x, y), g.const(2))
    out = g.op("mul", square, g.op("sin", square))
    assert g.operations([out]) == 4
    assert g.tree_operations([out]) == 8
    assert g.tape([out]).operations == 4


def test_tree_operations_of_an_exponentially_large_tree() -> None:
    g = Graph()
    node = g.input("x")
    for _ in range(200):
        node = g.op("sin", g.op("mul", node, node))
    assert g.operations([node]) == 400
    assert g.tree_operations([node]) == 2 * (2**200 - 1)


@pytest.mark.parametrize("name", [n for n in PRIMITIVES if n not in ("input", "const")])
def test_folding_agrees_with_the_interpreter(name: str) -> None:
    arity, function = PRIMITIVES[name]
    assert function is not None
    for point in ((0.3, 0.7, 0.2), (1.0, 1.0, 0.0), (0.0, 0.5, 1.0), (-0.4, 2.5, 3.0)):
        folded = fold(name, *point[:arity])
        if folded is not None:
            with np.errstate(all="ignore"):
                expected = function(*(np.float64(v) for v in point[:arity]))
            assert folded == pytest.approx(float(expected), rel=1e-15, abs=1e-300)
        else:
            assert name in ("select", "identity") or point[0] <= 0 or name == "acosh"


@pytest.mark.parametrize(
    ("name", "args"),
    [("div", (1, 0)), ("log", (0,)), ("log", (-1,)), ("sqrt", (-1,)), ("exp", (1000,)),
     ("div", (0, 0)), ("pow", (-1, 0.25)), ("asin", (2,)), ("mul", (1e200, 1e200))],
)  # fmt: skip
def test_what_has_no_finite_value_is_not_folded(name: str, args: tuple[float, ...]) -> None:
    g = Graph()
    node = g.op(name, *(g.const(a) for a in args))
    assert g.value(node) is None
    assert not np.isfinite(run(g, [node], []))[0]


def test_prescribed_derivative_costs_nothing_in_a_tape() -> None:
    g = Graph()
    x = g.input("x")
    value = g.op("sin", x)
    other = g.custom(value, [(x, g.const(3.0))])
    assert other != value
    tape = g.tape([g.op("mul", other, x), g.op("mul", value, x)])
    assert tape.outputs[0] == tape.outputs[1]
    assert "custom" not in tape.ops


def test_tape_numbers_inputs_as_asked() -> None:
    g = Graph()
    x, y = g.input("x"), g.input("y")
    tape = g.tape([g.op("sub", x, y)], inputs=["y", "unused", "x"])
    assert float(evaluate(tape, [1.0, 99.0, 5.0])[tape.outputs[0]]) == 4.0
    with pytest.raises(ValueError, match="'y'"):
        g.tape([y], inputs=["x"])


def test_nodes_remember_their_first_place() -> None:
    g = Graph()
    x = g.input("x")
    g.place = 7
    first = g.op("sin", x)
    g.place = 8
    assert g.op("sin", x) == first
    second = g.op("cos", x)
    tape = g.tape([first, second])
    assert [tape.places[o] for o in tape.outputs] == [7, 8]
    assert tape.places[0] == -1


def test_live_and_depends() -> None:
    g = Graph()
    x, y = inputs(g, 2)
    left = g.op("sin", x)
    right = g.op("cos", y)
    both = g.op("add", left, right)
    unused = g.op("exp", both)
    assert g.live([both]) == [x, y, left, right, both]
    assert g.depends([y]) == {y, right, both, unused}
    assert g.depends([]) == set()


def test_substitution_simplifies_again() -> None:
    g = Graph()
    x, y = inputs(g, 2)
    out = g.op("mul", g.op("sin", x), g.op("add", y, x))
    (at_zero,) = g.copy([out], g, {x: g.const(0.0)})
    assert g.value(at_zero) == 0.0
    (swapped,) = g.copy([out], g, {x: y, y: x})
    assert swapped == g.op("mul", g.op("sin", y), g.op("add", x, y))


def test_copies_keep_keys_places_and_prescribed_derivatives() -> None:
    g, h = Graph(), Graph()
    x = g.input("x")
    g.place = 3
    out = g.custom(g.op("sin", x), [(x, g.const(5.0))])
    (copied,) = g.copy([out], h)
    assert h.inputs == ["x"]
    assert h.ops[copied] == "custom"
    assert h.places[copied] == 3
    assert h.value(h.args[copied][2]) == 5.0


def test_rollback_forgets_everything_made_since() -> None:
    g = Graph()
    x = g.input("x")
    node = g.op("sin", x)
    before = (list(g.ops), list(g.args), list(g.constants), list(g.inputs))
    mark = len(g)
    y = g.input("y")
    g.custom(g.op("mul", g.op("cos", y), g.const(7.5)), [(y, g.const(math.nan))])
    g.rollback(mark)
    assert (g.ops, g.args, g.constants, g.inputs) == before
    assert g.op("sin", x) == node
    assert g.value(g.const(7.5)) == 7.5
    assert math.isnan(g.value(g.const(math.nan)) or 0.0)
    assert g.key(g.input("y")) == "y"


def test_unknown_operation_and_wrong_arity() -> None:
    g = Graph()
    x = g.input("x")
    for name, args in (("sine", (x,)), ("sin", (x, x)), ("input", ()), ("const", ())):
        with pytest.raises(ValueError, match="no operation"):
            g.op(name, *args)


@pytest.mark.slow
def test_programs_do_not_depend_on_the_hash_seed() -> None:
    script = (
        "from tests.symbolic.programs import between_factor\n"
        "from arael.symbolic.jacobian import jacobian\n"
        "g, out, seeds = between_factor()\n"
        "rows = jacobian(g, out, seeds)\n"
        "t = g.tape(out + [n for r in rows for n in r.values()])\n"
        "print([list(r) for r in rows], t.ops, t.args, t.constants, t.outputs)\n"
    )
    printed = set()
    for seed in ("0", "1", "4711"):
        done = subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
            text=True,
            check=True,
        )
        printed.add(done.stdout)
    assert len(printed) == 1


def test_the_compile_path_does_not_import_sympy() -> None:
    script = (
        "import sys, arael.symbolic.jacobian, arael.manifolds.parameters, arael.symbolic.scalars\n"
        "import arael.manifolds.inverse, arael.manifolds.rotation\n"
        "assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_between_factor_shares_nearly_everything() -> None:
    g, out, _ = between_factor()
    assert g.operations(out) <= 123
    assert g.tree_operations(out) > 2 * g.operations(out)
