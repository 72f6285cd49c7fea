"""A cache that cannot be written, was changed, is shared by processes or cleared under them."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.processes import Place, finished, wait_for

pytestmark = pytest.mark.slow
SOLVE = ("solve", "line.arael", "line.json", "--json")


def test_read_only_cache_serves_what_it_holds(
    place: Place, compiled_cache: Path, mounted: Callable[[str], Path]
) -> None:
    disk = mounted("size=8m")
    shutil.copytree(compiled_cache, disk / "cache")
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    env = {"ARAEL_CACHE_DIR": str(disk / "cache")}
    place.arael(*SOLVE, "--compiled", env=env).require(0, "converged")
    other = place.folder / "line.arael"
    other.write_text(other.read_text().replace("a * e.x", "2 * a * e.x"))
    place.arael(*SOLVE, "--compiled", env=env).require(2, "read-only")
    place.arael(*SOLVE, "--interpret", env=env).require(0, "converged")
    place.arael("cache", "info", env=env).require(0, "1 compiled model")
    place.arael("cache", "clear", env=env).require({0, 2})


@pytest.mark.parametrize("ending", ["json", "so", "pyx"])
def test_flipped_bits(warm: Place, ending: str, fuzz_seed: int) -> None:
    """An entry that was damaged is made anew; `cache info` and `cache clear` work on it."""
    rng = random.Random(f"{fuzz_seed} {ending}")
    originals = {path: path.read_bytes() for path in warm.in_cache(f"*.{ending}")}
    assert originals
    print(f"seed {fuzz_seed}")
    for k in range(3):
        for path, content in originals.items():
            damaged = bytearray(content)
            at = rng.randrange(len(damaged) if k else min(64, len(damaged)))
            damaged[at] ^= 0x80 if k == 1 else 1 << rng.randrange(8)  # 0x80: no UTF-8 any more
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(damaged)
            print(f"{path.name}: bit of byte {at}")
        warm.arael("cache", "info").require(0)
        warm.arael(*SOLVE, "--interpret").require(0, "converged")
        if k == 1:
            warm.arael(*SOLVE, "--compiled").require(0, "converged")
    warm.arael("cache", "clear").require(0, "removed")
    assert not warm.in_cache("*.so") + warm.in_cache("*.json")
    assert warm.half_built() == []


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b'{"format": 1}'])
def test_descriptions_that_are_none(warm: Place, content: bytes) -> None:
    for path in warm.in_cache("*.json"):
        path.write_bytes(content)
    warm.arael("cache", "info").require(0)
    warm.arael(*SOLVE, "--interpret").require(0, "converged")
    warm.arael("cache", "clear").require(0)


def test_eight_processes_compile_one_model(place: Place) -> None:
    command = [sys.executable, "-m", "arael", *SOLVE, "--compiled"]
    processes = [place.start(command) for _ in range(8)]
    for process in processes:
        finished(process, 300).require(0, "converged")
    assert len(place.in_cache("*.so")) == 1
    assert place.half_built() == []


def test_cleared_during_a_compilation(place: Place) -> None:
    process = place.start([sys.executable, "-m", "arael", *SOLVE, "--compiled"])
    wait_for(lambda: place.in_cache("*.c"), process)
    place.arael("cache", "clear").require({0, 2})
    finished(process).require({0, 2}, "converged", "clear", "removed")
    place.arael(*SOLVE, "--compiled").require(0, "converged")
    assert place.half_built() == []


def test_cache_of_another_user_is_not_loaded(warm: Place) -> None:
    if os.getuid() != 0:
        pytest.skip("needs the right to give files to another user (run as root)")
    for path in warm.in_cache("*"):
        os.chown(path, 65534, 65534)
    code = "from arael.loading import load_compiled; print(load_compiled('line.arael').origin)"
    done = warm.script(code).clean()
    assert done.out.strip() != "cache", done.text
