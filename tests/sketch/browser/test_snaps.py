"""Each of the ten snaps by the mouse: its mark before the click, what it adds after it."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at, click, start
from tests.sketch.browser.panels import run, wait


class Snapped(NamedTuple):
    """What is there, the tool and its places, of which the last one snaps."""

    drawn: str
    tool: str
    places: tuple[tuple[float, float], ...]
    point: str  # of the new entity, by its handle
    found: tuple[float, float]
    added: tuple[str, ...]  # constraints as kind and operands


SNAPS = {
    "endpoint": Snapped(
        "add_line 5,5 21,9", "point", ((5.3, 5.2),), "P0", (5, 5), ("coincident P0 L0.p1",)
    ),
    "centre": Snapped(
        "add_circle 11,5 4", "point", ((11.2, 5.1),), "P0", (11, 5), ("coincident P0 A0.center",)
    ),
    "midpoint": Snapped(
        "add_line 0,0 21,7", "point", ((10.6, 3.4),), "P0", (10.5, 3.5), ("midpoint P0 L0",)
    ),
    "quadrant": Snapped(
        "add_circle 11,5 4",
        "point",
        ((15.2, 5.3),),
        "P0",
        (15, 5),
        ("horizontal P0 A0.center", "point_on P0 A0"),
    ),
    "intersection": Snapped(
        "add_line 0,0 20,10; add_line 1,10 17,-1",
        "point",
        ((9.4, 4.6),),
        "P0",
        (9, 4.5),
        ("point_on P0 L0", "point_on P0 L1"),
    ),
    "nearest": Snapped(
        "add_line 0,0 20,15", "point", ((5.3, 3.5),), "P0", (5.072, 3.804), ("point_on P0 L0",)
    ),
    "tangent": Snapped(
        "add_circle 9,0 5",
        "line",
        ((-4, -7), (4.9, 3.0)),
        "L0.p2",
        (5.2787, 3.3395),
        ("point_on L0.p2 A0", "tangent L0 A0"),
    ),
    "perpendicular": Snapped(
        "add_line 0,0 20,10",
        "line",
        ((3, 12), (7.5, 3.4)),
        "L1.p2",
        (7.2, 3.6),
        ("perpendicular L1 L0", "point_on L1.p2 L0"),
    ),
    "alignment": Snapped("", "line", ((0, 0), (15.1, 0.4)), "L0.p2", (15.1, 0), ("horizontal L0",)),
    "grid": Snapped("", "point", ((4.2, 5.8),), "P0", (4, 6), ()),
}

ADDED = """() => [...app.store.constraints.values()]
    .map((one) => [one.kind, ...one.args].join(" ")).sort()"""


@exercises(*(f"snap:{kind}" for kind in SNAPS))
@pytest.mark.parametrize("kind", SNAPS)
def test_each_snap_by_the_mouse(sheet: Any, kind: str) -> None:
    case = SNAPS[kind]
    if case.drawn:
        run(sheet, case.drawn)
    before = set(sheet.evaluate(ADDED))
    start(sheet, case.tool)
    for place in case.places[:-1]:
        click(sheet, *place)
    sheet.mouse.move(*at(sheet, *case.places[-1]))
    snap = sheet.evaluate("app.tools.current.place.snap")
    assert snap["kind"] == kind
    click(sheet, *case.places[-1])
    count = len(before) + len(case.added)
    name = case.point.split(".")[0]
    wait(sheet, f"app.store.entities.has('{name}') && app.store.constraints.size === {count}")
    added = sorted(set(sheet.evaluate(ADDED)) - before)
    assert added == sorted(case.added)
    assert sheet.evaluate(f"app.store.point('{case.point}')") == pytest.approx(case.found, abs=1e-3)


@exercises("snap:alignment")
def test_a_point_in_line_with_one_that_the_pointer_touched(sheet: Any) -> None:
    run(sheet, "add_point -12,3")
    start(sheet, "point")
    sheet.mouse.move(*at(sheet, -12, 3))
    sheet.mouse.move(*at(sheet, 5, 3.3))
    assert sheet.evaluate("app.tools.current.place.snap.text") == "in line with P0"
    click(sheet, 5, 3.3)
    wait(sheet, "app.store.constraints.size === 1")
    assert sheet.evaluate(ADDED) == ["horizontal P1 P0"]


def test_a_snap_is_drawn_with_its_mark_and_word(sheet: Any) -> None:
    """Pixels of the overlay near the pointer, which are clear without a snap."""
    run(sheet, "add_line 5,5 21,9")
    sheet.evaluate("app.view.setGrid(false)")
    start(sheet, "point")
    inked = """([x, y]) => {
        const canvas = document.querySelector("#overlay");
        const ratio = canvas.width / canvas.clientWidth;
        const side = Math.round(24 * ratio);
        const data = canvas.getContext("2d").getImageData(
            Math.round(x * ratio - side / 2), Math.round(y * ratio - side / 2), side, side).data;
        let count = 0;
        for (let i = 3; i < data.length; i += 4) count += data[i] > 0;
        return count;
    }"""
    x, y = sheet.evaluate("app.view.toScreen([5, 5])")
    sheet.mouse.move(*at(sheet, -15, -15))
    wait(sheet, f"({inked})([{x}, {y}]) === 0")
    sheet.mouse.move(*at(sheet, 5.2, 5.1))
    wait(sheet, f"({inked})([{x}, {y}]) > 40")
