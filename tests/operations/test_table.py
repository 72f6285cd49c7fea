"""The table of operations: one record is all that a function needs."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy import special

from arael import runtime_model
from arael.operations import OPERATIONS
from arael.operations.instructions import header
from arael.operations.numbers import outside_domain, value
from arael.runtime.machine import compiled
from arael.symbolic.graph import Graph
from arael.symbolic.scalars import SCALARS
from arael.symbolic.simplify import fold
from tests.symbolic.programs import inputs, jacobian, run

ADDED = """
import json, sys
import numpy as np, sympy as sp
from arael.operations import OPERATIONS, Domain, Operation

class exp2(sp.Function):
    def fdiff(self, argindex=1):
        return self * sp.log(2)

class fdim(sp.Function):
    def fdiff(self, argindex=1):
        return sp.Integer(1 if argindex == 1 else -1)

OPERATIONS["exp2"] = Operation(
    "exp2", 1, np.exp2, "__main__:exp2", "pure", "exp2(x) ln 2", latex="\\\\exp_{2}",
    domain=Domain("x < 1024", lambda x: x < 1024))

OPERATIONS["fdim"] = Operation(
    "fdim", 2, lambda x, y: np.maximum(x - y, 0.0), "__main__:fdim", "joined", "1; -1")

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
found["model"] = float(model.a.value)
runtime = arael.runtime_model()
added = runtime.residuals.add("exp2(b) - 2", label="machine", parameters={"b": 0.0})
runtime.solve()
found["machine"] = float(runtime.residuals.parameters["b"])
runtime.residuals.add("fdim(c, 1) - 2 + fdim(1, c)", label="two", parameters={"c": 2.5})
found["two operands"] = runtime.cost()
f = sym.parse("exp2(x)")
found["latex"] = sym.latex(f)
found["slope"] = sym.eval(f.diff("x"), x=3.0)
found["number"] = float(f.subs("x", 3))
found["python"], found["c"], found["text"] = sym.python(f), sym.c(f), sym.text(f)
found["to sympy"] = str(sym.to_sympy(f))
found["slope of two"] = sym.eval(sym.parse("x * fdim(1, x)").diff("x"), x=0.5)
from arael.calculator.calculator import Calculator
found["calculator"] = [answer.text for answer in Calculator(17).run("exp2(5)")]
added.parameters["b"] = 2000.0
try:
    runtime.solve()
except arael.AraelError as error:
    found["domain"] = error.diagnostics[0].notes
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
    assert found["model"] == pytest.approx(3.0, rel=1e-9)
    assert found["machine"] == pytest.approx(1.0, rel=1e-9)
    assert found["latex"].startswith("\\exp_{2}")
    assert found["slope"] == pytest.approx(8 * math.log(2), rel=1e-14)
    assert found["number"] == 8.0
    assert (found["python"], found["c"]) == ("np.exp2(x)", "exp2(x)")
    assert found["text"] == found["to sympy"] == "exp2(x)"
    assert found["slope of two"] == 0.0
    assert found["calculator"] == ["32"]
    assert found["two operands"] == pytest.approx(0.25, rel=1e-12)
    assert "`exp2(x)` takes x < 1024" in found["domain"]


POINTS_OF_DOMAINS = (-2.5, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 2.5)
LIMITED = [one.name for one in OPERATIONS.values() if one.domain is not None and one.primitive]


@pytest.mark.parametrize("name", [one.name for one in OPERATIONS.values() if one.primitive])
def test_an_operation_is_finite_exactly_in_its_domain(name: str) -> None:
    one = OPERATIONS[name]
    seen = set()
    for operands in product(POINTS_OF_DOMAINS, repeat=one.arity):
        outside = one.outside(*operands)
        assert math.isfinite(value(name, *operands)) == (not outside), operands
        assert (fold(name, *operands) is None) == outside
        seen.add(outside)
    assert seen == ({False, True} if name in LIMITED else {False})


def test_operands_outside_of_the_domain_are_named_with_the_condition() -> None:
    assert outside_domain("log", -1.0) == "`log(x)` takes x > 0"
    assert outside_domain("div", 1.0, 0.0) == "`x / y` takes y != 0"
    assert outside_domain("log", 2.0) == outside_domain("extern:own", 2.0) == ""


# Where formulas are built of operations, or one has a meaning beyond that for scalars.
USES = {
    "arael/check": {
        *("cos", "exp", "log", "max", "min", "pow", "rad_diff", "rad_sum", "sin", "sqrt"),
        *("starship", "tan"),
        # What gives an angle, and ranges of values; `clamp` is a word of look-ups, too.
        *("abs", "atan2", "clamp", "cosh", "deg2rad", "hypot", "tanh"),
    },
    "arael/compiler": {
        *("abs", "clamp", "cos", "exp", "expm1", "identity", "log", "log1p", "max", "min"),
        *("pow", "rad_diff", "sin", "sqrt"),
    },
    "arael/runtime": set(),
}


@pytest.mark.parametrize("folder", USES)
def test_no_function_is_listed_elsewhere(folder: str) -> None:
    root = Path(__file__).parents[2] / folder
    text = "\n".join(
        path.read_text(encoding="utf-8")
        for pattern in ("*.py", "*.px?", "*.h")
        for path in root.rglob(pattern)
        if path.name != "instructions.h"
    )
    functions = [one.name for one in OPERATIONS.values() if one.function]
    found = {name for name in functions if re.search(rf"[\"']{name}[\"']", text)}
    assert found - {"floor", "e"} <= USES[folder]


def test_the_instructions_of_the_machine_are_those_of_the_table() -> None:
    written = Path(compiled.__file__).with_name("instructions.h").read_text(encoding="utf-8")
    assert written == header(), "build the extensions again"


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


CALLED = [one.name for one in OPERATIONS.values() if one.primitive and not one.opcode]


@pytest.mark.parametrize("name", CALLED)
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
