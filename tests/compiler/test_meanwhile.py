"""``interpret="meanwhile"``: a session does without kernels until they are there."""

from __future__ import annotations

import os
import shutil
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.loading import InterpretedWarning, load

pytestmark = pytest.mark.skipif(
    sys.platform == "win32" or shutil.which("cc") is None,
    reason="wraps a C compiler called `cc` in shell scripts: install gcc",
)


@pytest.fixture
def waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Make CC a script that runs the given lines first; returns its folder.

    The lines may wait for the file ``go``, which is made when the test ends in any case.
    """
    folder = tmp_path / "compiler"
    folder.mkdir()

    def make(lines: str) -> Path:
        script = folder / "cc"
        script.write_text(
            f'#!/bin/sh\nhere={folder}\n[ "$1" = --version ] && exec {shutil.which("cc")} '
            f'--version\n{lines}\nexec {shutil.which("cc")} "$@"\n'
        )
        script.chmod(0o700)
        monkeypatch.setenv("CC", str(script))
        return folder

    yield make  # type: ignore[misc]
    (folder / "go").touch()


UNTIL_GO = "while [ ! -e $here/go ]; do sleep 0.02; done"


def line(loaded: Any) -> Any:
    model = loaded(a=0.5)
    x = np.linspace(0, 1, 20)
    model.data.extend(x=x, y=3 * x + 0.01 * np.sin(9 * x))
    return model


def is_compiled(model: Any) -> bool:
    return model._compiled.kernels is not None


def test_a_model_changes_over_between_solves(
    model: Path, waiting: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = waiting(UNTIL_GO)
    loaded = load(model, interpret="meanwhile")
    compilation = loaded.compiled.meanwhile  # type: ignore[attr-defined]
    first, other = line(loaded), line(loaded)
    interpreted = first.solve()
    assert not is_compiled(first)
    assert not compilation.wait(0.01)

    def finish(record: Any) -> bool:
        """The kernels are there while a solve goes on."""
        (folder / "go").touch()
        assert compilation.wait(60)
        assert not is_compiled(other)
        return True

    during = other.solve(observer=finish)
    assert not is_compiled(other)
    assert during.cost == interpreted.cost

    first.a.value = 0.5
    compiled = first.solve()
    assert is_compiled(first)
    assert compiled.cost == pytest.approx(interpreted.cost, rel=1e-10)
    np.testing.assert_allclose(compiled.x, interpreted.x, rtol=1e-10)
    assert is_compiled(line(loaded)), "new instances have the kernels at once"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load(model, interpret="meanwhile").compiled.origin == "cache"  # type: ignore[attr-defined]


def test_a_failed_compilation_is_a_warning(model: Path, waiting: Callable[[str], Path]) -> None:
    waiting("echo 'no such luck' >&2; exit 1")
    loaded = load(model, interpret="meanwhile")
    instance = line(loaded)
    assert loaded.compiled.meanwhile.wait(60)  # type: ignore[attr-defined]
    with pytest.warns(InterpretedWarning, match="ended with status 1 on generated kernels") as seen:
        result = instance.solve()
    assert [os.path.basename(w.filename) for w in seen] == ["test_meanwhile.py"]
    assert result.converged
    assert not is_compiled(instance)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        instance.solve()  # warned once


def test_an_unknown_value_of_interpret_is_refused(model: Path) -> None:
    with pytest.raises(AraelError, match="E0827"):
        load(model, interpret="later")  # type: ignore[arg-type]
