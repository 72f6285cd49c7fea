"""Kernels on threads whose stacks are too small for them."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.runtime.parallel import frames
from arael.runtime.parallel.compiled import supported
from arael.runtime.parallel.frames import frame_of
from arael.scenes import benchmark_config, columns, fill, make_scene

KIB = 1024


@pytest.fixture
def small_threads() -> Iterator[None]:
    before = threading.stack_size(64 * KIB)
    yield
    threading.stack_size(before)


def scene() -> Any:
    slam = arael.load("slam")
    path = slam(gamma=3.18)
    fill(path, slam.layout, columns(make_scene(benchmark_config(20))))
    return path


def in_thread(call: Callable[[], Any]) -> Any:
    found: list[Any] = []

    def run() -> None:
        try:
            found.append(call())
        except BaseException as error:
            found.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join(60)
    assert found, "the thread did not end"
    return found[0]


def everything(path: Any) -> list[Any]:
    problem = path._problem()
    return [path.cost(), path.gradient(), *problem.evaluation.group_rows(4), path.solve().x]


@pytest.mark.parametrize("base", [8 * KIB, 1024 * KIB])
def test_results_are_the_same_bits_on_a_small_stack(
    small_threads: None, base: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = everything(scene())
    monkeypatch.setattr(frames, "_BASE", base)
    path = scene()
    found = in_thread(lambda: everything(path))
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.skipif(not supported(), reason="needs POSIX threads")
def test_a_kernel_that_no_stack_is_found_for_ends_in_memory_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = scene()
    monkeypatch.setattr(frames, "_BASE", 1 << 50)
    for use in (path.cost, path.gradient, path.solve):
        with pytest.raises(MemoryError, match="stack"):
            use()
    monkeypatch.undo()
    path.session.release()
    assert path.solve().converged


def test_bounds_grow_with_the_constraint() -> None:
    layout = arael.load("slam").layout
    bounds = {g.label: frame_of(g, layout.entities) for g in layout.groups}
    # GCC 12 takes 18,880 bytes for the first and 10,752 for the second.
    assert 2 * 18_880 < bounds["PosePair.odometry"] < 256 * KIB
    assert 2 * 10_752 < bounds["PointFrine.bearing"] < bounds["PosePair.odometry"]


LARGE = """
struct A {{
    param p: vec<8>
    param q: vec<8>
    t: vec<8>
    constraint c {{
{lets}
        [{products}] - t
    }}
}}
root R {{ items: list of A }}
"""

SOLVE = """
import sys, threading
import numpy as np
import arael

rng = np.random.default_rng(0)
p, q = rng.normal(size=(2, 40, 8))
ends = []

def solve():
    model = Large()
    model.items.extend(p=p, q=q, t=np.zeros((40, 8)))
    ends.append(model.solve(max_iters=3).end_cost)

Large = arael.load(sys.argv[1], interpret=False)
solve()
threading.stack_size(32 * 1024)
thread = threading.Thread(target=solve)
thread.start()
thread.join()
print(len(ends), ends[0] == ends[1])
"""


@pytest.mark.slow
def test_a_large_constraint_on_the_smallest_stack(tmp_path: Path) -> None:
    """Its kernel takes 40 KB of stack, the thread has 32: it crashed."""
    lets = "\n".join(
        f"    let x{i} = "
        + " + ".join(
            f"sin(p[{(i + k) % 8}] * {k + 1}.5 + q[{i * k % 8}] * {i + 1})" for k in range(30)
        )
        for i in range(8)
    )
    products = ", ".join(f"x{i} * x{(i + 1) % 8}" for i in range(8))
    path = tmp_path / "large.arael"
    path.write_text(LARGE.format(lets=lets, products=products), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", SOLVE, str(path)], capture_output=True, text=True, check=False
    )
    assert done.stdout == "2 True\n", done.stderr
