"""Processes that fork or spawn from one that solves on threads."""

from __future__ import annotations

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow

WORK = """
import multiprocessing, os, sys, threading, warnings
warnings.simplefilter("ignore", DeprecationWarning)
import numpy as np
import arael

def make(interpret=False):
    model = arael.load("line.arael", interpret=interpret)()
    x = np.linspace(-1, 1, 50_000)
    model.data.extend(x=x, y=2 * x + 1)
    return model

def solve(k):
    model = make()
    result = model.solve(num_threads=4)
    return result.status, round(model.a.value, 6)

def inherited(k):
    model.a.value = k
    result = model.solve(num_threads=4)
    return result.status, round(model.a.value, 6)
"""


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_pools(warm: Place, method: str) -> None:
    """Children solve on threads after their parent did."""
    (warm.folder / "work.py").write_text(WORK)
    text = f"""
from work import *
if __name__ == "__main__":
    print(solve(0))
    with multiprocessing.get_context({method!r}).Pool(3) as pool:
        found = pool.map_async(solve, range(6)).get(60)
    assert set(found) == {{("converged", 2.0)}}, found
    print(solve(1), "all equal")
"""
    (warm.folder / "main.py").write_text(text)
    warm.arael("info", "slam").require(0)
    from sys import executable

    warm.run([executable, "main.py"]).require(0, "all equal")


def test_fork_with_an_instance_that_was_solved(warm: Place) -> None:
    (warm.folder / "work.py").write_text(WORK)
    text = """
import work
from work import *
work.model = model = make()
print(model.solve(num_threads=4).status)
with multiprocessing.get_context("fork").Pool(3) as pool:
    found = pool.map_async(work.inherited, range(6)).get(60)
assert set(found) == {("converged", 2.0)}, found
print(inherited(5) == ("converged", 2.0), "all equal")
"""
    warm.script(text.replace("print(inherited(5)", "print(work.inherited(5)")).require(
        0, "all equal"
    )


@pytest.mark.parametrize("threads", [1, 4])
def test_fork_while_another_thread_solves(warm: Place, threads: int) -> None:
    """The child solves a separate instance, and the parent's solve continues."""
    (warm.folder / "work.py").write_text(WORK)
    text = f"""
from work import *
model = make()
# A fork while another thread imports hangs in Python's own import locks: import all of it first.
solve(0), model.solve(num_threads={threads})
stop = False
def loop():
    while not stop:
        model.a.value = 0
        assert model.solve(num_threads={threads}).status == "converged"
thread = threading.Thread(target=loop)
thread.start()
for k in range(8):
    child = os.fork()
    if child == 0:
        code = 1
        try:
            code = 0 if solve(k)[0] == "converged" else 2
        finally:
            os._exit(code)
    import signal, time
    ends = time.monotonic() + 60
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > ends:
            os.kill(child, signal.SIGKILL)
            stop = True
            raise SystemExit("the child hangs")
        time.sleep(0.01)
    assert status == 0, status
stop = True
thread.join()
print("all solved")
"""
    warm.script(text).require(0, "all solved")
