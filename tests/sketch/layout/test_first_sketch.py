"""The first sketch after a build from source: answered before its kernels are there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arael.loading import load_compiled
from arael.sketch import Sketch
from arael.sketch.layout import model

SCRIPT = "add_line 0,0 3,0.2; add_line 3,0.1 3.1,2; horizontal L0; vertical L1; length L0 5"


class Compilation:
    """One in the background, as `Meanwhile`."""

    failure = ""
    kernels: Any = None


@pytest.fixture
def compilation(monkeypatch: pytest.MonkeyPatch) -> Iterator[Compilation]:
    found, task = load_compiled("sketch"), Compilation()
    asked: list[Any] = []

    def loading(name: str, **options: Any) -> Any:
        asked.append((name, options))
        return replace(found, kernels=None, origin="interpreted", meanwhile=task)  # type: ignore[arg-type]

    monkeypatch.setattr(model, "load_compiled", loading)
    model._loaded.cache_clear()
    yield task
    model._loaded.cache_clear()
    assert asked == [("sketch", {"interpret": "meanwhile"})]


def test_a_sketch_is_solved_before_its_kernels_are_there(compilation: Compilation) -> None:
    sketch = Sketch()
    sketch.run(SCRIPT)
    assert model.compiled().kernels is None
    first, second = (sketch.document.numbers_of(name) for name in ("L0", "L1"))
    assert first[1] == pytest.approx(first[3], abs=1e-9)
    assert second[0] == pytest.approx(second[2], abs=1e-9)
    assert np.hypot(*(first[2:4] - first[:2])) == pytest.approx(5.0)


def test_kernels_are_taken_when_they_are_there(compilation: Compilation) -> None:
    assert model.compiled().kernels is None
    compilation.kernels = load_compiled("sketch").kernels
    assert model.compiled().kernels is compilation.kernels
    assert model.rows().n == 0
