"""A platform on legs, a survey by images and a calibration, with lengths that are known exactly.

Their optimal costs are those of Ipopt with a tolerance of 1e-12 and of SciPy's SLSQP, which agree.
"""

from __future__ import annotations

import math
from itertools import combinations

from benchmarks.constrained.formulas import Formulas


def _square(a: tuple[object, ...], b: tuple[object, ...]) -> str:
    """Square of the distance of two points."""
    return " + ".join(f"({p} - {q})^2" for p, q in zip(a, b, strict=True))


def stewart() -> Formulas:
    """A platform of three joints on six legs of limited length, whose goal is out of reach."""
    joints = [tuple(f"x{3 * k + j + 1}" for j in range(3)) for k in range(3)]
    cost, rows, start = [], [], []
    for k, joint in enumerate(joints):
        angle = 2 * math.pi * k / 3
        goal = (
            0.5 * math.cos(angle + 0.4) + 0.6,
            0.5 * math.sin(angle + 0.4) + 0.1,
            1.3 + 0.2 * math.cos(angle),
        )
        cost += [f"{x} - {g!r}" for x, g in zip(joint, goal, strict=True)]
        start += [0.5 * math.cos(angle), 0.5 * math.sin(angle), 1.0]
        for turn in (-0.7, 0.7):
            foot = (math.cos(angle + turn), math.sin(angle + turn), 0.0)
            rows += [f"{_square(joint, foot)} >= 0.8", f"{_square(joint, foot)} <= 1.8"]
    rows += [f"{_square(a, b)} == 0.75" for a, b in combinations(joints, 2)]
    return Formulas("stewart", tuple(cost), tuple(rows), tuple(start), 0.6931728083460735)


def survey() -> Formulas:
    """Three images of two walls: walls are vertical, and one distance was taped."""
    # Two walls meet in a corner; places are east, north, up.
    truth = [
        (east, north, up)
        for up in (0.0, 2.5)
        for east, north in ((-2.0, 6.0), (0.0, 6.8), (1.2, 7.28), (2.4, 5.5), (2.0, 6.0933333333))
    ]
    stations = [(0.0, 0.0, 1.5, 0.0), (-2.0, 0.5, 1.6, -0.3), (2.5, 0.3, 1.4, 0.35)]
    count = len(truth)
    points = [tuple(f"x{3 * k + j + 1}" for j in range(3)) for k in range(count)]
    first = 3 * count
    poses: list[tuple[object, ...]] = [stations[0]]
    poses += [tuple(f"x{first + 4 * k + j + 1}" for j in range(4)) for k in range(2)]
    start = [
        value + 0.1 * math.sin(9 * k + j) for k, p in enumerate(truth) for j, value in enumerate(p)
    ]
    start += [
        value + 0.05 * math.cos(7 * k + j)
        for k, p in enumerate(stations[1:])
        for j, value in enumerate(p)
    ]
    cost = []
    for i, (pose, station) in enumerate(zip(poses, stations, strict=True)):
        for k, (point, place) in enumerate(zip(points, truth, strict=True)):
            east, north, up = (f"({p} - {c})" for p, c in zip(point, pose[:3], strict=True))
            yaw = pose[3]
            ahead = f"({north} * cos({yaw}) + {east} * sin({yaw}))"
            side = f"({east} * cos({yaw}) - {north} * sin({yaw}))"
            e, n, u = (p - c for p, c in zip(place, station[:3], strict=True))
            c, s = math.cos(station[3]), math.sin(station[3])
            across = (e * c - n * s) / (n * c + e * s) + 3e-3 * math.sin(5 * k + 3 * i)
            height = u / (n * c + e * s) + 3e-3 * math.cos(4 * k + 7 * i)
            cost += [
                f"300 * ({side} / {ahead} - {across!r})",
                f"300 * ({up} / {ahead} - {height!r})",
            ]

    def upright(a: int, b: int, c: int) -> str:
        """Three points of one vertical wall are in line on the plan."""
        (e0, n0, _), (e1, n1, _), (e2, n2, _) = points[a], points[b], points[c]
        return f"({e1} - {e0}) * ({n2} - {n0}) - ({e2} - {e0}) * ({n1} - {n0}) == 0"

    half = count // 2
    rows = [f"{_square(points[0], points[3])} == {4.4**2 + 0.5**2!r}"]
    rows += [upright(0, 1, k) for k in (2, half, half + 1, half + 2)]
    rows += [upright(2, 3, k) for k in (4, half + 2, half + 3, half + 4)]
    return Formulas("survey", tuple(cost), tuple(rows), tuple(start), 7.369282782591)


def traced_length() -> Formulas:
    """Distances by an instrument of unknown offset and scale, with a bar of traceable length."""
    truth = ((0.0, 0.0), (4.0, 0.0), (1.0, 3.0), (5.0, 4.0), (2.0, 5.0), (3.5, 2.0))
    count = len(truth)
    points: list[tuple[object, object]] = [(0.0, 0.0), ("x1", 0.0)]
    points += [(f"x{2 * k}", f"x{2 * k + 1}") for k in range(1, count - 1)]
    offset, scale = f"x{2 * count - 2}", f"x{2 * count - 1}"
    start = [3.8]
    for k, (x, y) in enumerate(truth[2:]):
        start += [x + 0.2 * math.sin(3 * k), y + 0.2 * math.cos(5 * k)]
    start += [0.0, 1.0]
    cost = []
    for k, (a, b) in enumerate(combinations(range(count), 2)):
        seen = 0.05 + 1.02 * math.dist(truth[a], truth[b]) + 2e-3 * math.sin(11 * k)
        cost.append(
            f"500 * ({offset} + {scale} * sqrt({_square(points[a], points[b])}) - {seen!r})"
        )
    bar = math.dist(truth[2], truth[3])
    rows = (f"sqrt({_square(points[2], points[3])}) == {bar!r}",)
    return Formulas("traced_length", tuple(cost), rows, tuple(start), 3.045126161004)


METROLOGY = (stewart(), survey(), traced_length())
