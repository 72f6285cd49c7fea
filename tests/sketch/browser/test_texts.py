"""Texts in the editor: placed, typed with a preview, edited, dragged by their lettering."""

from __future__ import annotations

from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import GROUND
from tests.sketch.browser.panels import connected, press, wait
from tests.sketch.browser.test_drawing import at, click, drag, start


@pytest.fixture
def page(editor: Any) -> Any:
    found = connected(editor.page)
    found.evaluate("() => { app.tour.skip?.(); app.canvas.focus(); }")
    press(found, "Escape")
    return found


def text_of(page: Any, name: str) -> str:
    return str(page.evaluate(f"app.store.entities.get('{name}')?.text ?? ''"))


def numbers(page: Any, name: str) -> list[float]:
    return [float(x) for x in page.evaluate(f"[...app.store.numbers('{name}')]")]


DARK = (
    f"""([x, y, w, h]) => {{
    const ctx = {GROUND};
"""
    """
    const ratio = window.devicePixelRatio;
    const box = [x, y, w, h].map((one) => Math.round(one * ratio));
    const { data } = ctx.getImageData(...box);
    const { background } = app.renderer.palette;
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
        if (Math.abs(data[i] - data[0]) + Math.abs(data[i + 1] - data[1]) > 60) count++;
    }
    return count;
}"""
)


@exercises("tool:text")
def test_a_text_is_placed_typed_edited_and_dragged(page: Any) -> None:
    start(page, "text")
    click(page, -20, 5)
    page.locator(".typing").wait_for()
    page.keyboard.type('Ø8 "fit"')
    # the preview is the text that stands in the field
    shown = page.evaluate("app.tools.current.preview().texts.map((one) => one.text)")
    assert shown == ['Ø8 "fit"']
    press(page, "Enter")
    wait(page, "app.store.entities.size === 1")
    assert text_of(page, "L0") == 'Ø8 "fit"'
    before = numbers(page, "L0")
    assert before[1] == before[3] and before[2] > before[0]
    # lettering is on the canvas, above the base line
    press(page, "Escape", "Escape")
    x, y = page.evaluate(f"app.view.toScreen([{before[0]}, {before[1]}])")
    end, _ = page.evaluate(f"app.view.toScreen([{before[2]}, {before[3]}])")
    page.wait_for_timeout(100)
    assert page.evaluate(DARK, [x, y - 22, end - x, 18]) > 50
    # a double click edits it
    start(page, "select")
    middle = (0.5 * (before[0] + before[2]), before[1])
    page.mouse.dblclick(*at(page, middle[0], middle[1]))
    page.locator(".typing").wait_for()
    assert page.locator("#typed").input_value() == 'Ø8 "fit"'
    page.keyboard.type("Ø9")
    press(page, "Enter")
    wait(page, "app.store.entities.get('L0').text === 'Ø9'")
    after = numbers(page, "L0")
    assert after[:2] == pytest.approx(before[:2]) and after[2] < before[2]
    # its lettering drags it
    grip = page.evaluate(
        f"[{after[0]} + 0.3 * ({after[2]} - {after[0]}), {after[1]} + 12 / app.view.scale]"
    )
    drag(page, (grip[0], grip[1]), (grip[0] + 10, grip[1] - 8))
    wait(page, f"!app.store.dragging && Math.abs(app.store.numbers('L0')[0] - {after[0]} - 10) < 1")
    press(page, "Control+z")
    wait(page, f"Math.abs(app.store.numbers('L0')[0] - {after[0]}) < 1e-9")


def test_a_typed_height_is_that_of_the_text_and_escape_drops_it(page: Any) -> None:
    start(page, "text")
    page.mouse.move(*at(page, 0, 0))
    page.keyboard.type("3")
    press(page, "Enter")
    click(page, 0, 0)
    page.locator(".typing").wait_for()
    press(page, "Escape")
    page.locator(".typing").wait_for(state="hidden")
    assert page.evaluate("app.store.entities.size") == 0
    click(page, 0, 0)
    page.locator(".typing").wait_for()
    press(page, "Enter")
    # nothing was typed: the refusal stays in place
    page.locator(".typing [role=alert]").get_by_text("blank").wait_for()
    page.keyboard.type("H")
    press(page, "Enter")
    wait(page, "app.store.entities.size === 1")
    x1, _, x2, _ = numbers(page, "L0")
    # an H is 13 of 20 wide
    assert x2 - x1 == pytest.approx(3 * 13 / 20)
