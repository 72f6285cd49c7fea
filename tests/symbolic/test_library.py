"""Functions of the C library: one record is all that a function needs."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from scipy import special

from arael import runtime_model
from arael.runtime.machine.library import FUNCTIONS
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from tests.symbolic.programs import inputs, jacobian, run

ADDED = """
import json, sys
import numpy as np, sympy as sp
from arael.runtime.machine import library

class exp2(sp.Function):
    def fdiff(self, argindex=1):
        return self * sp.log(2)

library.FUNCTIONS.append(library.LibraryFunction(
    "exp2", 1, np.exp2, "__main__:exp2", "pure", "exp2(x) ln 2", latex="\\\\exp_{2}"))

import arael
from arael import sym
from arael.compiler.compilation import compile_text
from arael.diagnostics.records import AraelError, Source

TEXT = "root R { param a: real [%s] = 1\\n constraint c { exp2(a) - 8 } }"
made = compile_text(Source("m.arael", TEXT % "1"))
found = {"code": made.emit()}
try:
    compile_text(Source("m.arael", TEXT % "m"))
except AraelError as error:
    found["units"] = error.diagnostics[0].message
open(sys.argv[1], "w").write(TEXT % "1")
model = arael.load(sys.argv[1], interpret=True)()
model.solve()
found["interpreter"] = float(model.a.value)
runtime = arael.runtime_model()
runtime.residuals.add("exp2(b) - 2", label="machine", parameters={"b": 0.0})
runtime.solve()
found["machine"] = float(runtime.residuals.parameters["b"])
f = sym.parse("exp2(x)")
found["latex"] = sym.latex(f)
found["slope"] = sym.eval(f.diff("x"), x=3.0)
print(json.dumps(found))
"""


def test_a_function_is_added_in_one_place(tmp_path: object) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ADDED, f"{tmp_path}/m.arael"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert 'm_exp2 "exp2"(double) noexcept nogil' in found["code"]
    assert "= m_exp2(" in found["code"]
    assert found["units"] == "`exp2` takes a pure number, found m"
    assert found["interpreter"] == pytest.approx(3.0, rel=1e-9)
    assert found["machine"] == pytest.approx(1.0, rel=1e-9)
    assert found["latex"].startswith("\\exp_{2}")
    assert found["slope"] == pytest.approx(8 * math.log(2), rel=1e-14)


ORACLES = {
    "erf": (special.erf, lambda x: 2 / np.sqrt(np.pi) * np.exp(-(x**2))),
    "erfc": (special.erfc, lambda x: -2 / np.sqrt(np.pi) * np.exp(-(x**2))),
    "expm1": (np.expm1, np.exp),
    "log1p": (np.log1p, lambda x: 1 / (1 + x)),
    "lgamma": (special.gammaln, special.digamma),
    "digamma": (special.digamma, lambda x: special.polygamma(1, x)),
    "sinc": (
        lambda x: np.sinc(x / np.pi),
        lambda x: (np.cos(x) - np.sinc(x / np.pi)) / x,
    ),
}
POINTS = {
    "log1p": (1e-12, 0.3, 4.0, -0.5),
    "lgamma": (0.1, 1.0, 2.5, 30.0, -0.4, -3.7),
    "digamma": (0.1, 1.0, 2.5, 30.0, -0.4, -3.7),
    "sinc": (0.3, 1.0, -2.5, 30.0),
}


@pytest.mark.parametrize("name", ORACLES)
def test_value_and_derivative_against_scipy(name: str) -> None:
    value, slope = ORACLES[name]
    for at in POINTS.get(name, (1e-12, 0.3, -1.5, 3.0)):
        g = Graph()
        (x,) = inputs(g, 1)
        node = SCALARS[name](g, x)
        assert run(g, [node], [at])[0] == pytest.approx(value(at), rel=2e-13, abs=1e-15)
        assert jacobian(g, [node], [x], [at])[0, 0] == pytest.approx(slope(at), rel=1e-11)


@pytest.mark.parametrize("name", [f.name for f in FUNCTIONS if not f.opcode])
def test_the_machine_calls_it_by_address(name: str) -> None:
    model = runtime_model()
    model.residuals.add(f"{name}(a) - 3 * a", label="f", parameters={"a": 0.7})
    expected = ORACLES[name][0](0.7) - 2.1
    assert model.cost() == pytest.approx(expected**2, rel=1e-13)


def test_sinc_is_smooth_at_zero() -> None:
    g = Graph()
    (x,) = inputs(g, 1)
    node = SCALARS["sinc"](g, x)
    assert run(g, [node], [0.0])[0] == 1.0
    assert jacobian(g, [node], [x], [0.0])[0, 0] == 0.0
    assert jacobian(g, [node], [x], [1e-4])[0, 0] == pytest.approx(-1e-4 / 3, rel=1e-8)
