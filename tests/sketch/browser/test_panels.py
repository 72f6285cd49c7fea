"""Panels, command field, typed values, menus and messages in a browser."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from arael.sketch.document.saved import to_json
from tests import optional
from tests.event_loop import completed
from tests.sketch.browser.conftest import Editor
from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import click
from tests.sketch.browser.panels import RECTANGLE, connected, length, press, run, wait
from tests.sketch.server.inside import InsideServer
from tests.sketch.server.shared import shared_sketch


@pytest.fixture
def page(sheet: Any) -> Any:
    run(sheet, RECTANGLE)
    return sheet


@pytest.fixture
def own_page(editor: Any) -> Any:
    """Of a server of its own: for what depends on the history, or breaks the page."""
    found = connected(editor.page)
    run(found, RECTANGLE)
    found.evaluate("app.canvas.focus()")
    return found


def show(page: Any, panel: str) -> Any:
    page.evaluate("id => app.panels.show(id)", panel)
    return page.locator(f"#panel-{panel}")


@exercises("panel:parameters")
def test_a_parameter_is_added_edited_renamed_and_deleted(page: Any) -> None:
    panel = show(page, "parameters")
    panel.get_by_label("name of the new parameter").fill("width")
    panel.get_by_label("value of the new parameter").fill("40")
    press(page, "Enter")
    value = panel.get_by_label("value of width", exact=True)
    value.wait_for()
    run(page, "length L0 width")
    value.fill("25 + 5")
    press(page, "Enter")
    wait(page, "Math.abs(app.store.numbers('L0')[2] - app.store.numbers('L0')[0] - 30) < 1e-9")
    panel.get_by_label("name of width", exact=True).fill("w")
    press(page, "Enter")
    wait(page, "app.store.parameters.has('w') && !app.store.parameters.has('width')")
    assert page.evaluate("app.store.dimensions.get('d0').value.text") == "w"
    panel.get_by_label("delete w").click()
    wait(page, "app.store.parameters.size === 0")


def test_an_expression_that_is_refused_says_so_below_its_row(page: Any) -> None:
    run(page, "param width 40")
    panel = show(page, "parameters")
    value = panel.get_by_label("value of width", exact=True)
    value.fill("40 / 0")
    press(page, "Enter")
    problem = panel.locator(".param .row-problem .failure-text")
    problem.wait_for()
    assert "division by zero" in problem.inner_text()
    assert value.get_attribute("aria-invalid") is not None
    assert page.evaluate("app.store.parameters.get('width').amount.text") == "40"


@exercises("panel:relations")
def test_a_constraint_is_found_switched_off_and_deleted(page: Any) -> None:
    panel = show(page, "relations")
    panel.get_by_label("search constraints").fill("horizontal L0")
    rows = panel.locator("li.relation")
    wait(page, "document.querySelectorAll('#panel-relations li.relation').length === 1")
    rows.first.hover()
    assert page.evaluate("[...app.store.hovered]") == ["CL0H", "L0"]
    panel.get_by_label("switch off CL0H").click()
    panel.get_by_label("switch on CL0H").wait_for()
    assert page.evaluate("app.store.constraints.get('CL0H').active") is False
    panel.get_by_label("delete CL0H").click()
    wait(page, "!app.store.constraints.has('CL0H')")


def test_a_value_is_edited_from_the_list(page: Any) -> None:
    run(page, "length L0 40")
    panel = show(page, "relations")
    panel.get_by_label("value of d0").click()
    page.locator("#typed").fill("32 mm")
    press(page, "Enter")
    wait(page, "app.store.dimensions.get('d0').value.text === '32 mm'")
    assert length(page, "L0") == pytest.approx(32.0)


@exercises("panel:freedom")
def test_sentences_on_freedom_point_at_the_drawing(page: Any) -> None:
    panel = show(page, "freedom")
    sentence = panel.locator(".motions .sentence").first
    sentence.wait_for()
    sentence.hover()
    assert page.evaluate("[...app.store.hovered].sort()") == ["L0", "L1", "L2", "L3"]
    assert panel.locator(".freedoms").inner_text().split() == ["4", "degrees", "of", "freedom"]


def test_a_redundant_constraint_is_listed_with_what_may_be_dropped(page: Any) -> None:
    run(page, "parallel L0 L2 force")
    panel = show(page, "freedom")
    conflict = panel.locator(".conflict")
    conflict.wait_for()
    assert "CL0H" in conflict.inner_text()
    assert page.locator(".freedoms-button").inner_text() == "1 redundant"
    conflict.get_by_role("button", name="Delete C").first.click()
    wait(page, "Object.keys(app.store.verdict.constraints).length === 0")


@exercises("panel:history")
def test_the_history_goes_back_and_forth(own_page: Any) -> None:
    page = own_page
    run(page, "length L0 40", "length L1 20")
    panel = show(page, "history")
    panel.get_by_role("button", name=RECTANGLE).click()
    wait(page, "app.store.dimensions.size === 0")
    panel.get_by_role("button", name="length L1 20").click()
    wait(page, "app.store.dimensions.size === 2")
    page.get_by_role("button", name="Undo: length L1 20").wait_for()
    panel.get_by_role("button", name="Start").click()
    wait(page, "app.store.entities.size === 0")


@exercises("panel:selection")
def test_what_is_selected_is_renamed_by_a_double_click_on_its_name(page: Any) -> None:
    run(page, "length L0 40")
    page.evaluate("app.store.select(['L0'])")
    panel = show(page, "selection")
    panel.locator(".chips .name").dblclick()
    field = panel.get_by_label("new name of L0")
    field.fill("base")
    press(page, "Enter")
    panel.get_by_text("letters and a number").wait_for()
    field.fill("base1")
    press(page, "Enter")
    wait(page, "[...app.store.selection].join() === 'base1'")
    assert page.evaluate("app.store.dimensions.get('d0').args") == ["base1"]
    panel.get_by_role("button", name="base1").first.press("F2")
    panel.get_by_label("new name of base1").press("Escape")
    assert panel.locator(".chips").inner_text() == "base1"
    run(page, "undo")
    wait(page, "app.store.entities.has('L0') && !app.store.entities.has('base1')")


@exercises("panel:selection")
def test_the_selection_is_described(page: Any) -> None:
    page.evaluate("app.store.select(['L0'])")
    panel = show(page, "selection")
    wait(page, "document.querySelector('#panel-selection .facts').innerText.includes('length 40')")
    assert "CL0H: horizontal L0" in panel.inner_text()


@exercises("action:command", "key:/")
def test_the_command_field_completes_runs_and_keeps_its_history(page: Any) -> None:
    run(page, "param width 40")
    press(page, "/")
    page.keyboard.type("length L0 wid")
    page.locator(".field ~ .words, #field .words li").first.wait_for()
    press(page, "Tab")
    assert page.input_value("#command") == "length L0 width"
    press(page, "Enter")
    wait(page, "app.store.dimensions.size === 1")
    wait(page, "document.querySelector('#field .output').innerText.includes('Added d0')")
    press(page, "ArrowUp")
    assert page.input_value("#command") == "length L0 width"
    press(page, "Escape")
    assert page.evaluate("document.activeElement.id") == "canvas"


def test_an_error_of_the_command_field_is_marked_at_its_place(page: Any) -> None:
    press(page, "/")
    page.keyboard.type("length L0 breadth")
    press(page, "Enter")
    mark = page.locator("#field .output mark")
    mark.wait_for()
    assert mark.inner_text() == "breadth"
    assert page.input_value("#command") == "length L0 breadth"


def test_what_is_refused_stays_and_offers_the_cheapest_to_drop(
    own_page: Any,
) -> None:
    page = own_page
    run(page, "length L0 40")
    page.evaluate("() => { app.run('length L2 30'); }")
    note = page.locator(".note.error")
    note.wait_for()
    assert "impossible together with CL1V, CL3V and d0" in note.inner_text()
    note.hover()
    assert "d0" in page.evaluate("[...app.store.hovered]")
    note.get_by_role("button", name="delete d0 and repeat").click()
    wait(page, "app.store.dimensions.size === 1 && !document.querySelector('.note.error')")
    assert length(page, "L0") == pytest.approx(30.0)


def test_a_dimension_is_typed_in_place_with_tab_to_the_next(page: Any) -> None:
    run(page, "length L0 40", "length L1 20", "param h 15")
    page.evaluate("app.typing.edit('d0')")
    page.locator("#typed").fill("2 * h + 6 mm")
    wait(page, "document.querySelector('.typing-value').textContent === '= 36'")
    press(page, "Tab")
    wait(page, "document.querySelector('.typing-title').textContent.startsWith('d1')")
    page.locator("#typed").fill("h")
    press(page, "Enter")
    wait(page, "document.querySelector('.typing').hidden")
    assert length(page, "L0") == pytest.approx(36.0)
    assert length(page, "L1") == pytest.approx(15.0)


def test_a_refused_value_stays_in_its_place(page: Any) -> None:
    run(page, "length L0 40")
    page.evaluate("app.typing.edit('d0')")
    page.locator("#typed").fill("nothing")
    press(page, "Enter")
    problem = page.locator(".typing-problem .failure-text")
    problem.wait_for()
    assert "nothing" in problem.inner_text()
    assert page.locator("#typed").is_visible()
    press(page, "Escape")
    assert not page.locator(".typing").is_visible()
    assert page.evaluate("app.store.dimensions.get('d0').value.text") == "40"


def test_a_key_without_what_it_needs_says_what_it_needs(page: Any) -> None:
    page.evaluate("app.store.select(['CL0H'])")
    press(page, "x")
    page.locator(".note").wait_for()
    assert "Construction geometry needs entities" in page.locator(".note").inner_text()
    press(page, "x", "Alt+m")
    page.get_by_text("needs dimensions").wait_for()
    assert page.locator(".note").count() == 1, "the newest takes the place of the last"


@exercises("action:parallel", "key:Q")
def test_a_constraint_is_chosen_first_and_then_what_it_is_for(page: Any) -> None:
    run(page, "add_line 0,-5 30,-8", "add_line 0,-12 30,-10", "add_circle -10,-8 4")
    page.evaluate("app.fit()")
    page.evaluate("app.store.select([])")
    press(page, "q")
    page.get_by_role("status").get_by_text("Parallel: pick two or more lines").wait_for()
    click(page, 10, -6)
    click(page, -10, -4)
    page.get_by_text("Parallel needs two or more lines").wait_for()
    click(page, 10, -6)
    page.evaluate("app.store.select(['L4'])")
    click(page, 9, -11.4)
    made = "[...app.store.constraints.values()].find((one) => one.kind === 'parallel')"
    wait(page, f"{made}?.args.join() === 'L4,L5'")
    wait(page, "app.store.selection.size === 0")
    press(page, "Escape")
    assert page.evaluate("app.tools.id") == "select"


@exercises("action:length")
def test_a_dimension_is_chosen_first_and_then_what_it_measures(page: Any) -> None:
    page.evaluate("app.store.select([])")
    press(page, "Alt+l")
    click(page, 20, 0)
    page.locator("#typed").wait_for()
    assert float(page.input_value("#typed")) == pytest.approx(40)
    press(page, "Enter")
    wait(page, "app.store.dimensions.get('d0')?.args.join() === 'L0'")
    # of those that take any number Enter ends the picking
    press(page, "Alt+t")
    click(page, 30, 0)
    click(page, 40, 10)
    click(page, 10, 20)
    press(page, "Enter")
    wait(page, "document.querySelector('#typed').value === '100'")
    press(page, "Escape")


@exercises("pointer:Right click")
def test_a_right_click_opens_what_fits(page: Any) -> None:
    page.evaluate("app.fit()")
    click(page, 12, 0, button="right")
    menu = page.get_by_role("menu", name="what fits the selection")
    titles = menu.locator(".menu-text").all_inner_texts()
    assert {"Delete", "Horizontal", "Length", "Construction geometry"} <= set(titles)
    assert not {"Parallel", "Radius", "Driving dimension"} & set(titles)
    assert page.evaluate("[...app.store.selection]") == ["L0"]
    menu.get_by_text("Construction geometry").click()
    wait(page, "app.store.entities.get('L0').construction")
    assert menu.count() == 0
    click(page, 20, 10, button="right")
    assert "Select all" in menu.locator(".menu-text").all_inner_texts()
    press(page, "Escape")
    assert menu.count() == 0
    assert page.evaluate("app.store.selection.size") == 0


@exercises("action:show_glyphs")
def test_menus_set_theme_and_what_is_shown(page: Any) -> None:
    def choose(menu: str, item: str) -> None:
        page.get_by_role("menuitem", name=menu, exact=True).click()
        page.locator(".menu:not([hidden])").get_by_text(item, exact=True).click()

    choose("View", "Dark")
    assert page.evaluate("getComputedStyle(document.body).colorScheme") == "dark"
    choose("View", "All constraint marks")
    assert page.evaluate("app.renderer.annotations.shown.glyphs") is True
    choose("View", "Theme as the system")
    assert page.evaluate("document.documentElement.dataset.theme") is None


@pytest.mark.parametrize(("how", "number"), [("Convert", 40 / 25.4), ("Relabel", 40.0)])
def test_the_unit_of_the_part_is_converted_or_relabelled(
    page: Any, how: str, number: float
) -> None:
    run(page, "length L0 40")
    page.get_by_role("menuitem", name="Edit", exact=True).click()
    page.get_by_text("Unit of the part: mm ...").click()
    page.get_by_label("new unit of the part").select_option("in")
    page.get_by_role("button", name=how).click()
    wait(page, "app.store.unit === 'in'")
    assert page.evaluate("app.store.dimensions.get('d0').value.number") == pytest.approx(number)
    assert length(page, "L0") == pytest.approx(number)
    run(page, "undo")
    wait(page, "app.store.unit === 'mm' && app.store.dimensions.get('d0').value.number === 40")


def show_lengths_in(page: Any, unit: str) -> None:
    page.get_by_role("menuitem", name="View", exact=True).click()
    page.locator(".menu:not([hidden])").get_by_text(f"Lengths in {unit}").click()


def test_a_display_unit_converts_numbers_and_never_touches_the_part(page: Any) -> None:
    run(page, "length L0 50.8")
    state = "[app.store.revision, app.store.unit, ...app.store.values].join()"
    before = page.evaluate(state)
    show_lengths_in(page, "in")
    panel = show(page, "relations")
    value = panel.locator(".value").first
    typed = page.locator("#typed")
    panel_value = page.locator("#panel-relations .value", has_text="2 in")
    panel_value.first.wait_for()
    assert "in (the part: mm)" in page.locator("#status").inner_text()
    drawn = "app.renderer.annotations.dimensions.map((one) => one.text.text).join()"
    wait(page, f"{drawn} === '2 in'")
    value.click()
    assert typed.input_value() == "2 in"
    typed.press("Enter")  # the same as before: nothing is run
    assert page.evaluate(state) == before

    value.click()
    typed.fill("3")
    typed.press("Enter")
    wait(page, "Math.abs(app.store.dimensions.get('d0').value.number - 76.2) < 1e-9")
    assert length(page, "L0") == pytest.approx(76.2)
    show_lengths_in(page, "mm")
    wait(page, f"{drawn} === '76.2'")


def test_a_circle_is_drawn_with_a_radius_in_the_display_unit(page: Any) -> None:
    show_lengths_in(page, "in")
    page.evaluate("app.tools.start('circle')")
    click(page, -10, 10)
    press(page, "1", "Enter")
    wait(page, "app.store.dimensions.size === 1")
    assert page.evaluate("[...app.store.dimensions.values()][0].value") == {
        "text": "1 in",
        "number": pytest.approx(25.4),
    }


@exercises("action:keys", "action:manual")
def test_help_is_searched_and_runs_an_action(page: Any) -> None:
    press(page, "?")
    page.get_by_label("search the help").fill("three corners")
    press(page, "Enter")
    assert page.evaluate("app.tools.id") == "rect3"
    wait(page, "!document.querySelector('dialog')")
    press(page, "Escape", "F1")
    page.get_by_label("search the help").fill("add_slot")
    page.locator(".help-command summary").first.click()
    assert "add_slot x1,y1 x2,y2 RADIUS" in page.locator(".help-command").first.inner_text()


def test_escape_closes_the_help_also_while_something_is_searched(page: Any) -> None:
    help_open = "!!document.querySelector('dialog.help')"
    for keys in (["?", "Escape"], ["?", "t", "r", "Escape"], ["Control+k", "t", "Control+k"]):
        for key in keys[:-1]:
            press(page, key)
            wait(page, help_open)
        press(page, keys[-1])
        wait(page, f"!{help_open} && document.activeElement === app.canvas")
    press(page, "Control+k")
    wait(page, help_open)


def test_a_refusal_goes_when_something_else_succeeds(page: Any) -> None:
    run(page, RECTANGLE, "length L0 40")
    refused = "document.querySelectorAll('.note.error, .output.refused:not([hidden])').length"
    for again in (
        "app.run('length L1 20')",
        "app.wire.run('length L1 21')",
        "app.run('undo')",
        """app.wire.beginDrag(['L2.p1'], [40, 20])
            .then(() => { app.wire.dragTo([40, 25]); return app.wire.drop(); })""",
    ):
        page.evaluate("app.run('length L0 -1')")
        press(page, "/")
        page.keyboard.type("length L9 4")
        press(page, "Enter")
        wait(page, f"{refused} === 2")
        page.evaluate("app.wire.ask('measure', {names: 'L0 L1'})")
        assert page.evaluate(refused) == 2
        page.evaluate(again)
        wait(page, f"{refused} === 0")


def test_many_freedoms_are_grouped_and_listed_on_demand(page: Any) -> None:
    run(page, "clear", *(f"add_line 0,{5 * i} {20 + i},{6 * i + 1}" for i in range(7)))
    show(page, "freedom")
    # the sentences of the drawing before are shown until the new ones come
    said = "document.querySelector('.motions .sentence')?.innerText.replace(/\\n/g, '')"
    wait(page, f"{said} === 'L0..L6 can each move along x×7'")
    assert page.evaluate("document.querySelectorAll('.motions .sentence').length") == 4
    first = page.locator(".motions .sentence").first
    first.hover()
    wait(page, "app.store.hovered.size === 7")
    each = "document.querySelectorAll('.each .sentence').length"
    page.get_by_text("One by one").click()
    wait(page, f"{each} === 28")
    run(page, "add_line 90,0 95,7")  # a new verdict leaves the list open
    wait(page, f"{each} === 32")


ATTACK = "y 5; add_point 7,7 #"


@pytest.mark.parametrize("field", ["name", "value"])
def test_what_is_typed_into_the_parameter_panel_is_no_command(page: Any, field: str) -> None:
    panel = show(page, "parameters")
    panel.get_by_label("name of the new parameter").fill(ATTACK if field == "name" else "y")
    panel.get_by_label("value of the new parameter").fill(ATTACK if field == "value" else "3")
    press(page, "Enter")
    panel.locator(".row-problem .failure, .param-new + .row-problem:not(:empty)").first.wait_for()
    assert page.evaluate("[app.store.parameters.size, app.store.entities.has('P0')]") == [0, False]
    panel.get_by_label("name of the new parameter").fill("y")
    panel.get_by_label("value of the new parameter").fill("3 * (2 + 1)")
    press(page, "Enter")
    for name, kind in ((f"w {ATTACK}", "name"), (ATTACK, "value")):
        cell = panel.get_by_label(f"{kind} of y", exact=True)
        cell.fill(name)
        press(page, "Enter")
        panel.locator(".param .row-problem:not(:empty)").wait_for()
        cell.fill("y" if kind == "name" else "4")
        press(page, "Enter")
    assert page.evaluate("[app.store.parameters.size, app.store.entities.has('P0')]") == [1, False]


def test_a_typed_dimension_is_no_command(page: Any) -> None:
    run(page, "length L0 40")
    page.evaluate("app.editDimension(app.store.dimensions.get('d0'))")
    field = page.locator(".typing input")
    field.fill("30; delete L1")
    press(page, "Enter")
    page.locator(".typing .failure").wait_for()
    field.fill("20 + 15")
    press(page, "Enter")
    wait(page, "app.store.dimensions.get('d0').value.number === 35")
    assert page.evaluate("app.store.entities.has('L1')")


def test_defined_is_shown_only_of_what_was_checked(page: Any) -> None:
    """Until the verdict of this revision has come the state is not known."""
    shown = "document.querySelector('.freedoms-button').getAttribute('aria-label')"
    run(page, "lock L0.p1; length L0 40; length L1 20")
    wait(page, f"{shown} === 'Defined'")
    page.evaluate("() => { app.store._verdict = () => {}; }")  # none comes
    run(page, "add_line 90,0 95,7")
    wait(page, f"{shown} === 'checking ...'")
    page.evaluate("() => { delete app.store._verdict; }")
    run(page, "add_line 90,10 95,17")
    wait(page, f"{shown} === '8 free'")


def test_a_read_only_file_says_so_and_stays(browser: Any, tmp_path: Path) -> None:
    file = tmp_path / "plate.json"
    sketch = shared_sketch()
    file.write_bytes(to_json(sketch.session.document))
    file.chmod(0o444)
    before = file.read_bytes()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ARAEL_STATE_DIR", str(tmp_path / ".state"))
        with InsideServer(file) as running:
            editor = Editor(browser, running)
            page = connected(editor.page)
            assert page.locator(".read-only").inner_text() == "read-only"
            run(page, RECTANGLE)
            press(page, "Control+s")
            note = page.locator(".note.error").first
            assert "not saved: the file is read-only" in note.inner_text()
            editor.close()
    assert file.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir() if "plate" in one.name] == ["plate.json"]


def test_an_agent_is_refused_or_allowed(page: Any) -> None:
    ask = "message => app.store.receive(message)"
    page.evaluate(
        "() => { window.sent = []; app.wire.answer = (...given) => window.sent.push(given); }"
    )
    question = {"type": "agent", "id": "7f", "agent": "Painter", "what": "delete L0", "tool": "run"}
    for button, answer in {
        "Allow": ["7f", True, False],
        "Refuse": ["7f", False, False],
        "Always allow": ["7f", True, True],
    }.items():
        page.evaluate(ask, question)
        note = page.locator(".note.warning")
        assert "delete L0" in note.inner_text() and "Painter" in note.inner_text()
        note.get_by_role("button", name=button, exact=True).click()
        assert page.evaluate("window.sent.pop()") == answer
        assert note.count() == 0


def test_an_agents_permission_is_shown_and_revoked(editor: Any) -> None:
    """By the SDK's client: allowed for good, drawn, revoked in the status bar, asked again."""
    optional.require("mcp")
    page = editor.page
    connected(page)
    bar = page.locator(".status-agents")
    assert bar.inner_text() == ""
    replies: list[bool] = []

    def draw() -> None:
        from mcp import Client

        async def run() -> None:
            async with Client(editor.server.agents) as client:
                for place in ("0,0", "5,0", "9,0"):
                    found = await client.call_tool(
                        "execute_command", {"command": f"add_point {place}"}
                    )
                    replies.append(not found.is_error)
                    drawn.set()
                    if place != "9,0":
                        await asyncio.to_thread(go_on.get)

        completed(run())

    drawn, go_on = threading.Event(), SimpleQueue[None]()
    agent = threading.Thread(target=draw, daemon=True)
    agent.start()
    request = page.locator(".note.warning")
    request.get_by_role("button", name="Always allow").click()
    wait(page, "app.store.entities.size === 1")
    assert request.count() == 0 and "may draw" in bar.inner_text()
    go_on.put(None)
    wait(page, "app.store.entities.size === 2")
    assert request.count() == 0
    bar.get_by_role("button").click()
    wait(page, "document.querySelector('.status-agents').innerText === ''")
    go_on.put(None)
    request.get_by_role("button", name="Refuse").click()
    agent.join(30)
    assert replies == [True, True, False]
    assert page.evaluate("app.store.entities.size") == 2 and request.count() == 0


def test_what_runs_long_is_shown_and_can_be_broken_off(own_page: Any) -> None:
    page = own_page
    page.evaluate("() => { app.wire._receive = () => {}; }")  # nothing but what follows
    page.evaluate("() => { window.broken = 0; app.wire.breakOff = () => window.broken++; }")
    page.evaluate("app.store.receive({type: 'busy', since_ms: 150, what: 'freeze'})")
    page.get_by_role("button", name="Break off").click()
    assert page.evaluate("window.broken") == 1
    page.evaluate("app.store.receive({type: 'idle'})")
    assert not page.locator(".status-busy").is_visible()


@exercises("action:save", "key:Ctrl+S")
def test_that_it_was_saved_is_shown(own_page: Any) -> None:
    page = own_page
    press(page, "Control+s")
    wait(page, "document.querySelector('.saved').textContent === 'saved'")
    assert page.locator(".file-name").inner_text() == "sketch.json"
