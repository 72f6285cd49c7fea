"""Tools by the mouse that change or measure what is there, and what dragging moves."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at, click, drag, start
from tests.sketch.browser.panels import length, press, run, wait

CIRCLES = "[...app.store.entities.values()].filter((e) => e.kind === 'circle').length"


@exercises("tool:split", "pointer:Click")
def test_a_line_is_split_between_its_crossings(sheet: Any) -> None:
    run(sheet, "add_line -15,0 15,0", "add_line -5,-6 -5,6", "add_line 7,-6 7,6")
    start(sheet, "split")
    sheet.mouse.move(*at(sheet, 1, 0))
    wait(sheet, "app.tools.current.preview().cuts?.length === 2")
    click(sheet, 1, 0)
    wait(sheet, "app.store.entities.size === 5")
    ends = sheet.evaluate(
        """[...app.store.entities.values()].filter((e) => app.store.numbers(e.name)[1] === 0)
            .map((e) => [0, 2].map((k) => app.store.numbers(e.name)[k]))
            .sort((a, b) => a[0] - b[0])"""
    )
    assert [x for end in ends for x in end] == pytest.approx([-15, -5, -5, 7, 7, 15])


@exercises("tool:rotate", "pointer:0-9, A-Z", "pointer:Enter")
def test_the_selection_is_turned_by_a_typed_angle_and_by_clicks(sheet: Any) -> None:
    run(sheet, "add_line 4,0 12,0")
    sheet.evaluate("app.store.select(['L0'])")
    start(sheet, "rotate")
    click(sheet, 0, 0)
    sheet.keyboard.type("30")
    press(sheet, "Enter")
    wait(sheet, "app.store.point('L0.p2')[1] > 1")
    assert sheet.evaluate("app.store.point('L0.p2')") == pytest.approx(
        (12 * math.cos(math.pi / 6), 6.0), abs=1e-6
    )
    press(sheet, "Control+z")
    wait(sheet, "app.store.point('L0.p2')[1] === 0")
    sheet.evaluate("app.store.select(['L0'])")
    start(sheet, "rotate")
    for place in ((0, 0), (10, 0), (0, 10)):
        click(sheet, *place)
    wait(sheet, "Math.abs(app.store.point('L0.p2')[1] - 12) < 1e-6")


@exercises("tool:pattern_rect", "pointer:Tab")
def test_copies_in_rows_of_typed_numbers(sheet: Any) -> None:
    run(sheet, "add_circle 0,0 1.5")
    sheet.evaluate("app.store.select(['A0'])")
    start(sheet, "pattern_rect")
    sheet.mouse.move(*at(sheet, 6, 4))
    sheet.keyboard.type("4")
    press(sheet, "Tab")
    sheet.keyboard.type("2")
    press(sheet, "Enter")
    click(sheet, 6, 4)
    wait(sheet, f"{CIRCLES} === 8")
    centres = sheet.evaluate(
        """[...app.store.entities.values()].filter((e) => e.kind === 'circle')
            .map((e) => [...app.store.numbers(e.name)].slice(0, 2)
                .map((x) => Math.round(10 * x) / 10))"""
    )
    assert sorted(centres) == [[x, y] for x in (0, 6, 12, 18) for y in (0, 4)]


@exercises("tool:measure")
def test_one_thing_and_two_are_measured_and_nothing_is_added(sheet: Any) -> None:
    run(sheet, "add_line 0,0 20,0", "add_line 0,8 20,8")
    revision = sheet.evaluate("app.store.revision")
    start(sheet, "measure")
    click(sheet, 6, 0)
    wait(sheet, "document.querySelector('.status-hint').innerText.includes('20')")
    click(sheet, 6, 8)
    wait(sheet, "document.querySelector('.status-hint').innerText.includes('8')")
    assert sheet.evaluate("app.tools.current.names") == ["L0", "L1"]
    assert sheet.evaluate("app.store.revision") == revision


@exercises("tool:dimension")
def test_space_takes_another_kind_of_dimension(sheet: Any) -> None:
    run(sheet, "add_line 0,0 12,9")
    start(sheet, "dimension")
    click(sheet, 4, 3)
    sheet.mouse.move(*at(sheet, 6, -4))
    kind = "app.tools.current.record.kind"
    kinds = []
    for _ in range(4):
        press(sheet, " ")
        kinds.append(sheet.evaluate(kind))
    assert sorted(kinds) == ["hdistance", "length", "vdistance", "xangle"]
    while sheet.evaluate(kind) != "vdistance":
        press(sheet, " ")
    click(sheet, 6, -4)
    sheet.locator(".typing").wait_for()
    sheet.keyboard.type("7")
    press(sheet, "Enter")
    wait(sheet, "app.store.dimensions.get('d0')?.kind === 'vdistance'")
    wait(sheet, "Math.abs(app.store.point('L0.p2')[1] - app.store.point('L0.p1')[1] - 7) < 1e-6")


DIMENSIONS = {
    "radius of an arc": ("add_arc 10,0 0,10 7.0710678,7.0710678", [(7.07, 7.07)], "radius"),
    "diameter of a circle": ("add_circle 0,0 6", [(0, 6)], "diameter"),
    "angle of two lines": ("add_line 0,0 12,0; add_line 0,2 10,9", [(6, 0), (5, 5.5)], "angle"),
    "gap of two lines": ("add_line 0,0 12,0; add_line 0,5 12,5", [(6, 0), (6, 5)], "distance"),
    "point to line": ("add_line 0,0 12,0; add_point 5,6", [(5, 6), (4, 0)], "distance"),
    "first radius of an ellipse": ("add_ellipse 0,0 8 4 0", [(0, 4)], "radius"),
}


@exercises("tool:dimension")
@pytest.mark.parametrize(
    ("at", "value"), [((12, 4), "30"), ((-12, -4), "30"), ((-6, 12), "150"), ((6, -12), "150")]
)
def test_an_angle_is_that_of_the_sector_of_the_pointer(
    sheet: Any, at: tuple[float, float], value: str
) -> None:
    run(sheet, "add_line -20,0 20,0", "add_line -17.3205080757,-10 17.3205080757,10")
    start(sheet, "dimension")
    click(sheet, 18, 0)
    click(sheet, 15.588457268, 9)
    click(sheet, *at)
    sheet.locator(".typing").wait_for()
    assert sheet.input_value("#typed") == value
    press(sheet, "Enter")
    wait(sheet, "app.store.dimensions.size === 1")
    mode = "supplement" if value == "150" else ""
    assert sheet.evaluate("app.store.dimensions.get('d0').mode ?? ''") == mode


@exercises("tool:dimension")
def test_after_what_is_in_the_way_is_deleted_the_dimension_is_made(sheet: Any) -> None:
    run(sheet, "add_rect 0,0 40,20 hv", "length L0 40")
    start(sheet, "dimension")
    click(sheet, 12, 20)
    click(sheet, 20, 26)
    sheet.locator("#typed").fill("64")
    press(sheet, "Enter")
    sheet.get_by_role("button", name="delete d0 and repeat").click()
    wait(sheet, "app.store.dimensions.has('d1') && !app.store.dimensions.has('d0')")
    assert length(sheet, "L2") == pytest.approx(64.0)
    assert not sheet.locator(".typing").is_visible()


@pytest.mark.parametrize("case", DIMENSIONS)
@exercises("tool:dimension")
def test_what_is_picked_decides_the_kind_of_dimension(sheet: Any, case: str) -> None:
    drawn, places, kind = DIMENSIONS[case]
    run(sheet, drawn)
    start(sheet, "dimension")
    for place in places:
        click(sheet, *place)
    click(sheet, -9, -13)
    sheet.locator(".typing").wait_for()
    press(sheet, "Enter")
    wait(sheet, "app.store.dimensions.size === 1")
    assert sheet.evaluate("app.store.dimensions.get('d0').kind") == kind


@exercises("tool:dimension")
def test_an_expression_is_completed_where_a_dimension_is_typed(sheet: Any) -> None:
    run(sheet, "param width 14", "add_line 0,0 12,9")
    start(sheet, "dimension")
    click(sheet, 4, 3)
    press(sheet, " ", " ")
    click(sheet, 2, 8)
    sheet.locator(".typing").wait_for()
    sheet.keyboard.type("2 * wi")
    sheet.locator(".typing .words li").first.wait_for()
    press(sheet, "Tab")
    assert sheet.input_value("#typed") == "2 * width"
    press(sheet, "Enter")
    wait(sheet, "app.store.dimensions.get('d0')?.value.text === '2 * width'")


def test_dragging_moves_points_curves_radii_and_selections(sheet: Any) -> None:
    run(sheet, "add_line -10,0 0,4", "add_circle 12,0 4")
    shown = "(name) => [...app.store.numbers(name)]"
    drag(sheet, (0, 4), (2, 8))
    wait(sheet, "!app.store.dragging && Math.abs(app.store.point('L0.p2')[1] - 8) < 0.3")
    assert sheet.evaluate(f"({shown})('L0')")[:2] == pytest.approx([-10, 0], abs=1e-9)
    before = length(sheet, "L0")
    drag(sheet, (-4, 4), (-4, -6))
    wait(sheet, "!app.store.dragging && app.store.point('L0.p1')[1] < -8")
    assert length(sheet, "L0") == pytest.approx(before)
    drag(sheet, (12, 4), (12, 7))
    wait(sheet, "!app.store.dragging && Math.abs(app.store.numbers('A0')[2] - 7) < 0.3")
    sheet.evaluate("app.store.select(['L0', 'A0'])")
    centre = sheet.evaluate("app.store.point('A0.center')")
    drag(sheet, (12, 7), (8, 7))
    wait(sheet, f"!app.store.dragging && app.store.point('A0.center')[0] < {centre[0] - 3.5}")
    assert sheet.evaluate("app.store.numbers('A0')[2]") == pytest.approx(7, abs=0.3)
    assert sheet.evaluate("app.store.history.done.length") >= 4


def test_a_tool_is_chosen_from_its_family_in_the_palette(sheet: Any) -> None:
    sheet.get_by_role("button", name="more circles").click()
    flyout = sheet.get_by_role("group", name="circles")
    flyout.get_by_text("Circle by three points", exact=True).click()
    assert sheet.evaluate("app.tools.id") == "circle3"
    assert not flyout.is_visible()


@exercises("pointer:Escape")
def test_escape_drops_what_was_begun_then_the_tool_then_the_selection(sheet: Any) -> None:
    run(sheet, "add_line 0,0 10,5")
    sheet.evaluate("app.store.select(['L0'])")
    start(sheet, "circle")
    click(sheet, -5, -5)
    assert sheet.evaluate("app.tools.current.begun")
    press(sheet, "Escape")
    assert sheet.evaluate("[app.tools.id, app.tools.current.begun]") == ["circle", False]
    press(sheet, "Escape")
    assert sheet.evaluate("[app.tools.id, app.store.selection.size]") == ["select", 1]
    press(sheet, "Escape")
    assert sheet.evaluate("app.store.selection.size") == 0
