"""Data sets of NIST's collection for nonlinear regression, as models."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FORMULAS = {
    "BoxBOD": "b1*(1 - exp(-b2*x))",
    "Chwirut1": "exp(-b1*x) / (b2 + b3*x)",
    "DanWood": "b1 * x^b2",
    "ENSO": (
        "b1 + b2*cos(2*pi*x/12) + b3*sin(2*pi*x/12) + b5*cos(2*pi*x/b4) + b6*sin(2*pi*x/b4)"
        " + b8*cos(2*pi*x/b7) + b9*sin(2*pi*x/b7)"
    ),
    "Gauss1": "b1*exp(-b2*x) + b3*exp(-(x - b4)^2/b5^2) + b6*exp(-(x - b7)^2/b8^2)",
    "Hahn1": "(b1 + b2*x + b3*x^2 + b4*x^3) / (1 + b5*x + b6*x^2 + b7*x^3)",
    "Kirby2": "(b1 + b2*x + b3*x^2) / (1 + b4*x + b5*x^2)",
    "Lanczos3": "b1*exp(-b2*x) + b3*exp(-b4*x) + b5*exp(-b6*x)",
    "MGH09": "b1*(x^2 + x*b2) / (x^2 + x*b3 + b4)",
    "MGH10": "b1*exp(b2 / (x + b3))",
    "MGH17": "b1 + b2*exp(-x*b4) + b3*exp(-x*b5)",
    "Misra1a": "b1*(1 - exp(-b2*x))",
    "Misra1b": "b1*(1 - 1/(1 + b2*x/2)^2)",
    "Misra1c": "b1*(1 - 1/sqrt(1 + 2*b2*x))",
    "Roszman1": "b1 - b2*x - atan(b3/(x - b4))/pi",
    "Thurber": "(b1 + b2*x + b3*x^2 + b4*x^3) / (1 + b5*x + b6*x^2 + b7*x^3)",
}
"""Formula of each set; parameters are b1, b2 ..."""


def parsed(text: str) -> tuple[Array, float, Array]:
    """Starts and certified values (columns), certified cost, and data (y, x) of a NIST file."""
    number = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
    lines = [line.split("=")[1] for line in text.splitlines() if re.match(r"\s*b\d+ =", line)]
    values = np.array([[float(v) for v in re.findall(number, line)] for line in lines])
    cost = float(re.search(r"Residual Sum of Squares:\s*(\S+)", text)[1])  # type: ignore[index]
    data = text[text.rindex("Data:") :].splitlines()[1:]
    return values, cost, np.array([[float(v) for v in row.split()] for row in data if row.strip()])


def model_text(name: str, parameters: int) -> str:
    """Text of the model of a set."""
    formula = re.sub(r"\b(b\d)\b", r"root.\1", FORMULAS[name])
    return (
        "struct Point { x: real\n y: real\n"
        f"    constraint fit {{ {formula} - y }}\n}}\n"
        "root A { points: list of Point\n"
        + "".join(f"    param b{k + 1}: real\n" for k in range(parameters))
        + "}\n"
    )


def filled(kind: Any, start: Array, data: Array) -> Any:
    """An instance of a model of a set, at a start."""
    model = kind(**{f"b{k + 1}": value for k, value in enumerate(start)})
    model.points.extend(x=data[:, 1], y=data[:, 0])
    return model
