"""A curve with its equation from the command line, fitted to data with outliers.

    python runtime_fit_demo.py ["a * exp(-b * x) + c"] [--start a=1 b=0.1 c=0] [--plot fit.png]

There is no model file: the equation is parsed, differentiated and evaluated while the program runs.
The robust fit is done twice: with the residual as text, and by a function for all points at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import arael
from arael import sym

EQUATION = "a * exp(-b * x) + c"
TRUTH = {"a": 2.5, "b": 0.7, "c": 0.3}
SIGMA = 0.03


def make_data(seed: int = 42) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Abscissae, ordinates and a mask of the outliers of a decay: 80 points, 15 outliers."""
    rng = np.random.Generator(np.random.PCG64(seed))
    x = np.linspace(0, 6, 80)
    y = TRUTH["a"] * np.exp(-TRUTH["b"] * x) + TRUTH["c"] + SIGMA * rng.standard_normal(80)
    wrong = np.zeros(80, dtype=bool)
    wrong[rng.choice(80, 15, replace=False)] = True
    y[wrong] += rng.uniform(0.5, 2.5, 15)
    return x, y, wrong


def fit(equation: str, start: dict[str, float], robust: bool) -> dict[str, float]:
    """Parameters of `equation` fitted to the data, with the loss applied to the residual."""
    x, y, _ = make_data()
    residual = f"(({equation}) - y) / {SIGMA}"
    if robust:
        residual = f"starship({residual}, starship_gamma(25))"
    curve = arael.runtime_residual(residual, label="curve", parameters=start, data={"x": x, "y": y})
    arael.runtime_model(curve).solve(rel_precision=1e-10, abs_precision=1e-12, max_iters=300)
    return dict(curve.parameters)


def fit_by_code(equation: str, start: dict[str, float]) -> dict[str, float]:
    """The same robust fit by a function: residuals and Jacobians of all points in one call."""
    x, y, _ = make_data()
    names = list(start)
    formula = sym.parse(f"starship((({equation}) - y) / {SIGMA}, starship_gamma(25))")
    value = sym.compiled(formula, [*names, "x", "y"])
    slopes = [sym.compiled(formula.diff(name), [*names, "x", "y"]) for name in names]

    def residuals(*values: np.ndarray, x: np.ndarray, y: np.ndarray) -> Any:
        return value(*values, x, y), [slope(*values, x, y) for slope in slopes]

    lines = [f"param {name}: real = {number!r}" for name, number in start.items()]
    model = arael.loads("root Curve {\n" + "\n".join(lines) + "\n}", interpret=True)()
    parameters = [model[name] for name in names]
    model.add_residuals(residuals, parameters, data={"x": x, "y": y}, name="curve")
    model.solve(rel_precision=1e-10, abs_precision=1e-12, max_iters=300)
    return {name: float(parameter) for name, parameter in zip(names, parameters, strict=True)}


def plot(equation: str, fits: dict[str, dict[str, float]], path: Path) -> None:
    """Draw the points and the fitted curves."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    x, y, wrong = make_data()
    figure, axes = pyplot.subplots(figsize=(6, 3.6), dpi=90)
    axes.plot(x[~wrong], y[~wrong], "k.", label="points")
    axes.plot(x[wrong], y[wrong], "x", color="0.6", label="wrong points")
    for name, parameters in fits.items():
        curve = arael.runtime_residual(
            f"one * ({equation})", parameters={"one": 1, **parameters}, data={"x": x}
        )
        arael.runtime_model(curve)
        axes.plot(x, curve.residuals[:, 0], label=name)
    axes.set_title(equation)
    axes.legend()
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)


def main(arguments: list[str] | None = None) -> dict[str, dict[str, float]]:
    """Fit twice, without and with a robust loss; print the parameters."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("equation", nargs="?", default=EQUATION)
    parser.add_argument("--start", nargs="+", default=["a=1", "b=0.3", "c=0"], metavar="NAME=VALUE")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)
    start = {name: float(value) for name, _, value in (s.partition("=") for s in args.start)}
    fits = {
        "least squares": fit(args.equation, start, robust=False),
        "robust": fit(args.equation, start, robust=True),
        "robust by code": fit_by_code(args.equation, start),
    }
    for name, parameters in fits.items():
        print(f"{name:14}", *(f"{k} = {v:.4f}" for k, v in parameters.items()))
    if args.plot:
        plot(args.equation, fits, args.plot)
        print("wrote", args.plot)
    return fits


if __name__ == "__main__":
    main()
