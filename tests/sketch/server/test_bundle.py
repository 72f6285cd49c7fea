"""The page in a wheel: one bundle where Node is there, else the modules as they are."""

from __future__ import annotations

import importlib.util
import subprocess
from pathlib import Path
from typing import Any

import pytest

SETUP = Path(__file__).parents[3] / "setup.py"


@pytest.fixture
def made() -> Any:
    """The functions of `setup.py`."""
    spec = importlib.util.spec_from_file_location("setup_of_arael", SETUP)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def page(tmp_path: Path) -> Path:
    (tmp_path / "page.js").write_text("import './a.js';")
    return tmp_path


def test_the_bundle_takes_the_place_of_the_module_that_is_loaded(
    made: Any, page: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def bundled(command: list[str], cwd: Path, **options: Any) -> None:
        assert command[2] == made.ESBUILD and "--bundle" in command
        (name,) = (one.split("=")[1] for one in command if one.startswith("--outfile="))
        (cwd / name).write_text("bundled")

    monkeypatch.setattr(made.shutil, "which", lambda name: name)
    monkeypatch.setattr(subprocess, "run", bundled)
    assert made.bundle_page(page)
    assert [one.name for one in page.iterdir()] == ["page.js"]
    assert (page / "page.js").read_text() == "bundled"


@pytest.mark.parametrize("there", [True, False])
def test_without_node_or_npm_the_modules_stay(
    made: Any, page: Path, monkeypatch: pytest.MonkeyPatch, there: bool
) -> None:
    def failed(command: list[str], **options: Any) -> None:
        raise subprocess.CalledProcessError(1, command)

    monkeypatch.setattr(made.shutil, "which", lambda name: name if there else None)
    monkeypatch.setattr(subprocess, "run", failed)
    assert not made.bundle_page(page)
    assert (page / "page.js").read_text() == "import './a.js';"
