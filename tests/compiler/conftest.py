"""A small model, and a cache in which it is compiled: once for all tests, a copy for each."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from arael.loading import load_compiled

LINE = """
struct Point { x: real; y: real }
root Line {
    param a: real
    data: list of Point
    # Distance of a point.
    fit data as e { a * e.x - e.y }
}
"""


@pytest.fixture(scope="session")
def filled_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache with the kernels of `LINE`."""
    folder = tmp_path_factory.mktemp("filled")
    (folder / "line.arael").write_text(LINE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ARAEL_CACHE_DIR", str(folder / "cache"))
        patch.setenv("CFLAGS", "-O0")
        assert load_compiled(folder / "line.arael").origin == "compiled"
    return folder / "cache"


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model file and an empty cache beside it."""
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("CFLAGS", "-O0")  # compile fast
    path = tmp_path / "line.arael"
    path.write_text(LINE)
    return path


@pytest.fixture
def compiled(model: Path, filled_cache: Path) -> Path:
    """A model file, and beside it a cache with its kernels."""
    shutil.copytree(filled_cache, model.parent / "cache")
    return model
