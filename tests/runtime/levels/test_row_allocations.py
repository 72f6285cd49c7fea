"""An evaluation of rows allocates nothing per row: calls of the allocator are counted."""

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

# Calls of ten evaluations of both kinds with few and with many instances, terms and expressions.
COUNTED = """
import ctypes, json, sys
import numpy as np
from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from tests.runtime.levels.test_kernel_rows import product_tape

counted = ctypes.CDLL(sys.argv[1]).counted
counted.restype = ctypes.c_long
model = load_compiled(sys.argv[2], interpret=False)
found = {}
for count in 1, 500:
    rows = KernelRows(model.layout, model.kernels, 2000)
    x = np.random.default_rng(0).normal(size=2000)
    for k in range(count):
        first = rows.add("Distance", [4 * k % 1990, 4 * k % 1990 + 2], [0.0])
        one = rows.add("Distance", [4 * k % 1900, 4 * k % 1900 + 7], [0.0], quantity=True)
        rows.add("Turned", [k, k + 5], [0.3])
        rows.add("Difference", [k + 1, k + 9])
        rows.add_term(first, k, -1.0)
        rows.add_expression(first, product_tape(), [one, one], [k + 3], [2.0])
    rows.jacobian(x)
    before = counted()
    for _ in range(10):
        rows.jacobian(x)
        rows.evaluate(x)
    found[count] = counted() - before
print(json.dumps(found))
"""


def test_an_evaluation_allocates_nothing_per_row(tmp_path: Path) -> None:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if "LD_PRELOAD" in os.environ:
        pytest.skip("another library, such as a sanitizer's, stands before the allocator")
    if sys.platform != "linux" or platform.libc_ver()[0] != "glibc" or compiler is None:
        pytest.skip("counts by standing before glibc's allocator")
    (tmp_path / "counter.c").write_text(COUNTER)
    (tmp_path / "rows.arael").write_text(MODEL)
    library = tmp_path / "counter.so"
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "counter.c", "-o", library],
                   cwd=tmp_path, check=True)  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, str(library), str(tmp_path / "rows.arael")],
        env={**os.environ, "LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    few, many = json.loads(done.stdout).values()
    # Three arrays of results, which NumPy allocates by itself where they are small.
    assert few <= many <= 3 * 10
