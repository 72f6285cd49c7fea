"""Small limits of stack, memory, file size, files and processes (`ulimit`)."""

from __future__ import annotations

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow
SOLVE = "$ARAEL solve line.arael line.json"


@pytest.mark.parametrize("kilobytes", [512, 1024])
def test_small_stack(warm: Place, kilobytes: int) -> None:
    """Also for input that is nested as deep as it may be."""
    deep = "(" * 60 + "a" + ")" * 60
    (warm.folder / "deep.arael").write_text(
        f"root R {{ param a: real\n constraint c {{ {deep} }} }}\n"
    )
    (warm.folder / "nested.json").write_text('{"a":' + "[" * 100_000 + "}")
    limit = f"ulimit -s {kilobytes} && "
    warm.shell(f"{limit}{SOLVE} --compiled").require(0, "converged")
    warm.shell(f"{limit}$ARAEL check deep.arael").require({0, 2})
    warm.shell(f"{limit}$ARAEL solve line.arael nested.json --interpret").require(2)
    warm.shell(f"{limit}$ARAEL calc 'diff(sin(x)^20, x, 3)'").require({0, 2})


@pytest.mark.parametrize("megabytes", [150, 300, 600, 1500])
def test_little_memory(warm: Place, megabytes: int) -> None:
    """Enough for the problem or a message that memory is short; never a crash."""
    env = {"OPENBLAS_NUM_THREADS": "1"}
    limit = f"ulimit -v {megabytes * 1024} && "
    for options in ("--compiled", "--interpret"):
        done = warm.shell(f"{limit}{SOLVE} {options}", env=env)
        short = "memory" in done.text.lower() or "failed to map" in done.text
        if not (short and done.code != 0):
            done.require({0} if megabytes >= 600 else {0, 2})
        assert done.code >= 0 or megabytes < 300, done.text
    if megabytes >= 600:
        rows = ",".join('{"x": 1, "y": 2}' for _ in range(300_000))
        (warm.folder / "large.json").write_text(f'{{"a": 0, "b": 0, "data": [{rows}]}}')
        warm.shell(
            f"{limit}{SOLVE.replace('line.json', 'large.json')} --compiled", env=env
        ).require({0, 1, 2})
    assert warm.leftovers("large.json") == []


@pytest.mark.parametrize("blocks", [0, 1, 8])
def test_files_bounded_in_size(warm: Place, blocks: int) -> None:
    """`ulimit -f`, in units of 512 bytes: what a quota or a full disk does, without privileges."""
    rows = ",".join(f'{{"x": {k}, "y": {2 * k + 1}}}' for k in range(500))
    (warm.folder / "rows.json").write_text(f'{{"a": 0, "b": 0, "data": [{rows}]}}')
    limit = f"ulimit -f {blocks} && "
    outputs = ["-o out.json", "-o out.npz"] + ["--covariance s.json", "--report r.html"] * (
        blocks == 0
    )
    for output in outputs:
        done = warm.shell(
            f"{limit}$ARAEL solve line.arael rows.json --compiled {output} 2>&1 | cat"
        )
        low = done.text.lower()
        assert (
            "too large" in low
            or "cannot" in low
            or (blocks and "wrote" in low and "out.npz" in output)
        ), done.text
        done.clean()
    assert not [name for name in warm.leftovers("rows.json") if name != "out.npz"]
    other = warm.folder / "line.arael"
    other.write_text(other.read_text().replace("a * e.x", "3 * a * e.x"))
    done = warm.shell(f"{limit}{SOLVE} --compiled 2>&1 | cat").clean()
    assert "E0804" in done.text or "too large" in done.text.lower() or "compiler" in done.text, (
        done.text
    )
    assert warm.half_built() == []


@pytest.mark.parametrize("files", [8, 16, 32])
def test_few_files(warm: Place, files: int) -> None:
    limit = f"ulimit -n {files} && "
    done = warm.shell(f"{limit}{SOLVE} --compiled -o out.json")
    if "Error" not in done.text or done.code != 1:  # Python itself does not start with very few
        done.require({0, 2})


def test_threads_with_small_stacks(warm: Place) -> None:
    """A Python thread of 64 KB solves with kernels and on the expression machine.

    What SciPy imports, it imports before: where charset-normalizer is installed, NumPy's f2py loads
    it, which takes 36 KB of the stack by itself.
    """
    text = """
import sys, threading, arael, scipy.sparse.linalg
threading.stack_size(64 * 1024 if sys.argv[1] == "small" else 256 * 1024)
found = []
def work(interpret):
    try:
        model = arael.load("line.arael", interpret=interpret)()
        model.read("line.json")
        found.append(model.solve().status)
        model.covariance(), model.jacobian(), model.diagnose()
    except arael.AraelError as error:
        found.append(str(error))
for interpret in (False, True):
    thread = threading.Thread(target=work, args=(interpret,))
    thread.start()
    thread.join()
print(found)
"""
    warm.script(text, "small").require(0, "converged")
    warm.script(text, "medium").require(0, "['converged', 'converged']")


WIDE = """
root Wide {
    param a: vec<16>
    param b: vec<16>
    m: mat<16,16>
    constraint wide { [m * a - b, sin(a[0]) * b, a, b] }
}
"""


def test_wide_kernels_on_small_stacks(place: Place) -> None:
    """Kernels with many intermediates need no more stack than a thread has."""
    (place.folder / "wide.arael").write_text(WIDE)
    text = """
import threading, numpy as np, arael
model = arael.load("wide.arael", interpret=False)(a=[0.5] * 16, b=[1.0] * 16, m=np.eye(16) * 3)
threading.stack_size(128 * 1024)
def work():
    try:
        print(model.solve(max_iters=3).status)
    except arael.AraelError as error:
        print("refused", error)
thread = threading.Thread(target=work)
thread.start()
thread.join()
"""
    place.script(text).require(0, "converged", "max_iterations", "refused")


def test_no_threads_to_be_had(warm: Place) -> None:
    """Where the system refuses threads, a solve runs on those there are."""
    text = """
import resource, threading, arael
model = arael.load("line.arael")()
model.data.extend(x=range(200_000), y=range(200_000))
print(model.solve(num_threads=1).status)  # imports what another user may not read
model.a.value = 1
import os
os.setuid(65534) if os.getuid() == 0 else None
resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
print(model.solve(num_threads=8).status)
"""
    warm.script(text).require(0, "converged")
