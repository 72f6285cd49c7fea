"""One finger draws and drags, two zoom and pan; on a page 390 px wide."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.sketch.browser.conftest import Editor
from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at
from tests.sketch.browser.panels import connected, run, wait
from tests.sketch.browser.test_phone import PHONE

Place = tuple[float, float]


@pytest.fixture
def page(browser: Any, server: Any) -> Iterator[Any]:
    editor = Editor(browser, server, **PHONE)
    yield connected(editor.page)
    editor.close()
    assert editor.errors == []


class Fingers:
    """Touches of the screen, which the browser turns into events of pointers."""

    def __init__(self, page: Any) -> None:
        self._session = page.context.new_cdp_session(page)

    def send(self, kind: str, *places: Place) -> None:
        points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
        event = {"type": f"touch{kind}", "touchPoints": points}
        self._session.send("Input.dispatchTouchEvent", event)

    def move(self, start: list[Place], end: list[Place], steps: int = 6) -> None:
        """All go straight from their starts to their ends, and leave the screen."""
        self.send("Start", *start)
        for k in range(1, steps + 1):
            f = k / steps
            places = [
                (a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]))
                for a, b in zip(start, end, strict=True)
            ]
            self.send("Move", *places)
        self.send("End")


def middle(page: Any) -> Place:
    box = page.locator("#canvas").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@exercises("pointer:Wheel", "pointer:Drag with the middle button")
def test_two_fingers_zoom_between_them_and_pan(page: Any) -> None:
    x, y = middle(page)
    before = page.evaluate("app.view.scale")
    Fingers(page).move([(x - 40, y), (x + 40, y)], [(x - 120, y), (x + 120, y)])
    wait(page, f"Math.abs(app.view.scale / {before} - 3) < 0.15")
    centre = page.evaluate(
        "([x, y]) => { const box = app.canvas.getBoundingClientRect();"
        " return app.view.toWorld([x - box.left, y - box.top]); }",
        [x, y],
    )
    Fingers(page).move([(x - 40, y), (x + 40, y)], [(x - 40, y + 90), (x + 40, y + 90)])
    wait(page, f"Math.abs(app.view.toScreen({centre})[1] - app.view.height / 2 - 90) < 3")
    assert page.evaluate("app.view.scale") == pytest.approx(3 * before, rel=0.06)


def test_two_fingers_draw_nothing_and_drop_what_the_first_began(page: Any) -> None:
    run(page, "add_line -10,0 10,0")
    x, y = at(page, 10, 0)
    fingers = Fingers(page)
    fingers.send("Start", (x, y))
    for k in range(1, 5):
        fingers.send("Move", (x - 5 * k, y - 10 * k))
    wait(page, "app.store.dragging")
    fingers.send("Start", (x - 20, y - 40), (x - 120, y + 60))
    wait(page, "!app.store.dragging")
    fingers.send("End")
    wait(page, "app.store.point('L0.p2')[1] === 0")
    page.evaluate("app.tools.start('line')")
    x, y = middle(page)
    fingers.move([(x - 40, y), (x + 40, y)], [(x - 60, y), (x + 60, y)])
    assert not page.evaluate("app.tools.current.begun")
    assert page.evaluate("app.store.entities.size") == 1


@exercises("tool:rect", "tool:dimension", "tool:circle")
def test_a_part_is_drawn_and_dimensioned_by_touch(page: Any) -> None:
    tap = page.touchscreen.tap
    page.locator("#left [data-action=tool_rect]").tap()
    tap(*at(page, -12, -8))
    tap(*at(page, 12, 8))
    wait(page, "app.store.entities.size === 4")
    page.locator("#left [data-action=tool_circle]").tap()
    tap(*at(page, 0, 0))
    tap(*at(page, 4, 0))
    wait(page, "app.store.entities.size === 5")
    page.locator("#left [data-action=tool_dimension]").tap()
    tap(*at(page, -6, -8))
    tap(*at(page, -6, -13))
    page.locator(".typing").wait_for()
    page.locator("#typed").fill("30")
    page.keyboard.press("Enter")
    wait(page, "app.store.dimensions.size === 1")
    wait(page, "Math.abs(app.store.numbers('L0')[2] - app.store.numbers('L0')[0] - 30) < 1e-6")


@exercises("pointer:Drag")
def test_a_point_is_dragged_by_a_finger(page: Any) -> None:
    run(page, "add_line -10,0 10,0")
    fingers = Fingers(page)
    fingers.move([at(page, 10, 0)], [at(page, 6, 12)])
    wait(page, "!app.store.dragging && app.store.point('L0.p2')[1] > 10")
    assert page.evaluate("app.store.point('L0.p1')") == pytest.approx([-10, 0], abs=1e-9)


def test_what_overlaps_is_selected_by_taps_that_add(page: Any) -> None:
    run(page, "add_line -10,0 10,0", "add_line -10,8 10,8")
    page.touchscreen.tap(*at(page, 3, 0))
    page.touchscreen.tap(*at(page, 3, 8))
    wait(page, "app.store.selection.size === 2")
