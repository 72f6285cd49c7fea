"""An iteration allocates nothing: calls of the allocator are counted from within a process."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys

import pytest

# Solvers of ours; CHOLMOD and LAPACK allocate as they like.
OWN = ("dense", "band", "sparse", "schur", "schur_pcg")

# Stands before glibc's allocator, whose functions go by these names too, and counts.
COUNTER = """
#include <errno.h>
#include <stddef.h>
#include <stdatomic.h>

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

static atomic_long calls;
long counted(void) { return calls; }

void *malloc(size_t n) { calls++; return __libc_malloc(n); }
void *calloc(size_t n, size_t size) { calls++; return __libc_calloc(n, size); }
void *realloc(void *old, size_t n) { calls++; return __libc_realloc(old, n); }
void *memalign(size_t a, size_t n) { calls++; return __libc_memalign(a, n); }
void *aligned_alloc(size_t a, size_t n) { calls++; return __libc_memalign(a, n); }
int posix_memalign(void **found, size_t a, size_t n) {
    calls++;
    *found = __libc_memalign(a, n);
    return *found ? 0 : ENOMEM;
}
"""

# Calls of a short and of a long solve from one start, after one that has allocated what is kept.
COUNTED = """
import ctypes, json, sys
import arael
from arael.config import LmConfig
from arael.runtime.assembly import shares
from arael.runtime.parallel import vector_parts
from arael.runtime.linear import parts, subtrees
from arael.runtime.solve import minimise
from arael.scenes import SceneConfig, columns, fill, make_scene
from arael.solving import problem_of

# Everything is split as if it took long, so that two threads have something to do.
shares.GRAIN, shares._ROOM, vector_parts.GRAIN = 1.0, 100.0, 20
parts.GRAIN, parts._ROOM, subtrees.GRAIN = 100.0, 100.0, 100.0

counted = ctypes.CDLL(sys.argv[1]).counted
counted.restype = ctypes.c_long
scene = columns(make_scene(SceneConfig(poses=40, landmarks=120, seed=3)))
found = {}
for precision in "f64", "f32":
    model = arael.load("slam", precision=precision)
    instance = model()
    fill(instance, instance.layout, scene)
    problem = problem_of(instance)
    start = problem.x
    for name in sys.argv[3:]:
        solver = problem.make_solver(name)
        for threads in 1, 2:
            calls = []
            for count in 20, 20, 60:  # inner iterations allocate when they begin
                problem.put(start)
                problem.refresh()
                config = LmConfig.of(
                    max_iters=count, num_threads=threads, min_iters=1000, patience=1000,
                    abs_precision=0.0, rel_precision=0.0,
                )
                before = counted()
                outcome = minimise(problem, config, solver)
                calls.append((outcome.iterations, counted() - before))
            found[f"{name}, {precision}, {threads} threads"] = calls
# Components: most have ended after the short solve, and some go on. Not narrowed, which allocates.
model = arael.load(sys.argv[2])
instance = model()
for k in range(60):
    instance.boxes.append(x=1.0, y=0.0, k=1.0 + k)
for k in range(4):
    instance.curves.append(x=1.0 + k)
problem = problem_of(instance)
start = problem.x
solver = problem.make_solver("sparse")
for threads in 1, 2:
    calls = []
    for count in 20, 20, 60:
        problem.put(start)
        problem.refresh()
        config = LmConfig.of(max_iters=count, num_threads=threads)
        before = counted()
        outcome = minimise(problem, config, solver)
        calls.append((outcome.iterations, counted() - before))
        assert outcome.components.counts() == {"converged": 60, "max_iterations": 4}
    found[f"components, {threads} threads"] = calls
print(json.dumps(found))
"""

# Some that end at once, and some whose minimum is at infinity.
COMPONENTS = """
struct Box { param x: real
    param y: real
    k: real
    constraint c { [x*x - k, y - x*k] } }
struct Curve { param x: real
    constraint c { exp(-0.05 * log(x)) } }
root All {
    boxes: list of Box
    curves: list of Curve }
"""


@pytest.fixture(scope="module")
def counts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[list[int]]]:
    """(iterations, calls) of three solves by each solver, precision and number of threads."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if "LD_PRELOAD" in os.environ:
        pytest.skip("another library, such as a sanitizer's, stands before the allocator")
    if sys.platform != "linux" or platform.libc_ver()[0] != "glibc" or compiler is None:
        pytest.skip("counts by standing before glibc's allocator")
    folder = tmp_path_factory.mktemp("counter")
    (folder / "counter.c").write_text(COUNTER)
    library, model = folder / "counter.so", folder / "all.arael"
    model.write_text(COMPONENTS)
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "counter.c", "-o", library],
                   cwd=folder, check=True)  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, str(library), str(model), *OWN],
        env={**os.environ, "LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("name", OWN)
def test_forty_more_iterations_allocate_nothing(
    counts: dict[str, list[list[int]]], name: str, precision: str, threads: int
) -> None:
    _, (few, short), (many, long) = counts[f"{name}, {precision}, {threads} threads"]
    assert many >= few + 25  # some end before their limit
    # What is left is the record of the attempts, which Python takes over after a solve.
    assert long - short <= 4


@pytest.mark.parametrize("threads", [1, 2])
def test_attempts_of_components_allocate_nothing(
    counts: dict[str, list[list[int]]], threads: int
) -> None:
    _, (few, short), (many, long) = counts[f"components, {threads} threads"]
    assert (few, many) == (20, 60)
    assert long - short <= 4
