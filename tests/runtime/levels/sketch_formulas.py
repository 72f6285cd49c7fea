"""What each struct of `models/sketch.arael` means, in complex numbers and angles.

Written without looking at the model's cross and dot products: a point is a complex number.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Values = dict[str, Any]  # refs: complex points, real scalars; fields: numbers
Formula = Callable[[Values], Any]


def smaller(*lengths: float) -> float:
    """A smooth lower bound of the smallest length."""
    return float(1 / np.sqrt(sum(length**-2.0 for length in lengths)))


def turn(u: complex, v: complex) -> float:
    return float(np.angle(v * np.conj(u)))


def ahead(angle: float, low: float) -> float:
    """The angle in (low, low + 2 pi]."""
    return float(low + 2 * np.pi - (low - angle) % (2 * np.pi))


def sweep(v: Values) -> float:
    turned = turn(v["start"] - v["center"], v["end"] - v["center"])
    return turned if turned > 0 else turned + 2 * np.pi


def beside(p: complex, a: complex, b: complex) -> float:
    """How far p is to the left of the line from a to b."""
    return float(((p - a) * abs(b - a) / (b - a)).imag)


def along(p: complex, a: complex, b: complex) -> float:
    return float(((p - a) * abs(b - a) / (b - a)).real)


def mirrored(p: complex, a: complex, b: complex) -> complex:
    return complex(a + np.conj((p - a) / (b - a)) * (b - a))


def lines(v: Values, names: str = "abcd") -> tuple[complex, complex]:
    a, b, c, d = (v[name] for name in names)
    return b - a, d - c


def apart(v: Values, value: float, wave: Callable[[float], float], names: str = "abcd") -> float:
    one, other = lines(v, names)
    return float(wave(turn(one, other) - value) * smaller(abs(one), abs(other)))


def plane(*points: complex) -> list[float]:
    return [part for point in points for part in (point.real, point.imag)]


def ellipse_angle(v: Values, p: str) -> float:
    """Angle of the point on the unit circle of which an ellipse is the image."""
    u = (v[p] - v["center"]) * np.exp(-1j * v["rot"])
    return float(np.angle(complex(u.real / v["rx"], u.imag / v["ry"])))


def ellipse_normal(v: Values, end: str = "") -> complex:
    """Gradient of half of q = (x/rx)^2 + (y/ry)^2, in the plane."""
    turned = np.exp(1j * v["rot" + end])
    u = (v["p"] - v["center" + end]) / turned
    return complex(turned * complex(u.real / v["rx" + end] ** 2, u.imag / v["ry" + end] ** 2))


def on_ellipse(v: Values) -> float:
    u = v["p"] - v["center"]
    n = ellipse_normal(v)
    q = np.sqrt((n * np.conj(u)).real)
    return float(abs(u) * (1 - 1 / q) * ((n * np.conj(u)).real / (abs(n) * abs(u))))


def line_ellipse(v: Values) -> float:
    """Left distance of the centre less the largest reach of points of the ellipse."""
    t = np.linspace(0, 2 * np.pi, 20001)
    point = np.exp(1j * v["rot"]) * (v["rx"] * np.cos(t) + 1j * v["ry"] * np.sin(t))
    across = (point * abs(v["b"] - v["a"]) / (v["b"] - v["a"])).imag
    k = int(across.argmax())
    # The parabola through three samples around the largest one.
    y0, y1, y2 = across[k - 1], across[k], across[(k + 1) % 20000]
    reach = y1 + (y0 - y2) ** 2 / (8 * (2 * y1 - y0 - y2))
    return float(v["side"] * beside(v["center"], v["a"], v["b"]) - reach)


def normal_size(v: Values, end: str = "") -> float:
    return abs(ellipse_normal(v, end)) * v["rx" + end] * v["ry" + end]


def cubic(v: Values, order: int = 0) -> complex:
    t = v["t"]
    weights = np.reshape(v["basis"], (4, 4)) @ (
        np.array([1, t, t**2, t**3]) if order == 0 else np.array([0, 1, 2 * t, 3 * t**2])
    )
    return complex(weights @ np.array([v["p0"], v["p1"], v["p2"], v["p3"]]))


def cubic_turn(v: Values) -> tuple[float, float]:
    u, w = cubic(v, 1), v["b"] - v["a"]
    return turn(u, w), smaller(abs(u), abs(w))


def curvature(p0: complex, p1: complex, p2: complex, factor: float) -> float:
    """Of a spline at its beginning; factor 2/3 for a Bezier curve: tested by itself."""
    u, w = p1 - p0, p2 - p1
    return float(factor * abs(w) * np.sin(turn(u, w)) / abs(u) ** 2)


def equal_angle(v: Values) -> float:
    u, w = lines(v)
    s, t = lines(v, "efgh")
    off = v["side"] * turn(s, t) - turn(u, w)
    return float(np.sin(off) * smaller(abs(u), abs(w), abs(s), abs(t)))


def smooth_splines(v: Values) -> float:
    one = curvature(v["p0"], v["p1"], v["p2"], v["factor_p"])
    other = curvature(v["q0"], v["q1"], v["q2"], v["factor_q"])
    size = abs(v["p1"] - v["p0"]) * abs(v["q1"] - v["q0"])
    return float((one - v["side"] * other) * size)


def image_along(v: Values) -> complex:
    unit = (v["b"] - v["a"]) / abs(v["b"] - v["a"])
    return complex(v["q"] - v["p"] - unit * (v["along"] + 1j * v["left"]))


def ellipse_area(v: Values) -> float:
    """Area between an arc of an ellipse and its chord: that of a circle, stretched."""
    first, last = ellipse_angle(v, "start"), ellipse_angle(v, "end")
    turned = (last - first) % (2 * np.pi)
    return float(v["side"] * v["rx"] * v["ry"] * (turned - np.sin(turned)) / 2)


def sweep_guard(v: Values) -> float:
    u, w = v["start"] - v["center"], v["end"] - v["center"]
    angle = turn(u, w)
    shape = v["side"] * np.sin(angle) + 4 * max(-np.cos(angle), 0)
    return float(shape * smaller(abs(u), abs(w)))


FORMULAS: dict[str, Formula] = {
    "Coincident": lambda v: plane(v["p"] - v["q"]),
    "Lock": lambda v: plane(v["p"] - complex(*v["at"])),
    "Horizontal": lambda v: (v["b"] - v["a"]).imag,
    "Vertical": lambda v: (v["b"] - v["a"]).real,
    "HorizontalDistance": lambda v: v["side"] * (v["b"] - v["a"]).real - v["value"],
    "VerticalDistance": lambda v: v["side"] * (v["b"] - v["a"]).imag - v["value"],
    "Distance": lambda v: abs(v["b"] - v["a"]) - v["value"],
    "PointLineDistance": lambda v: v["side"] * beside(v["p"], v["a"], v["b"]) - v["value"],
    "Midpoint": lambda v: plane(v["m"] - (v["a"] + v["b"]) / 2),
    "OnNormal": lambda v: along(v["p"], v["a"], v["b"]) - along(v["foot"], v["a"], v["b"]),
    "Parallel": lambda v: apart(v, 0, np.sin),
    "Perpendicular": lambda v: apart(v, 0, np.cos),
    "Angle": lambda v: apart(v, v["value"], np.sin),
    "XAngle": lambda v: abs(v["b"] - v["a"]) * np.sin(np.angle(v["b"] - v["a"]) - v["value"]),
    "Collinear": lambda v: [beside(v[end], v["a"], v["b"]) for end in "cd"],
    "EqualAngle": equal_angle,
    "EqualLength": lambda v: abs(v["b"] - v["a"]) - abs(v["d"] - v["c"]),
    "ScalarValue": lambda v: v["a"] - v["value"],
    "Difference": lambda v: v["side"] * (v["a"] - v["b"]) - v["value"],
    "PointOnCircle": lambda v: abs(v["p"] - v["center"]) - v["r"],
    "TangentLineCircle": lambda v: v["side"] * beside(v["center"], v["a"], v["b"]) - v["r"],
    "TangentCircles": lambda v: (
        abs(v["center_a"] - v["center_b"]) - v["r_a"] - v["side"] * v["r_b"]
    ),
    "Sweep": lambda v: (
        np.sin(sweep(v) - v["value"])
        * smaller(abs(v["start"] - v["center"]), abs(v["end"] - v["center"]))
    ),
    "ArcLength": lambda v: v["r"] * sweep(v) - v["value"],
    "ArcMidpoint": lambda v: [
        abs(v["m"] - v["center"]) - v["r"],
        along(v["m"], v["start"], v["end"]) - abs(v["end"] - v["start"]) / 2,
    ],
    "SymmetricPoints": lambda v: [
        along(v["q"], v["a"], v["b"]) - along(v["p"], v["a"], v["b"]),
        (beside(v["q"], v["a"], v["b"]) + beside(v["p"], v["a"], v["b"])) / 2,
    ],
    "SymmetricAboutPoint": lambda v: plane((v["p"] + v["q"]) / 2 - v["center"]),
    "SymmetricLines": lambda v: [
        beside(mirrored(v[end], v["e"], v["f"]), v["c"], v["d"]) for end in "ab"
    ],
    "RotatedImage": lambda v: plane(
        v["q"] - v["center"] - np.exp(1j * v["value"]) * (v["p"] - v["center"])
    ),
    "ShiftedImage": lambda v: plane(v["q"] - v["p"] - complex(*v["shift"])),
    "ImageAlong": lambda v: plane(image_along(v)),
    "PointOnEllipse": on_ellipse,
    "TangentLineEllipse": line_ellipse,
    "EllipseNormalAlong": lambda v: (
        np.sin(turn(ellipse_normal(v), v["b"] - v["a"]))
        * smaller(normal_size(v), abs(v["b"] - v["a"]))
    ),
    "EllipseTangentAlong": lambda v: (
        np.cos(turn(ellipse_normal(v), v["b"] - v["a"]))
        * smaller(normal_size(v), abs(v["b"] - v["a"]))
    ),
    "TangentEllipses": lambda v: (
        np.sin(turn(ellipse_normal(v, "_a"), ellipse_normal(v, "_b")))
        * smaller(normal_size(v, "_a"), normal_size(v, "_b"))
    ),
    "AxisAngle": lambda v: (
        abs(v["b"] - v["a"]) * np.sin(np.angle(v["b"] - v["a"]) - v["rot"] - v["value"])
    ),
    "AxesAngle": lambda v: (
        np.sin(v["rot_b"] - v["rot_a"] - v["value"]) * smaller(v["rx_a"], v["rx_b"])
    ),
    "PointOnCubic": lambda v: plane(cubic(v) - v["p"]),
    "CubicTangentAlong": lambda v: np.sin(cubic_turn(v)[0]) * cubic_turn(v)[1],
    "CubicNormalAlong": lambda v: np.cos(cubic_turn(v)[0]) * cubic_turn(v)[1],
    "SmoothSplineArc": lambda v: (
        abs(v["p1"] - v["p0"]) ** 2
        * (curvature(v["p0"], v["p1"], v["p2"], v["factor"]) - v["side"] / v["r"])
    ),
    "SmoothSplines": smooth_splines,
    "AngleMeasure": lambda v: (
        ahead(v["side"] * turn(*lines(v)), -np.pi / 2) + v["turn"] - v["value"]
    ),
    "XAngleMeasure": lambda v: np.angle(v["b"] - v["a"]) + v["turn"] - v["value"],
    "SweepMeasure": lambda v: sweep(v) - v["value"],
    "LineArea": lambda v: (np.conj(v["a"]) * v["b"]).imag / 2 - v["value"],
    "ArcArea": lambda v: (
        v["side"] * (v["r"] ** 2 * sweep(v) / 2 - v["r"] ** 2 * np.sin(sweep(v)) / 2) - v["value"]
    ),
    "EllipseArcArea": lambda v: ellipse_area(v) - v["value"],
    "SplineCurvature": lambda v: curvature(v["p0"], v["p1"], v["p2"], v["factor"]) - v["value"],
    "EllipseCurvature": lambda v: (
        1 / (v["rx"] * v["ry"]) ** 2 / abs(ellipse_normal(v)) ** 3 - v["value"]
    ),
    "SegmentGuard": lambda v: (np.conj(complex(*v["along"])) * (v["b"] - v["a"])).real,
    "TurnGuard": lambda v: apart(v, v["value"], np.cos),
    "SweepGuard": sweep_guard,
}

# Fields that are no lengths; what else is a number of the model's fields scales with the drawing.
PURE = {
    "side", "turn", "basis", "factor", "factor_p", "factor_q", "weight", "rot", "t",
}  # fmt: skip
ANGLES = {"Angle", "XAngle", "Sweep", "RotatedImage", "AxisAngle", "AxesAngle", "TurnGuard"}
# The power of a length that residuals and `value` are, where it is not 1.
POWERS = {
    "AngleMeasure": 0, "XAngleMeasure": 0, "SweepMeasure": 0, "LineArea": 2, "ArcArea": 2,
    "EllipseArcArea": 2,    "SplineCurvature": -1, "EllipseCurvature": -1, "SegmentGuard": 2,
}  # fmt: skip
