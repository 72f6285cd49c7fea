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


AS_IF_CLEARED = """() => {
    const { renderer } = app;
    const { canvas, ctx } = renderer.moving.layer;
    const pixels = () => ctx.getImageData(0, 0, canvas.width, canvas.height).data;
    const found = pixels().slice();
    ctx.clearRect(0, 0, app.view.width, app.view.height);
    renderer.moving.repainted = true;
    renderer._paintMoving();
    const wanted = pixels();
    let inked = 0, other = 0;
    for (let i = 0; i < wanted.length; i++) {
        if (i % 4 === 3) inked += wanted[i] > 0;
        other += found[i] !== wanted[i];
    }
    return [inked, other];
}"""
"""Pixels of what moves, and bytes that differ from those after everything was cleared."""

INKED = """() => {
    const { canvas, ctx } = app.renderer.moving.layer;
    const { data } = ctx.getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((one, i) => i % 4 === 3 && one).length;
}"""
"""Pixels of what moves."""

LAYERS = (
    "(({ moving, overlay }) => [moving.layer, overlay].map("
    "({ canvas }) => canvas.style.visibility !== 'hidden'))(app.renderer)"
)
"""Whether what moves and the overlay are shown."""


@exercises("pointer:Drag")
def test_a_drag_leaves_nothing_of_earlier_frames_and_shows_no_empty_canvas(page: Any) -> None:
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
    page.mouse.move(*at(page, -8, -8))
    wait(page, "!app.renderer.pending && app.store.hovered.size === 0")
    page.evaluate("app.renderer.overlayChanged()")
    wait(page, f"!app.renderer.pending && {LAYERS}.every((one) => !one)")
    corner = page.evaluate("app.store.point('L1.p2')")
    page.mouse.move(*at(page, *corner))
    wait(page, f"app.store.hovered.size > 0 && {LAYERS}[1]")
    page.mouse.down()
    for x, y in ((24, 16), (12, 20), (26, 9), (21, 13)):
        if x == 26:  # from now on as with a graphics processor
            page.evaluate(
                "(({ moving }) => [moving.sheet, window.kept] = [null, moving.sheet])(app.renderer)"
            )
        page.mouse.move(*at(page, x, y), steps=4)
        wait(page, "app.store.dragging && app.wire.delay === 0 && !app.renderer.pending")
        inked, other = page.evaluate(AS_IF_CLEARED)
        assert inked > 500 and other == 0
        assert page.evaluate(LAYERS) == [True, False]
    # A frame around what has the focus would be painted with every frame of the drag.
    assert page.evaluate("getComputedStyle(app.canvas).outlineStyle") == "none"
    assert page.evaluate("getComputedStyle(app.canvas, '::after').display") == "none"
    # It is hidden as it was: were it cleared first, what moved would be seen nowhere for a refresh.
    shown = page.evaluate(INKED)
    page.mouse.up()
    wait(page, f"!app.store.dragging && !app.renderer.pending && !{LAYERS}[0]")
    assert shown > 500 and page.evaluate(INKED) == shown
    page.mouse.move(*at(page, 34, 6))
    page.mouse.down()
    page.mouse.move(*at(page, 38, 9), steps=4)
    wait(page, "app.store.dragging && app.wire.delay === 0 && !app.renderer.pending")
    inked, other = page.evaluate(AS_IF_CLEARED)
    assert inked > 500 and other == 0
    page.mouse.up()
    page.evaluate("() => { app.renderer.moving.sheet = window.kept; }")


@exercises("pointer:Drag", "pointer:Wheel")
def test_what_moves_is_drawn_over_a_copy_of_the_ground(page: Any) -> None:
    run(
        page,
        "add_rect 0,0 20,12 hv",
        "length L0 20",
        "add_rect 2,-6 9,20",
        "add_circle 12,6 4",
    )
    page.evaluate("app.fit()")
    wait(page, "app.renderer.moving.sheet !== null && !app.renderer.pending")
    page.mouse.move(*at(page, 20, 12))
    wait(page, "app.store.hovered.size > 0")
    page.mouse.down()
    for x, y in ((24, 16), (12, 20), (26, 9), (21, 13)):
        if x == 26:  # the ground changes with the view
            page.mouse.wheel(0, -200)
        page.mouse.move(*at(page, x, y), steps=4)
        wait(page, "app.store.dragging && app.wire.delay === 0 && !app.renderer.pending")
        assert page.evaluate("app.renderer.moving.layer.canvas.id") == "filled"
        inked, other = page.evaluate(AS_IF_CLEARED)
        assert inked > 100_000 and other == 0
        inked, mean, far = page.evaluate(BY_HAND_OR_NOT)
        assert inked > 400 and mean < 0.04 and far < 0.01
    page.mouse.up()
    wait(page, "!app.store.dragging && !app.renderer.pending")
    shown = "app.renderer.moving.layers.map((one) => one.canvas.style.visibility)"
    assert page.evaluate(shown) == ["hidden", "hidden"]


BY_HAND_OR_NOT = """() => {
    const { renderer, renderer: { moving, ground: { canvas } } } = app;
    const { width, height } = canvas;
    const ctx = new OffscreenCanvas(width, height).getContext("2d");
    const pixels = (...layers) => {
        for (const one of layers) ctx.drawImage(one, 0, 0);
        return ctx.getImageData(0, 0, width, height).data;
    };
    const drawn = (sheet) => {
        moving.sheet = sheet;
        renderer._paintMoving();
        return pixels(canvas, moving.layer.canvas);
    };
    const { sheet } = moving;
    const [mine, its] = [drawn(sheet), drawn(null)];
    moving.sheet = sheet;
    const below = pixels(canvas);
    let inked = 0, sum = 0, far = 0;
    for (let i = 0; i < its.length; i += 4) {
        inked += Math.abs(its[i] - below[i]) > 5;
        const by = Math.max(...[0, 1, 2].map((k) => Math.abs(mine[i + k] - its[i + k])));
        sum += by / 255;
        far += by > 64;
    }
    return [inked, sum / inked, far / inked];
}"""
"""The ground with what moves, drawn by hand and by the canvas: how many pixels have ink of what
moves, by how much they differ on the average of those, and how many of them by more than a quarter
of the brightness."""


@pytest.mark.parametrize("layer", ["moving", "filled"])
@exercises("pointer:Drag")
def test_what_is_drawn_by_hand_looks_like_what_the_canvas_draws(page: Any, layer: str) -> None:
    curved = [
        "add_circle 15,12 6",
        "distance L0.p1 A0.center 19",
        "diameter A0 12",
    ]
    run(
        page,
        "add_line 0,0 30,0",
        "add_line 30,0 42,17",
        "add_line 42,17 0,26",
        "length L0 30",
        "length L1 20.8",
        "length L2 43 derived",
        "vdistance L0.p1 L2.p2 26",
        "angle L0 L1 55",
        *(curved if layer == "moving" else ["hdistance L0.p1 L2.p1 42", "distance L2.p2 L1.p1 40"]),
    )
    page.evaluate("app.fit()")
    wait(page, "app.renderer.moving.sheet !== null")
    corner = page.evaluate("app.store.point('L1.p2')")
    page.mouse.move(*at(page, *corner))
    wait(page, "app.store.hovered.size > 0")
    page.mouse.down()
    page.mouse.move(*at(page, corner[0] - 9, corner[1] + 5.3), steps=5)
    wait(page, "app.store.dragging && app.wire.delay === 0 && !app.renderer.pending")
    assert page.evaluate("app.renderer.annotations._moving.dimensions.length") == 7
    assert page.evaluate("app.renderer.moving.layer.canvas.id") == layer
    inked, mean, far = page.evaluate(BY_HAND_OR_NOT)
    # the pointer rests: its coordinates are shown
    shown = "document.querySelector('.status-place').textContent.split(', ').map(Number)"
    wait(page, f"app.tools.current.place.at.every((x, i) => Math.abs(x - {shown}[i]) < 0.1)")
    page.mouse.up()
    assert inked > 3000
    assert mean < 0.04
    assert far < 0.01


def test_a_drag_is_rehearsed_off_the_screen(page: Any) -> None:
    run(
        page,
        "add_rect 0,0 20,12 hv",
        "add_circle 34,6 5",
        "length L0 20",
        "radius A0 5",
    )
    page.evaluate("app.fit()")
    wait(page, "!app.renderer.pending && app.renderer.moving._unseen !== null")
    assert page.evaluate("app.renderer.moving._unseen.getImageData(0, 0, 300, 150).data.length") > 0
    assert page.evaluate(f"[app.renderer.movedCount, {LAYERS}[0]]") == [0, False]
    assert page.evaluate("app.store.values.every((one, i) => one === app.store._settled[i])")
    counts = "(({dimensions, still, movingCount}) => [dimensions, still.dimensions].map((one) =>"
    found = page.evaluate(f"{counts} one.length).concat(movingCount))(app.renderer.annotations)")
    assert found == [2, 2, 0]


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
