"""What is on the screen during a drag: nothing of earlier frames, and as the canvas draws it."""

from __future__ import annotations

from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at
from tests.sketch.browser.panels import run, wait


@pytest.fixture
def page(sheet: Any) -> Any:
    return sheet


PIXELS = """() => {
    const { canvas } = app.renderer.moving;
    const { data } = app.renderer.moving.getImageData(0, 0, canvas.width, canvas.height);
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) {
        if (data[i + 3]) sum = (sum * 31 + i + data[i] + data[i + 1] + data[i + 2]) % 1e9;
    }
    return [data.filter((one, i) => i % 4 === 3 && one).length, sum];
}"""
"""How many pixels of what moves are inked, and a number that differs if they do."""


@exercises("pointer:Drag")
def test_a_drag_leaves_nothing_of_earlier_frames(page: Any) -> None:
    run(
        page,
        "add_rect 0,0 20,12 hv",
        "add_circle 34,6 5",
        "add_arc 24,20 27,23 30,20",
        "add_spline 20,12 10,20 0,25 -9,18",
        "coincident L1.p2 A1.start",
        "distance L1.p1 A0.center 14",
        "length L0 20",
    )
    page.evaluate("app.fit()")
    page.mouse.move(*at(page, *page.evaluate("app.store.point('L1.p2')")))
    wait(page, "app.store.hovered.size > 0")
    page.mouse.down()
    for x, y in ((24, 16), (12, 20), (21, 13)):
        page.mouse.move(*at(page, x, y), steps=4)
        wait(page, "app.store.dragging && app.wire.delay === 0 && !app.renderer.pending")
        found = page.evaluate(PIXELS)
        page.evaluate("app.renderer.resize()")  # everything is blank
        wait(page, "!app.renderer.pending")
        assert found[0] > 500 and page.evaluate(PIXELS) == found
    # A frame around what has the focus would be painted with every frame of the drag.
    assert page.evaluate("getComputedStyle(app.canvas).outlineStyle") == "none"
    page.mouse.up()
    wait(page, "!app.store.dragging && !app.renderer.pending")
    assert page.evaluate(PIXELS)[0] == 0  # all is on the ground


@exercises("pointer:Drag")
def test_a_drag_takes_each_place_of_the_pointer_once(page: Any) -> None:
    """As soon as the browser tells it, and not again with the refresh of the screen."""
    run(page, "add_rect 0,0 20,12 hv")
    page.evaluate("app.fit()")
    page.evaluate(
        """() => {
            const tool = app.tools.current;
            const move = tool.move.bind(tool);
            window.heard = [];
            window.taken = [];
            tool.move = (place, event) => (event && taken.push(event.type), move(place, event));
            app.canvas.addEventListener("pointermove", (event) => heard.push(event.type));
        }"""
    )
    page.mouse.move(*at(page, 20, 12))
    wait(page, "app.store.hovered.size > 0")
    page.mouse.down()
    page.mouse.move(*at(page, 22, 14), steps=4)
    wait(page, "app.store.dragging && taken.includes('pointerrawupdate')")
    page.evaluate("heard.length = taken.length = 0")
    page.mouse.move(*at(page, 26, 17), steps=12)
    wait(page, "heard.length > 0 && app.wire.delay === 0")
    assert set(page.evaluate("taken")) == {"pointerrawupdate"}
    page.mouse.up()
    wait(page, "!app.store.dragging")
    page.evaluate("taken.length = 0")
    page.mouse.move(*at(page, 10, 6), steps=3)
    wait(page, "taken.includes('pointermove')")
