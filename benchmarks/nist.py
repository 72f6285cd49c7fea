"""Data sets of NIST's collection for nonlinear regression, as models."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_DECAYS = "b1*exp(-b2*x) + b3*exp(-b4*x) + b5*exp(-b6*x)"
_PEAKS = "b1*exp(-b2*x) + b3*exp(-(x - b4)^2/b5^2) + b6*exp(-(x - b7)^2/b8^2)"
_CUBICS = "(b1 + b2*x + b3*x^2 + b4*x^3) / (1 + b5*x + b6*x^2 + b7*x^3)"

FORMULAS = {
    "Bennett5": "b1 * (b2 + x)^(-1/b3)",
    "BoxBOD": "b1*(1 - exp(-b2*x))",
    "Chwirut1": "exp(-b1*x) / (b2 + b3*x)",
    "Chwirut2": "exp(-b1*x) / (b2 + b3*x)",
    "DanWood": "b1 * x^b2",
    "ENSO": (
        "b1 + b2*cos(2*pi*x/12) + b3*sin(2*pi*x/12) + b5*cos(2*pi*x/b4) + b6*sin(2*pi*x/b4)"
        " + b8*cos(2*pi*x/b7) + b9*sin(2*pi*x/b7)"
    ),
    "Eckerle4": "b1/b2 * exp(-0.5*((x - b3)/b2)^2)",
    "Gauss1": _PEAKS,
    "Gauss2": _PEAKS,
    "Gauss3": _PEAKS,
    "Hahn1": _CUBICS,
    "Kirby2": "(b1 + b2*x + b3*x^2) / (1 + b4*x + b5*x^2)",
    "Lanczos1": _DECAYS,
    "Lanczos2": _DECAYS,
    "Lanczos3": _DECAYS,
    "MGH09": "b1*(x^2 + x*b2) / (x^2 + x*b3 + b4)",
    "MGH10": "b1*exp(b2 / (x + b3))",
    "MGH17": "b1 + b2*exp(-x*b4) + b3*exp(-x*b5)",
    "Misra1a": "b1*(1 - exp(-b2*x))",
    "Misra1b": "b1*(1 - 1/(1 + b2*x/2)^2)",
    "Misra1c": "b1*(1 - 1/sqrt(1 + 2*b2*x))",
    "Misra1d": "b1*b2*x / (1 + b2*x)",
    "Nelson": "b1 - b2*x1*exp(-b3*x2)",
    "Rat42": "b1 / (1 + exp(b2 - b3*x))",
    "Rat43": "b1 / (1 + exp(b2 - b3*x))^(1/b4)",
    "Roszman1": "b1 - b2*x - atan(b3/(x - b4))/pi",
    "Thurber": _CUBICS,
}
"""Formula of each set; parameters are b1, b2 ..."""


def columns(name: str, data: Array) -> dict[str, Array]:
    """Columns of a set by name, the response as ``y``: of Nelson its logarithm."""
    if name == "Nelson":
        return {"y": np.log(data[:, 0]), "x1": data[:, 1], "x2": data[:, 2]}
    return {"y": data[:, 0], "x": data[:, 1]}


def parsed(text: str) -> tuple[Array, float, Array]:
    """Starts, certified values and their standard errors (columns), certified cost, data (y, x).

    Parameters
    ----------
    text : a file of the collection
    """
    number = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
    lines = [line.split("=")[1] for line in text.splitlines() if re.match(r"\s*b\d+ *=", line)]
    values = np.array([[float(v) for v in re.findall(number, line)] for line in lines])
    cost = float(re.search(r"Residual Sum of Squares:\s*(\S+)", text)[1])  # type: ignore[index]
    data = text[text.rindex("Data:") :].splitlines()[1:]
    return values, cost, np.array([[float(v) for v in row.split()] for row in data if row.strip()])


def model_text(name: str, parameters: int) -> str:
    """Text of the model of a set."""
    formula = re.sub(r"\b(b\d)\b", r"root.\1", FORMULAS[name])
    fields = ("x1", "x2", "y") if name == "Nelson" else ("x", "y")
    return (
        "struct Point {\n"
        + "".join(f"    {field}: real\n" for field in fields)
        + f"    constraint fit {{ {formula} - y }}\n}}\n"
        "root A { points: list of Point\n"
        + "".join(f"    param b{k + 1}: real\n" for k in range(parameters))
        + "}\n"
    )


def filled(kind: Any, start: Array, data: Array) -> Any:
    """An instance of a model of a set, at a start."""
    model = kind(**{f"b{k + 1}": value for k, value in enumerate(start)})
    model.points.extend(**columns("Nelson" if data.shape[1] > 2 else "", data))
    return model
