"""Frames of a drag in Chromium: from the message of the mouse to the painted canvas, by stage.

A chain of rectangles, corner to corner: coincident ends, horizontal and vertical sides, a width
each; the heights are free. The corner at one end is dragged on ellipses, to the side on which its
rectangle grows: the whole chain moves in every frame, and no rectangle would turn over, which the
solver refuses. Moves of the mouse are made in three ways, at most one per `PERIOD`:

- *page*: the event is dispatched in the page, the next one as soon as the frame is on the canvas;
- *mouse*: through the browser's input, the next one when the page has handled the one before; the
  time begins with the event's own stamp, so that it includes what the browser waits before it hands
  the event to the page;
- *paced*: the same, but one every `PERIOD` whatever the browser does, as of a mouse.

Reading a pixel back forces the rasterisation, whose end is that of a frame. Times *from the
message* begin when the page sends the message of the mouse: without what the browser takes to hand
the event over, and the page to find the place.

A run during which the host of a virtual machine took processors away is made again, and named in
the table with its times (`undisturbed.py`).
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.document.saved import save
from benchmarks.measure import table
from benchmarks.sketch.browser import Browser
from benchmarks.systems import Plan
from benchmarks.undisturbed import MOST, Run, undisturbed

T = TypeVar("T")

PER_RECTANGLE = 10
PERIOD = 8.0
"""Milliseconds between moves of the mouse: 125 a second."""
WAYS = ("page", "mouse", "paced")
WANTED = {500: "p95 16.7 ms", 10_000: "p95 16.7 ms"}

_SERVER = Path(__file__).with_name("timed_server.py")
_SCRIPT = Path(__file__).with_name("frames_page.js")

STAGES = (
    ("stamp", "heard", "browser hands the event over"),
    ("heard", "send", "page: event to message"),
    ("send", "received_there", "socket to the server"),
    ("received_there", "begun", "handed to the solving thread"),
    ("begun", "solved", "solver"),
    ("solved", "encoded", "what moved, encoded"),
    ("encoded", "sent", "handed to the socket"),
    ("sent", "received", "socket to the page"),
    ("received", "decoded", "decoded"),
    ("decoded", "painting", "taken in; waits for a refresh"),
    ("painting", "painted", "drawing commands"),
    ("painted", "flushed", "rasterised"),
    ("first", "flushed", "all"),
)
"""From, to, name."""


@dataclass(frozen=True)
class Frames:
    """Times of the frames of one drag.

    Attributes
    ----------
    times : milliseconds by moment, (n,) each, NaN where a frame did not come to it
    moved : entities that moved
    still : frames in which nothing moved
    cpu : (n,) processor time of the solving thread
    """

    times: dict[str, NDArray[np.float64]]
    moved: int
    still: int
    cpu: NDArray[np.float64]

    def between(self, first: str, last: str) -> NDArray[np.float64]:
        """Milliseconds from one moment to another of the frames that have both."""
        found = self.times[last] - self.times[first]
        return found[np.isfinite(found)]

    @property
    def total(self) -> NDArray[np.float64]:
        """Milliseconds from the mouse to the canvas."""
        return self.between("first", "flushed")

    @property
    def from_message(self) -> NDArray[np.float64]:
        """Milliseconds from the message of the mouse to the canvas."""
        return self.between("send", "flushed")


def chain(count: int) -> Document:
    """A chain of rectangles with about `count` constraints."""
    document = Document()
    with document.transaction("chain"):
        for i in range(max(count // PER_RECTANGLE, 1)):
            _rectangle(document, i)
    return document


def _rectangle(document: Document, i: int) -> None:
    w, h = 6.0 + i % 3, 4.0 + i % 4
    x, y = document.numbers_of(f"L{4 * i - 2}")[:2] if i else (0.0, 0.0)
    up = 1.0 if _goes_up(i) else -1.0
    corners = [(x, y), (x + w, y), (x + w, y + up * h), (x, y + up * h)]
    names = [f"L{4 * i + k}" for k in range(4)]
    for k, name in enumerate(names):
        ends = (*corners[k], *corners[(k + 1) % 4])
        document.add_entity("line", ends, name=name)
    pairs = [(f"{names[k]}.p2", f"{names[(k + 1) % 4]}.p1") for k in range(4)]
    if i:
        pairs.append((f"{names[0]}.p1", f"L{4 * i - 2}.p1"))
    for k, pair in enumerate(pairs):
        document.put("constraints", Constraint(f"C{5 * i + k}", "coincident", pair))
    for k, name in enumerate(names):
        kind = ("horizontal", "vertical")[k % 2]
        own = f"C{name}{kind[0].upper()}"
        document.put("constraints", Constraint(own, kind, (name,)))
    document.put("dimensions", Dimension(f"d{i}", "length", (names[0],), Amount(f"{w:g}", w)))


def _goes_up(i: int) -> bool:
    """Whether a rectangle is above the one before it; the chain turns every forty."""
    return (i // 40) % 2 == 0


@contextmanager
def _page(file: Path, log: Path) -> Iterator[Browser]:
    """The editor on a file in a browser. The server's times are in `log` afterwards."""
    from tests.sketch.server.process import ServerProcess

    server = ServerProcess(file, folder=file.parent)
    server.command = [sys.executable, str(_SERVER), str(file), str(log)]
    with server, Browser() as browser:
        browser.open(server.address, "window.app")
        browser.evaluate(f"{_SCRIPT.read_text()}; window.taken = recorded(); 0")
        browser.await_("app.store.verdict.revision > 0")
        time.sleep(2.0)
        yield browser


def frames(count: int, moves: int, way: str = "page") -> Frames:
    """Drag a chain of about `count` constraints; `way`: one of `WAYS`, as the module says."""
    with tempfile.TemporaryDirectory() as folder:
        file, log = Path(folder) / "chain.json", Path(folder) / "times.json"
        save(chain(count), file)
        last = max(count // PER_RECTANGLE, 1) - 1
        drag = json.dumps([f"L{4 * last + 2}.p1", moves, _goes_up(last)])[1:-1]
        with _page(file, log) as browser:
            if way == "page":
                found = browser.evaluate(f"dispatched({drag}, {PERIOD})")
            else:
                found = _by_mouse(browser, drag, way == "paced")
        there = {int(key): one for key, one in json.loads(log.read_text()).items()}
    return _joined(dict(found["records"]), there, found["moved"], way != "page")


def _by_mouse(browser: Browser, drag: str, paced: bool) -> dict[str, Any]:
    """Move the mouse of the browser, one event per `PERIOD`: at most, or exactly."""
    first, second, *rest = browser.evaluate(f"places({drag})")
    browser.mouse("mouseMoved", first)
    browser.mouse("mousePressed", first, pressed=True)
    browser.mouse("mouseMoved", second, pressed=True)
    time.sleep(1.5)
    browser.evaluate("taken.clear()")
    browser.move(rest, PERIOD, pressed=True, paced=paced)
    time.sleep(0.3)
    found: dict[str, Any] = browser.evaluate(
        "({ records: [...taken], moved: app.renderer.movedCount })"
    )
    browser.mouse("mouseReleased", rest[-1])
    return found


def _joined(
    here: dict[int, dict[str, float]],
    there: dict[int, dict[str, float]],
    moved: int,
    by_mouse: bool,
) -> Frames:
    """Times of the page and of the server by the page's clock."""
    keys = [key for key, one in sorted(here.items()) if "sent" in there.get(key, {})]
    page = [here[key] for key in keys]
    server = [there[key] for key in keys]
    # no message arrives before it was sent: both ways bound how far the clocks are apart
    both = list(zip(page, server, strict=True))
    least = max(b["sent"] - a["received"] for a, b in both if "received" in a)
    most = min(b["received"] - a["send"] for a, b in both)
    apart = 0.5 * (least + most)
    times: dict[str, NDArray[np.float64]] = {}
    for name in ("stamp", "heard", "send", "received", "decoded", "painting", "painted", "flushed"):
        times[name] = np.array([one.get(name, np.nan) for one in page])
    for name in ("received", "begun", "solving", "solved", "encoded", "sent"):
        key = "received_there" if name == "received" else name
        times[key] = np.array([one.get(name, np.nan) for one in server]) - apart
    times["first"] = times["stamp" if by_mouse else "heard"]
    still = sum(one.get("numbers") == 0 for one in page)
    return Frames(times, moved, still, np.array([one["cpu"] for one in server]))


def run(plan: Plan, picture: Path | None) -> list[str]:
    """The chapter of a report."""
    del picture
    moves = 60 if plan.quick else 600
    rows, stages = [], []
    for count, wanted in WANTED.items():
        for way in WAYS:
            runs = undisturbed(partial(frames, count, moves, way))
            found = runs[-1].found
            row = [f"{count:,}", way, str(found.moved), *_quantiles(found.total)]
            row += [_three(found.from_message), _late(found.total), str(found.still)]
            rows.append([*row, *_taken(runs, lambda one: one.from_message), wanted])
            stages += ["", f"{count:,}, {way}:", "", *_stages(found, way != "page")]
    head = ["constraints", "moves by", "entities that move", "p50", "p95", "p99", "most"]
    head += ["from the message: p50, p95, p99", "later than 16.7 ms", "nothing moved"]
    head += ["taken by the host", "runs left out: taken; from the message", "wanted"]
    return [
        "## sketch-frames",
        "",
        "From the message of the mouse to the painted canvas, milliseconds, in Chromium; the",
        "server is a process on the same machine. A run in which the host of a virtual machine",
        f"took more than {MOST:.1%} of the processors' time is made again.",
        "",
        *table(head, rows),
        *stages,
    ]


def _stages(found: Frames, by_mouse: bool) -> list[str]:
    rows = []
    for first, last, name in STAGES:
        if first == "stamp" and not by_mouse:
            continue
        rows.append([name, *(_percentiles(found.between(first, last)))])
    rows.append(["(processor time of the solving thread)", *_percentiles(found.cpu)])
    return table(["stage", "p50", "p95", "p99", "most"], rows)


def _taken(
    runs: Sequence[Run[T]], from_message: Callable[[T], NDArray[np.float64]]
) -> tuple[str, str]:
    """What the host took in the run that counts; the same of the others, with their times."""
    others = [f"{one.taken:.1%}; {_three(from_message(one.found))}" for one in runs[:-1]]
    return f"{runs[-1].taken:.1%}", "<br>".join(others) or "-"


def _quantiles(total: NDArray[np.float64]) -> list[str]:
    return [f"{x:.1f}" for x in (*np.percentile(total, [50, 95, 99]), total.max())]


def _late(total: NDArray[np.float64]) -> str:
    return f"{int((total > 16.7).sum())} of {len(total)}"


def _three(values: NDArray[np.float64]) -> str:
    return ", ".join(f"{x:.1f}" for x in np.percentile(values, [50, 95, 99]))


def _percentiles(values: NDArray[np.float64]) -> list[str]:
    return [f"{x:.2f}" for x in (*np.percentile(values, [50, 95, 99]), values.max())]


if __name__ == "__main__":
    moves = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    sys.stdout.write("\n".join(run(Plan((), "", (1,), moves <= 60, ()), None)) + "\n")
