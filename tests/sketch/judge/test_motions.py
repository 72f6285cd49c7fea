"""Free directions in words: named motions first, as many as there are degrees of freedom."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import null_space

from arael.sketch.document.document import Document
from arael.sketch.judge.motions import Motion, Part, motions, shortened

Floats = NDArray[np.float64]


def sketch(*entities: tuple[str, list[float]]) -> Document:
    document = Document()
    with document.transaction("x"):
        for kind, numbers in entities:
            document.add_entity(kind, numbers)
    return document


def described(
    document: Document,
    rows: Callable[[Floats], list[float]] = lambda v: [],
    same: Mapping[int, int] | None = None,
    fixed: tuple[int, ...] = (),
) -> list[Motion]:
    """Motions under equations on the document's numbers, derivatives by differences.

    `same` maps offsets of numbers to the offset they are an alias of.
    """
    values = document.values.copy()
    alias = dict(same or {})
    own = [i for i in range(len(values)) if i not in alias and i not in fixed]
    unknown_of = np.full(len(values), -1, dtype=np.int64)
    unknown_of[own] = np.arange(len(own))
    for one, other in alias.items():
        unknown_of[one] = unknown_of[other]

    def at(x: Floats) -> Floats:
        full = values.copy()
        full[unknown_of >= 0] = x[unknown_of[unknown_of >= 0]]
        return np.array(rows(full), dtype=float)

    x = values[own]
    eye = 1e-6 * np.eye(len(own))
    columns = [(at(x + e) - at(x - e)) / 2e-6 for e in eye]
    jacobian = np.array(columns).reshape(len(own), -1).T if own else np.zeros((0, 0))
    basis = null_space(jacobian, rcond=1e-8) if len(jacobian) else np.eye(len(own))
    found = motions(document, Part(tuple(document.entities), unknown_of, basis))
    assert len(found) == basis.shape[1]
    for motion in found:
        assert np.allclose(jacobian @ motion.velocity, 0.0, atol=1e-5), motion.sentence
    stacked = np.column_stack([m.velocity for m in found]) if found else np.zeros((len(own), 0))
    assert np.linalg.matrix_rank(stacked) == len(found)
    return found


def sentences(found: list[Motion]) -> list[str]:
    return [motion.sentence for motion in found]


def test_a_free_line() -> None:
    assert sentences(described(sketch(("line", [0, 0, 4, 0])))) == [
        "L0 can move along x",
        "L0 can move along y",
        "L0 can turn about (2, 0)",
        "L0 can become longer at p1",
    ]


def test_a_line_of_fixed_length_on_a_point() -> None:
    found = described(
        sketch(("line", [1, 1, 4, 5])),
        lambda v: [np.hypot(v[2] - v[0], v[3] - v[1]) - 5],
        fixed=(0, 1),
    )
    assert sentences(found) == ["L0 can turn about L0.p1"]


def test_a_horizontal_line_at_a_height_slides() -> None:
    found = described(
        sketch(("line", [0, 2, 4, 2])), lambda v: [v[1] - 2, v[3] - 2, v[2] - v[0] - 4]
    )
    assert sentences(found) == ["L0 can move along x"]


def test_a_slanted_line_of_fixed_length_in_a_slot_slides_along_itself() -> None:
    def rows(v: Floats) -> list[float]:
        return [v[1] - v[0], v[3] - v[2], np.hypot(v[2] - v[0], v[3] - v[1]) - 1]

    s = 0.5**0.5
    assert sentences(described(sketch(("line", [0, 0, s, s])), rows)) == [
        "L0 can slide along itself"
    ]


def test_a_rectangle_moves_as_one_body_and_grows() -> None:
    document = sketch(
        ("line", [0, 0, 5, 0]),
        ("line", [5, 0, 5, 3]),
        ("line", [5, 3, 0, 3]),
        ("line", [0, 3, 0, 0]),
    )
    same = {4: 2, 5: 3, 8: 6, 9: 7, 12: 10, 13: 11, 14: 0, 15: 1}

    def rows(v: Floats) -> list[float]:
        return [v[3] - v[1], v[6] - v[4], v[11] - v[9], v[14] - v[12]]

    found = described(document, rows, same)
    assert sentences(found)[:2] == ["L0..L3 can move along x", "L0..L3 can move along y"]
    assert len(found) == 4
    for motion in found[2:]:
        assert "can" in motion.sentence
        assert len(motion.entities) >= 3


def test_a_circle_can_grow_and_its_center_can_move_on_a_line() -> None:
    found = described(sketch(("circle", [1, 2, 3])), lambda v: [v[1] - 2])
    assert sentences(found) == ["A0 can move along x", "A0 can grow"]


def test_the_end_of_an_arc_moves_along_it() -> None:
    def rows(v: Floats) -> list[float]:
        cx, cy, sx, sy, ex, ey, r = v
        start, end = np.hypot(sx - cx, sy - cy) - r, np.hypot(ex - cx, ey - cy) - r
        return [start, end, cx, cy, r - 2, sy]

    found = described(sketch(("arc", [0, 0, 2, 0, 0, 2, 2])), rows)
    assert sentences(found) == ["the end of A0 can move along it"]


def test_a_four_bar_linkage_is_told_by_what_its_bars_do() -> None:
    document = sketch(("line", [0, 0, 0, 1]), ("line", [0, 1, 3, 2]), ("line", [3, 2, 3, 0]))

    def rows(v: Floats) -> list[float]:
        bars = [(v[0:2], v[2:4], 1), (v[4:6], v[6:8], 10**0.5), (v[8:10], v[10:12], 2)]
        return [float(np.hypot(*(b - a))) - length for a, b, length in bars]

    found = described(document, rows, {4: 2, 5: 3, 8: 6, 9: 7}, fixed=(0, 1, 10, 11))
    assert sentences(found) == ["L0 can turn, L1 can move and L2 can turn together"]
    assert found[0].entities == ("L0", "L1", "L2")


def test_a_part_of_a_sketch_that_turns_about_a_point() -> None:
    document = sketch(("line", [0, 0, 4, 0]), ("line", [4, 0, 4, 3]), ("line", [4, 3, 0, 0]))

    def rows(v: Floats) -> list[float]:
        ends = [(v[0:2], v[2:4], 4), (v[4:6], v[6:8], 3), (v[8:10], v[10:12], 5)]
        return [float(np.hypot(*(b - a))) - length for a, b, length in ends]

    same = {4: 2, 5: 3, 8: 6, 9: 7}
    found = described(document, rows, same, fixed=(0, 1, 10, 11))
    assert sentences(found) == ["L0..L2 can turn about L0.p1"]


def test_nothing_free_nothing_said() -> None:
    assert described(sketch(("point", [1, 2])), fixed=(0, 1)) == []


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["L0", "L1", "L2", "L3"], ["L0..L3"]),
        (["L0", "L1"], ["L0", "L1"]),
        (["L0", "L1", "L2", "A5", "P1", "P2", "P3", "P7"], ["L0..L2", "A5", "P1..P3", "P7"]),
        (["L0", "A2", "A4", "P1", "P9", "S0"], ["L0", "A2", "A4", "P1", "2 more"]),
    ],
)
def test_names_are_shortened(names: list[str], said: list[str]) -> None:
    assert shortened(names) == said
