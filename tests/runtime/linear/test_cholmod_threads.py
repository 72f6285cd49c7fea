"""CHOLMOD keeps to the threads that a solve may use, each time in a process that has none yet."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.optional import needs

pytestmark = needs("scikit-sparse")
ROOT = Path(__file__).resolve().parents[3]

LOOPS = """
import os
from tests.runtime.linear.block_matrices import build, positive
from arael.runtime.linear.auto import make_solver

full = build([6] * 90, [(i, j) for i in range(90) for j in range(i)])
solver = make_solver("cholmod", full)
before = len(os.listdir("/proc/self/task"))
assert solver.factorise(*positive(full, 3)) == 0
print(len(os.listdir("/proc/self/task")) - before)
"""

BLAS = """
import sys
from threadpoolctl import threadpool_info
import arael

model = arael.load(sys.argv[1])(a=0.0)
model.points.extend(x=[1.0, 3.0])
seen = []

def look(step):
    seen.extend(p["num_threads"] for p in threadpool_info() if p["user_api"] == "blas")

result = model.solve(solver="cholmod", num_threads=1, observer=look)
assert result.plan["solver"] == "cholmod"
print(max(seen))
"""

MEAN = """
struct Point { x: real
    constraint here { root.a - x }
}
root Mean { param a: real; points: list of Point }
"""


def said_by(script: str, *arguments: str) -> str:
    """What a script prints in a process where BLAS would take two threads if left alone."""
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "2"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads in /proc")
def test_its_loops_stay_on_the_calling_thread() -> None:
    assert said_by(LOOPS) == "0"


@pytest.mark.slow
def test_its_blas_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "mean.arael"
    path.write_text(MEAN)
    assert said_by(BLAS, str(path)) == "1"
