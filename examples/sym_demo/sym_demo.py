"""Symbolic mathematics: building, differentiating, common subexpressions, printing, parsing.

    python sym_demo.py [--plot sym_demo.png]

`arael.sym` without a model and a solver. Its expressions are SymPy's.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import sympy as sp

from arael import sym


def building() -> sp.Expr:
    """Build an expression with operators, evaluate it, differentiate it."""
    x = sym.symbol("x")
    f = sp.sin(x) * x + 1
    print("f(x)    =", sym.text(f))
    print("f'(x)   =", sym.text(f.diff(x)))
    print("f''(x)  =", sym.text(f.diff(x, 2)))
    print("f(2)    =", sym.eval(f, x=2.0))
    print("f(2 y)  =", sym.text(f.subs(x, 2 * sym.symbol("y"))))
    return f


def rearranging() -> None:
    """Multiply out, collect, simplify."""
    f = sym.parse("(x + y)^2 - a * x^2")
    print("expand  =", sym.text(f.expand()))
    print("collect =", sym.text(sym.collect(f, "x")))
    g = sym.parse("sin(x)^2 + cos(x)^2 + (x^2 - 1) / (x - 1)")
    print("simple  =", sym.text(sp.simplify(g)))


def sharing() -> sym.Shared:
    """Differentiate a residual by all its variables and extract common subexpressions."""
    residual = sym.parse("starship(atan2(y - b, x - a) * isigma, gamma)")
    rows = sym.jacobian(residual.subs("gamma", 3), ["a", "b"])
    shared = sym.cse(rows)
    print(shared)
    return shared


def printing(f: sp.Expr) -> None:
    """Write an expression in four notations."""
    print("text    =", sym.text(f))
    print("LaTeX   =", sp.latex(f))
    print("Python  =", sym.python(f))
    print("C       =", sym.c(f))


def parsing() -> None:
    """Read formulas with user-defined functions, which shadow built-in ones."""
    bag = sym.FunctionBag(
        "sigmoid(x) derivs [sigmoid(x) * (1 - sigmoid(x))] = 1 / (1 + exp(-x))",
        "abs(x) = sqrt(x^2 + 1e-6)",
    )
    f = sym.parse("sigmoid(2 * t) + abs(t)", bag)
    print("f(t)    =", sym.text(f))
    print("f'(t)   =", sym.text(f.diff("t")))
    print("f'(0.5) =", round(sym.eval(f.diff("t"), t=0.5), 12))


def rotations() -> float:
    """Rotate a vector by a quaternion and by its matrix; return the difference."""
    q = sym.exp(sym.vector("w", 3))
    v = sp.Matrix([1, 2, 3])
    apart = sym.rotate(q, v) - sym.rotation_matrix(q) * v
    at = {"w.x": 0.3, "w.y": -0.5, "w.z": 1.1}
    distance = float(np.abs(sym.eval(apart, at)).max())
    print("q v q* - R v:", "equal to rounding" if distance < 1e-14 else distance)
    return distance


def plot(f: sp.Expr, path: Path) -> None:
    """Draw an expression and its derivatives."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    x = np.linspace(-8, 8, 400)
    figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for order, name in enumerate(("f", "f'", "f''")):
        curve = f.diff("x", order)
        axes.plot(x, sym.eval(curve, x=x), label=f"${name} = {sp.latex(curve)}$")
    axes.set_xlabel("x")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=100)
    print("wrote", path)


def main() -> None:
    """Go through the tour."""
    parser = argparse.ArgumentParser(description="Symbolic mathematics, a tour.")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    f = building()
    for part in (rearranging, sharing, lambda: printing(f), parsing, rotations):
        print()
        part()
    if args.plot:
        plot(f, args.plot)


if __name__ == "__main__":
    main()
