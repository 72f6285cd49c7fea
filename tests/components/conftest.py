"""The model of independent problems, and solves that narrow early."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import arael
from arael.model import Model
from arael.runtime.linear import narrowing
from tests.components.problems import (
    MODEL,
    Load,
)


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Load]:
    """The model, compiled or interpreted, once each."""
    path = Path(tmp_path_factory.mktemp("components")) / "all.arael"
    path.write_text(MODEL)
    loaded: dict[tuple[str, bool], type[Model]] = {}

    def kind(precision: str, interpret: bool) -> type[Model]:
        key = (precision, interpret)
        if key not in loaded:
            loaded[key] = arael.load(path, precision=precision, interpret=interpret)  # type: ignore[arg-type]
        return loaded[key]

    yield kind


@pytest.fixture
def narrowed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Narrow the loop wherever components have ended; the scalars that remained each time."""
    seen = []
    build = narrowing.remaining_solver

    def counted(*args: Any) -> Any:
        found = build(*args)
        seen.append(found.inner.n)
        return found

    monkeypatch.setattr(narrowing, "remaining_solver", counted)
    monkeypatch.setattr(narrowing, "CONSTANT", 0)
    monkeypatch.setattr(narrowing, "MULTIPLE", 0)
    return seen
