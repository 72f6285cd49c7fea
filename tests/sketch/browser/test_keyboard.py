"""The keyboard alone suffices; nothing is hidden from assistive programs."""

from __future__ import annotations

from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.panels import RECTANGLE, connected, length, names, press, run, wait


@pytest.fixture
def page(editor: Any) -> Any:
    found = connected(editor.page)
    found.evaluate("app.canvas.focus()")
    return found


@exercises("tool:rect", "pointer:Arrow keys", "pointer:Enter", "pointer:Escape")
def test_a_part_is_drawn_and_dimensioned_by_keys(page: Any) -> None:
    press(page, "r", "Enter", "ArrowRight*10", "ArrowUp*6", "Enter")
    wait(page, "app.store.entities.size === 4")
    first = length(page, "L0")
    press(page, "Escape", "Escape", "ArrowDown*6", "ArrowLeft*5", "Enter")
    assert page.evaluate("[...app.store.selection]") == ["L0"]
    press(page, "Alt+l")
    page.locator(".typing").wait_for()
    assert float(page.input_value("#typed")) == pytest.approx(first)
    page.keyboard.type("24 mm")
    press(page, "Enter")
    wait(page, "app.store.dimensions.size === 1 && document.activeElement === app.canvas")
    assert length(page, "L0") == pytest.approx(24.0)
    press(page, "Control+z")
    wait(page, "app.store.dimensions.size === 0")
    press(page, "Control+z")
    wait(page, "app.store.entities.size === 0")
    press(page, "Control+Shift+Z")
    wait(page, "app.store.entities.size === 4")


@exercises("tool:line", "pointer:Arrow keys", "pointer:Enter")
def test_a_chain_of_lines_ends_with_enter_twice(page: Any) -> None:
    press(page, "l", "Enter", "ArrowRight*8", "Enter", "ArrowUp*5", "Enter")
    wait(page, "app.store.entities.size === 2")
    press(page, "Enter")
    assert not page.evaluate("app.tools.current.begun")


def test_several_things_are_selected_and_constrained_by_keys(page: Any) -> None:
    run(page, "add_line 0,0 20,1", "add_line 0,8 20,10")
    page.evaluate("() => { app.fit(); app.store.select(['L0', 'L1']); }")
    press(page, "q")
    wait(page, "app.store.constraints.size === 1")
    press(page, "Control+a", "Delete")
    wait(page, "app.store.entities.size === 0")


def test_the_arrow_keys_show_a_cursor_that_the_pointer_takes_away(page: Any) -> None:
    assert not page.locator(".key-cursor").is_visible()
    press(page, "ArrowRight")
    assert page.locator(".key-cursor").is_visible()
    page.mouse.move(300, 300)
    assert not page.locator(".key-cursor").is_visible()


def test_tab_reaches_every_part_of_the_page_and_the_focus_is_seen(page: Any) -> None:
    run(page, RECTANGLE)
    reached: set[str] = set()
    for _ in range(160):
        press(page, "Tab")
        found = page.evaluate(
            """() => {
                const one = document.activeElement;
                const part = one.closest("#top, #left, #canvas, #field, #right");
                // the canvases lie on the outline of the drawing: its focus is a frame above them
                const frame = one.id === "canvas" ? "::after" : null;
                const style = getComputedStyle(one.closest(".field") ?? one, frame);
                const seen = frame
                    ? parseFloat(style.borderTopWidth) > 1
                    : style.outlineStyle !== "none" || style.borderColor !== "";
                return [part ? part.id : "", seen];
            }"""
        )
        assert found[1]
        reached.add(found[0])
        if reached >= {"top", "left", "canvas", "field", "right"}:
            return
    raise AssertionError(f"reached {sorted(reached)}")


def test_every_button_and_field_has_a_name(page: Any) -> None:
    run(page, RECTANGLE, "param w 3", "length L0 40")
    for panel in ("selection", "parameters", "relations", "freedom", "history"):
        page.evaluate("id => app.panels.show(id)", panel)
        wait(page, f"!document.querySelector('#panel-{panel}').hidden")
        unnamed = page.evaluate(
            """() => [...document.querySelectorAll("button, input, select, [role=application]")]
                .filter((one) => one.offsetParent && one.type !== "file")
                .filter((one) => !(one.getAttribute("aria-label") || one.title || one.labels?.length
                    || one.textContent.trim()))
                .map((one) => one.outerHTML)"""
        )
        assert unnamed == []


def test_menus_are_walked_by_arrow_keys(page: Any) -> None:
    page.get_by_role("menuitem", name="File", exact=True).focus()
    press(page, "ArrowDown", "ArrowRight")
    assert page.locator(".menu:not([hidden])").get_attribute("aria-label") == "Edit"
    press(page, "End")
    assert "Unit of the part" in page.evaluate("document.activeElement.textContent")
    press(page, "Escape")
    assert page.evaluate("document.activeElement.textContent") == "Edit"


def test_the_tour_has_six_steps_and_can_be_skipped(browser: Any, server: Any) -> None:
    context = browser.new_context(viewport={"width": 1100, "height": 750})
    page = context.new_page()
    page.goto(server.address)
    tour = page.get_by_role("dialog", name="tour")
    tour.wait_for()
    for step in range(1, 6):
        assert f"{step} of 6" in tour.inner_text()
        press(page, "Enter")
    assert tour.get_by_role("button", name="Done").count() == 1
    press(page, "Escape")
    assert tour.count() == 0
    page.reload()
    connected(page)  # the tour of a first visit begins before that
    assert tour.count() == 0
    assert names(page, "entities") == []
    context.close()


def test_no_motion_where_the_person_wants_none(browser: Any, server: Any) -> None:
    context = browser.new_context(reduced_motion="reduce")
    context.add_init_script("localStorage.setItem('arael-sketch-tour', 'seen')")
    page = connected_page(context, server)
    page.evaluate("() => { app.notes.show({level: 'info', text: 'a note'}); }")
    assert (
        page.evaluate("getComputedStyle(document.querySelector('.note')).animationName") == "none"
    )
    context.close()


def connected_page(context: Any, server: Any) -> Any:
    page = context.new_page()
    page.goto(server.address)
    return connected(page)
