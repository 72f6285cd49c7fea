"""Lettering follows its frame."""

from __future__ import annotations

import math

import pytest

from arael.sketch.geometry import Affine, Arc, Circle, Line
from arael.sketch.text import (
    bounds_of,
    box_of,
    height_of,
    lettering,
    unknown_characters,
    width_of,
)


def ends(text: str, start: tuple[float, float], end: tuple[float, float]) -> list[float]:
    return [
        number
        for stroke in lettering(text, start, end)
        for piece in stroke
        for point in (piece.start, piece.end)
        for number in point
    ]


def test_a_text_fills_its_frame() -> None:
    xs = ends("HH", (3.0, 2.0), (31.0, 2.0))[::2]
    ys = ends("HH", (3.0, 2.0), (31.0, 2.0))[1::2]
    assert (min(xs), max(xs)) == pytest.approx((3.0, 31.0))
    height = height_of("HH", 28.0)
    assert (min(ys), max(ys)) == pytest.approx((2.0, 2.0 + height))
    assert width_of("HH") * height == pytest.approx(28.0)


def test_a_turned_frame_turns_its_text() -> None:
    by = Affine.rotation(0.7, (1.0, 2.0))
    a, b = (1.0, 2.0), (9.0, 2.0)
    straight, turned = ends("Rg8", a, b), ends("Rg8", by(a), by(b))
    pairs = zip(straight[::2], straight[1::2], strict=True)
    assert [x for p in pairs for x in by(p)] == pytest.approx(turned)


def test_pieces_are_lines_arcs_and_circles_at_any_size_and_direction() -> None:
    for size in (1e-6, 1.0, 1e6):
        end = size * math.cos(1.1), size * math.sin(1.1)
        pieces = [p for s in lettering("Øß&8.", (0.0, 0.0), end) for p in s]
        assert {type(one) for one in pieces} == {Line, Arc, Circle}


def test_the_box_holds_the_strokes() -> None:
    a, b = (1.0, 1.0), (5.0, 4.0)
    box = bounds_of("Ägj(]", a, b)
    for stroke in lettering("Ägj(]", a, b):
        for piece in stroke:
            inner = piece.bounds()
            assert box.x_min <= inner.x_min + 1e-9 and box.x_max >= inner.x_max - 1e-9
            assert box.y_min <= inner.y_min + 1e-9 and box.y_max >= inner.y_max - 1e-9
    low, _, _, high = box_of("a", a, b)
    assert math.dist(low, high) > math.dist(low, a)


def test_characters_that_the_font_does_not_have_are_boxes() -> None:
    assert unknown_characters("a→b→ש") == "→ש"
    assert len(lettering("→", (0.0, 0.0), (1.0, 0.0))[0]) == 4
    assert unknown_characters("Ø8 ±0.1") == ""
