"""The line that counts the problems that have ended."""

from __future__ import annotations

import json
import sys
import types
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.distributed.progress import Solved
from arael.distributed.work import Row
from tests.optional import needs

DONE = Row("a", "a", "converged", converged=True)
FAILED = Row("b", "b", "failed")


def test_the_line_counts_problems_and_names_the_dashboard() -> None:
    lines: list[str] = []
    solved = Solved(3, lines.append, "http://127.0.0.1:8787/status", delay=0, interval=0)
    solved.add(DONE)
    solved.add(FAILED)
    solved.clear()
    assert lines[0].startswith("1 of 3 problems, 0.0 s, dashboard http://127.0.0.1:8787/status")
    assert lines[1].startswith("2 of 3 problems, 1 not converged, 0.0 s, dashboard")
    assert lines[2:] == [""]


def test_nothing_is_shown_of_a_short_run() -> None:
    lines: list[str] = []
    solved = Solved(2, lines.append, None)
    solved.add(DONE)
    solved.clear()
    assert lines == []


@needs("Dask")
def test_in_a_notebook_the_cell_is_updated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from arael.distributed import many, map, progress

    pages: list[str] = []
    display: Any = types.ModuleType("IPython.display")
    display.HTML = lambda text: text
    handle = types.SimpleNamespace(update=pages.append)
    display.display = lambda page, display_id: [pages.append(page), handle][1]
    shell: Any = types.ModuleType("IPython")
    shell.get_ipython = lambda: types.SimpleNamespace(kernel=True)
    monkeypatch.setitem(sys.modules, "IPython", shell)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(many, "dashboard", lambda client: "http://127.0.0.1:1/status")
    monkeypatch.setattr(progress.Solved.__init__, "__defaults__", (0.0, 0.0))
    for k in range(2):
        (tmp_path / f"{k}.json").write_text(json.dumps({"a": k}))
    kind = arael.loads("root R : f64 { param a: real; constraint c { a - 1 } }", interpret=True)
    found = list(map(kind, [tmp_path / "*.json"], workers=1))
    assert len(found) == 2
    assert pages[0].startswith("<pre>1 of 2 problems, ")
    assert "dashboard http://127.0.0.1:1/status" in pages[1]
    assert pages[-1] == ""
