"""A disk without space: the command fails, names it, and leaves neither empty nor partial files."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.processes import Place, full

pytestmark = pytest.mark.slow
Mount = Callable[[str], Path]
WORDS = ("no space", "disk", "full")


def listed(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


OUTPUTS = {
    "output": ["-o", "{}/out.json"],
    "archive": ["-o", "{}/out.npz"],
    "compressed": ["-o", "{}/out.json.gz"],
    "covariance": ["--covariance", "{}/sigma.json"],
    "covariance archive": ["--covariance", "{}/sigma.npz"],
    "report": ["--report", "{}/report.html"],
    "plot": ["--plot", "{}/plot.png"],
}


@pytest.mark.parametrize("before", ["nothing", "a file"])
@pytest.mark.parametrize("kind", OUTPUTS)
def test_what_a_solve_writes(place: Place, mounted: Mount, kind: str, before: str) -> None:
    if kind == "plot" and importlib.util.find_spec("matplotlib") is None:
        pytest.skip("needs matplotlib (pip install arael[plot])")
    disk = mounted("size=64k")
    options = [word.format(disk) for word in OUTPUTS[kind]]
    target = Path(options[1])
    if before == "a file":
        target.write_text("old")
    with full(disk):
        there = listed(disk)
        place.arael("solve", "line.arael", "line.json", "--interpret", *options).require(
            {1, 2}, *WORDS
        )
        assert listed(disk) == there
    if before == "a file":
        assert target.read_bytes() == b"old"


def test_new(place: Place, mounted: Mount) -> None:
    disk = mounted("size=64k")
    with full(disk):
        there = listed(disk)
        place.arael("new", "line", cwd=disk).require(2, *WORDS)
        assert listed(disk) == there
    place.arael("new", "line", cwd=disk).require(0)


def test_fmt(place: Place, mounted: Mount) -> None:
    disk = mounted("size=64k")
    ugly = disk / "ugly.arael"
    ugly.write_text("root R{param a:real;constraint c{a-1}}\n")
    with full(disk):
        there, text = listed(disk), ugly.read_text()
        place.arael("fmt", str(ugly)).require(2, *WORDS)
        assert listed(disk) == there
        assert ugly.read_text() == text


@pytest.mark.parametrize("left", [0, 4096, 16384])
def test_cache(place: Place, mounted: Mount, left: int) -> None:
    """A compilation that the cache has no space for, whenever that shows."""
    disk = mounted("size=8m")
    env = {"ARAEL_CACHE_DIR": str(disk / "cache")}
    with full(disk, left):
        done = place.arael("solve", "line.arael", "line.json", "--compiled", env=env)
        done.require(2, *WORDS)
        assert not [*disk.rglob("build-*"), *disk.rglob("*.so")]
    place.arael("solve", "line.arael", "line.json", "--compiled", env=env).require(0, "converged")


def test_temporary_files_of_the_compiler(place: Place, mounted: Mount) -> None:
    """One failure does not pin the expression machine: with space again, the model is compiled."""
    disk = mounted("size=64k")
    env = {"TMPDIR": str(disk)}
    with full(disk):
        place.arael("solve", "line.arael", "line.json", env=env).require(
            {0, 2}, *WORDS, "converged"
        )
        assert listed(disk) == {"filler"}
    done = place.arael("solve", "line.arael", "line.json", env=env).require(0, "converged")
    assert "expression machine" not in done.text
