"""The constants have one value in models, graphs and SymPy's expressions."""

from __future__ import annotations

import math

import pytest

import arael
from arael import sym
from arael.operations.constants import CONSTANTS
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS

EXPECTED = {"pi": math.pi, "e": math.e, "epsilon": 2.0**-52}


@pytest.mark.parametrize("name", EXPECTED)
def test_a_constant_has_one_value_everywhere(name: str) -> None:
    assert set(CONSTANTS) == set(EXPECTED)
    expected = EXPECTED[name]
    graph = Graph()
    assert CONSTANTS[name].number == expected
    assert graph.value(SCALARS[name](graph)) == expected
    assert sym.eval(sym.parse(name)) == expected
    model = arael.loads(f"root M {{ x: real = {name} }}", interpret=True)
    assert model().x == expected
