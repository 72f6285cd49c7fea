"""Faults are injected with signals, limits and mounts of POSIX."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.faults.processes import Place

if os.name != "posix":
    collect_ignore_glob = ["test_*.py"]


@pytest.fixture
def fuzz_seed(request: pytest.FixtureRequest) -> int:
    return int(request.config.getoption("--fuzz-seed", 0))


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path / "place")


@pytest.fixture(scope="session")
def compiled_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that holds `line.arael` compiled; only to be copied."""
    place = Place(tmp_path_factory.mktemp("compiled") / "place")
    place.arael("solve", "line.arael", "line.json", "--compiled").require(0)
    return place.cache


@pytest.fixture(scope="session")
def net_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that holds `net.arael` compiled; not to be changed."""
    place = Place(tmp_path_factory.mktemp("compiled") / "place")
    place.arael("solve", "net.arael", "net.json", "--compiled").require({0, 1})
    return place.cache


@pytest.fixture
def warm(place: Place, compiled_cache: Path) -> Place:
    """A place whose cache holds `line.arael` compiled."""
    shutil.copytree(compiled_cache, place.cache)
    return place


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """Mount a file system in memory with given options; a folder, gone after the test."""
    folders: list[Path] = []

    def mount(options: str) -> Path:
        folder = tmp_path / f"disk{len(folders)}"
        folder.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(
                f"needs the right to mount file systems (run as root): {done.stderr.strip()}"
            )
        folders.append(folder)
        return folder

    if not shutil.which("mount"):
        pytest.skip("needs the command mount (install util-linux)")
    yield mount
    for folder in folders:
        subprocess.run(["umount", "-l", str(folder)], check=True)
