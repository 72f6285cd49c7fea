"""A model with every kind of function, and libm's functions to bind."""

from __future__ import annotations

import ctypes
import ctypes.util
import math
from typing import Any

MODEL = """
const HALF = 0.5

fn sigmoid(x) = 1 / (1 + exp(-x))                  # a formula
fn both(v) = [v.x * v.y, sigmoid(v.x)]             # of a vector
fn pair(x, y) = [x * y, x + HALF * y]              # a vector of scalars
fn grow(x) derivs [grow(x)] = exp(x)               # its own derivative
extern fn si(x) derivs [co(x)]                     # native, each the derivative of the other
extern fn co(x) derivs [-si(x)]
extern fn arc(y, x) derivs [x / (x * x + y * y), -y / (x * x + y * y)]

struct Point {
    u: real
    v: real
    constraint near when co(u) > 0 {
        let p = root.p
        [si(p.x * u) - v, grow(0.3 * p.y) * arc(u, 2 + p.y) + both(p).x - si(u),
         if p.x > 100 then si(p.x) else sigmoid(p.y) - 0.1 * v]
    }
}

root Fit PRECISION {
    param p: vec2
    points: list of Point
}
"""


def libm(name: str, arguments: int = 1) -> Any:
    """A function of the C library, with its signature."""
    library = ctypes.CDLL(ctypes.util.find_library("m"))
    found = getattr(library, name)
    found.restype, found.argtypes = ctypes.c_double, [ctypes.c_double] * arguments
    return found


def native() -> dict[str, Any]:
    """What the model's native functions are bound to, as pointers."""
    return {"si": libm("sin"), "co": libm("cos"), "arc": libm("atan2", 2)}


PYTHON = {"si": math.sin, "co": math.cos, "arc": math.atan2}


def data() -> dict[str, Any]:
    """Data of a root."""
    points = [{"u": 0.1 * k - 0.8, "v": math.sin(0.7 * k)} for k in range(30)]
    return {"p": [0.4, -0.3], "points": points}
