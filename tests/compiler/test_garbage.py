"""The garbage collector while a model is compiled."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

from arael.compiler import build, compilation, compiler
from arael.compiler.garbage import RARELY, rare_collections
from arael.diagnostics.records import AraelError, Source

TEXT = "root R { param a: real; constraint c { a - 1 } }\n"


@pytest.fixture(autouse=True)
def threshold() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    yield
    gc.set_threshold(*before)


def test_derivation_collects_rarely(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    syntax = compiler.syntax
    monkeypatch.setattr(
        compiler, "syntax", lambda source: (seen.append(gc.get_threshold()), syntax(source))[1]
    )
    compilation.compile_text(Source("model.arael", TEXT))
    assert seen == [(RARELY, 10, 10)]
    assert gc.get_threshold() == (700, 10, 10)


def test_thresholds_are_restored_after_an_error() -> None:
    with pytest.raises(AraelError):
        compilation.compile_text(Source("model.arael", TEXT.replace("a - 1", "b")))
    assert gc.get_threshold() == (700, 10, 10)


def test_cython_collects_rarely(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    class Stopped(Exception):
        pass

    def stopped(*args: object, **options: object) -> None:
        assert gc.get_threshold()[0] == RARELY
        raise Stopped

    monkeypatch.setattr("Cython.Compiler.Main.compile_single", stopped)
    with pytest.raises(Stopped):
        build.cython_to_c(tmp_path / "model.pyx")
    assert gc.get_threshold()[0] == 700


def test_a_disabled_collector_stays_disabled() -> None:
    gc.set_threshold(0, 10, 10)
    with rare_collections():
        assert gc.get_threshold()[0] == 0
