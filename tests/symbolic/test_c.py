"""Expressions in C: their looks, and that they mean what the graph means."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.c import c, c_literal, c_prelude
from arael.symbolic.graph import Graph
from tests.symbolic.programs import run


def every_operation(g: Graph, x: int, y: int) -> dict[str, int]:
    """One node per operation, with operands that are themselves operations."""
    a, b = g.op("sub", x, g.op("mul", y, y)), g.op("add", g.op("div", x, y), g.const(-2.5))
    condition = g.op("lt", x, y)
    made = {}
    for name, (arity, function) in PRIMITIVES.items():
        if function is None:
            continue
        operands = (a, b) if arity == 2 else (a,) if arity == 1 else (condition, a, b)
        if name in ("asin", "acos"):
            operands = (g.op("sin", a),)
        if name in ("sqrt", "log", "log2", "log10", "log1p"):
            operands = (g.op("exp", a),)
        if name == "pow":
            operands = (g.op("exp", a), b)
        made[name] = g.op(name, *operands)
    return made


POINTS = [(0.7, 1.3), (-1.2, 0.4), (2.0, 2.0), (1.0, 1.0)]


@pytest.mark.parametrize("real", ["double", "float"])
def test_c_means_the_same(real: str, tmp_path: Path) -> None:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    assert compiler, "this test needs a C compiler"
    g = Graph()
    x, y = g.input("x"), g.input("y")
    made = every_operation(g, x, y)
    dtype = np.float64 if real == "double" else np.float32
    lines = ["#include <stdio.h>", c_prelude(real), f"static void f({real} x, {real} y) {{"]
    for node in made.values():
        lines.append(f'    printf("%.17g\\n", (double)({c(g, node, real=real)}));')
    lines.append("}\nint main(void) {")
    points = [*POINTS, (math.nan, 1.0), (1.0, math.nan)]
    for point in points:
        lines.append(f"    f({c_literal(point[0], real)}, {c_literal(point[1], real)});")
    lines.append("    return 0;\n}")
    source = tmp_path / "program.c"
    source.write_text("\n".join(lines))
    program = tmp_path / "program"
    subprocess.run(
        [compiler, "-std=c99", "-O1", "-ffp-contract=off", str(source), "-o", str(program), "-lm"],
        check=True,
    )
    output = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    values = np.array(output.split(), float).reshape(len(points), -1)
    tolerance = 1e-14 if real == "double" else 2e-5
    for row, point in zip(values, points, strict=True):
        expected = run(g, made.values(), [dtype(p) for p in point]).astype(float)
        for name, found, want in zip(made, row, expected, strict=True):
            assert found == pytest.approx(want, rel=tolerance, abs=tolerance, nan_ok=True), name


def test_c_literals() -> None:
    assert [c_literal(v) for v in (1, -2.5, 1e-12, math.inf, -math.inf, math.nan)] == [
        "1.0", "-2.5", "1e-12", "INFINITY", "-INFINITY", "NAN",
    ]  # fmt: skip
    assert c_literal(0.1, "float") == "0.1f"


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda g, x, y: g.op("sub", x, g.op("sub", y, x)), "x - (y - x)"),
        (lambda g, x, y: g.op("mul", g.op("add", x, g.const(1)), y), "y * (x + 1.0)"),
        (lambda g, x, y: g.op("div", x, g.op("mul", x, y)), "x / (x * y)"),
        (lambda g, x, y: g.op("neg", g.op("add", x, y)), "-(x + y)"),
        (lambda g, x, y: g.op("div", g.const(1), g.op("sqrt", x)), "1.0 / sqrt(x)"),
        (lambda g, x, y: g.op("max", x, g.op("neg", y)), "arael_max(x, -y)"),
        (
            lambda g, x, y: g.op("select", g.op("lt", x, y), x, y),
            "((x < y ? 1.0 : 0.0) != 0.0 ? x : y)",
        ),
    ],
)
def test_parentheses(make: Callable[[Graph, int, int], int], expected: str) -> None:
    g = Graph()
    assert c(g, make(g, g.input("x"), g.input("y"))) == expected


def test_prescribed_derivatives_print_as_their_value() -> None:
    g = Graph()
    x = g.input("x")
    assert c(g, g.op("exp", g.custom(g.op("sin", x), [(x, x)]))) == "exp(sin(x))"
