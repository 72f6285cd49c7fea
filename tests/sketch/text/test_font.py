"""The font: every character that was promised, strokes that join, on the grid."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from arael.sketch.geometry import Circle
from arael.sketch.text import ABOVE, BELOW, CAPITAL, GLYPHS, strokes_of
from arael.sketch.text.lettering import Stroke

PROMISED = "".join(map(chr, range(32, 127))) + "°±Ø×µäöüÄÖÜß"


def test_the_font_has_every_character_that_was_promised() -> None:
    assert sorted(GLYPHS) == sorted(PROMISED)


@pytest.mark.parametrize("one", PROMISED)
def test_a_character_lies_on_the_grid(one: str) -> None:
    width, _ = GLYPHS[one]
    for stroke in strokes_of(one):
        for piece in stroke:
            box = piece.bounds()
            assert box.x_min >= -0.01 and box.x_max <= width + 0.01
            assert box.y_min >= BELOW - 0.01 and box.y_max <= ABOVE


@pytest.mark.parametrize("one", PROMISED)
def test_pieces_of_a_stroke_join(one: str) -> None:
    for stroke in strokes_of(one):
        for a, b in pairwise(stroke):
            assert math.dist(a.end, b.start) < 1e-9


def points(strokes: tuple[Stroke, ...]) -> list[tuple[float, float]]:
    return [
        (round(x, 3), round(y, 3))
        for stroke in strokes
        for piece in stroke
        for x, y in (piece.point_at(k / 8) for k in range(9))
    ]


def test_no_two_characters_look_the_same() -> None:
    found = {str(sorted(set(points(strokes_of(one))))) for one in PROMISED}
    assert len(found) == len(PROMISED)


def test_capitals_and_digits_are_as_high_as_the_grid_says() -> None:
    for one in "ABCDEFGHIJKLMNOPRSTUVWXYZ0123456789":
        ys = [y for _, y in points(strokes_of(one))]
        assert min(ys) == pytest.approx(0.0, abs=0.3)
        assert max(ys) == pytest.approx(CAPITAL, abs=0.3)


def test_a_dot_is_a_circle() -> None:
    ((dot,),) = strokes_of(".")
    assert isinstance(dot, Circle)
