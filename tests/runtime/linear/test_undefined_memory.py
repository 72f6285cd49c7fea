"""Solvers read no memory that they have not written: what lay there before has no effect."""

from __future__ import annotations

import os
import subprocess
import sys

PROGRAM = """
import hashlib
import numpy as np
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.auto import make_solver

rng = np.random.default_rng(5)
seen = hashlib.sha256()
for count, reach in ((1, 1), (4, 2), (9, 3), (30, 2), (60, 7), (150, 3)):
    sizes = rng.integers(1, 7, count)
    rows = np.arange(count).repeat(2)
    columns = np.minimum(rows + rng.integers(0, reach + 1, 2 * count), count - 1)
    pattern = BlockPattern.from_pairs(sizes, rows, columns)
    values, b = rng.uniform(-1, 1, pattern.value_count), rng.uniform(-1, 1, pattern.size)
    for name in ("dense", "band", "sparse"):
        for single in (False, True):
            kind = np.float32 if single else np.float64
            solver = make_solver(name, pattern, single)
            diagonal = np.full(pattern.size, 8.0 * (reach + 2), kind)
            status, x = solver.step(values.astype(kind), diagonal, b.astype(kind))
            assert status == 0 and np.isfinite(x).all(), (name, count)
            seen.update(np.ascontiguousarray(x).tobytes())
            seen.update(np.ascontiguousarray(solver.solved(b.astype(kind))).tobytes())
print(seen.hexdigest())
"""


def test_what_lay_in_the_memory_has_no_effect() -> None:
    # The allocator of glibc fills what it hands out, with the complement of this byte.
    found = [
        subprocess.run(
            [sys.executable, "-c", PROGRAM],
            env={**os.environ, "MALLOC_PERTURB_": fill},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for fill in ("0", "1", "128")
    ]
    assert found[0].strip() and found == found[:1] * 3
