"""Every kind of constraint and dimension, in every form: solved, it means what it says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import minimize_scalar

from arael.sketch.document.handles import takes
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS, Form
from arael.sketch.layout.operands import operands
from tests.sketch.solving import (
    Drawing,
    cross,
    ellipse_points,
    off_ellipse,
    off_line,
    spline_points,
)

Check = Callable[[Drawing], Any]


class Case(NamedTuple):
    kind: str
    args: tuple[str, ...]
    check: Check
    options: Mapping[str, Any] = MappingProxyType({})
    ties: tuple[tuple[str, str], ...] = ()
    freedoms: int | None = None


def drawing_of_all() -> Drawing:
    """One of everything, in general position."""
    d = Drawing()
    d.add("line", 0.0, 0.0, 4.0, 1.0)  # L0
    d.add("line", 1.0, 3.0, 5.2, 3.5)  # L1
    d.add("line", 6.0, 0.0, 7.0, 3.0)  # L2
    d.add("line", 8.0, 1.0, 12.0, 2.2)  # L3
    d.add("circle", 2.0, 6.0, 1.5)  # A0
    d.arc(6.0, 6.0, 2.0, 20.0, 130.0)  # A1
    d.arc(11.0, 6.0, 1.7, -60.0, 200.0)  # A2
    d.add("ellipse", 2.0, 12.0, 2.5, 1.2, 0.3)  # EA0
    d.earc(8.0, 12.0, 2.0, 1.1, -0.2, 10.0, 150.0)  # EA1
    d.add("bezier", 14, 0, 15, 2, 17, 2.5, 19, 1)  # S0
    d.add("bspline", 14, 6, 15, 8, 16.5, 7, 18, 8.5, 19, 6, 21, 7)  # S1
    d.add("point", 3.0, 2.0)  # P0
    d.add("point", 10.0, 9.0)  # P1
    return d


def length(d: Drawing, name: str) -> float:
    a, b = d.line(name)
    return float(np.linalg.norm(b - a))


def axis(d: Drawing, name: str) -> np.ndarray:
    rot = d.ellipse(name)[3]
    return np.array([math.cos(rot), math.sin(rot)])


def sweep(d: Drawing, name: str) -> float:
    center, _ = d.circle(name)
    u, v = d.point(f"{name}.start") - center, d.point(f"{name}.end") - center
    return (math.atan2(v[1], v[0]) - math.atan2(u[1], u[0])) % (2 * math.pi)


def middle(d: Drawing, name: str) -> np.ndarray:
    center, r = d.circle(name)
    u = d.point(f"{name}.start") - center
    angle = math.atan2(u[1], u[0]) + sweep(d, name) / 2
    return center + r * np.array([math.cos(angle), math.sin(angle)])


def mirrored(d: Drawing, point: np.ndarray, line: str) -> np.ndarray:
    n = np.array([-d.direction(line)[1], d.direction(line)[0]])
    return point - 2 * off_line(d, point, line) * n


def rotated(point: np.ndarray, center: np.ndarray, degrees: float) -> np.ndarray:
    a = math.radians(degrees)
    matrix = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    return center + matrix @ (point - center)


def tangent_at(d: Drawing, handle: str) -> np.ndarray:
    """Unit direction of a curve at its end, by finite differences on points along it."""
    name, point = handle.split(".")
    kind = d.document.entities[name].kind
    if kind == "line":
        return d.direction(name)
    if kind == "arc":
        u = d.point(handle) - d.circle(name)[0]
        u = np.array([-u[1], u[0]])
    elif kind == "earc":
        center, rx, ry, rot = d.ellipse(name)
        u = rotated(d.point(handle) - center, np.zeros(2), -math.degrees(rot))
        u = np.array([-u[1] / ry**2, u[0] / rx**2])
        u = rotated(u, np.zeros(2), math.degrees(rot))
    else:
        poles = d.numbers(name).reshape(-1, 2)
        u = poles[1] - poles[0] if point == "p1" else poles[-1] - poles[-2]
    return u / np.linalg.norm(u)


def curvature(d: Drawing, name: str, last: bool) -> float:
    """Signed curvature at an end of a spline, by SciPy's derivatives."""
    poles = d.numbers(name).reshape(-1, 2)
    spans = len(poles) - 3
    knots = np.r_[[0.0] * 3, np.arange(spans + 1), [spans] * 3].astype(float)
    curve = BSpline(knots, poles, 3)
    at = float(spans) if last else 0.0
    u, v = curve(at, 1), curve(at, 2)
    return cross(u, v) / float(np.linalg.norm(u)) ** 3


def ellipse_curvature(d: Drawing, name: str, handle: str) -> float:
    center, rx, ry, rot = d.ellipse(name)
    u = rotated(d.point(handle) - center, np.zeros(2), -math.degrees(rot))
    t = math.atan2(u[1] / ry, u[0] / rx)
    return rx * ry / math.hypot(rx * math.sin(t), ry * math.cos(t)) ** 3


def on_spline(d: Drawing, point: np.ndarray, name: str) -> float:
    """Distance of a point from a spline."""
    poles = d.numbers(name).reshape(-1, 2)
    spans = len(poles) - 3
    knots = np.r_[[0.0] * 3, np.arange(spans + 1), [spans] * 3].astype(float)
    curve = BSpline(knots, poles, 3)
    t = np.linspace(0, spans, 4001)
    k = int(np.argmin(np.sum((curve(t) - point) ** 2, axis=1)))
    found = minimize_scalar(
        lambda t: float(np.linalg.norm(curve(t) - point)),
        bounds=(t[max(k - 1, 0)], t[min(k + 1, 4000)]),
        options={"xatol": 1e-13},
    )
    return float(found.fun)


def touching(d: Drawing, a: str, b: str) -> float:
    """0 where two round curves touch: the least of one's equation on the other is 0."""

    def off(points: np.ndarray, name: str) -> np.ndarray:
        if d.document.entities[name].kind in ("circle", "arc"):
            center, r = d.circle(name)
            return np.linalg.norm(points - center, axis=1) / r - 1
        return np.array([off_ellipse(d, p, name) for p in points])

    values = off(ellipse_points(d, a, 20000), b)
    # A parabola through the sample nearest to zero.
    k = int(np.argmin(np.abs(values)))
    low, mid, high = values[k - 1], values[k], values[(k + 1) % len(values)]
    bend = low - 2 * mid + high
    return float(mid - (high - low) ** 2 / (8 * bend)) if bend else float(mid)


def chord_area(d: Drawing, names: tuple[str, ...]) -> float:
    """Area of a chain by the shoelace formula on many points."""
    points: list[np.ndarray] = []
    for name in names:
        kind = d.document.entities[name].kind
        if kind == "line":
            part = np.array(d.line(name))
        elif kind == "arc":
            center, r = d.circle(name)
            u = d.point(f"{name}.start") - center
            t = math.atan2(u[1], u[0]) + np.linspace(0, sweep(d, name), 20001)
            part = center + r * np.column_stack([np.cos(t), np.sin(t)])
        elif kind == "earc":
            center, rx, ry, rot = d.ellipse(name)
            ends = []
            for point in ("start", "end"):
                u = rotated(d.point(f"{name}.{point}") - center, np.zeros(2), -math.degrees(rot))
                ends.append(math.atan2(u[1] / ry, u[0] / rx))
            t = ends[0] + np.linspace(0, (ends[1] - ends[0]) % (2 * math.pi), 20001)
            u, v = rx * np.cos(t), ry * np.sin(t)
            c, s = math.cos(rot), math.sin(rot)
            part = center + np.column_stack([c * u - s * v, s * u + c * v])
        else:
            part = spline_points(d, name, 20001)
        if points and np.linalg.norm(part[-1] - points[-1][-1]) < np.linalg.norm(
            part[0] - points[-1][-1]
        ):
            part = part[::-1]
        points.append(part)
    p = np.concatenate(points)
    q = np.roll(p, -1, axis=0)
    return abs(float(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])) / 2)


TIED = (("L0.p2", "A1.start"),)

CONSTRAINT_CASES = [
    Case("horizontal", ("L0",), lambda d: d.numbers("L0")[1] - d.numbers("L0")[3]),
    Case("horizontal", ("P0", "L1.p1"), lambda d: d.point("P0")[1] - d.point("L1.p1")[1]),
    Case("vertical", ("L2",), lambda d: d.numbers("L2")[0] - d.numbers("L2")[2]),
    Case("vertical", ("P0", "A0.center"), lambda d: d.point("P0")[0] - d.point("A0.center")[0]),
    Case("parallel", ("L0", "L2"), lambda d: cross(d.direction("L0"), d.direction("L2"))),
    Case("parallel", ("L0", "EA0"), lambda d: cross(d.direction("L0"), axis(d, "EA0"))),
    Case("parallel", ("EA1", "L0"), lambda d: cross(d.direction("L0"), axis(d, "EA1"))),
    Case("parallel", ("EA0", "EA1"), lambda d: cross(axis(d, "EA1"), axis(d, "EA0"))),
    Case("perpendicular", ("L0", "L2"), lambda d: d.direction("L0") @ d.direction("L2")),
    Case("perpendicular", ("L0", "EA0"), lambda d: d.direction("L0") @ axis(d, "EA0")),
    Case("perpendicular", ("EA1", "L0"), lambda d: d.direction("L0") @ axis(d, "EA1")),
    Case("perpendicular", ("EA0", "EA1"), lambda d: axis(d, "EA1") @ axis(d, "EA0")),
    Case("collinear", ("L0", "L3"), lambda d: [off_line(d, p, "L0") for p in d.line("L3")]),
    Case(
        "collinear",
        ("L0", "L3"),
        lambda d: [off_line(d, p, "L0") for p in d.line("L3")],
        ties=(("L0.p2", "L3.p1"),),
        freedoms=1,
    ),
    Case("equal", ("L0", "L2"), lambda d: length(d, "L0") - length(d, "L2")),
    Case("equal", ("A0", "A1"), lambda d: d.circle("A0")[1] - d.circle("A1")[1]),
    Case(
        "equal",
        ("EA0", "EA1"),
        lambda d: np.subtract(d.ellipse("EA0")[1:3], d.ellipse("EA1")[1:3]),
    ),
    Case(
        "equal_angle",
        ("L0", "L1", "L2", "L3"),
        lambda d: (
            math.acos(d.direction("L0") @ d.direction("L1"))
            - math.acos(d.direction("L2") @ d.direction("L3"))
        ),
    ),
    Case(
        "tangent",
        ("L0", "A0"),
        lambda d: abs(off_line(d, d.circle("A0")[0], "L0")) - d.circle("A0")[1],
    ),
    Case(
        "tangent",
        ("A1", "L0"),
        lambda d: abs(off_line(d, d.circle("A1")[0], "L0")) - d.circle("A1")[1],
    ),
    Case(
        "tangent",
        ("L0", "A1"),
        lambda d: abs(off_line(d, d.circle("A1")[0], "L0")) - d.circle("A1")[1],
        ties=TIED,
    ),
    Case(
        "tangent",
        ("L0", "EA0"),
        lambda d: touching_line(d, "L0", "EA0"),
    ),
    Case(
        "tangent",
        ("L0", "EA1"),
        lambda d: touching_line(d, "L0", "EA1"),
        ties=(("L0.p2", "EA1.end"),),
    ),
    Case(
        "tangent",
        ("A0", "A1"),
        lambda d: (
            np.linalg.norm(d.circle("A0")[0] - d.circle("A1")[0])
            - d.circle("A0")[1]
            - d.circle("A1")[1]
        ),
    ),
    Case(
        "tangent",
        ("A0", "A1"),
        lambda d: (
            np.linalg.norm(d.circle("A0")[0] - d.circle("A1")[0])
            - abs(d.circle("A0")[1] - d.circle("A1")[1])
        ),
        {"mode": "inside"},
    ),
    Case(
        "tangent",
        ("A1", "A2"),
        lambda d: (
            np.linalg.norm(d.circle("A1")[0] - d.circle("A2")[0])
            - d.circle("A1")[1]
            - d.circle("A2")[1]
        ),
        ties=(("A1.start", "A2.end"),),
    ),
    Case("tangent", ("EA0", "A0"), lambda d: touching(d, "EA0", "A0")),
    Case("tangent", ("A0", "EA1"), lambda d: touching(d, "EA1", "A0")),
    Case("tangent", ("EA0", "EA1"), lambda d: touching(d, "EA0", "EA1")),
    *(
        Case(
            "tangent",
            pair,
            lambda d, pair=pair: cross(tangent_at(d, pair[0]), tangent_at(d, pair[1])),
            ties=(pair,),
        )
        for pair in (
            ("L0.p2", "L2.p1"),
            ("L0.p2", "A1.start"),
            ("A1.start", "A2.end"),
            ("L1.p2", "EA1.start"),
            ("A1.end", "EA1.start"),
            ("EA1.end", "S0.p1"),
            ("L3.p2", "S0.p1"),
            ("S0.p2", "S1.p1"),
            ("A2.end", "S1.p1"),
        )
    ),
    Case(
        "smooth",
        ("S0.p2", "S1.p1"),
        lambda d: abs(curvature(d, "S0", True)) - abs(curvature(d, "S1", False)),
        ties=(("S0.p2", "S1.p1"),),
    ),
    Case(
        "smooth",
        ("A1.start", "S0.p1"),
        lambda d: abs(curvature(d, "S0", False)) - 1 / d.circle("A1")[1],
    ),
    Case("smooth", ("S1.p2", "L0.p1"), lambda d: curvature(d, "S1", True)),
    Case("smooth", ("A1.end", "A2.start"), lambda d: d.circle("A1")[1] - d.circle("A2")[1]),
    Case(
        "smooth",
        ("EA1.start", "S1.p1"),
        lambda d: abs(curvature(d, "S1", False)) - ellipse_curvature(d, "EA1", "EA1.start"),
    ),
    Case("coincident", ("L0.p2", "P0"), lambda d: d.point("L0.p2") - d.point("P0")),
    Case("concentric", ("A0", "EA1"), lambda d: d.circle("A0")[0] - d.ellipse("EA1")[0]),
    Case("point_on", ("P0", "L0"), lambda d: off_line(d, d.point("P0"), "L0")),
    Case(
        "point_on",
        ("P1", "A1"),
        lambda d: np.linalg.norm(d.point("P1") - d.circle("A1")[0]) - d.circle("A1")[1],
    ),
    Case("point_on", ("P0", "EA0"), lambda d: off_ellipse(d, d.point("P0"), "EA0")),
    Case("point_on", ("P0", "EA1"), lambda d: off_ellipse(d, d.point("P0"), "EA1")),
    Case("point_on", ("P1", "S0"), lambda d: on_spline(d, d.point("P1"), "S0")),
    Case("point_on", ("P1", "S1"), lambda d: on_spline(d, d.point("P1"), "S1")),
    Case("midpoint", ("P0", "L0"), lambda d: 2 * d.point("P0") - sum(d.line("L0"))),
    Case("midpoint", ("P1", "A1"), lambda d: d.point("P1") - middle(d, "A1")),
    Case("midpoint", ("P1", "A2"), lambda d: d.point("P1") - middle(d, "A2")),
    Case(
        "symmetry",
        ("P0", "L2", "P1"),
        lambda d: mirrored(d, d.point("P0"), "L2") - d.point("P1"),
    ),
    Case(
        "symmetry",
        ("L0", "L2", "L3"),
        lambda d: [off_line(d, mirrored(d, p, "L2"), "L3") for p in d.line("L0")],
    ),
    Case(
        "symmetry",
        ("A0", "L2", "A2"),
        lambda d: [
            *(mirrored(d, d.circle("A0")[0], "L2") - d.circle("A2")[0]),
            d.circle("A0")[1] - d.circle("A2")[1],
        ],
    ),
    Case(
        "symmetry",
        ("P0", "A1.center", "P1"),
        lambda d: d.point("P0") + d.point("P1") - 2 * d.point("A1.center"),
    ),
    *(
        Case(
            "on_normal",
            ("P1", end),
            lambda d, end=end: tangent_at(d, end) @ (d.point("P1") - d.point(end)),
        )
        for end in ("L0.p2", "A1.start", "EA1.end", "S0.p1", "S1.p2")
    ),
    Case(
        "image",
        ("L0", "L1"),
        lambda d: [*(d.line("L1")[0] - d.line("L0")[0] - [1, 3])],
        {"mode": "p1", "numbers": (0.0, 1.0, 3.0)},
        freedoms=2,
    ),
    Case(
        "image",
        ("L0", "L2", "P0"),
        lambda d: d.line("L2")[1] - rotated(d.line("L0")[1], d.point("P0"), 30) - [1.0, 0.5],
        {"mode": "p2", "numbers": (30.0, 1.0, 0.5)},
        freedoms=2,
    ),
    Case(
        "image",
        ("EA1", "EA0", "P0"),
        lambda d: [
            *(d.ellipse("EA0")[0] - rotated(d.ellipse("EA1")[0], d.point("P0"), 20)),
            math.sin(d.ellipse("EA0")[3] - d.ellipse("EA1")[3] - math.radians(20)),
            d.ellipse("EA0")[1] - d.ellipse("EA1")[1],
            d.ellipse("EA0")[2] - d.ellipse("EA1")[2],
        ],
        {"mode": "center radius radius_b rotation", "numbers": (20.0, 0.0, 0.0)},
        freedoms=5,
    ),
    Case(
        "image",
        ("A0", "A1", "L0"),
        lambda d: (
            d.circle("A1")[0]
            - d.circle("A0")[0]
            - 4 * d.direction("L0")
            - 0.5 * np.array([-d.direction("L0")[1], d.direction("L0")[0]])
        ),
        {"mode": "center", "numbers": (0.0, 4.0, 0.5)},
        freedoms=2,
    ),
    Case("lock", ("P0",), lambda d: d.point("P0") - [3.1, 2.2], {"numbers": (3.1, 2.2)}),
    Case("fix", ("EA0",), lambda d: 0.0, freedoms=5),
]

SQUARE = (("L0.p2", "L2.p1"), ("L2.p2", "L1.p2"), ("L1.p1", "L0.p1"))

DIMENSION_CASES = [
    Case("length", ("L0",), lambda d: length(d, "L0") - 5, {"value": 5.0}),
    Case(
        "distance",
        ("P0", "A0.center"),
        lambda d: np.linalg.norm(d.point("P0") - d.circle("A0")[0]) - 3,
        {"value": 3.0},
    ),
    Case(
        "distance",
        ("P0", "L2"),
        lambda d: off_line(d, d.point("P0"), "L2") - 2.5,
        {"value": 2.5},
    ),
    Case(
        "distance",
        ("L0", "L1"),
        lambda d: off_line(d, d.line("L1")[0], "L0") - 2,
        {"value": 2.0},
    ),
    Case(
        "distance",
        ("A0", "A1"),
        lambda d: d.circle("A1")[1] - d.circle("A0")[1] - 0.7,
        {"value": 0.7},
        freedoms=3,  # around one centre
    ),
    Case(
        "distance",
        ("A0", "A1"),
        lambda d: apart(d) - d.circle("A0")[1] - d.circle("A1")[1] - 0.7,
        {"value": 0.7, "mode": "outside"},
    ),
    Case(
        "distance",
        ("A0", "A1"),
        lambda d: d.circle("A1")[1] - d.circle("A0")[1] - apart(d) - 0.7,
        {"value": 0.7, "mode": "inside", "side": 1},
    ),
    Case(
        "distance",
        ("P0", "A0"),
        lambda d: np.linalg.norm(d.point("P0") - d.circle("A0")[0]) - d.circle("A0")[1] - 2,
        {"value": 2.0},
    ),
    Case(
        "distance",
        ("L1", "A0"),
        lambda d: off_line(d, d.circle("A0")[0], "L1") - d.circle("A0")[1] - 2,
        {"value": 2.0},
    ),
    Case(
        "hdistance",
        ("P1", "P0"),
        lambda d: d.point("P1")[0] - d.point("P0")[0] - 6,
        {"value": 6.0},
    ),
    Case(
        "vdistance",
        ("P0", "P1"),
        lambda d: d.point("P1")[1] - d.point("P0")[1] - 6,
        {"value": 6.0},
    ),
    Case("radius", ("A1",), lambda d: d.circle("A1")[1] - 2.5, {"value": 2.5}),
    Case("radius", ("EA1",), lambda d: d.ellipse("EA1")[1] - 2.5, {"value": 2.5}),
    Case("diameter", ("A0",), lambda d: d.circle("A0")[1] - 2, {"value": 4.0}),
    Case("radius_b", ("EA0",), lambda d: d.ellipse("EA0")[2] - 1.5, {"value": 1.5}),
    Case("sweep", ("A1",), lambda d: sweep(d, "A1") - math.radians(95), {"value": 95.0}),
    Case("sweep", ("A2",), lambda d: sweep(d, "A2") - math.radians(230), {"value": 230.0}),
    Case("arc_length", ("A1",), lambda d: sweep(d, "A1") * d.circle("A1")[1] - 5, {"value": 5.0}),
    Case(
        "angle",
        ("L0", "L2"),
        lambda d: math.acos(d.direction("L0") @ d.direction("L2")) - math.radians(40),
        {"value": 40.0},
    ),
    Case(
        "angle",
        ("L2", "L0"),
        lambda d: math.acos(d.direction("L0") @ d.direction("L2")) - math.radians(40),
        {"value": 140.0, "mode": "supplement"},
    ),
    Case(
        "xangle",
        ("L2",),
        lambda d: math.atan2(d.direction("L2")[1], d.direction("L2")[0]) - math.radians(60),
        {"value": 60.0},
    ),
    Case("xangle", ("EA0",), lambda d: d.ellipse("EA0")[3] - math.radians(10), {"value": 10.0}),
    Case(
        "total_length",
        ("L0", "A1", "A0"),
        lambda d: (
            length(d, "L0")
            + d.circle("A1")[1] * sweep(d, "A1")
            + 2 * math.pi * d.circle("A0")[1]
            - 18
        ),
        {"value": 18.0},
    ),
    Case(
        "area",
        ("L0", "L2", "L1"),
        lambda d: chord_area(d, ("L0", "L2", "L1")) - 12,
        {"value": 12.0},
        SQUARE,
    ),
    Case(
        "area",
        ("L0", "A1", "L1"),
        lambda d: (chord_area(d, ("L0", "A1", "L1")) - 12) * 1e-3,
        {"value": 12.0},
        (("L0.p2", "A1.start"), ("A1.end", "L1.p2"), ("L1.p1", "L0.p1")),
    ),
    Case(
        "area",
        ("S1", "L1"),
        lambda d: (chord_area(d, ("S1", "L1")) - 4) * 1e-3,
        {"value": 4.0},
        (("S1.p1", "L1.p1"), ("L1.p2", "S1.p2")),
    ),
    Case(
        "area",
        ("EA0",),
        lambda d: math.pi * np.prod(d.ellipse("EA0")[1:3]) - 7,
        {"value": 7.0},
    ),
    Case(
        "area",
        ("EA1", "L1"),
        lambda d: (chord_area(d, ("EA1", "L1")) - 3) * 1e-3,
        {"value": 3.0},
        (("EA1.start", "L1.p1"), ("L1.p2", "EA1.end")),
    ),
    Case("area", ("A0",), lambda d: math.pi * d.circle("A0")[1] ** 2 - 9, {"value": 9.0}),
]


def touching_line(d: Drawing, line: str, name: str) -> float:
    """0 where a line touches an ellipse: the support function."""
    center, rx, ry, rot = d.ellipse(name)
    u = rotated(d.direction(line), np.zeros(2), -math.degrees(rot))
    return abs(off_line(d, center, line)) - math.hypot(rx * u[1], ry * u[0])


def identity(case: Case) -> str:
    mode = case.options.get("mode", "")
    tied = "-tied" if case.ties else ""
    return "-".join([case.kind, *case.args, *mode.split()]) + tied


def laid_out(case: Case) -> tuple[Drawing, str]:
    """The drawing of everything with a case's ties, solved, and then its record."""
    d = drawing_of_all()
    for pair in case.ties:
        d.constrain("coincident", *pair)
    assert d.solver.solve().solved
    if case in DIMENSION_CASES:
        return d, d.dimension(case.kind, *case.args, **case.options)
    return d, d.constrain(case.kind, *case.args, **case.options)


HOMOGENEOUS = [c for c in CONSTRAINT_CASES if c.kind not in ("smooth", "image", "lock", "fix")]


@pytest.mark.sweep(4)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("case", HOMOGENEOUS, ids=identity)
def test_it_holds_at_every_scale(case: Case, scale: float) -> None:
    d = drawing_of_all()
    d.layout.refresh()
    lengths = np.ones(len(d.document.values), dtype=bool)
    for entity in d.document.entities.values():
        if entity.kind in ("ellipse", "earc"):
            lengths[entity.at + entity.size - 1] = False
    with d.document.transaction("scale"):
        values = d.document.values
        factors = np.where(lengths, scale, 1.0)
        d.document.set_values(np.arange(len(values)), values * factors)
    d.layout.gather()
    for pair in case.ties:
        d.constrain("coincident", *pair)
    assert d.solver.solve().solved
    d.constrain(case.kind, *case.args, **case.options)
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    with d.document.transaction("back"):
        d.document.set_values(np.arange(len(factors)), d.document.values / factors)
    assert np.abs(case.check(d)).max() < 1e-7


def form_of(case: Case, d: Drawing) -> Form:
    """The form of `kinds` that a case is of."""
    forms = (CONSTRAINTS.get(case.kind) or DIMENSIONS[case.kind]).forms
    found = operands(d.document, case.args)
    for form in forms:
        wanted = form.operands
        if wanted[-1].endswith("*"):
            wanted = wanted * len(found)
        if len(wanted) == len(found) and all(
            takes(w, one.entity, one.point) for w, one in zip(wanted, found, strict=True)
        ):
            return form
    raise AssertionError(case)


ALL = [*CONSTRAINT_CASES, *DIMENSION_CASES]


@pytest.mark.parametrize("case", ALL, ids=identity)
def test_it_means_what_it_says(case: Case) -> None:
    d, _ = laid_out(case)
    outcome = d.solver.solve()
    assert outcome.solved, outcome
    assert np.abs(case.check(d)).max() < 1e-8
    # and again from a perturbed start
    d.perturb(0.05, seed=len(case.args))
    if case.kind != "fix":
        outcome = d.solver.solve()
        assert outcome.solved, outcome
        assert np.abs(case.check(d)).max() < 1e-8
    d.layout.check()


@pytest.mark.parametrize("case", ALL, ids=identity)
def test_it_takes_its_degrees_of_freedom(case: Case) -> None:
    d, name = laid_out(case)
    assert d.solver.solve().solved
    after = freedoms(d)
    if case in DIMENSION_CASES:
        d.change("dimensions", name, active=False)
    else:
        d.change("constraints", name, active=False)
    expected = form_of(case, d).freedoms if case.freedoms is None else case.freedoms
    assert freedoms(d) - after == expected


def apart(d: Drawing) -> float:
    """Distance of the centres of the first two round curves."""
    return float(np.linalg.norm(d.circle("A1")[0] - d.circle("A0")[0]))


def freedoms(d: Drawing) -> int:
    """Degrees of freedom by the rank of the whole Jacobian."""
    system = d.layout.linearisation()
    matrix = np.zeros((len(system.owners), len(system.x)))
    row_of = np.repeat(np.arange(len(system.owners)), np.diff(system.indptr))
    matrix[row_of, system.indices] = system.entries
    return len(system.x) - int(np.linalg.matrix_rank(matrix, tol=1e-7))


@pytest.mark.parametrize("name", ["EA0", "EA1", "S0"])
def test_a_length_that_no_rows_give_is_refused(name: str) -> None:
    d = drawing_of_all()
    dimension = d.dimension("total_length", name, "L0", value=9.0)
    outcome = d.solver.solve()
    assert not outcome.solved
    assert outcome.open == (dimension,)
    assert name in d.layout.impossible[dimension]


def test_all_forms_are_covered() -> None:
    d = drawing_of_all()
    covered = {(case.kind, form_of(case, d).operands) for case in ALL}
    wanted = {
        (kind, form.operands)
        for table in (CONSTRAINTS, DIMENSIONS)
        for kind, one in table.items()
        for form in one.forms
    }
    assert wanted - covered == set()
