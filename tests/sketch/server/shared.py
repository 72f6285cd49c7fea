"""A shared sketch without a server: windows whose messages go to mirrors."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json
from arael.sketch.server.keeping import Keeper
from arael.sketch.server.protocol import received
from arael.sketch.server.shared import SharedSketch
from tests.sketch.server.client import Mirror, encoded, place


class Local(Mirror):
    """A window without a network: the link of the shared sketch, and the mirror behind it."""

    def __init__(self, shared: SharedSketch, name: str = "w1", since: int = -1) -> None:
        super().__init__()
        self.shared = shared
        self.is_behind = False
        self._ids = itertools.count(1)
        self.window = shared.open(name, self, since)

    def send(self, data: bytes) -> None:
        """Of the link: a message to this page."""
        self.take(data)

    def ask(self, kind: str, **content: Any) -> dict[str, Any]:
        """Send a message; its reply."""
        number = next(self._ids)
        message = received(encoded({"type": kind, "id": number, **content}))
        self.shared.receive(self.window, message)
        return next(
            (m for m in reversed(self.messages) if m["type"] == "reply" and m["id"] == number), {}
        )

    def run(self, text: str, **options: Any) -> dict[str, Any]:
        """Run commands; the reply."""
        return self.ask("run", text=text, **options)

    def drag_to(self, sequence: int, x: float, y: float) -> None:
        """A place of the pointer."""
        self.shared.receive(self.window, received(place(sequence, x, y)))

    def last(self, kind: str) -> dict[str, Any]:
        """The last message of a type."""
        return next(m for m in reversed(self.messages) if m["type"] == kind)

    def is_in_step(self) -> bool:
        """Whether the mirror is the document: records in their order, numbers bit by bit."""
        document = self.shared.session.document
        known = {name: list(records) for name, records in self.tables.items()}
        there = {name: list(getattr(document, name)) for name in known}
        return known == there and self.values == document.values.tolist()


def shared_sketch(path: Path | None = None) -> SharedSketch:
    """A sketch that is kept in a file, or in none."""
    keeper = Keeper(path) if path else None
    session = Session(folder=path.parent if path else None)
    if keeper is not None:
        session.editor = session.make_editor(keeper.document)
    return SharedSketch(session, keeper)


def chain(path: Path, lines: int) -> Path:
    """A file with a zigzag of lines of equal length, all connected."""
    names = [f"L{i}" for i in range(lines)]
    heights = [3.0 * (i % 2) for i in range(lines + 1)]
    entities = [
        {
            "name": name,
            "kind": "line",
            "values": [10.0 * i, heights[i], 10.0 * i + 10, heights[i + 1]],
        }
        for i, name in enumerate(names)
    ]
    pairs = list(itertools.pairwise(names))
    relations = [("coincident", [f"{b}.p1", f"{a}.p2"]) for a, b in pairs]
    relations += [("equal", [a, b]) for a, b in pairs]
    session = Session()
    session.run("add_line 0,0 1,0; add_line 1,0 1,1")
    content = json.loads(to_json(session.document))
    pattern = content["constraints"][0]
    content["entities"] = entities
    content["constraints"] = [
        {**pattern, "name": f"C{i}", "kind": kind, "args": args}
        for i, (kind, args) in enumerate(relations)
    ]
    content["counters"] = {"C": len(relations), "L": lines}
    path.write_text(json.dumps(content))
    return path


def contradictory(path: Path) -> Path:
    """A file with a rectangle one side of which has two lengths, 50 and 60."""
    session = Session()
    session.run("add_rect 0,0 50,30 hv; length L0 50; hdistance L0.p1 L0.p2 50 force")
    content = json.loads(to_json(session.document))
    content["dimensions"][1]["value"] = {"text": "60", "number": 60.0}
    path.write_text(json.dumps(content))
    return path
