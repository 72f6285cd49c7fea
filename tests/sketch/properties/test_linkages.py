"""Published linkages driven through their range: no step to the other branch.

Mechanisms of the textbooks (Artobolevsky, *Mechanisms in Modern Engineering Design*; Norton,
*Design of Machinery*), where their proportions matter with those, else with proportions of the same
class. Positions are compared with closed forms: the intersection of two circles on a side that
never changes.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.sketch.commands.session import Session


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def at(session: Session, handle: str) -> np.ndarray:
    offset = session.document.point_at(handle)
    return session.document.values[offset : offset + 2].copy()


def meet(a: np.ndarray, r: float, b: np.ndarray, s: float, side: int) -> np.ndarray:
    """The point at `r` from `a` and `s` from `b`, left of the way from a to b if side > 0."""
    d = b - a
    q = float(d @ d)
    t = (q + r * r - s * s) / (2 * q)
    h = math.sqrt(r * r / q - t * t)
    return a + t * d + side * h * np.array([-d[1], d[0]])


def polar(r: float, degrees: float) -> np.ndarray:
    return r * np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


#: Ground, crank, coupler, follower, and the crank's range.
FOUR_BARS = {
    "crank-rocker": (4.0, 1.0, 3.5, 2.5, (0, 359)),
    "drag link": (1.0, 3.0, 2.5, 2.5, (0, 359)),
    "double crank": (2.0, 4.0, 3.5, 5.0, (0, 359)),
    "double rocker": (4.0, 3.0, 1.5, 3.5, (40, 62)),
    "triple rocker": (4.0, 3.0, 3.0, 2.5, (30, 80)),
    "parallelogram": (5.0, 2.0, 5.0, 2.0, (20, 160)),
    "Chebyshev": (4.0, 5.0, 2.0, 5.0, (40, 70)),
    "Roberts": (2.0, 1.2, 1.0, 1.2, (50, 80)),
    "Hoeken": (2.0, 1.0, 2.5, 2.5, (0, 359)),
}


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", FOUR_BARS)
def test_four_bars_stay_on_their_branch(name: str, side: int) -> None:
    ground, crank, coupler, follower, (low, high) = FOUR_BARS[name]
    angles = np.linspace(low, high, 25)[1:-1]
    pivot = np.array([ground, 0.0])

    def joint(degrees: float) -> np.ndarray:
        # On the open branch the follower's joint keeps its side of the diagonal.
        return meet(polar(crank, degrees), coupler, pivot, follower, side)

    a, b = polar(crank, angles[0]), joint(angles[0])
    session = sketch(
        f"add_line 0,0 {a[0]:.17g},{a[1]:.17g} {b[0]:.17g},{b[1]:.17g} {ground},0\n"
        f"lock L0.p1 0,0; lock L2.p2 {ground},0\n"
        f"length L0 {crank}; length L1 {coupler}; length L2 {follower}; xangle L0 {angles[0]:.17g}"
    )
    assert session.editor.judge.freedoms().total == 0
    for angle in [*angles, *angles[::-1]]:
        session.run(f"xangle L0 {float(angle):.17g}")
        assert at(session, "L1.p2") == pytest.approx(joint(float(angle)), abs=1e-8), angle


@pytest.mark.parametrize("offset", [0.0, 0.6])
def test_a_slider_crank_keeps_its_side(offset: float) -> None:
    x = math.sqrt(16 - offset**2)
    session = sketch(
        f"add_line 0,0 1,0 {1 + x:.17g},{offset}\n"
        "lock L0.p1 0,0; length L0 1; length L1 4; xangle L0 1"
    )
    session.run(f"add_line -9,{offset} 9,{offset}; fix L2\npoint_on L1.p2 L2")
    for angle in np.linspace(1, 359, 40):
        session.run(f"xangle L0 {float(angle):.17g}")
        c, s = polar(1.0, float(angle))
        expected = (c + math.sqrt(16 - (offset - s) ** 2), offset)
        assert at(session, "L1.p2") == pytest.approx(expected, abs=1e-8)


def test_a_scotch_yoke_is_a_sine() -> None:
    session = sketch("add_line 0,0 2,0.1; lock L0.p1 0,0; length L0 2; xangle L0 3")
    session.run("add_point 2,0; horizontal P0 L0.p1; vertical P0 L0.p2")
    for angle in np.linspace(3, 357, 40):
        session.run(f"xangle L0 {float(angle):.17g}")
        assert at(session, "P0") == pytest.approx((polar(2.0, float(angle))[0], 0.0), abs=1e-9)


def test_a_quick_return_swings_as_its_formula() -> None:
    # Inverted slider-crank: the crank's pin runs along a lever that turns about another pivot.
    session = sketch("add_line 0,0 1,0; lock L0.p1 0,0; length L0 1; xangle L0 2")
    session.run("add_line 0,-2.5 1.6,1.5; lock L1.p1 0,-2.5; length L1 5; point_on L0.p2 L1")
    for angle in np.linspace(2, 358, 40):
        session.run(f"xangle L0 {float(angle):.17g}")
        way = polar(1.0, float(angle)) + np.array([0.0, 2.5])
        expected = np.array([0.0, -2.5]) + 5 * way / np.linalg.norm(way)
        assert at(session, "L1.p2") == pytest.approx(expected, abs=1e-8)


def test_a_peaucellier_linkage_draws_a_straight_line() -> None:
    # Arms 5 from the pole, a rhombus of sides 2, the inner corner on a circle through the pole.
    def corners(degrees: float) -> tuple[np.ndarray, ...]:
        inner = np.array([2.0, 0.0]) + polar(2.0, degrees)
        near = float(np.linalg.norm(inner))
        outer = inner * (25 - 4) / near**2
        zero = np.zeros(2)
        return inner, meet(zero, 5, outer, 2, 1), meet(zero, 5, outer, 2, -1), outer

    inner, b, d, outer = corners(40)
    text = {
        k: f"{v[0]:.17g},{v[1]:.17g}" for k, v in zip("ibdo", (inner, b, d, outer), strict=True)
    }
    session = sketch(
        f"add_line 2,0 {text['i']}\nlock L0.p1 2,0\n"
        f"add_line 0,0 {text['b']}; add_line 0,0 {text['d']}\nlock L1.p1 0,0\n"
        f"add_line {text['i']} {text['b']} {text['o']} {text['d']} {text['i']}\n"
        "length L0 2; length L1 5; length L2 5\n"
        "length L3 2; length L4 2; length L5 2; length L6 2; xangle L0 40"
    )
    assert session.editor.judge.freedoms().total == 0
    x = 21 / 4
    for angle in [*np.linspace(40, 66, 14), *np.linspace(66, 10, 10)]:
        if not 2.999 < np.linalg.norm(corners(float(angle))[0]) < 6.999:
            continue
        session.run(f"xangle L0 {float(angle):.17g}")
        assert at(session, "L4.p2")[0] == pytest.approx(x, abs=1e-9)
        assert at(session, "L4.p2") == pytest.approx(corners(float(angle))[3], abs=1e-8)


def test_a_chebyshev_lambda_follows_its_curve() -> None:
    # Crank 1, ground 2, rocker 2.5, coupler 2.5 drawn out to twice its length.
    pivot = np.array([2.0, 0.0])
    start = polar(1.0, 5)
    b = meet(start, 2.5, pivot, 2.5, 1)
    end = 2 * b - start
    session = sketch(
        f"add_line 0,0 {start[0]:.17g},{start[1]:.17g} {end[0]:.17g},{end[1]:.17g}\n"
        f"add_line 2,0 {b[0]:.17g},{b[1]:.17g}\nmidpoint L2.p2 L1\n"
        "lock L0.p1 0,0; lock L2.p1 2,0; length L0 1; length L1 5; length L2 2.5; xangle L0 5"
    )
    for angle in np.linspace(5, 355, 36):
        session.run(f"xangle L0 {float(angle):.17g}")
        a = polar(1.0, float(angle))
        expected = 2 * meet(a, 2.5, pivot, 2.5, 1) - a
        assert at(session, "L1.p2") == pytest.approx(expected, abs=1e-8)


def test_a_pantograph_enlarges() -> None:
    session = sketch("add_line 0,0 2,3 4,0\nadd_line 1,1.5 2,0 3,1.5\nlock L0.p1 0,0")
    session.run("midpoint L2.p1 L0; midpoint L3.p2 L1; length L0 3.6; length L1 3.6")
    session.run("length L2 1.8; length L3 1.8")
    for k in range(30):
        target = 2.0 + 0.7 * math.cos(k / 3), 0.7 * math.sin(k / 3)
        session.editor.drag({"L2.p2": target})
        assert at(session, "L2.p2") == pytest.approx(target, abs=1e-8)
        assert at(session, "L1.p2") == pytest.approx(2 * np.array(target), abs=1e-7)


def test_lazy_tongs_stretch_evenly() -> None:
    # Three crossed pairs of bars of length 4, pinned in the middle and at their ends.
    lines = [
        f"add_line {3 * k},{y} {3 * (k + 1)},{2.6457513 - y}"
        for k in range(3)
        for y in (0, 2.6457513)
    ]
    session = sketch("\n".join(lines) + "\nlock L0.p1 0,0; vertical L0.p1 L1.p1")
    for k in range(3):
        session.run(f"add_point {3 * k + 1.5},1.32287565; midpoint P{k} L{2 * k}")
        session.run(f"midpoint P{k} L{2 * k + 1}")
    for k in range(6):
        session.run(f"length L{k} 4")
    session.run("distance L0.p1 L1.p1 2.6457513")
    for width in np.linspace(2.6, 0.5, 15):
        session.run(f"distance L0.p1 L1.p1 {float(width):.17g}")
        step = math.sqrt(16 - width**2)
        assert at(session, "L4.p2")[0] == pytest.approx(3 * step, abs=1e-6)
