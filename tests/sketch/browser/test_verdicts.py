"""Verdicts are drawn: by colour and by shape."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.sketch.browser.conftest import Editor
from tests.sketch.browser.mouse import GROUND, at, click
from tests.sketch.browser.panels import connected, press, run, wait
from tests.sketch.server.process import ServerProcess
from tests.sketch.server.shared import contradictory

PIXELS = (
    f"""(places) => {{
    const ctx = {GROUND};
"""
    """
    const ratio = app.renderer.ratio;
    return places.map(([x, y, dx, dy]) => {
        const [u, v] = app.view.toScreen([x, y]);
        const [px, py] = [Math.round((u + dx) * ratio), Math.round((v + dy) * ratio)];
        return [...ctx.getImageData(px, py, 1, 1).data];
    });
}"""
)


@pytest.fixture
def contradicting(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    """A page on a file whose dimensions contradict."""
    file = contradictory(tmp_path / "plate.json")
    with ServerProcess(file, folder=tmp_path) as running:
        found = Editor(browser, running)
        yield found
        found.close()
        assert found.errors == []


def pixels(page: Any, *places: tuple[float, float, float, float]) -> list[list[int]]:
    """Colours at places: x and y of the sketch, then pixels to the right and down."""
    found: list[list[int]] = page.evaluate(PIXELS, [list(place) for place in places])
    return found


def palette(page: Any, name: str) -> list[int]:
    """A colour of the drawing."""
    found: list[int] = page.evaluate(
        """name => {
            const ctx = new OffscreenCanvas(1, 1).getContext("2d");
            ctx.fillStyle = app.renderer.palette[name];
            ctx.fillRect(0, 0, 1, 1);
            return [...ctx.getImageData(0, 0, 1, 1).data];
        }""",
        name,
    )
    return found


def test_what_is_impossible_has_a_colour_a_dashed_halo_and_crosses(contradicting: Editor) -> None:
    page = connected(contradicting.page)
    wait(page, "app.store.verdict.constraints.d1 === 'impossible'")
    page.evaluate("() => app.fit()")
    page.wait_for_timeout(200)
    impossible = palette(page, "impossible")
    # the line itself, away from its middle where the text of the dimensions stands
    assert pixels(page, (10, 0, 0, 0))[0] == pytest.approx(impossible, abs=60)
    # along its edge the halo comes and goes
    blue = [one[2] for one in pixels(page, *[(8, 0, step, 3) for step in range(26)])]
    assert min(blue) < 170 and max(blue) > 240
    # its free end is a cross, not a ring: ink in the middle and on the diagonal
    middle, diagonal = pixels(page, (0, 0, 0, 0), (0, 0, -3, 3))
    assert middle == pytest.approx(impossible, abs=60)
    assert diagonal == pytest.approx(impossible, abs=60)
    assert page.evaluate("app.renderer.annotations._state('d1')") == "impossible"
    assert page.locator(".freedoms-button").inner_text() == "2 impossible"


def test_a_half_free_line_has_one_ring_and_one_disc(editor: Editor) -> None:
    page = connected(editor.page)
    run(page, "add_line 0,0 40,25", "lock L0.p1 0,0")
    wait(page, "app.store.verdict.points['L0.p1'] === 'defined'")
    page.evaluate("() => app.fit()")
    page.wait_for_timeout(200)
    assert page.evaluate("app.store.verdict.entities.L0") == "free"
    disc, ring = pixels(page, (0, 0, 0, 0), (40, 25, 0, 0))
    assert disc == pytest.approx(palette(page, "defined"), abs=40)
    assert ring == pytest.approx(palette(page, "background"), abs=20)
    (edge,) = pixels(page, (40, 25, 3, 0))
    assert edge[:3] != pytest.approx(palette(page, "background")[:3], abs=40)


MARKS = "[...new Set(app.renderer.annotations.glyphs.map((one) => one.name))].sort()"


def test_marks_are_those_of_what_is_hovered_selected_or_contradicts(sheet: Any) -> None:
    run(sheet, "add_rect -20,-10 20,10 hv")
    assert sheet.evaluate(MARKS) == []
    sheet.mouse.move(*at(sheet, 5, 10))
    wait(sheet, "app.store.hovered.has('L2')")
    hovered = sheet.evaluate("app.renderer.annotations.hoveredGlyphs().map((one) => one.name)")
    assert sorted(hovered) == ["C1", "C2", "CL2H"]
    click(sheet, 5, 10)
    wait(sheet, f"{MARKS}.join(' ') === 'C1 C2 CL2H'")
    sheet.mouse.move(1, 1)
    press(sheet, "z")
    wait(sheet, f"{MARKS}.length === 8")
    press(sheet, "z", "Escape")
    sheet.evaluate("app.store.select([])")
    wait(sheet, f"{MARKS}.length === 0")
    run(sheet, "parallel L0 L2 force")
    wait(sheet, f"{MARKS}.includes('C4')")
    sheet.evaluate("app.store.select(['L1'])")
    wait(sheet, f"{MARKS}.includes('CL1V')")
    sheet.evaluate("app.view.scale = 0.5; app.view.centre([0, 0])")
    wait(sheet, f"!{MARKS}.includes('CL1V')")
    assert "C4" in sheet.evaluate(MARKS)
