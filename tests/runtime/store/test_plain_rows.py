"""Rows of plain values, which are stored without the general conversion."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Info { gain: real; serial: int = 4 }
struct Point { param at: vec2; weight: real = 2; count: int = 7; good: bool = true }
struct Mark {
    point: ref Point in root.points
    seen: vec2
    turn: mat2 = [[1, 0], [0, 1]]
    param scale: real
    extra: real?
    info: Info?
}
struct Owner { param height: real; marks: list of Mark }
root Scene {
    points: list of Point
    owners: list of Owner
    fit points as p { p.at * p.weight }
    fit owners as o { o.height }
}
"""


@pytest.fixture(scope="module")
def scene_type() -> Any:
    return arael.loads(TEXT, interpret=True)


@pytest.fixture
def scene(scene_type: Any) -> Any:
    scene = scene_type()
    for k in range(3):
        scene.points.append(at=[k, k + 0.5])
    scene.owners.append(height=1.0)
    scene.owners.append(height=2.0)
    return scene


def content(table: Any) -> dict[str, Any]:
    return {name: table.buffers.view(name).tolist() for name in sorted(table.buffers._arrays)}


MARKS: list[dict[str, Any]] = [
    {"seen": [1.0, 2.0], "scale": 3.0},
    {"seen": (1, 2), "scale": 3},
    {"seen": np.array([1.0, 2.0]), "scale": np.float64(3)},
    {"seen": [np.float64(1), 2.0], "scale": 3.0, "turn": np.eye(2) * 2},
]


@pytest.mark.parametrize("values", MARKS)
def test_a_plain_row_is_as_the_general_way_stores_it(
    scene: Any, values: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Flags that were set for the whole collection, owner, defaults and handles included."""
    other = scene.copy()
    for one in (scene, other):
        one.owners.marks.scale.optimize = False
    plain, general = scene.owners[1].marks, other.owners[1].marks
    monkeypatch.setattr(plain._table, "append", None)
    first = plain.append(point=scene.points[2], **values)
    general.append(point=2, **values)  # an index is not plain
    assert content(plain._table) == content(general._table)
    assert first.point == scene.points[2]
    assert (first.index, first.name) == (0, "owners[1].marks[0]")
    assert first.scale.optimize is False
    assert first.extra is None
    assert first.info is None


def test_plain_rows_do_take_the_short_way(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    table = scene.points._table
    monkeypatch.setattr(table, "append", None)
    for _ in range(20):
        scene.points.append(at=[1, 2], weight=0.5, count=3, good=False)
    assert scene.points[-1].count == 3
    assert scene.points.weight.tolist() == [2.0] * 3 + [0.5] * 20


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"at": [1, 2], "weight": True}, "E0703"),
    ({"at": [1, False]}, "E0703"),
    ({"at": [1, 2, 3]}, "E0704"),
    ({"at": [[1, 2]]}, "E0704"),
    ({"at": [1, float("nan")]}, "E0705"),
    ({"at": [1, float("inf")]}, "E0705"),
    ({"at": [1, 2], "count": 1.5}, "E0706"),
    ({"at": [1, 2], "count": 2**70}, "E0706"),
    ({"at": [1, 2], "good": 1}, "E0703"),
    ({"weight": 1.0}, "E0702"),
    ({"at": None}, "E0707"),
    ({"at": [1, 2], "colour": 1}, "E0701"),
]


@pytest.mark.parametrize(("values", "code"), WRONG)
def test_wrong_values_are_refused_and_add_nothing(
    scene: Any, values: dict[str, Any], code: str
) -> None:
    before = content(scene.points._table)
    with pytest.raises(AraelError) as caught:
        scene.points.append(**values)
    assert caught.value.diagnostics[0].code == code
    assert content(scene.points._table) == before


def test_stale_and_foreign_refs_are_refused(scene: Any) -> None:
    marks, gone = scene.owners[0].marks, scene.points[2]
    scene.points.pop()
    other = scene.copy().points[0]
    for ref, code in ((gone, "E0709"), (other, "E0710")):
        with pytest.raises(AraelError) as caught:
            marks.append(point=ref, seen=[0, 0], scale=1)
        assert caught.value.diagnostics[0].code == code
    assert len(marks) == 0


def test_bounds_that_were_set_for_rows_are_those_of_the_model_in_new_ones(scene: Any) -> None:
    scene.points.at.low = -5
    scene.points.append(at=[1, 2])
    assert scene.points[-1].at.low.tolist() == [-np.inf, -np.inf]


def calls_of(function: Callable[[], Any]) -> int:
    """Python functions that a call enters, without itself."""
    entered = 0

    def count(frame: FrameType, event: str, arg: Any) -> None:
        nonlocal entered
        entered += event == "call"

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        function()
    finally:
        sys.setprofile(before)
    return entered - 1


def test_reading_and_appending_take_few_calls_whatever_the_number_of_rows(scene: Any) -> None:
    """Loops over rows are common; each of these took three to five times as many."""

    def read() -> float:
        return float(scene.owners[1].height.value)

    def append() -> None:
        scene.points.append(at=[1.0, 2.0])

    read()
    append()
    assert calls_of(read) <= 20
    assert calls_of(append) <= 31
    for _ in range(40):
        append()
    assert calls_of(append) <= 31
