"""Published linkages driven through their range: no step to the other branch.

Mechanisms of the textbooks (Artobolevsky, *Mechanisms in Modern Engineering Design*; Norton,
*Design of Machinery*), where their proportions matter with those, else with proportions of the same
class; where a number is of another source, the test names it. Positions are compared with closed
forms: the intersection of two circles on a side that never changes.
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


# --- linkages of many bars, joint by joint -------------------------------------------------------

Places = dict[str, np.ndarray]


class Bars:
    """A linkage of bars between joints, driven by the direction of its first bar.

    Parameters
    ----------
    places : of all joints
    ground : joints that are locked
    bars : pairs of joints; the first is the crank
    """

    def __init__(self, places: Places, ground: str, bars: str) -> None:
        self.session = Session()
        self.point = {}
        for name, place in places.items():
            (reply,) = self.session.run(f"add_point {place[0]:.17g},{place[1]:.17g} noconnect")
            self.point[name] = reply.names[0]
        for name in ground:
            self.session.run(f"lock {self.point[name]}")
        for k, bar in enumerate(bars.split()):
            a, b = (self.point[name] for name in bar)
            self.session.run(f"add_line {a} {b} noconnect")
            self.session.run(f"coincident L{k}.p1 {a}\ncoincident L{k}.p2 {b}")
            length = float(np.linalg.norm(places[bar[1]] - places[bar[0]]))
            self.session.run(f"length L{k} {length:.17g}")
        a, b = (places[name] for name in bars.split()[0])
        angle = math.degrees(math.atan2(*(b - a)[::-1]))
        self.session.run(f"xangle L0 {angle:.17g}")
        assert self.session.editor.judge.freedoms().total == 0

    def turn(self, degrees: float, expected: Places) -> None:
        """Turn the crank, and compare all joints."""
        self.session.run(f"xangle L0 {degrees:.17g}")
        for name, place in expected.items():
            found = at(self.session, self.point[name])
            assert found == pytest.approx(place, abs=1e-7), (degrees, name)


def jansen(degrees: float) -> Places:
    """A leg with the numbers that Theo Jansen published in "The Great Pretender" (2007)."""
    o, f = np.zeros(2), np.array([-38.0, -7.8])
    m = polar(15.0, degrees)
    up = meet(m, 50.0, f, 41.5, -1)
    low = meet(m, 61.9, f, 39.3, 1)
    out = meet(up, 55.8, f, 40.1, -1)
    knee = meet(out, 39.4, low, 36.7, -1)
    foot = meet(knee, 65.7, low, 49.0, -1)
    return {"o": o, "m": m, "f": f, "u": up, "l": low, "e": out, "k": knee, "g": foot}


def klann(degrees: float) -> Places:
    """A leg of J. Klann (US patent 6260862); lengths of boim.com/Walkin8r/Klann.html."""
    a, b, d = np.zeros(2), np.array([-38.8, -12.5]), np.array([-14.6, 41.9])
    c = polar(17.5, degrees)
    h = meet(c, 38.8, b, 23.7, -1)
    f = meet(c, 73.4, h, 35.2, 1)
    e = meet(f, 57.7, d, 34.1, 1)
    g = meet(e, 111.7, f, 59.0, 1)
    return {"a": a, "b": b, "d": d, "c": c, "h": h, "f": f, "e": e, "g": g}


def stephenson(degrees: float) -> Places:
    """A crank-rocker whose coupler point moves a second rocker (Stephenson III)."""
    a, d, g = np.zeros(2), np.array([4.0, 0.0]), np.array([-2.0, 1.0])
    b = polar(1.0, degrees)
    c = meet(b, 3.5, d, 2.5, 1)
    p = meet(b, 3.0, c, 2.0, 1)
    f = meet(p, 4.0, g, 2.5, 1)
    return {"a": a, "d": d, "g": g, "b": b, "c": c, "p": p, "f": f}


def watt_six(degrees: float) -> Places:
    """Two four-bars in a row, the rocker of the first driving the second (Watt II)."""
    a, d, g = np.zeros(2), np.array([4.0, 0.0]), np.array([8.0, 0.5])
    b = polar(1.0, degrees)
    c = meet(b, 3.5, d, 2.5, 1)
    e = meet(c, 1.5, d, 2.0, 1)
    f = meet(e, 4.0, g, 2.5, 1)
    return {"a": a, "d": d, "g": g, "b": b, "c": c, "e": e, "f": f}


#: Positions of the joints, those on the ground, and the bars, the crank first.
MANY_BARS = {
    "Jansen": (jansen, "of", "om mu uf ml lf ue ef ek lk kg lg"),
    "Klann": (klann, "abd", "ac ch hb cf hf fe ed eg fg"),
    "Stephenson III": (stephenson, "adg", "ab bc cd bp cp pf fg"),
    "Watt II": (watt_six, "adg", "ab bc cd ce ed ef fg"),
}


@pytest.mark.parametrize("name", MANY_BARS)
def test_linkages_of_many_bars_turn_round_on_their_branch(name: str) -> None:
    positions, ground, bars = MANY_BARS[name]
    start = 10.0
    linkage = Bars(positions(start), ground, bars)
    for degrees in [*np.linspace(start, start + 360, 25), *np.linspace(start + 340, start, 7)]:
        linkage.turn(float(degrees), positions(float(degrees)))


def test_watts_linkage_keeps_its_middle_on_a_line_nearly() -> None:
    # Equal rockers on opposite sides of a short coupler: J. Watt's parallel motion of 1784.
    far = np.array([10.0, 2.0])

    def positions(degrees: float) -> Places:
        b = polar(5.0, degrees)
        return {"a": np.zeros(2), "d": far, "b": b, "c": meet(b, 2.0, far, 5.0, 1)}

    linkage = Bars(positions(0.0), "ad", "ab bc cd")
    linkage.session.run("add_point 5,1 noconnect; midpoint P4 L1")
    for degrees in [*np.linspace(0, 22, 8), *np.linspace(22, -22, 15)]:
        expected = positions(float(degrees))
        linkage.turn(float(degrees), expected)
        middle = at(linkage.session, "P4")
        assert middle == pytest.approx((expected["b"] + expected["c"]) / 2, abs=1e-8)
        assert abs(middle[0] - 5.0) < 0.05


def test_harts_inversor_draws_a_straight_line() -> None:
    # Crossed bars 5, short ones 3; the middles O, P, Q of a short and both long ones are in line,
    # and |OP| |OQ| = (25 - 9) / 4 (H. Hart, 1875). P runs on a circle through O.
    def corners(degrees: float) -> tuple[np.ndarray, ...]:
        p = np.array([2.0, 0.0]) + polar(2.0, degrees)
        near = float(np.linalg.norm(p))
        ahead = p / near
        aside = np.array([-ahead[1], ahead[0]])
        q, far = 2 * near, 16 / (2 * near)
        h = math.sqrt(25 - ((far + q) / 2) ** 2)
        # O is the middle of A D; A and C on one parallel, D and B on the other one.
        a = -(far - q) / 4 * ahead - h / 2 * aside
        return a, a + far * ahead, -a + q * ahead, -a, p, p * 4 / near**2

    a, c, b, d, p, _ = corners(60)
    text = " ".join(f"{v[0]:.17g},{v[1]:.17g}" for v in (a, b, c, d, a))
    session = sketch(
        f"add_line {text}; length L0 5; length L1 3; length L2 5; length L3 3\n"
        "add_point 0,0 noconnect; lock P0; midpoint P0 L3\n"
        f"add_line 2,0 {p[0]:.17g},{p[1]:.17g}; lock L4.p1; length L4 2; midpoint L4.p2 L0\n"
        "add_point 1,1 noconnect; midpoint P1 L2\nxangle L4 60"
    )
    assert session.editor.judge.freedoms().total == 0
    for degrees in [*np.linspace(60, 140, 9), *np.linspace(140, 25, 13)]:
        session.run(f"xangle L4 {float(degrees):.17g}")
        expected = corners(float(degrees))
        assert at(session, "P1") == pytest.approx(expected[-1], abs=1e-7)
        assert at(session, "P1")[0] == pytest.approx(1.0, abs=1e-7)
        assert at(session, "L1.p2") == pytest.approx(expected[1], abs=1e-7)


def test_scott_russells_linkage_draws_a_straight_line() -> None:
    # A crank of half the length of the bar at its middle, whose one end slides through the pivot's
    # line: the other end moves at right angles to it, exactly.
    session = sketch("add_line 0,0 1.5,2; lock L0.p1 0,0; length L0 2.5; xangle L0 53")
    session.run("add_line 3,0 0,4; length L1 5; midpoint L0.p2 L1; horizontal L0.p1 L1.p1")
    for degrees in [*np.linspace(53, 85, 9), *np.linspace(85, 5, 17)]:
        session.run(f"xangle L0 {float(degrees):.17g}")
        x, y = polar(2.5, float(degrees))
        assert at(session, "L1.p2") == pytest.approx((0.0, 2 * y), abs=1e-8)
        assert at(session, "L1.p1") == pytest.approx((2 * x, 0.0), abs=1e-8)


def test_the_trammel_of_archimedes_draws_an_ellipse_through_all_quadrants() -> None:
    session = sketch("add_line 4,0 0,3; length L0 5; add_point 0,0 noconnect; lock P0")
    session.run("horizontal P0 L0.p1; vertical P0 L0.p2\nxangle L0 143")
    session.run("add_line L0.p2 -4,6; collinear L0 L1; length L1 2")
    for degrees in [*np.linspace(143, 500, 40), *np.linspace(500, 143, 15)]:
        session.run(f"xangle L0 {float(degrees):.17g}")
        way = polar(1.0, float(degrees))
        assert at(session, "L0.p1") == pytest.approx((-5 * way[0], 0.0), abs=1e-8)
        assert at(session, "L1.p2") == pytest.approx((2 * way[0], 7 * way[1]), abs=1e-8)
