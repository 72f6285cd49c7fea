"""A part is drawn by the mouse, dimensioned, dragged, broken, repaired and undone."""

from __future__ import annotations

from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at, click, drag, start
from tests.sketch.browser.panels import connected, length, names, press, run, wait


@pytest.fixture
def page(sheet: Any) -> Any:
    return sheet


def rectangle(page: Any) -> None:
    start(page, "rect")
    click(page, -20, -10)
    click(page, 20, 10)
    wait(page, "app.store.entities.size === 4")


@exercises("tool:rect", "tool:dimension", "action:undo", "pointer:Drag")
def test_a_rectangle_is_drawn_dimensioned_dragged_broken_repaired_and_undone(editor: Any) -> None:
    page = connected(editor.page)
    rectangle(page)
    assert length(page, "L0") == pytest.approx(40.0)
    # dimension: the lower side, then the place of the text, then the value
    start(page, "dimension")
    click(page, -6, -10)
    click(page, 0, -16)
    page.locator(".typing").wait_for()
    page.keyboard.type("30")
    press(page, "Enter")
    wait(page, "app.store.dimensions.size === 1")
    assert length(page, "L0") == pytest.approx(30.0)
    wait(page, "app.store.dimensions.get('d0').offset !== null")
    # drag a corner: the length holds
    press(page, "Escape", "Escape")
    before = page.evaluate("app.store.point('L2.p1')")
    drag(page, tuple(before), (before[0] + 6, before[1] + 5))
    wait(
        page, f"!app.store.dragging && Math.abs(app.store.point('L2.p1')[1] - {before[1] + 5}) < 1"
    )
    assert length(page, "L0") == pytest.approx(30.0)
    # break it: the opposite side cannot have another length
    start(page, "dimension")
    x, y = page.evaluate(
        "[0, 1].map((k) => 0.8 * app.store.point('L2.p1')[k] + 0.2 * app.store.point('L2.p2')[k])"
    )
    click(page, x, y)
    click(page, x, y + 6)
    page.locator(".typing").wait_for()
    page.keyboard.type("35")
    press(page, "Enter")
    message = page.locator(".typing [role=alert] .failure-text")
    message.wait_for()
    assert "d0" in message.inner_text()
    assert page.evaluate("app.store.dimensions.size") == 1
    # repair it: what is offered first is a reference, where the text was put
    assert page.evaluate("app.tools.current.preview().dimension.text.text") == "30"
    buttons = page.locator(".typing .offers button")
    assert buttons.all_inner_texts() == ["as reference (30)", "delete d0 and repeat"]
    buttons.first.click()
    wait(page, "app.store.dimensions.get('d1')?.derived && app.store.dimensions.get('d1').offset")
    assert not page.locator(".typing").is_visible()
    steps = wait(page, "app.store.history.done.length")
    for left in reversed(range(steps)):
        press(page, "Control+z")
        wait(page, f"app.store.history.done.length === {left}")
    wait(page, "app.store.entities.size === 0 && app.store.dimensions.size === 0")


@exercises("tool:line")
def test_a_chain_of_lines_is_connected_and_level_as_shown_before_the_click(page: Any) -> None:
    start(page, "line")
    click(page, 0, 0)
    page.mouse.move(*at(page, 20, 0.2))
    assert page.evaluate("app.tools.current.place.snap.extras") == ["horizontal {c}"]
    click(page, 20, 0.2)
    wait(page, "app.store.entities.size === 1")
    click(page, 20.1, 12)
    wait(page, "app.store.entities.size === 2")
    click(page, 0, 0)
    wait(page, "app.store.entities.size === 3")
    wait(page, "app.store.constraints.size === 5 && !app.tools.current.begun")
    kinds = page.evaluate("[...app.store.constraints.values()].map((c) => c.kind).sort()")
    assert kinds == ["coincident", "coincident", "coincident", "horizontal", "vertical"]


@exercises("tool:line", "pointer:Ctrl, or B")
def test_control_leaves_automatic_constraints_off(page: Any) -> None:
    start(page, "line")
    page.keyboard.down("Control")
    click(page, 0, 0)
    click(page, 20, 0.2)
    page.keyboard.up("Control")
    wait(page, "app.store.entities.size === 1")
    assert names(page, "constraints") == []


@exercises("tool:line", "pointer:0-9, A-Z", "pointer:Tab")
def test_typed_length_and_angle_become_dimensions(page: Any) -> None:
    start(page, "line")
    click(page, 0, 0)
    page.mouse.move(*at(page, 10, 7))
    page.keyboard.type("25")
    press(page, "Tab")
    page.keyboard.type("30")
    press(page, "Enter")
    wait(page, "app.store.dimensions.size === 2")
    assert length(page, "L0") == pytest.approx(25.0)
    kinds = page.evaluate("[...app.store.dimensions.values()].map((d) => d.kind)")
    assert kinds == ["length", "xangle"]


CLICKS: dict[str, tuple[list[tuple[float, float]], list[str]]] = {
    "rect": ([(0, 0), (10, 6)], ["line"] * 4),
    "rectcenter": ([(0, 0), (10, 6)], ["line"] * 4),
    "rect3": ([(0, 0), (10, 3), (8, 10)], ["line"] * 4),
    "circle": ([(0, 0), (6, 0)], ["circle"]),
    "circle2": ([(0, 0), (12, 5)], ["circle"]),
    "circle3": ([(0, 0), (12, 5), (3, 9)], ["circle"]),
    "arc": ([(0, 0), (12, 0), (7, 5)], ["arc"]),
    "arc_center": ([(0, 0), (10, 0), (3, 9)], ["arc"]),
    "ellipse": ([(0, 0), (12, 3), (3, 6)], ["ellipse"]),
    "earc_center": ([(0, 0), (12, 3), (3, 6), (13, 1), (-4, 9)], ["earc"]),
    "earc3": ([(0, 0), (12, 0), (7, 5)], ["earc"]),
    "earc_tangent": ([(0, 0), (3, 5), (12, 0), (15, -5)], ["earc"]),
    "slot": ([(0, 0), (12, 0), (6, 3)], ["line", "line", "arc", "arc"]),
    "polygon": ([(0, 0), (9, 2)], ["line"] * 6 + ["circle"]),
    "point": ([(3, 4)], ["point"]),
}


@exercises(*(f"tool:{tool}" for tool in CLICKS), "pointer:Click")
@pytest.mark.parametrize("tool", CLICKS)
def test_each_tool_draws_by_clicks(page: Any, tool: str) -> None:
    places, kinds = CLICKS[tool]
    start(page, tool)
    for place in places:
        click(page, *place)
    wait(page, f"app.store.entities.size === {len(kinds)}")
    found = page.evaluate("[...app.store.entities.values()].map((e) => e.kind).sort()")
    assert found == sorted(kinds)


@exercises("tool:spline", "pointer:Right click")
def test_a_spline_ends_by_a_right_click(page: Any) -> None:
    start(page, "spline")
    for place in ((0, 0), (4, 8), (10, -4), (15, 5), (20, 0)):
        click(page, *place)
    page.mouse.click(*at(page, 20, 0), button="right")
    wait(page, "app.store.entities.size === 1")
    assert page.evaluate("app.store.entities.get('S0').size") == 10


@exercises("tool:spline_through", "key:Alt+Shift+S")
def test_a_spline_through_points_shows_its_control_polygon(page: Any) -> None:
    press(page, "Alt+Shift+S")
    for place in ((0, 0), (4, 8), (10, -4)):
        click(page, *place)
    press(page, "Enter")
    wait(page, "app.store.entities.size === 1")
    poles = page.evaluate("[...app.store.numbers('S0')]")
    expected = [0, 0, 7 / 6, 13 / 3, 3.5, 13, 47 / 6, 5 / 3, 10, -4]
    assert poles == pytest.approx(expected, abs=0.2)
    press(page, "Escape")
    before = page.evaluate("app.renderer.ground.canvas.toDataURL()")
    page.evaluate("app.store.select(['S0.pole3'])")
    wait(page, "app.renderer.resting && app.renderer.resting.polygons.length === 1")
    assert page.evaluate("app.renderer.ground.canvas.toDataURL()") != before


@exercises("tool:circle3t", "tool:circle2t", "tool:arc_tangent")
def test_tangent_circles_and_arcs(page: Any) -> None:
    run(page, "add_line 0,0 20,0; add_line 0,0 0,20; add_line 20,0 0,20")
    start(page, "circle3t")
    for place in ((12, 0), (0, 12), (8, 12)):
        click(page, *place)
    wait(page, "app.store.entities.size === 4")
    run(page, "delete A0")
    start(page, "circle2t")
    click(page, 12, 0)
    click(page, 0, 12)
    page.mouse.move(*at(page, 3, 3))
    page.keyboard.type("4")
    press(page, "Enter")
    wait(page, "app.store.entities.has('A1') || app.store.entities.has('A0')")
    start(page, "arc_tangent")
    run(page, "add_line -30,-10 -20,-10")
    click(page, -20, -10)
    click(page, -15, -4)
    wait(page, "[...app.store.entities.values()].some((e) => e.kind === 'arc')")
    wait(
        page, "[...app.store.constraints.values()].filter((c) => c.kind === 'tangent').length >= 3"
    )


@exercises("tool:fillet", "tool:chamfer", "tool:trim", "tool:extend", "tool:offset")
def test_corners_cuts_and_copies(page: Any) -> None:
    run(page, "add_rect 0,0 20,12 hv")
    page.evaluate("app.fit()")
    start(page, "fillet")
    click(page, 20, 12)
    page.keyboard.type("3")
    press(page, "Enter")
    wait(page, "app.store.entities.size >= 5")
    start(page, "chamfer")
    click(page, 0, 0)
    page.keyboard.type("2")
    press(page, "Enter")
    wait(page, "app.store.entities.size >= 6")
    run(page, "clear", "add_line 0,0 20,0", "add_line 5,-5 5,5", "add_line 15,-5 15,5")
    page.evaluate("app.fit()")
    start(page, "trim")
    click(page, 10, 0)
    wait(page, "app.store.entities.size === 4")
    run(page, "clear", "add_line 0,0 20,0", "add_line 25,-5 25,5")
    page.evaluate("app.fit()")
    start(page, "extend")
    click(page, 19, 0)
    wait(page, "Math.abs(app.store.point('L0.p2')[0] - 25) < 1e-6")
    start(page, "offset")
    click(page, 12, 0)
    page.mouse.move(*at(page, 12, 3))
    page.keyboard.type("4")
    press(page, "Enter")
    wait(page, "app.store.entities.size >= 3")


@exercises("tool:pattern_circular", "tool:mirror", "tool:move", "tool:scale", "pointer:Enter")
def test_transforms_and_patterns_of_the_selection(page: Any) -> None:
    run(page, "add_circle 10,0 2", "add_point 0,0", "add_line -5,-8 -5,8")
    page.evaluate("() => { app.fit(); app.store.select(['A0']); }")
    start(page, "pattern_circular")
    page.mouse.move(*at(page, 0, 0))
    page.keyboard.type("4")
    press(page, "Enter")
    click(page, 0, 0)
    wait(page, "[...app.store.entities.values()].filter((e) => e.kind === 'circle').length === 4")
    press(page, "Control+z")
    wait(page, "app.store.entities.size === 3")
    page.evaluate("app.store.select(['A0'])")
    start(page, "mirror")
    click(page, -5, 4)
    wait(page, "[...app.store.entities.values()].filter((e) => e.kind === 'circle').length === 2")
    press(page, "Control+z")
    wait(page, "app.store.entities.size === 3")
    page.evaluate("app.store.select(['A0'])")
    start(page, "move")
    click(page, 10, 0)
    click(page, 10, 5)
    wait(page, "Math.abs(app.store.point('A0.center')[1] - 5) < 0.3")
    page.evaluate("app.store.select(['A0'])")
    start(page, "scale")
    click(page, 0, 0)
    page.keyboard.type("2")
    press(page, "Enter")
    wait(page, "Math.abs(app.store.numbers('A0')[2] - 4) < 1e-6")


@exercises("tool:select", "pointer:Drag", "pointer:Double click", "pointer:Tab")
def test_selecting_boxes_chains_and_overlapping_things(page: Any) -> None:
    run(page, "add_rect 0,0 20,12 hv", "add_line 30,0 40,0")
    page.evaluate("app.fit()")
    selected = "[...app.store.selection].sort()"
    drag(page, (-3, -3), (24, 8))
    assert page.evaluate(selected) == ["L0"]
    drag(page, (24, 8), (-3, -3))
    assert page.evaluate(selected) == ["L0", "L1", "L3"]
    page.mouse.dblclick(*at(page, 6, 0))
    assert page.evaluate(selected) == ["L0", "L1", "L2", "L3"]
    page.mouse.move(*at(page, 0, 0))
    first = page.evaluate("[...app.store.hovered]")
    page.evaluate("app.canvas.focus()")
    press(page, "Tab")
    assert page.evaluate("[...app.store.hovered]") != first
    click(page, 35, 0)
    press(page, "Delete")
    wait(page, "app.store.entities.size === 4")


def drawn(page: Any, where: str, name: str) -> Any:
    """Where something is drawn, once it stands still: two frames with the same answer."""
    still = (
        f"async (name) => {{ const where = {where};"
        """
            const frame = () => new Promise((done) => requestAnimationFrame(done));
            let last = "";
            for (let i = 0; i < 200; i++) {
                await frame();
                const found = where(name);
                const text = found ? JSON.stringify([found.x, found.y]) : "";
                if (text && text === last) return found;
                last = text;
            }
        }"""
    )
    found = page.evaluate(still, name)
    assert found, name
    return found


@exercises("tool:select", "pointer:Drag")
def test_texts_of_dimensions_and_glyphs_are_dragged_and_glyphs_deleted(page: Any) -> None:
    run(page, "add_rect 0,0 20,12 hv", "length L0 20")
    page.evaluate("app.fit()")
    where = "(n) => app.renderer.annotations.dimensions.find((d) => d.name === n)?.text"
    text = drawn(page, where, "d0")
    box = page.evaluate("(({left, top}) => [left, top])(app.canvas.getBoundingClientRect())")
    page.mouse.move(box[0] + text["x"], box[1] + text["y"])
    page.mouse.down()
    page.mouse.move(box[0] + text["x"] + 40, box[1] + text["y"] + 30, steps=5)
    page.mouse.up()
    wait(page, "app.store.dimensions.get('d0').offset !== null")
    moved = drawn(page, where, "d0")
    assert moved["y"] - text["y"] == pytest.approx(30, abs=2)
    # the marks of a line are there once it is selected
    page.mouse.click(*at(page, 5, 12))
    glyph = drawn(page, "(n) => app.renderer.annotations.glyphs.find((g) => g.name === n)", "CL2H")
    page.mouse.click(box[0] + glyph["x"], box[1] + glyph["y"])
    assert page.evaluate("[...app.store.selection]") == ["CL2H"]
    press(page, "Delete")
    wait(page, "!app.store.constraints.has('CL2H')")


@exercises("pointer:Wheel", "pointer:Drag with the middle button")
def test_the_wheel_zooms_at_the_pointer_and_the_middle_button_pans(page: Any) -> None:
    x, y = at(page, 7, 3)
    page.mouse.move(x, y)
    scale = page.evaluate("app.view.scale")
    page.mouse.wheel(0, -300)
    wait(page, f"app.view.scale > {1.3 * scale}")
    assert at(page, 7, 3) == pytest.approx((x, y), abs=1.0)  # wheels report whole pixels
    page.mouse.down(button="middle")
    page.mouse.move(x + 50, y + 20)
    page.mouse.up(button="middle")
    assert at(page, 7, 3) == pytest.approx((x + 50, y + 20), abs=1.0)
