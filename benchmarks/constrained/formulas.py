"""Small problems, written once as formulas over x1, x2, ..., for arael and for CasADi.

Of W. Hock, K. Schittkowski, "Test Examples for Nonlinear Programming Codes", 1981, those whose
objective is a sum of squares. Starts that violate a bound keep it as a row, because a start outside
of the bounds of a parameter is an error.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Formulas:
    """``min sum r^2`` with rows that hold.

    Attributes
    ----------
    residuals : formulas
    rows : comparisons, ``A == B``, ``A >= B`` or ``A <= B``
    start : values of x1, x2, ...
    cost : at the optimum
    bounds : of parameters by number from 1, (low, high) or None where open
    """

    name: str
    residuals: tuple[str, ...]
    rows: tuple[str, ...]
    start: tuple[float, ...]
    cost: float
    bounds: dict[int, tuple[float | None, float | None]] | None = None
    tolerance: float = 1e-7

    def text(self) -> str:
        """The model in the language of arael."""
        lines = ["root Problem {"]
        for k in range(1, len(self.start) + 1):
            low, high = (self.bounds or {}).get(k, (None, None))
            ends = f"{'' if low is None else low} .. {'' if high is None else high}"
            lines.append(f"    param x{k}: real" + (f" in {ends}" if ends != " .. " else ""))
        lines.append(f"    constraint cost {{ [{', '.join(self.residuals)}] }}")
        for k, row in enumerate(self.rows, 1):
            lines.append(f"    require row{k} {{ {row} }}")
        return "\n".join([*lines, "}", ""])

    def data(self) -> dict[str, float]:
        """The start."""
        return {f"x{k}": float(value) for k, value in enumerate(self.start, 1)}

    def casadi(self, ca: Any) -> dict[str, Any]:
        """The same as arguments of ``nlpsol``, and of its call."""
        n = len(self.start)
        x = ca.SX.sym("x", n)
        names = {f"x{k + 1}": x[k] for k in range(n)}
        names |= {one: getattr(ca, one) for one in ("sin", "cos", "sqrt", "exp", "log")}

        def value(formula: str) -> Any:
            return eval(formula.replace("^", "**"), {"__builtins__": {}}, names)

        low = [-math.inf] * n
        high = [math.inf] * n
        for k, (a, b) in (self.bounds or {}).items():
            low[k - 1] = -math.inf if a is None else a
            high[k - 1] = math.inf if b is None else b
        g, lbg, ubg = [], [], []
        for row in self.rows:
            left, op, right = re.split(r"(==|>=|<=)", row)
            g.append(value(left) - value(right))
            lbg.append(-math.inf if op == "<=" else 0.0)
            ubg.append(math.inf if op == ">=" else 0.0)
        cost = sum(value(r) ** 2 for r in self.residuals)
        return {
            "nlp": {"x": x, "f": cost, "g": ca.vertcat(*g)},
            "call": {"x0": self.start, "lbx": low, "ubx": high, "lbg": lbg, "ubg": ubg},
        }


_ROSENBROCK = ("10 * (x2 - x1^2)", "1 - x1")
_NEAR = ("x1 - x2", "x2 + x3 - 2", "x4 - 1", "x5 - 1")
_POWERS = ("(x4 - 1)^2", "(x5 - 1)^3")
_FIVE = ("x1 + 3 * x2 == 0", "x3 + x4 - 2 * x5 == 0", "x2 - x5 == 0")
_HALF = ("x1 >= -0.5", "x1 <= 0.5")

FORMULAS = (
    Formulas("hs1", _ROSENBROCK, ("x2 >= -1.5",), (-2, 1), 0),
    # From the start of the book, (-2, 1), the next optimum is another one.
    Formulas("hs2", _ROSENBROCK, ("x2 >= 1.5",), (2, 1), 0.0504261879),
    Formulas("hs6", ("1 - x1",), ("10 * (x2 - x1^2) == 0",), (-1.2, 1), 0),
    Formulas(
        "hs14",
        ("x1 - 2", "x2 - 1"),
        ("x1 - 2 * x2 + 1 == 0", "1 - 0.25 * x1^2 - x2^2 >= 0"),
        (2, 2),
        9 - 2.875 * math.sqrt(7),
    ),
    Formulas(
        "hs15",
        _ROSENBROCK,
        ("x1 * x2 >= 1", "x1 + x2^2 >= 0", "x1 <= 0.5"),
        (-2, 1),
        306.5,
    ),
    Formulas(
        "hs16",
        _ROSENBROCK,
        ("x1 + x2^2 >= 0", "x1^2 + x2 >= 0", *_HALF, "x2 <= 1"),
        (2, 1),  # as for hs2
        0.25,
    ),
    Formulas(
        "hs17",
        _ROSENBROCK,
        ("x2^2 - x1 >= 0", "x1^2 - x2 >= 0", *_HALF, "x2 <= 1"),
        (-2, 1),
        1,
    ),
    Formulas(
        "hs18",
        ("0.1 * x1", "x2"),
        ("x1 * x2 >= 25", "x1^2 + x2^2 >= 25"),
        (2, 2),
        5,
        {1: (2, 50), 2: (0, 50)},
    ),
    Formulas(
        "hs20",
        _ROSENBROCK,
        ("x1 + x2^2 >= 0", "x1^2 + x2 >= 0", "x1^2 + x2^2 >= 1", *_HALF),
        (2, 1),  # as for hs2
        81.5 - 25 * math.sqrt(3),
    ),
    Formulas("hs22", ("x1 - 2", "x2 - 1"), ("x1 + x2 <= 2", "x2 >= x1^2"), (2, 2), 1),
    Formulas(
        "hs23",
        ("x1", "x2"),
        (
            "x1 + x2 >= 1",
            "x1^2 + x2^2 >= 1",
            "9 * x1^2 + x2^2 >= 9",
            "x1^2 - x2 >= 0",
            "x2^2 - x1 >= 0",
        ),
        (3, 1),
        2,
        {1: (-50, 50), 2: (-50, 50)},
    ),
    Formulas(
        "hs26",
        ("x1 - x2", "(x2 - x3)^2"),
        ("(1 + x2^2) * x1 + x3^4 == 3",),
        (-2.6, 2, 2),
        0,
    ),
    Formulas("hs27", ("0.1 * (x1 - 1)", "x2 - x1^2"), ("x1 + x3^2 == -1",), (2, 2, 2), 0.04),
    Formulas("hs28", ("x1 + x2", "x2 + x3"), ("x1 + 2 * x2 + 3 * x3 == 1",), (-4, 1, 1), 0),
    Formulas(
        "hs30",
        ("x1", "x2", "x3"),
        ("x1^2 + x2^2 >= 1",),
        (1, 1, 1),
        1,
        {1: (1, 10), 2: (-10, 10), 3: (-10, 10)},
    ),
    Formulas(
        "hs31",
        ("3 * x1", "x2", "3 * x3"),
        ("x1 * x2 >= 1",),
        (1, 1, 1),
        6,
        {1: (-10, 10), 2: (1, 10), 3: (-10, 1)},
    ),
    Formulas(
        "hs32",
        ("x1 + 3 * x2 + x3", "2 * (x1 - x2)"),
        ("6 * x2 + 4 * x3 - x1^3 >= 3", "x1 + x2 + x3 == 1"),
        (0.1, 0.7, 0.2),
        1,
        {k: (0, None) for k in (1, 2, 3)},
    ),
    Formulas(
        "hs42",
        ("x1 - 1", "x2 - 2", "x3 - 3", "x4 - 4"),
        ("x1 == 2", "x3^2 + x4^2 == 2"),
        (1, 1, 1, 1),
        28 - 10 * math.sqrt(2),
    ),
    Formulas(
        "hs46",
        ("x1 - x2", "x3 - 1", *_POWERS),
        ("x1^2 * x4 + sin(x4 - x5) == 1", "x2 + x3^4 * x4^2 == 2"),
        (math.sqrt(2) / 2, 1.75, 0.5, 2, 2),
        0,
    ),
    Formulas(
        "hs48",
        ("x1 - 1", "x2 - x3", "x4 - x5"),
        ("x1 + x2 + x3 + x4 + x5 == 5", "x3 - 2 * (x4 + x5) == -3"),
        (3, 5, -3, 2, -2),
        0,
    ),
    Formulas(
        "hs49",
        ("x1 - x2", "x3 - 1", *_POWERS),
        ("x1 + x2 + x3 + 4 * x4 == 7", "x3 + 5 * x5 == 6"),
        (10, 7, 2, -3, 0.8),
        0,
    ),
    Formulas(
        "hs50",
        ("x1 - x2", "x2 - x3", "(x3 - x4)^2", "x4 - x5"),
        (
            "x1 + 2 * x2 + 3 * x3 == 6",
            "x2 + 2 * x3 + 3 * x4 == 6",
            "x3 + 2 * x4 + 3 * x5 == 6",
        ),
        (35, -31, 11, 5, -5),
        0,
    ),
    Formulas(
        "hs51",
        _NEAR,
        ("x1 + 3 * x2 == 4", "x3 + x4 - 2 * x5 == 0", "x2 - x5 == 0"),
        (2.5, 0.5, 2, -1, 0.5),
        0,
    ),
    Formulas("hs52", ("4 * x1 - x2", *_NEAR[1:]), _FIVE, (2, 2, 2, 2, 2), 1859 / 349),
    Formulas("hs53", _NEAR, _FIVE, (2, 2, 2, 2, 2), 176 / 43, {k: (-10, 10) for k in range(1, 6)}),
    Formulas(
        "hs60",
        ("x1 - 1", "x1 - x2", "(x2 - x3)^2"),
        ("x1 * (1 + x2^2) + x3^4 == 4 + 3 * sqrt(2)",),
        (2, 2, 2),
        0.03256820025,
        {k: (-10, 10) for k in (1, 2, 3)},
    ),
    Formulas(
        "hs65",
        ("x1 - x2", "(x1 + x2 - 10) / 3", "x3 - 5"),
        ("x1^2 + x2^2 + x3^2 <= 48", "x1 >= -4.5", "x1 <= 4.5", "x2 >= -4.5", "x2 <= 4.5"),
        (-5, 5, 0),
        0.9535288567,
        {3: (-5, 5)},
    ),
    Formulas(
        "hs77",
        ("x1 - 1", "x1 - x2", "x3 - 1", *_POWERS),
        (
            "x1^2 * x4 + sin(x4 - x5) == 2 * sqrt(2)",
            "x2 + x3^4 * x4^2 == 8 + sqrt(2)",
        ),
        (2, 2, 2, 2, 2),
        0.24150513,
    ),
    Formulas(
        "hs79",
        ("x1 - 1", "x1 - x2", "x2 - x3", "(x3 - x4)^2", "(x4 - x5)^2"),
        (
            "x1 + x2^2 + x3^3 == 2 + 3 * sqrt(2)",
            "x2 - x3^2 + x4 == 2 * sqrt(2) - 2",
            "x1 * x5 == 2",
        ),
        (2, 2, 2, 2, 2),
        0.0787768209,
    ),
)
