"""Texts in any state of being typed: every question has an answer, if an empty one."""

from __future__ import annotations

import random
from pathlib import Path

from arael.diagnostics.records import Source
from arael.lsp.completion import completions
from arael.lsp.document import analyse
from arael.lsp.hints import hints
from arael.lsp.hover import hover
from arael.lsp.signatures import signature
from arael.lsp.workspace import Workspace

TEXT = (Path(__file__).parents[2] / "models/pose_graph_3d.arael").read_text()
INSERTED = ["", ".", "(", "{", "}", "x", "sum(", "sum(k in ", '"', "#", "let ", "fn ", "\n"]


def test_damaged_texts() -> None:
    rng = random.Random(7)
    workspace = Workspace()
    whole = analyse(Source("m.arael", TEXT), workspace)
    incomplete = 0
    for _ in range(60):
        at = rng.randrange(len(TEXT))
        text = TEXT[:at] + rng.choice(INSERTED) + TEXT[at + rng.choice([0, 1, 3, 30]) :]
        if rng.random() < 0.3:
            text = TEXT[:at]
        document = analyse(Source("m.arael", text), workspace, whole)
        incomplete += not document.complete
        for offset in (min(at, len(text)), len(text), rng.randrange(len(text) + 1)):
            hover(document, offset, {})
            signature(document, offset)
            labels = [c.label for c in completions(document, offset)]
            assert len(labels) == len(set(labels))
        hints(document, 0, len(text))
        assert document.names.structs or document.complete
    assert incomplete > 20
