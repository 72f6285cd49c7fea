"""Nodes with Python's operators are the operations of graphs."""

from __future__ import annotations

import pytest

from arael.symbolic.graph import Graph
from arael.symbolic.operators import Scalar


def test_operators_and_methods_make_operations() -> None:
    g = Graph()
    x, y = Scalar(g, g.input("x")), Scalar(g, g.input("y"))
    one = g.const(1.0)
    made = {
        x + y: g.op("add", x.node, y.node),
        1 - x: g.op("sub", one, x.node),
        x - 1: g.op("sub", x.node, one),
        1 / x: g.op("div", one, x.node),
        2 * x: g.op("mul", g.const(2.0), x.node),
        -x: g.op("neg", x.node),
        x < y: g.op("lt", x.node, y.node),
        x > 1: g.op("lt", one, x.node),
        x.sin(): g.op("sin", x.node),
        x.max(1): g.op("max", x.node, one),
        (x < y).select(1, y): g.op("select", g.op("lt", x.node, y.node), one, y.node),
    }
    assert [scalar.node for scalar in made] == list(made.values())


def test_an_unknown_operation_is_refused() -> None:
    g = Graph()
    with pytest.raises(ValueError, match="no operation 'sine'"):
        Scalar(g, g.input("x")).sine()
