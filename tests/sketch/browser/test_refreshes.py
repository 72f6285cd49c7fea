"""What the screen shows, refresh by refresh, while a drag begins and ends."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
from matplotlib.image import imread

from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.mouse import at
from tests.sketch.browser.panels import connected, run, wait


def inked(picture: str, box: dict[str, float]) -> int:
    """Pixels of a recorded refresh, in a box of the page, that differ clearly from most others."""
    image = imread(io.BytesIO(base64.b64decode(picture)), format="png")[..., :3]
    left, top, wide, high = (int(box[key]) for key in ("left", "top", "width", "height"))
    part = image[top : top + high, left : left + wide]
    paper = np.median(part.reshape(-1, 3), axis=0)
    return int((np.abs(part - paper).sum(axis=2) > 0.5).sum())


@exercises("pointer:Drag")
def test_no_refresh_of_the_screen_is_without_what_moves(editor: Any) -> None:
    """What moves is on a canvas that goes to the screen by itself; what it leaves is on another."""
    page = connected(editor.page)
    run(page, *(f"add_rect {9 * i},0 {9 * i + 9},7" for i in range(6)))
    page.evaluate("app.fit()")
    wait(page, "app.renderer.moving.sheet !== null && !app.renderer.pending")
    box = page.evaluate(
        """() => {
            const { left, top, width, height } = app.canvas.getBoundingClientRect();
            // without the frame that shows that the drawing has the focus
            return { left: left + 9, top: top + 9, width: width - 18, height: height - 18 };
        }"""
    )
    session = page.context.new_cdp_session(page)
    seen: list[str] = []

    def refreshed(given: dict[str, Any]) -> None:
        seen.append(given["data"])
        session.send("Page.screencastFrameAck", {"sessionId": given["sessionId"]})

    session.on("Page.screencastFrame", refreshed)
    session.send("Page.startScreencast", {"format": "png", "everyNthFrame": 1})
    for _ in range(3):
        corner = page.evaluate("app.store.point('L22.p1')")
        page.mouse.move(*at(page, *corner))
        page.mouse.down()
        page.mouse.move(*at(page, corner[0] + 3, corner[1] + 2), steps=8)
        wait(page, "app.store.dragging && app.wire.delay === 0")
        page.mouse.up()
        wait(page, "!app.store.dragging && !app.renderer.pending")
        page.wait_for_timeout(200)
    session.send("Page.stopScreencast")
    counts = [inked(one, box) for one in seen]
    assert len(counts) > 10
    assert min(counts) > 0.75 * max(counts), counts
