"""Symbolic mathematics: building, differentiating, common subexpressions, printing, parsing.

    python sym_demo.py [--plot sym_demo.png]

`arael.sym` without a model and a solver.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from arael import sym


def building() -> sym.Expr:
    """Build an expression with operators, evaluate it, differentiate it."""
    x = sym.symbol("x")
    f = sym.sin(x) * x + 1.0
    print("f(x)    =", f)
    print("f'(x)   =", f.diff("x"))
    print("f''(x)  =", f.diff("x", 2))
    print("f(2)    =", f.eval(x=2.0))
    print("f(2 y)  =", f.subs(x=2 * sym.symbol("y")))
    return f


def rearranging() -> None:
    """Multiply out, collect, simplify."""
    f = sym.parse("(x + y)^2 - a * x^2")
    print("expand  =", f.expand())
    print("collect =", f.collect("x"))
    print("simple  =", sym.parse("sin(x)^2 + cos(x)^2 + (x^2 - 1) / (x - 1)").simplify())


def sharing() -> sym.Shared:
    """Differentiate a residual by all its variables and extract common subexpressions."""
    residual = sym.parse("starship(atan2(y - b, x - a) * isigma, gamma)")
    rows = sym.jacobian(residual.subs(gamma=3.0), ["a", "b"])
    shared = sym.cse(rows)
    print(shared)
    return shared


def printing(f: sym.Expr) -> None:
    """Write an expression in four notations."""
    print("text    =", f)
    print("LaTeX   =", f.latex())
    print("Python  =", f.python())
    print("C       =", f.c())


def parsing() -> None:
    """Read formulas with user-defined functions, which shadow built-in ones."""
    bag = sym.FunctionBag(
        "sigmoid(x) derivs [sigmoid(x) * (1 - sigmoid(x))] = 1 / (1 + exp(-x))",
        "abs(x) = sqrt(x^2 + 1e-6)",
    )
    f = sym.parse("sigmoid(2 * t) + abs(t)", bag)
    print("f(t)    =", f)
    print("f'(t)   =", f.diff("t"))
    print("f'(0.5) =", round(f.diff("t").eval(t=0.5), 12))


def rotations() -> float:
    """Rotate a vector by a quaternion and by its matrix; return the difference."""
    q = sym.exp(sym.Vector("w", 3))
    v = sym.Vector([1, 2, 3])
    apart = q.rotate(v) - q.rotation_matrix() @ v
    at = {"w.x": 0.3, "w.y": -0.5, "w.z": 1.1}
    distance = float(np.abs(apart.eval(at)).max())
    print("q v q* - R v:", "equal to rounding" if distance < 1e-14 else distance)
    return distance


def plot(f: sym.Expr, path: Path) -> None:
    """Draw an expression and its derivatives."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    x = np.linspace(-8, 8, 400)
    figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for order, name in enumerate(("f", "f'", "f''")):
        curve = f.diff("x", order)
        axes.plot(x, curve.eval(x=x), label=f"${name} = {curve.latex()}$")
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
