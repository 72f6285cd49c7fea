"""What tools show before a click: cuts, typed angles, measured values."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.panels import connected, length, press, run, wait
from tests.sketch.browser.test_drawing import at, click, start


@pytest.fixture
def page(editor: Any) -> Any:
    found = connected(editor.page)
    found.evaluate("() => app.canvas.focus()")
    return found


def preview(page: Any) -> Any:
    return page.evaluate("app.tools.current.preview()")


@pytest.mark.parametrize("tool", ["split", "trim"])
def test_cuts_are_bars_across_the_curve_not_points(page: Any, tool: str) -> None:
    run(page, "add_line 0,0 60,0", "add_line 20,-10 20,15", "add_line 40,-10 40,15")
    page.evaluate("app.fit()")
    start(page, tool)
    page.mouse.move(*at(page, 30, 0))
    shown = preview(page)
    assert "points" not in shown
    assert [cut["at"] for cut in shown["cuts"]] == [pytest.approx([x, 0]) for x in (20, 40)]
    assert all(cut["along"][1] == pytest.approx(0) for cut in shown["cuts"])


@pytest.mark.parametrize("tool", ["fillet", "chamfer"])
def test_a_corner_is_shown_as_it_becomes_before_the_click_and_while_typing(
    page: Any, tool: str
) -> None:
    run(page, "add_rect 0,0 40,20 hv")
    page.evaluate("app.fit()")
    start(page, tool)
    page.mouse.move(*at(page, 40, 20))
    assert len(preview(page)["curves"]) == 1
    click(page, 40, 20)
    page.keyboard.type("6")
    (shown,) = preview(page)["curves"]
    if tool == "fillet":
        assert (shown["cx"], shown["cy"], shown["rx"]) == pytest.approx((34, 14, 6))
        assert abs(shown["sweep"]) == pytest.approx(math.pi / 2)
    else:
        assert sorted([shown["x1"], shown["x2"]]) == pytest.approx([34, 40])
    press(page, "Backspace")
    page.keyboard.type("25")
    found = preview(page)
    assert not found["curves"] and [one["text"] for one in found["labels"]] == ["below 20 mm"]
    press(page, "Backspace", "Backspace", "6", "Enter")
    wait(page, "app.store.entities.size >= 5")


def test_the_guide_of_rotate_follows_the_typed_angle(page: Any) -> None:
    run(page, "add_line 0,0 20,0")
    page.evaluate("() => { app.fit(); app.store.select(['L0']); }")
    start(page, "rotate")
    click(page, 0, 0)
    page.mouse.move(*at(page, 15, 3))
    page.keyboard.type("90")
    ends = [[guide["x2"], guide["y2"]] for guide in preview(page)["guides"]]
    assert ends == [pytest.approx([10, 0], abs=0.3), pytest.approx([0, 10], abs=0.3)]
    page.mouse.move(*at(page, 5, 8))
    assert [[g["x2"], g["y2"]] for g in preview(page)["guides"]] == ends


def test_what_is_measured_has_labels_and_an_overlap_is_called_so(page: Any) -> None:
    run(page, "add_circle 0,0 8", "add_circle 10,0 6")
    page.evaluate("app.fit()")
    start(page, "measure")
    click(page, -8, 0)
    click(page, 16, 0)
    hint = "document.querySelector('.status-hint').textContent"
    wait(page, f"{hint}.includes('overlap')")
    assert page.evaluate(hint) == "center distance: 10 · overlap: 4 · concentric: no · tangent: no"
    (label,) = preview(page)["labels"]
    assert label["text"] == "center distance: 10\noverlap: 4"
    press(page, "Escape")


def test_a_letter_begins_an_expression_while_drawing_and_names_complete(page: Any) -> None:
    run(page, "param width 30", "param tilt 20 deg")
    start(page, "line")
    click(page, -10, 0)
    page.mouse.move(*at(page, 5, 3))
    press(page, "w", "i")
    assert page.input_value("#typed") == "wi"
    assert page.evaluate("app.tools.id") == "line"
    page.locator(".typing .words").get_by_text("width", exact=True).wait_for()
    assert page.locator(".typing .words li").count() == 1, "no commands"
    press(page, "Tab")
    assert page.input_value("#typed") == "width"
    press(page, "/", "2")
    # the preview has the value
    wait(page, "document.querySelector('.typing-value').textContent === '= 15'")
    curve = preview(page)["curves"][0]
    assert math.hypot(curve["x2"] - curve["x1"], curve["y2"] - curve["y1"]) == pytest.approx(15)
    press(page, "Tab", "=", "t", "i", "l", "t", "Enter")
    wait(page, "app.store.dimensions.size === 2")
    values = page.evaluate("[...app.store.dimensions.values()].map((d) => [d.kind, d.value.text])")
    assert values == [["length", "width/2"], ["xangle", "tilt"]]
    run(page, "param width 40")
    wait(page, "app.store.dimensions.get('d0').value.number === 20")
    assert length(page, "L0") == pytest.approx(20)


def test_a_wrong_expression_stays_in_place_and_a_click_takes_a_right_one(page: Any) -> None:
    run(page, "param width 30")
    start(page, "circle")
    click(page, 0, 0)
    page.mouse.move(*at(page, 5, 3))
    press(page, "n", "o", "Enter")
    page.locator(".typing-problem").get_by_text("no").first.wait_for()
    assert page.evaluate("app.store.entities.size") == 0
    page.locator("#typed").fill("width / 3")
    wait(page, "document.querySelector('.typing-value').textContent === '= 10'")
    click(page, 12, 3)
    wait(page, "app.store.dimensions.get('d0')?.value.text === 'width / 3'")
    assert page.evaluate("app.store.numbers('A0')[2]") == pytest.approx(10)


@exercises("action:snapshot", "key:Alt+Shift+V")
def test_equals_links_and_a_snapshot_has_an_action(page: Any) -> None:
    run(page, "param width 30", "add_line 0,0 25,3", "length L0 25")
    page.evaluate("app.typing.edit('d0')")
    page.locator("#typed").fill("=width")
    press(page, "Enter")
    wait(page, "app.store.dimensions.get('d0').value.text === 'width'")
    page.evaluate("app.store.select(['d0'])")
    press(page, "Alt+Shift+V")
    wait(page, "app.store.dimensions.get('d0').value.text === '30'")
