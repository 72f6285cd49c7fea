"""The editor in a notebook, by the widget's message handler: no browser, no kernel."""

from __future__ import annotations

import asyncio
import struct
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from arael.sketch.sketch import Sketch
from tests import optional
from tests.sketch.server.client import Mirror, encoded, place

optional.require("anywidget")

from arael.sketch.notebook import SketchWidget, files  # noqa: E402


class View(Mirror):
    """A view of the widget: what its JavaScript does, in Python."""

    def __init__(self, widget: SketchWidget, name: str = "view1") -> None:
        super().__init__()
        self.widget = widget
        self.name = name
        self.other: list[Any] = []
        send = widget.send

        def sending(content: Any, buffers: Any = None) -> None:
            if content.get("window") != name:
                send(content, buffers)
            elif content["type"] == "page":
                self.take(buffers[0])
            else:
                self.other.append(content)

        widget.send = sending

    def post(self, kind: str, *buffers: bytes, **content: Any) -> None:
        """Send a message of the view to the kernel."""
        whole = {"type": kind, "window": self.name, **content}
        self.widget._received(self.widget, whole, [memoryview(one) for one in buffers])

    def open(self) -> View:
        self.post("open", since=-1)
        return self

    def rest(self) -> View:
        """What the kernel does when it is idle: a browser test's event loop may run meanwhile."""
        self.widget._idle()
        return self

    def ask(self, kind: str, **content: Any) -> dict[str, Any]:
        self.post("page", encoded({"type": kind, "id": 1, **content}))
        return next(m for m in reversed(self.messages) if m["type"] == "reply")


@pytest.fixture
def sketch() -> Sketch:
    return Sketch()


@pytest.fixture
def view(sketch: Sketch) -> View:
    return View(sketch.edit()).open()


def test_the_widget_of_a_sketch_is_one(sketch: Sketch) -> None:
    assert sketch.edit() is sketch.edit()
    assert Sketch().edit() is not sketch.edit()


def test_a_view_draws(sketch: Sketch, view: View) -> None:
    assert view.ask("run", text="add_rect 0,0 50,30 hv")["ok"]
    assert len(sketch.entities) == 4 and list(view.tables["entities"]) == ["L0", "L1", "L2", "L3"]
    assert view.rest().verdict["freedoms"] == 4


def test_what_a_cell_changes_appears_in_every_view(sketch: Sketch, view: View) -> None:
    other = View(sketch.edit(), "view2").open()
    line = sketch.add_line((0, 0), (50, 0))
    sketch.length(line, 60)
    for one in (view, other):
        assert one.numbers("L0") == sketch.document.values.tolist()
    changes = [m for m in view.messages if m["type"] == "change"]
    assert [m["by"] for m in changes] == ["script", "script"]
    assert view.rest().verdict["freedoms"] == 3


def test_verdicts_come_when_the_event_loop_is_idle() -> None:
    async def draw() -> tuple[bool, bool]:
        view = View(Sketch().edit()).open()
        view.ask("run", text="add_rect 0,0 50,30 hv")
        before = "freedoms" in view.verdict
        async with asyncio.timeout(20):
            while "freedoms" not in view.verdict:
                await asyncio.sleep(0.01)
        return before, view.verdict["freedoms"] == 4

    # in a thread of its own: that of the tests may have an event loop
    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(asyncio.run, draw()).result() == (False, True)


def test_cells_and_views_have_variables_of_their_own(sketch: Sketch, view: View) -> None:
    sketch.run("mine = add_line 0,0 50,0")
    assert not view.ask("run", text="print mine.length")["ok"]
    assert view.ask("run", text="theirs = add_line 0,9 50,9")["ok"]
    assert sketch.run("print mine.length")[0].text.endswith("50")


def test_a_drag_in_a_view(sketch: Sketch, view: View) -> None:
    sketch.add_line((0, 0), (50, 0))
    assert view.ask("drag", handles=["L0.p2"], at=[50, 0])["ok"]
    for k in range(1, 4):
        view.post("page", place(k, 50.0 + k, float(k)))
    assert view.frames == [1, 2, 3] and view.numbers("L0")[2:] == pytest.approx([53, 3])
    view.ask("drop")
    assert sketch["L0.p2"].x == pytest.approx(53)
    sketch.undo()
    assert view.numbers("L0") == [0, 0, 50, 0]


def test_an_error_of_a_cell_leaves_views_in_step(sketch: Sketch, view: View) -> None:
    with pytest.raises(Exception, match="E1201"):
        sketch.run("add_line 0,0 50,0\nlength L9 3")
    assert list(view.tables["entities"]) == ["L0"]


@pytest.mark.parametrize(
    "content", [None, "x", {}, {"type": "page"}, {"type": "page", "window": "w9"}, {"type": "x"}]
)
def test_other_messages_are_ignored(sketch: Sketch, view: View, content: Any) -> None:
    view.widget._received(view.widget, content, [b"x"])
    assert view.ask("run", text="add_point 1,1")["ok"]


def test_a_damaged_message_is_answered(view: View) -> None:
    view.post("page", struct.pack("<I", 7))
    assert "cannot be read" in next(m for m in view.messages if m["type"] == "message")["text"]


def test_a_closed_view_takes_its_drag_back(sketch: Sketch, view: View) -> None:
    sketch.add_line((0, 0), (50, 0))
    view.ask("drag", handles=["L0.p2"], at=[50, 0])
    view.post("page", place(1, 60.0, 9.0))
    view.post("close")
    assert sketch["L0.p2"].x == 50


def test_the_files_of_the_page_are_sent(view: View) -> None:
    view.post("files")
    (found,) = view.other
    assert {"index.html", "main.js", "wire.js"} <= set(found["files"])
    assert not any("test" in path or "eslint" in path for path in found["files"])
    assert sum(map(len, found["files"].values())) < 800_000
    assert found["files"] == files()


def test_a_missing_package_is_named() -> None:
    script = (
        "import sys; sys.modules['anywidget'] = None\n"
        "from arael.sketch import Sketch\n"
        "try:\n    Sketch().edit()\n"
        "except Exception as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert "error[E1412]" in done.stdout and "pip install 'arael[notebook]'" in done.stdout
