"""Models and formulas to start from: what the package ships, examples, documents and tests hold."""
# ruff: noqa: E501 - models, a line each or more

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_BLOCK = re.compile(r"^```arael[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@cache
def models() -> tuple[tuple[str, str], ...]:
    """Name of the origin, and text; small ones come more than once, whole models are few."""
    files = [*(ROOT / "models").glob("*.arael"), *(ROOT / "examples").glob("*/*.arael")]
    found = {path.read_text(encoding="utf-8"): path for path in sorted(files)}
    for path in sorted([*(ROOT / "tests").rglob("*.md"), *(ROOT / "docs").rglob("*.md")]):
        for match in _BLOCK.finditer(path.read_text(encoding="utf-8")):
            found.setdefault(match[1], path)
    for path in sorted((ROOT / "tests").rglob("*.py")):
        if path.parent.name in ("fuzz", "faults"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = node.value
                if 30 < len(text) < 4000 and "root " in text and "{" in text:
                    found.setdefault(text, path)
    return tuple((str(path.relative_to(ROOT)), text) for text, path in found.items())


SMALL = (
    "struct Point { x: real; y: real }\nroot Line {\n    param a: real\n    param b: real = 1\n"
    "    data: list of Point\n    fit data as e { a * e.x + b - e.y }\n}\n",
    "struct Pose {\n    param p: vec3\n    param e: euler\n    w: real = 1\n    on: bool\n"
    "    constraint near { 1e-2 * [p, e] }\n}\n"
    "struct Seen {\n    a: ref Pose in root.poses\n    b: ref Pose in root.poses\n    d: vec3\n"
    "    constraint step when a.on loss huber(1) { a.w * (a.e.rotation_matrix()' * (b.p - a.p) - d) }\n}\n"
    "root Walk {\n    poses: deque of Pose\n    seen: list of Seen\n    scale: real = 2\n"
    "    solve { pass coarse { freeze poses.e } pass fine { scale = 1 } }\n}\n",
    "struct Turn {\n    param r: rotation\n    param q: quaternion\n    param h: angle\n"
    "    param T: transform\n    param d: direction\n    v: vec3\n    gps: vec2?\n"
    "    constraint turn { [r.rotate(v) - q.rotate(v), sin(h)] }\n    constraint far { T * v - d }\n"
    "    constraint sky when gps { T.translation.x - gps.x }\n    constraint still { 0.1 * [(T * T.value.inverse()).log(), d - d.value, q.x, q.y, q.z] }\n}\n"
    "root Turns {\n    turns: arena of Turn\n    param g: vec2\n    constraint own { g - [0.3, 0.4] }\n}\n",
    "fn soft(x) = x / sqrt(1 + x * x)\nconst K = pi / 4\nstruct In { k: real; z: vec2 }\n"
    "struct Spot {\n    param x: real in 0 .. 10 = 4\n    param y: vec2\n    info: In\n    more: list of In\n"
    "    constraint c {\n        let s = soft(x - info.k)\n        [s, K * y.x, log(1 + y.y^2)]\n    }\n}\n"
    "root Spots : f32 {\n    all: list of Spot\n    param t: real\n"
    "    constraint c loss cauchy(2) { [if t > 1 then t^2 - 2 else atan2(t, 2), max(t, 0.5)] }\n}\n",
)
"""Models that use most of the language and take little time each."""

FORMULAS = (
    "a * exp(-b * x) + c", "1 / (1 + exp(-x))", "sqrt(a^2 + b^2) / c", "sin(x) * cos(y) - tan(a)",
    "atan2(a, b) + hypot(x, y)", "log(1 + x^2) / log10(3 + y^2)", "if x > a then b else c * x",
    "max(a, min(b, x)) + abs(y)", "clamp(x, 0, 1) * heaviside(y - a)", "sign(x) + floor(y) + ceil(a)",
    "dot([a, b, c], [x, y, 1])", "cross([1, a, b], [x, 0, c])", "norm([a - x, b - y])",
    "unit([a, b, 1 + c^2])", "[[a, b], [c, x]] * [1, y]", "x^2^y + x^-0.5 - a^0", "starship(x - a, 3)",
    "rad_diff(a, b) + deg2rad(x)", "cbrt(x) + fast_atan(y)", "2 * (3 - -4) / 5e-3", "a.x + b[0]'",
    "tanh(a * x) - sinh(b) / cosh(c)", "asin(x / 3) + acos(y / 3)", "identity(a) * identity2(b)",
)  # fmt: skip
"""Formulas of numbers and vectors, every kind of function."""

STATEMENTS = (
    "{}", "diff({}, x)", "diff({}, a, 2)", "simplify({})", "expand({})", "collect({}, x)",
    "jacobian([{}, x], [a, b])", "subs({}, x, 1 + y)", "latex({})", "python({})", "c({})",
    "f(x) = {}; f(2) + f(f(a))", "x = 2; {}", "a = {}; a * a",
)  # fmt: skip
"""What the calculator is asked about a formula."""
