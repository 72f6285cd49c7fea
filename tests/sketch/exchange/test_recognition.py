"""Constraints recognised in geometry: what holds within the tolerance, and nothing else."""

from __future__ import annotations

import math
from typing import Any

import pytest

from arael.sketch.document.document import Document
from arael.sketch.document.saved import from_json, to_json
from arael.sketch.exchange import Imported, recognised


def sketch(*entities: tuple[str, list[float]]) -> Document:
    document = Document()
    with document.transaction("draw"):
        for kind, numbers in entities:
            document.add_entity(kind, numbers)
    return document


def found(*entities: tuple[str, list[float]], **options: Any) -> set[str]:
    return {str(one) for one in recognised(sketch(*entities), **options)}


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_rectangle(scale: float) -> None:
    corners = [(0, 0), (4, 0), (4, 3), (0, 3)]
    lines: list[tuple[str, list[float]]] = [
        ("line", [scale * x for x in (*corners[i], *corners[(i + 1) % 4])]) for i in range(4)
    ]
    assert found(*lines) == {
        "coincident L0.p1 L3.p2",
        "coincident L0.p2 L1.p1",
        "coincident L1.p2 L2.p1",
        "coincident L2.p2 L3.p1",
        "horizontal L0",
        "vertical L1",
        "horizontal L2",
        "vertical L3",
    }


def test_points_in_one_place_are_a_chain_without_redundancy() -> None:
    names = found(
        ("line", [0, 0, 1, 1]), ("line", [0, 0, 1, 2]), ("line", [0, 0, 2, 1]), ("point", [0, 0])
    )
    assert {n for n in names if n.startswith("coincident")} == {
        "coincident L0.p1 L1.p1",
        "coincident L1.p1 L2.p1",
        "coincident L2.p1 P0",
    }


def test_ends_apart_by_more_than_the_tolerance_are_not_joined() -> None:
    lines: list[tuple[str, list[float]]] = [("line", [0, 0, 1, 2]), ("line", [1.001, 2, 3, 3])]
    assert found(*lines) == set()
    assert found(*lines, tolerance=0.01) == {"coincident L0.p2 L1.p1"}


def test_tangents_concentric_and_equal_circles() -> None:
    names = found(
        ("line", [0, 0, 4, 0]),
        ("arc", [4, 1, 4, 0, 4, 2, 1]),
        ("circle", [4, 1, 2]),
        ("circle", [20, 20, 2]),
        ("line", [15, 22, 25, 22]),
    )
    assert "tangent L0.p2 A0.start" in names
    assert "concentric A0 A1" in names
    assert "equal A1 A2" in names
    assert "tangent L1 A2" in names
    assert not any(n.startswith("equal A0") for n in names)


def test_a_corner_of_arc_and_line_is_not_tangent() -> None:
    assert not any(
        "tangent" in n for n in found(("line", [4, -3, 4, 0]), ("arc", [4, 1, 4, 0, 4, 2, 1]))
    )


def test_an_accepted_tangent_keeps_its_side() -> None:
    document = sketch(
        ("line", [0, 0, 10, 0]), ("circle", [5, -1, 1]), ("arc", [10, 1, 10, 0, 10, 2, 1])
    )
    imported = Imported(document, recognised(document))
    sides = {c.args: c.side for c in imported.accept() if c.kind == "tangent"}
    assert sides == {("L0.p2", "A1.start"): 1, ("L0", "A0"): -1}


def test_nothing_is_applied_until_it_is_accepted() -> None:
    document = sketch(("line", [0, 0, 4, 0]), ("line", [4, 0, 4, 3]), ("circle", [2, 1, 1]))
    imported = Imported(document, recognised(document))
    assert not document.constraints
    chosen = [one for one in imported.suggestions if one.kind != "coincident"]
    imported.accept(chosen)
    assert {c.name for c in document.constraints.values()} == {"CL0H", "CL1V", "C0"}
    document.undo()
    assert not document.constraints
    imported.accept()
    assert len(document.constraints) == len(imported.suggestions)
    assert to_json(from_json(to_json(document))) == to_json(document)


def test_many_circles_are_recognised_quickly() -> None:
    many = [("circle", [3.0 * (i % 100), 3.0 * (i // 100), 1.0]) for i in range(3000)]
    names = recognised(sketch(*many))
    assert len([one for one in names if one.kind == "equal"]) == 2999
    assert not [one for one in names if one.kind == "concentric"]
    assert math.isfinite(names[0].gap)
