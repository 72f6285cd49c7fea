"""Linkages, arms, chains, cams and paths, generated as formulas for arael and for CasADi.

Their optimal costs are those of Ipopt with a tolerance of 1e-12, but for two: on the cam it stops
short, and the three links have an optimum that is better than the one it finds.
"""

from __future__ import annotations

import math

from benchmarks.constrained.formulas import Formulas


def four_bar() -> Formulas:
    """A closed four-bar linkage whose coupler point comes as close to a target as it can."""
    coupler = ("x1 + 0.5 * (x3 - x1) - 0.6 * (x4 - x2)", "x2 + 0.5 * (x4 - x2) + 0.6 * (x3 - x1)")
    return Formulas(
        "four_bar",
        tuple(f"{c} - {t}" for c, t in zip(coupler, (1.0, 2.6), strict=True)),
        (
            "x1^2 + x2^2 == 1",
            "(x3 - x1)^2 + (x4 - x2)^2 == 4",
            "(x3 - 2.5)^2 + x4^2 == 2.25",
        ),
        (0.5, 0.9, 2.4, 1.4),
        0.0536654541938,
    )


def three_links(times: int = 20) -> Formulas:
    """An arm of three links whose tip is on a curve at each time, with least accelerations."""
    cost, rows, start = [], [], []

    def joint(k: int, j: int) -> str:
        return f"x{3 * k + j + 1}"

    for k in range(times):
        a, b, c = (joint(k, j) for j in range(3))
        angle = 0.5 * math.pi * k / (times - 1)
        target = 1.9 * math.cos(angle), 0.3 + 1.6 * math.sin(angle)
        rows.append(f"cos({a}) + cos({a} + {b}) + 0.5 * cos({a} + {b} + {c}) == {target[0]!r}")
        rows.append(f"sin({a}) + sin({a} + {b}) + 0.5 * sin({a} + {b} + {c}) == {target[1]!r}")
        rows.append(f"{b} <= 1.2")
        rows.append(f"{c} >= 0.2")
        start += [angle - 0.5, 0.9, 0.4]
    for k in range(1, times - 1):
        cost += [f"{joint(k - 1, j)} - 2 * {joint(k, j)} + {joint(k + 1, j)}" for j in range(3)]
    return Formulas("three_links", tuple(cost), tuple(rows), tuple(start), 1.57880673e-4)


def hanging_chain(links: int = 20) -> Formulas:
    """Links of one length between two hooks, with least energy, as squares of roots."""
    cost, rows, start = [], [], []
    length = 12 / links

    def point(k: int) -> tuple[str, str]:
        if k in (0, links):
            return ("0", "0") if k == 0 else ("8", "1")
        return f"x{2 * k - 1}", f"x{2 * k}"

    for k in range(1, links):
        cost.append(f"sqrt({point(k)[1]} + 20)")
        part = k / links
        start += [8 * part, part - 6 * part * (1 - part)]
    for k in range(links):
        (a, b), (c, d) = point(k), point(k + 1)
        rows.append(f"({c} - {a})^2 + ({d} - {b})^2 == {length**2!r}")
    return Formulas("hanging_chain", tuple(cost), tuple(rows), tuple(start), 341.5665999949)


def cam(count: int = 24) -> Formulas:
    """Lifts of a cam at equal angles: given dwell and peak, convex enough, with least jerks."""
    cost, rows = [], ["x1 == 0", f"x{count} == 1"]
    start = [k / (count - 1) for k in range(count)]
    for k in range(1, count - 2):
        cost.append(f"100 * (x{k + 3} - 3 * x{k + 2} + 3 * x{k + 1} - x{k})")
    for k in range(1, count):
        rows.append(f"x{k + 1} - x{k} >= 0")
        rows.append(f"x{k + 1} - x{k} <= 0.07")
    rows.append("x2 - x1 == 0")
    rows.append(f"x{count} - x{count - 1} == 0")
    return Formulas("cam", tuple(cost), tuple(rows), tuple(start), 0.2352557411)


def spectrum(bands: int = 12) -> Formulas:
    """Parts of a mixture by its spectrum: none is negative, and they sum to one."""
    cost = []
    for k in range(2 * bands):
        at = k / 2
        model = " + ".join(
            f"{math.exp(-0.5 * ((at - j) / 1.5) ** 2)!r} * x{j + 1}" for j in range(bands)
        )
        seen = sum(w * math.exp(-0.5 * ((at - j) / 1.5) ** 2) for j, w in ((2, 0.5), (7, 0.6)))
        cost.append(f"100 * ({model} - {seen + 0.02 * math.sin(5.0 * k)!r})")
    total = " + ".join(f"x{j + 1}" for j in range(bands))
    return Formulas(
        "spectrum",
        tuple(cost),
        (f"{total} == 1",),
        (1 / bands,) * bands,
        322.5204427940,
        {j: (0, None) for j in range(1, bands + 1)},
    )


def race_line(count: int = 30) -> Formulas:
    """Offsets from the middle of a closed track that make the line's curvature least."""

    def at(k: int) -> tuple[float, float, float, float]:
        t = 2 * math.pi * (k % count) / count
        r = 10 + 2.5 * math.cos(3 * t)
        return r * math.cos(t), r * math.sin(t), math.cos(t), math.sin(t)

    cost = []
    for k in range(count):
        for axis in (0, 1):
            terms = []
            for shift, weight in ((-1, 1), (0, -2), (1, 1)):
                here = at(k + shift)
                number = (k + shift) % count + 1
                terms.append(f"{weight} * ({here[axis]!r} + {here[2 + axis]!r} * x{number})")
            cost.append(" + ".join(terms))
    rows = tuple(f"-1.5 <= x{k + 1}" for k in range(count))
    rows += tuple(f"x{k + 1} <= 1.5" for k in range(count))
    return Formulas("race_line", tuple(cost), rows, (0.0,) * count, 9.0879713255)


def rig(count: int = 12) -> Formulas:
    """Two receivers on one vehicle at a fixed distance, along a path of noisy fixes."""
    cost, rows, start = [], [], []
    for k in range(count):
        a, b, c, d = (f"x{4 * k + j}" for j in (1, 2, 3, 4))
        x, y, turn = 0.8 * k, math.sin(0.4 * k), 0.4 * math.cos(0.4 * k)
        fixes = (
            x - 0.5 * math.cos(turn) + 0.1 * math.sin(7 * k),
            y - 0.5 * math.sin(turn) + 0.1 * math.cos(5 * k),
            x + 0.5 * math.cos(turn) + 0.1 * math.sin(3 * k),
            y + 0.5 * math.sin(turn) + 0.1 * math.cos(9 * k),
        )
        cost += [f"10 * ({p} - {fix!r})" for p, fix in zip((a, b, c, d), fixes, strict=True)]
        rows.append(f"({c} - {a})^2 + ({d} - {b})^2 == 1")
        start += [x - 0.3, y, x + 0.4, y + 0.1]
    return Formulas("rig", tuple(cost), tuple(rows), tuple(start), 3.3751926574)


def limits_of_reach(joints: int = 7) -> Formulas:
    """Inverse kinematics of a planar arm with joint limits, closest to its rest."""
    names = [f"x{k + 1}" for k in range(joints)]
    angles = [" + ".join(names[: k + 1]) for k in range(joints)]
    tip = [" + ".join(f"{f}({a})" for a in angles) for f in ("cos", "sin")]
    return Formulas(
        "limits_of_reach",
        tuple(f"0.1 * {name}" for name in names),
        (f"{tip[0]} == 2.5", f"{tip[1]} == 4.0"),
        (0.3,) * joints,
        0.0100663534,
        {k + 1: (-0.5, 0.5) for k in range(joints)},
    )


GEOMETRY = (
    four_bar(),
    three_links(),
    hanging_chain(),
    cam(),
    spectrum(),
    race_line(),
    rig(),
    limits_of_reach(),
)
