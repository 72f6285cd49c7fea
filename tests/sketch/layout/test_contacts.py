"""Where ellipses touch is found among the places where they nearly do."""

import math
from itertools import permutations

import numpy as np
import pytest

from arael.sketch.commands.session import Session
from arael.sketch.document.document import Document
from arael.sketch.geometry import Ellipse
from arael.sketch.layout.operands import operands
from arael.sketch.layout.tangency import contact

# From within they touch; a quarter of a unit away there is another common normal, along which they
# are 6e-4 apart, and then they cross.
TOUCHING = (
    (6.145481500073528, 5.411668600268189, 4.235517179382294, 12.46011339769349, 2.76338360512042),
    (-7.196354097026493, 17.941340694660177, 8.283839177213675, 26.09452305433295, 3.54334619538),
)
PLACE = (2.5892885732, -6.2133148748)


def document_of(numbers: tuple[tuple[float, ...], ...]) -> Document:
    document = Document()
    with document.transaction("ellipses"):
        for one in numbers:
            document.add_entity("ellipse", list(one))
    return document


@pytest.mark.parametrize("turn", [0.0, 0.01, 0.02, 0.03, 0.05])
def test_of_several_common_normals_that_of_no_length_is_taken(turn: float) -> None:
    """`turn` shifts the samples of the search along the curve."""
    c, s = math.cos(turn), math.sin(turn)
    turned = tuple(
        (c * x - s * y, s * x + c * y, rx, ry, rotation + turn)
        for x, y, rx, ry, rotation in TOUCHING
    )
    document = document_of(turned)
    args = operands(document, tuple(document.entities))
    found = contact(document.values, *args)
    x, y = PLACE
    assert found == pytest.approx((c * x - s * y, s * x + c * y), abs=1e-4)


def test_the_place_is_on_both() -> None:
    for x, y, rx, ry, rotation in TOUCHING:
        curve = Ellipse((x, y), rx, ry, rotation)
        points = np.array([curve.point_at(t) for t in np.linspace(0, 1, 200_001)])
        assert np.hypot(*(points - PLACE).T).min() < 1e-3


@pytest.mark.sweep(4)
@pytest.mark.parametrize("aspect", [1e-1, 1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("side", [1, -1])
def test_a_circle_touches_a_flat_ellipse_where_it_was_drawn_to(aspect: float, side: int) -> None:
    """At its flanks and at its tips, from outside and from inside, where it crosses it as well."""
    rng = np.random.default_rng(5)
    for k in range(40):
        rx = rng.uniform(1, 5)
        ry = rx * aspect * rng.uniform(1, 3)
        rotation, radius = rng.uniform(0, 2 * math.pi), rng.uniform(0.3, 4)
        angle = rng.choice([0, math.pi]) + 3 * aspect * rng.normal()
        if k % 2:
            angle = rng.uniform(0, 2 * math.pi)
        point = np.array([rx * math.cos(angle), ry * math.sin(angle)])
        normal = np.array([ry * math.cos(angle), rx * math.sin(angle)])
        center = point + side * radius * normal / math.hypot(*normal)
        c, s = math.cos(rotation), math.sin(rotation)
        turned = np.array([[c, -s], [s, c]])
        document = Document()
        with document.transaction("draw"):
            document.add_entity("ellipse", (0, 0, rx, ry, rotation))
            document.add_entity("circle", (*(turned @ center), radius))
        ellipse, circle = operands(document, tuple(document.entities))
        found = contact(document.values, ellipse, circle)
        assert math.dist(found, turned @ point) < 1e-12


def test_a_circle_about_the_centre_of_a_round_ellipse_touches_it_somewhere() -> None:
    document = Document()
    with document.transaction("draw"):
        document.add_entity("ellipse", (1, 2, 3, 3, 0.5))
        document.add_entity("circle", (1, 2, 3))
    ellipse, circle = operands(document, tuple(document.entities))
    assert math.dist(contact(document.values, ellipse, circle), (1, 2)) == pytest.approx(3)


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi, -math.pi / 2])
@pytest.mark.parametrize("side", [1, -1])
def test_a_circle_touches_an_ellipse_at_its_vertices(angle: float, side: int) -> None:
    rx, ry, radius = 1.733, 2.614, 4.341
    point = np.array([round(math.cos(angle)) * rx, round(math.sin(angle)) * ry])
    center = point + side * radius * point / math.hypot(*point)
    document = Document()
    with document.transaction("draw"):
        document.add_entity("ellipse", (0, 0, rx, ry, 0))
        document.add_entity("circle", (*center, radius))
    ellipse, circle = operands(document, tuple(document.entities))
    assert math.dist(contact(document.values, ellipse, circle), point) < 1e-12


TOUCH = ("tangent L0 A0", "point_on P0 L0", "point_on P0 A0")


@pytest.mark.parametrize("order", list(permutations(TOUCH)))
def test_a_point_on_a_line_and_its_circle_is_where_they_touch(order: tuple[str, ...]) -> None:
    """Where both pass through a point their distance has no derivative: directions are compared."""
    session = Session()
    session.run(
        "add_circle 0,0 3 noconnect; add_line -5,4 6,3.5 noconnect; add_point 1,3.5 noconnect"
    )
    session.run("lock A0.center; radius A0 3")
    for line in order:
        session.run(line)
    a, b, c, d = session.document.numbers_of("L0").tolist()
    way = complex(c - a, d - b)
    foot = complex(a, b) + way * (-complex(a, b) * way.conjugate()).real / abs(way) ** 2
    point = complex(*session.document.numbers_of("P0").tolist())
    assert abs(point - foot) < 1e-9
    assert abs(foot) == pytest.approx(3.0, abs=1e-9)
    assert session.editor.judge.freedoms().total == 3  # of the line; none of the point
    session.editor.layout.check()
