"""Functions of `scaled_factor.pxd`, called from a Cython module without the GIL."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.runtime.orthogonal import RankQR

MODULE = """
# cython: language_level=3, boundscheck=False
import numpy as np
from arael.runtime.orthogonal.compiled cimport RankQR

def use(RankQR qr, double[::1] entries, double[::1] right, double[::1] vector):
    cdef double[::1] step = np.zeros(qr.n), factors = np.zeros(qr.m)
    cdef int[::1] equations = np.zeros(qr.m, np.int32)
    cdef int[2] at = [0, 1]
    cdef double[2] values = [3.0, 3.0]
    cdef double remainder
    cdef int wrong, count, rank, basic
    with nogil:
        wrong = qr.factor_entries(&entries[0], NULL, NULL)
        if wrong == 0:
            qr.least_norm_into(&right[0], &step[0])
            qr.project_into(&vector[0])
            count = qr.dependency_into(
                2, at, values, &equations[0], &factors[0], &remainder
            )
            rank = qr.rank_now()
            basic = qr.is_basic(0) + qr.is_basic(1)
    if wrong:
        return wrong
    return rank, basic, list(step), list(vector), count, equations[0], factors[0], remainder
"""


@pytest.mark.slow
def test_without_the_gil(tmp_path: Path) -> None:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None or "LD_PRELOAD" in os.environ:
        pytest.skip("needs a C compiler that runs without a sanitizer")
    (tmp_path / "use_qr.pyx").write_text(MODULE)
    root = Path(arael.__file__).parents[1]
    library = tmp_path / f"use_qr{sysconfig.get_config_var('EXT_SUFFIX')}"
    include = sysconfig.get_path("include")
    run = [sys.executable, "-m", "cython", f"-I{root}", "use_qr.pyx"]
    subprocess.run(run, cwd=tmp_path, check=True)
    build = [
        compiler,
        "-O1",
        "-w",
        "-shared",
        "-fPIC",
        f"-I{include}",
        "use_qr.c",
        "-o",
        str(library),
    ]
    subprocess.run(build, cwd=tmp_path, check=True)
    spec = importlib.util.spec_from_file_location("use_qr", library)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)

    factor = RankQR(2, 3, [0, 2, 4], [0, 1, 0, 1])
    factor.factor([1.0, 1.0, 1.0, -1.0])
    assert factor.dependent.tolist() == []
    vector = np.array([1.0, 3.0, 5.0])
    found = module.use(factor, np.array([1.0, 1.0, 2.0, 2.0]), np.array([4.0, 8.0]), vector)
    assert found[:2] == (1, 1)
    assert found[2] == pytest.approx([2, 2, 0])
    assert found[3] == pytest.approx([-1, 1, 5])
    assert found[4] == 1
    assert found[6] == pytest.approx(3.0 if found[5] == 0 else 1.5)
    assert found[7] < 1e-15
    # What Python had found of the factor before is not taken for that of the new one.
    assert factor.dependent.tolist() == [1]
    assert module.use(factor, np.array([1.0, 1.0, np.nan, 2.0]), np.ones(2), vector) == 2
