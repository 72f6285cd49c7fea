"""A factorisation of an analysed pattern allocates nothing."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.runtime.levenberg.test_allocations import COUNTER

COUNTED = """
import ctypes, json, sys
from tests.runtime.orthogonal.matrices import beams, grid, polygon

counted = ctypes.CDLL(sys.argv[1]).counted
counted.restype = ctypes.c_long
found = {}
for name, made in (("beams", beams(3000)), ("grid", grid(12)), ("polygon", polygon(200))):
    factor = made.analysed()

    def again(count):
        before = counted()
        for _ in range(count):
            factor.factor(made.entries)
        return counted() - before

    again(3)
    found[name] = again(50)
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def counts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, int]:
    """Calls of the allocator in fifty factorisations."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if "LD_PRELOAD" in os.environ:
        pytest.skip("another library, such as a sanitizer's, stands before the allocator")
    if sys.platform != "linux" or platform.libc_ver()[0] != "glibc" or compiler is None:
        pytest.skip("counts by standing before glibc's allocator")
    folder = tmp_path_factory.mktemp("counter")
    (folder / "counter.c").write_text(COUNTER)
    library = folder / "counter.so"
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "counter.c", "-o", library],
                   cwd=folder, check=True)  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, str(library)],
        cwd=Path(__file__).parents[3],
        env={**os.environ, "LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize("name", ["beams", "grid", "polygon"])
def test_nothing_is_allocated(counts: dict[str, int], name: str) -> None:
    # Python itself takes a new arena of small objects now and then.
    assert counts[name] <= 3
