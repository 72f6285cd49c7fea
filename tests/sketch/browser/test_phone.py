"""A page 390 px wide, by touch; dark and light."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

from tests.sketch.browser.conftest import Editor
from tests.sketch.browser.mouse import GROUND
from tests.sketch.browser.panels import RECTANGLE, connected, run, wait

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


@pytest.fixture
def page(browser: Any, server: Any) -> Iterator[Any]:
    editor = Editor(browser, server, **PHONE)
    yield connected(editor.page)
    editor.close()
    assert editor.errors == []


def test_nothing_is_wider_than_the_page(page: Any) -> None:
    run(page, RECTANGLE, "param width 40", "length L0 width")
    page.evaluate("app.store.select(['L0', 'L1'])")
    for panel in ("", "selection", "parameters", "relations", "freedom", "history"):
        page.evaluate("id => app.panels.show(id)", panel)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        wide = page.evaluate(
            """() => [...document.querySelectorAll("#right *, .bar *, #field *")]
                .filter((one) => one.getBoundingClientRect().right > 390.5)
                .map((one) => one.outerHTML.slice(0, 80))"""
        )
        assert wide == [], panel


def test_what_is_not_judged_yet_fits_beside_the_menus(page: Any) -> None:
    run(page, RECTANGLE)
    page.evaluate(
        """() => {
            Object.defineProperty(app.store, "isJudged", { value: false });
            app.store.dispatchEvent(new Event("verdict"));
        }"""
    )
    wait(page, "document.querySelector('.freedoms-button').ariaLabel === 'checking ...'")
    assert page.evaluate("document.querySelector('.bar').scrollWidth") <= 390


def test_the_verdict_fits_beside_the_menus(page: Any) -> None:
    run(page, RECTANGLE, *(f"length L{k} {40 - 20 * (k % 2)} force" for k in range(4)))
    wait(page, "document.querySelector('.freedoms-button').ariaLabel === '2 redundant'")
    button = page.locator(".freedoms-button")
    box = button.bounding_box()
    assert box["x"] + box["width"] <= 390
    assert button.inner_text().strip() == "2"


def test_targets_are_at_least_40_px(page: Any) -> None:
    run(page, RECTANGLE, "length L0 40")
    page.evaluate("() => { app.store.select(['L0']); app.panels.show('relations'); }")
    small = page.evaluate(
        """() => [...document.querySelectorAll("#left .tool, #bottom .tab, .bar button,"
                + ".strip button, #right button:not(.name), .send")]
            .filter((one) => one.offsetParent && !one.matches(".freedoms-button"))
            .map((one) => [one.getBoundingClientRect(), one.outerHTML.slice(0, 90)])
            .filter(([box]) => box.width < 39.5 || box.height < 39.5)
            .map(([box, text]) => `${box.width} x ${box.height}: ${text}`)"""
    )
    assert small == []


def test_panels_are_a_sheet_from_below_that_a_tab_opens_and_closes(page: Any) -> None:
    sheet, tab = page.locator("#right"), page.locator("#bottom .tab[data-panel=relations]")
    assert not sheet.is_visible()
    tab.tap()
    assert sheet.is_visible()
    box = sheet.bounding_box()
    assert box["width"] == 390
    assert box["y"] > 844 * 0.4
    tab.tap()
    assert not sheet.is_visible()


def test_a_line_is_drawn_by_touch(page: Any) -> None:
    page.locator("#left [data-action=tool_line]").tap()
    box = page.locator("#canvas").bounding_box()
    for x, y in ((90, 200), (290, 320)):
        page.touchscreen.tap(box["x"] + x, box["y"] + y)
    wait(page, "app.store.entities.size === 1")


def test_the_prompt_stays_and_values_are_typed_while_drawing(page: Any) -> None:
    prompt = page.locator("#status .status-hint")
    page.locator("#left [data-action=tool_line]").tap()
    assert prompt.inner_text() == "start of the line"
    before = page.locator("#canvas").bounding_box()
    page.touchscreen.tap(before["x"] + 90, before["y"] + 200)
    assert prompt.inner_text().startswith("end of the line")
    page.locator(".status-values").get_by_text("length").tap()
    page.locator("#typed").fill("12")
    page.locator(".status-values").get_by_text("angle").tap()
    page.locator("#typed").fill("30")
    page.locator("#typed").press("Enter")
    wait(page, "app.store.dimensions.size === 2")
    x1, y1, x2, y2 = page.evaluate("[...app.store.numbers('L0')]")
    turned = math.radians(30)
    assert (x2 - x1, y2 - y1) == pytest.approx((12 * math.cos(turned), 12 * math.sin(turned)))
    assert page.locator("#canvas").bounding_box() == before


def test_what_fits_the_selection_is_offered_without_moving_the_drawing(page: Any) -> None:
    run(page, RECTANGLE)
    before = page.locator("#canvas").bounding_box()
    assert not page.locator(".strip").is_visible()
    page.evaluate("app.store.select(['L0'])")
    page.locator(".strip [data-action=length]").wait_for()
    assert not page.locator(".strip [data-action=radius]").is_visible()
    assert page.locator("#canvas").bounding_box() == before
    page.locator(".strip [data-action=length]").tap()
    page.locator(".typing").wait_for()
    box = page.locator(".typing").bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 390


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_drawing_follows_the_theme(browser: Any, server: Any, scheme: str) -> None:
    editor = Editor(browser, server, color_scheme=scheme)
    page = connected(editor.page)
    pixel = f"() => [...{GROUND}.getImageData(3, 3, 1, 1).data].slice(0, 3)"

    bright = f"({pixel})().reduce((sum, one) => sum + one, 0) / (3 * 255)"

    wait(page, f"{bright} > 0.7" if scheme == "light" else f"{bright} < 0.3")
    page.evaluate("app.theme.set('dark')")
    wait(page, f"{bright} < 0.3")
    page.evaluate("app.theme.set('light')")
    wait(page, f"{bright} > 0.7")
    editor.close()
    assert editor.errors == []
