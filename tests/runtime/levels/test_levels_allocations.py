"""Steps allocate nothing: calls of the allocator are counted from within a process."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.runtime.levels.test_kernel_rows import MODEL
from tests.runtime.levenberg.test_allocations import COUNTER

COUNTED = """
import ctypes, json, sys
import numpy as np
from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows, Levels

counted = ctypes.CDLL(sys.argv[1]).counted
counted.restype = ctypes.c_long
model = load_compiled(sys.argv[2])
points = 30
rows = KernelRows(model.layout, model.kernels, 2 * points)
k = 2 * np.arange(points - 1)
rows.extend("Distance", np.stack([k, k + 2], 1), {"value": np.ones(points - 1)})
start = np.random.default_rng(0).normal(size=2 * points) * 5
found = {"solve": [], "drag": []}
for limit in 2, 2, 6:
    levels = Levels(rows, step_limit=limit)
    for _ in range(2):
        x = start.copy()
        before = counted()
        outcome = levels.solve(x, 1e-300)
        calls = counted() - before
    found["solve"].append((outcome.rounds, calls))
levels = Levels(rows)
x = start.copy()
assert levels.solve(x).solved
home = x.copy()
for limit in 1, 1, 4:
    x = home.copy()
    before = counted()
    outcome = levels.drag(x, [0, 1], home[:2] + [90.0, 5.0], home, limit=limit)
    found["drag"].append((levels.linearisations, counted() - before))
print(json.dumps(found))
"""


def test_more_steps_allocate_nothing(tmp_path: Path) -> None:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if "LD_PRELOAD" in os.environ:
        pytest.skip("another library, such as a sanitizer's, stands before the allocator")
    if sys.platform != "linux" or platform.libc_ver()[0] != "glibc" or compiler is None:
        pytest.skip("counts by standing before glibc's allocator")
    (tmp_path / "counter.c").write_text(COUNTER)
    library, model = tmp_path / "counter.so", tmp_path / "rows.arael"
    model.write_text(MODEL)
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "counter.c", "-o", library],
                   cwd=tmp_path, check=True)  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, str(library), str(model)],
        env={**os.environ, "LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    _, (few, short), (many, long) = found["solve"]
    assert (few, many) == (2, 6)
    assert long - short <= 4
    _, (few, short), (many, long) = found["drag"]
    assert many >= few + 30
    assert long - short <= 4
