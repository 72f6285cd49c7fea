"""Every action by its key, on a selection that it fits; every key of the table."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import GROUND, at, drag
from tests.sketch.browser.panels import names, press, run, wait

LINES = "add_line 0,0 10,2; add_line 0,6 9,9"
ARC = "add_arc 10,0 0,10 7.0710678,7.0710678"

CONSTRAINTS: dict[str, tuple[str, list[str], str]] = {
    "coincident": ("add_line 0,0 10,2; add_line 12,4 20,9", ["L0.p2", "L1.p1"], "C"),
    "point_on": ("add_point 3,4; add_circle 0,0 6", ["P0", "A0"], "I"),
    "midpoint": ("add_point 3,4; add_line 0,0 10,3", ["P0", "L0"], "M"),
    "horizontal": (LINES, ["L0", "L1"], "H"),
    "vertical": ("add_line 0,0 2,10", ["L0"], "V"),
    "parallel": (LINES, ["L0", "L1"], "Q"),
    "perpendicular": ("add_line 0,0 10,2; add_line 0,6 3,15", ["L0", "L1"], "N"),
    "tangent": ("add_line -10,5 10,6; add_circle 0,0 4", ["L0", "A0"], "T"),
    "equal": (LINES, ["L0", "L1"], "E"),
    "collinear": ("add_line 0,0 10,1; add_line 14,2 20,3", ["L0", "L1"], "J"),
    "concentric": ("add_circle 0,0 6; add_circle 2,1 3", ["A0", "A1"], "Shift+C"),
    "symmetry": (
        "add_point -5,1; add_point 5,2; add_line 0,-5 0.5,8",
        ["P0", "P1", "L0"],
        "Y",
    ),
    "equal_angle": (
        "add_line 0,0 10,0; add_line 0,1 9,5; add_line 0,10 10,10; add_line 0,11 8,16",
        ["L0", "L1", "L2", "L3"],
        "Shift+Q",
    ),
    "smooth": (
        "add_arc -5,5 0,0 -1.5,3.5; add_spline 0,0 4,-3 8,1 12,0",
        ["A0.end", "S0.p1"],
        "Shift+J",
    ),
    "on_normal": ("add_line 0,0 10,0; add_point 12,3", ["P0", "L0.p2"], "Shift+N"),
    "lock": ("add_point 3,4", ["P0"], "K"),
    "fix": ("add_line 0,0 10,2", ["L0"], "Shift+F"),
}


def pressed(name: str) -> str:
    """A key of the table as playwright names it."""
    *modifiers, key = re.split(r"(?<=.)\+", name) if name != "+" else [name]
    modifiers = [{"Ctrl": "Control"}.get(one, one) for one in modifiers]
    if modifiers and re.fullmatch(r"[0-9]", key):
        key = f"Digit{key}"
    elif re.fullmatch("[A-Z]", key) and "Shift" not in modifiers:
        key = key.lower()
    return "+".join([*modifiers, key])


def select(page: Any, chosen: list[str]) -> None:
    page.evaluate("names => { app.store.select(names); app.canvas.focus(); }", chosen)


@exercises(*(f"action:{kind}" for kind in CONSTRAINTS))
@exercises(*(f"key:{key}" for _, _, key in CONSTRAINTS.values()))
@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_each_constraint_by_its_key(sheet: Any, kind: str) -> None:
    drawn, chosen, key = CONSTRAINTS[kind]
    run(sheet, drawn)
    select(sheet, chosen)
    press(sheet, pressed(key))
    wait(sheet, f"[...app.store.constraints.values()].some((one) => one.kind === '{kind}')")
    assert sheet.locator(".note.error").count() == 0


@exercises("action:unlock", "key:Shift+K")
def test_a_locked_point_is_unlocked(sheet: Any) -> None:
    run(sheet, "add_point 3,4", "lock P0")
    select(sheet, ["P0"])
    press(sheet, "Shift+K")
    wait(sheet, "app.store.constraints.size === 0")


DIMENSIONS: dict[str, tuple[str, list[str], str, str]] = {
    "length": (LINES, ["L0"], "Alt+L", "12"),
    "distance": (LINES, ["L0.p1", "L1.p2"], "Alt+D", "14"),
    "hdistance": (LINES, ["L0.p1", "L1.p2"], "Alt+H", "11"),
    "vdistance": (LINES, ["L0.p1", "L1.p2"], "Alt+V", "8"),
    "radius": ("add_circle 0,0 6", ["A0"], "Alt+R", "5"),
    "diameter": ("add_circle 0,0 6", ["A0"], "Alt+O", "14"),
    "radius_b": ("add_ellipse 0,0 8 4 0", ["EA0"], "Alt+B", "3"),
    "angle": (LINES, ["L0", "L1"], "Alt+A", "15"),
    "xangle": (LINES, ["L0"], "Alt+X", "20"),
    "sweep": (ARC, ["A0"], "Alt+W", "100"),
    "arc_length": (ARC, ["A0"], "Alt+C", "17"),
    "total_length": ("add_line 0,0 10,0; add_line 10,0 10,5", ["L0", "L1"], "Alt+T", "18"),
    "area": ("add_rect 0,0 10,6", ["L0", "L1", "L2", "L3"], "Alt+Q", "50"),
}


@exercises(*(f"action:{kind}" for kind in DIMENSIONS))
@exercises(*(f"key:{key}" for _, _, key, _ in DIMENSIONS.values()))
@pytest.mark.parametrize("kind", DIMENSIONS)
def test_each_dimension_by_its_key(sheet: Any, kind: str) -> None:
    drawn, chosen, key, value = DIMENSIONS[kind]
    run(sheet, drawn)
    select(sheet, chosen)
    press(sheet, pressed(key))
    sheet.locator(".typing").wait_for()
    offered = sheet.input_value("#typed")
    assert offered or kind in ("angle", "distance", "area"), "the present value is offered"
    sheet.locator("#typed").fill(value)
    press(sheet, "Enter")
    wait(sheet, "app.store.dimensions.size === 1")
    found = sheet.evaluate("app.store.dimensions.get('d0')")
    assert (found["kind"], found["value"]["number"]) == (kind, float(value))


EDITS: dict[str, tuple[str, list[str], str, str]] = {
    "construction": (LINES, ["L0"], "X", "app.store.entities.get('L0').construction"),
    "quiet": (LINES, ["L0"], "Shift+X", "app.store.entities.get('L0').quiet"),
    "style_solid": (
        f"{LINES}; style L0 dashed",
        ["L0"],
        "Alt+1",
        "app.store.entities.get('L0').style === 'solid'",
    ),
    "style_dashed": (
        LINES,
        ["L0"],
        "Alt+2",
        "app.store.entities.get('L0').style === 'dashed'",
    ),
    "style_dashdot": (
        LINES,
        ["L0"],
        "Alt+3",
        "app.store.entities.get('L0').style === 'dashdot'",
    ),
    "freeze": (LINES, [], "Alt+F", "app.store.dimensions.size >= 2"),
    "set_derived": (
        f"{LINES}; length L0 12",
        ["d0"],
        "Alt+M",
        "app.store.dimensions.get('d0').derived",
    ),
    "set_driven": (
        f"{LINES}; length L0 derived",
        ["d0"],
        "Alt+N",
        "!app.store.dimensions.get('d0').derived",
    ),
    "switch_off": (
        "add_line 0,0 10,0; horizontal L0",
        ["CL0H"],
        "Alt+J",
        "app.store.constraints.get('CL0H').active === false",
    ),
    "switch_on": (
        "add_line 0,0 10,0; horizontal L0; switch_off CL0H",
        ["CL0H"],
        "Alt+K",
        "app.store.constraints.get('CL0H').active !== false",
    ),
    "select_all": (LINES, [], "Ctrl+A", "app.store.selection.size === 2"),
    "deselect": (LINES, ["L0"], "Ctrl+Shift+A", "app.store.selection.size === 0"),
    "edit_value": (
        f"{LINES}; length L0 12",
        ["d0"],
        "F2",
        "document.activeElement.id === 'typed' && document.activeElement.value === '12'",
    ),
    "rename": (
        LINES,
        ["L1"],
        "Shift+F2",
        "document.activeElement.getAttribute('aria-label') === 'new name of L1'",
    ),
    "image": (
        LINES,
        ["L0", "L1"],
        "Alt+I",
        "document.activeElement.value === 'image L0 L1 shift '",
    ),
}


@exercises(*(f"action:{one}" for one in EDITS))
@exercises(*(f"key:{key}" for _, _, key, _ in EDITS.values()))
@pytest.mark.parametrize("one", EDITS)
def test_each_edit_by_its_key(sheet: Any, one: str) -> None:
    drawn, chosen, key, condition = EDITS[one]
    run(sheet, drawn)
    select(sheet, chosen)
    press(sheet, pressed(key))
    wait(sheet, condition)


@exercises("action:undo", "action:redo", "key:Ctrl+Z", "key:Ctrl+Y", "key:Ctrl+Shift+Z")
def test_steps_are_undone_and_done_again(sheet: Any) -> None:
    run(sheet, "add_line 0,0 10,2", "add_circle 0,8 3")
    for key, count in (
        ("Control+z", 1),
        ("Control+z", 0),
        ("Control+y", 1),
        ("Control+Shift+Z", 2),
    ):
        press(sheet, key)
        wait(sheet, f"app.store.entities.size === {count}")


@pytest.mark.parametrize("key", ["Delete", "Backspace"])
def test_the_selection_is_deleted_by_keys(sheet: Any, key: str) -> None:
    run(sheet, LINES)
    select(sheet, ["L1"])
    press(sheet, key)
    wait(sheet, "app.store.entities.size === 1")


@exercises("action:delete")
def test_of_a_point_that_is_deleted_from_the_menu_the_curve_goes(sheet: Any) -> None:
    run(sheet, LINES)
    select(sheet, ["L1.p2"])
    sheet.get_by_role("menuitem", name="Edit", exact=True).click()
    sheet.locator(".menu:not([hidden]) .menu-text", has_text="Delete").click()
    wait(sheet, "app.store.entities.size === 1")


LAYERS = ("dimensions", "points", "construction", "regions")

VIEWS: dict[str, tuple[str, str]] = {
    "zoom_in": ("+", "app.view.scale === 12.5"),
    "zoom_out": ("-", "app.view.scale === 8"),
    "grid": ("#", "!app.view.grid"),
    "theme": ("Alt+Shift+L", "document.documentElement.dataset.theme"),
    "command": ("/", "document.activeElement.id === 'command'"),
    "actions": ("Ctrl+K", "document.querySelector('dialog.help[open]')"),
    "keys": ("?", "document.querySelector('dialog.help[open]').innerText.includes('Coincident')"),
    "manual": ("F1", "document.querySelector('dialog.help[open] .help-command')"),
    "tour": ("Shift+F1", "document.querySelector('.tour')"),
    "show_glyphs": ("Z", "app.shown.glyphs === true"),
    "focus_canvas": ("F6", "document.activeElement === app.canvas"),
    **{
        f"show_{layer}": (f"Alt+Shift+{key}", f"app.shown.{layer} === false")
        for layer, key in zip(LAYERS, "DIXU", strict=True)
    },
}


@exercises(*(f"action:{one}" for one in VIEWS))
@exercises(*(f"key:{key}" for key, _ in VIEWS.values()))
@pytest.mark.parametrize("one", VIEWS)
def test_each_action_on_the_view_by_its_key(sheet: Any, one: str) -> None:
    key, condition = VIEWS[one]
    if one == "focus_canvas":
        press(sheet, "/")
    press(sheet, pressed(key))
    wait(sheet, f"!!({condition})")
    if one == "tour":
        press(sheet, "Escape")


@exercises("action:fit", "key:Home", "key:.")
def test_everything_is_shown(sheet: Any) -> None:
    run(sheet, "add_line 200,100 300,180")
    for key in ("Home", "."):
        sheet.evaluate("app.view.centre([0, 0])")
        press(sheet, key)
        wait(sheet, "app.view.toScreen([300, 100])[0] <= app.view.width")
        assert sheet.evaluate("app.view.toScreen([200, 180])[0]") >= 0


def test_closed_regions_are_shaded_and_measured_under_the_pointer(sheet: Any) -> None:
    run(sheet, "add_rect 0,0 60,30 hv", "add_circle 15,15 6", "add_line 70,0 90,0 90,20")
    sheet.evaluate("() => { app.view.setGrid(false); app.fit(); }")
    sheet.wait_for_timeout(100)
    pixel = f"""([x, y]) => {{
        const [u, v] = app.view.toScreen([x, y]).map((one) => Math.round(one * app.renderer.ratio));
        return [...{GROUND}.getImageData(u, v, 1, 1).data];
    }}"""
    inside, hole, outside = (sheet.evaluate(pixel, list(p)) for p in ((40, 11), (12, 11), (80, 9)))
    assert inside != outside and hole == outside
    sheet.mouse.move(*at(sheet, 40, 11))
    area, perimeter = 1800 - 36 * math.pi, 180 + 12 * math.pi
    said = f"region: area {area:.5g} mm², perimeter {perimeter:.5g} mm"
    sheet.get_by_role("status").get_by_text(said, exact=True).wait_for()
    sheet.mouse.move(*at(sheet, 12, 11))
    sheet.get_by_role("status").get_by_text("click to select").wait_for()
    drag(sheet, (60, 30), (50, 40))
    wait(sheet, "!app.store.dragging && app.store.point('L1.p2')[1] > 35")
    sheet.mouse.move(*at(sheet, 40, 33))
    sheet.get_by_role("status").get_by_text("region: area").wait_for()


SPREAD = """() => {
    const { view, renderer } = app;
    const xs = [], ys = [];
    for (const { lines, thin, text } of renderer.annotations.dimensions) {
        [...lines, ...thin].forEach((one, i) => (i % 2 ? ys : xs).push(one));
        xs.push(text.x);
        ys.push(text.y);
    }
    const field = document.querySelector('#field .field').getBoundingClientRect().top;
    const top = app.canvas.getBoundingClientRect().top;
    const room = [view.width - Math.max(...xs), field - top - Math.max(...ys)];
    return [Math.min(...xs), Math.min(...ys), ...room];
}"""
"""Pixels between dimensions and the edges: left, top, right, and to the command field."""


def test_dimensions_are_shown_whole_and_clear_of_the_command_field(sheet: Any) -> None:
    run(sheet, "add_rect 0,0 30,200 hv", "length L0 30", "length L1 200", "dim_pos d0 offset -60")
    sheet.evaluate("app.fit()")
    sheet.wait_for_timeout(100)
    assert min(sheet.evaluate(SPREAD)) > 20


def test_the_view_follows_what_a_command_draws_outside_of_it(sheet: Any) -> None:
    run(sheet, "add_line 0,0 10,0")
    sheet.evaluate("app.fit()")
    before = sheet.evaluate("app.view.scale")
    for text, moved in (("add_line 2,1 8,1", False), ("add_circle 500,500 20", True)):
        sheet.locator("#command").fill(text)
        sheet.locator("#command").press("Enter")
        wait(sheet, f"app.store.entities.size === {3 if moved else 2}")
        sheet.wait_for_timeout(100)
        assert (sheet.evaluate("app.view.scale") < before) == moved
    box = sheet.evaluate("app.view.visible")
    assert box["xmin"] < 0 and box["xmax"] > 520 and box["ymax"] > 520


PANELS = ("selection", "parameters", "relations", "freedom", "history")


@exercises(*(f"action:panel_{one}" for one in PANELS), *(f"panel:{one}" for one in PANELS))
@exercises(*(f"key:{number}" for number in range(1, 6)))
def test_each_panel_is_opened_and_closed_by_its_key(sheet: Any) -> None:
    for number, panel in enumerate(PANELS, 1):
        press(sheet, str(number))
        wait(sheet, f"!document.querySelector('#panel-{panel}').hidden")
        sheet.evaluate("app.canvas.focus()")
        press(sheet, str(number))
        wait(sheet, f"document.querySelector('#panel-{panel}').hidden")


@exercises("action:break", "key:Ctrl+.")
def test_what_runs_is_broken_off_by_a_key(sheet: Any) -> None:
    sheet.evaluate(
        """() => {
            window.broken = 0;
            const before = app.wire.breakOff.bind(app.wire);
            app.wire.breakOff = () => { window.broken += 1; before(); };
        }"""
    )
    press(sheet, "Control+.")
    wait(sheet, "window.broken === 1")
    run(sheet, "add_point 1,2")
    assert names(sheet, "entities") == ["P0"]


@exercises("key:*")
def test_every_key_of_the_table_reaches_its_action(sheet: Any) -> None:
    keys = sheet.evaluate("[...app.actions.byKey].map(([key, one]) => [key, one.id])")
    assert len(keys) > 100
    sheet.evaluate(
        """() => {
            window.reached = "";
            window.unpatched = app.actions.run;
            app.actions.run = (id) => { window.reached = id; };
        }"""
    )
    wrong = []
    for key, one in keys:
        sheet.evaluate("() => { window.reached = ''; app.canvas.focus(); }")
        press(sheet, pressed(key))
        found = sheet.evaluate("window.reached")
        if found != one:
            wrong.append((key, one, found))
    sheet.evaluate("() => { app.actions.run = window.unpatched; }")
    assert wrong == []
