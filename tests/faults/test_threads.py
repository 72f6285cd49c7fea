"""Two Python threads on one instance: serialised, or refused by name; never a crash."""
# ruff: noqa: E501 - scripts

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow

HEAD = """
import sys, threading, time
import numpy as np
import arael
interpret = sys.argv[1] == "interpreter"
model = arael.load("net.arael", interpret=interpret)()
start = np.zeros((20_000, 3))
model.nodes.extend(p=start)
stop = time.monotonic() + 1.5
refused, failed, solves = [], [], []
def solver():
    while time.monotonic() < stop:
        try:
            solves.append(model.solve(num_threads=2, max_iters=5).status)
        except arael.AraelError as error:
            assert error.diagnostics[0].message and error.diagnostics[0].code
            refused.append(error.diagnostics[0].code)
        except BaseException as error:
            failed.append(repr(error))
            raise
def run(*targets):
    threads = [threading.Thread(target=target) for target in targets]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
"""
TAIL = """
assert not failed, failed
assert solves or refused
print("ended", len(solves), len(refused), sorted(set(refused)))
model.nodes.clear()
model.nodes.extend(p=start[:10])
model.solve()
assert np.isfinite(model.nodes.p.value).all()
assert np.isfinite(model.cost())
"""

OTHERS = {
    "another solve": "def other(): solver()",
    "rows appended": """
def other():
    while time.monotonic() < stop:
        try:
            model.nodes.append(p=[0, 0, 0])
            time.sleep(0.0005)
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
""",
    "all rows replaced": """
def other():
    while time.monotonic() < stop:
        try:
            model.nodes.clear()
            model.nodes.extend(p=start)
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
""",
    "data read": """
def other():
    while time.monotonic() < stop:
        try:
            model.read("net.json")
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
""",
    "values set": """
def other():
    while time.monotonic() < stop:
        try:
            model.nodes.p.value[...] = 0.5
            model.nodes.w[...] = 2.0
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
        except (ValueError, TypeError):
            pass
""",
    "diagnosed": """
def other():
    while time.monotonic() < stop:
        try:
            model.cost(), model.jacobian(), model.gradient(), model.cost_table()
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
""",
    "residuals added": """
def other():
    k = 0
    while time.monotonic() < stop:
        try:
            model.residuals.add(arael.runtime_residual(f"1e-9 * (p{k} - 1)", parameters={f"p{k}": 1.0}, label=f"r{k}"))
            k += 1
            time.sleep(0.05)
        except arael.AraelError as error:
            refused.append(error.diagnostics[0].code)
""",
}  # fmt: skip


@pytest.mark.parametrize("kind", OTHERS)
@pytest.mark.parametrize("way", ["kernels", "interpreter"])
def test_one_instance(place: Place, net_cache: Path, way: str, kind: str) -> None:
    text = f"{HEAD}{OTHERS[kind]}\nrun(solver, other){TAIL}"
    place.script(text, way, env={"ARAEL_CACHE_DIR": str(net_cache)}).require(0, "ended")


def test_one_class_of_model(warm: Place) -> None:
    """Instances of their own share nothing that one could disturb."""
    text = """
import threading, numpy as np, arael
Line = arael.load("line.arael")
found = []
def work(slope):
    x = np.linspace(-1, 1, 5000)
    for _ in range(10):
        model = Line()
        model.data.extend(x=x, y=slope * x + 1)
        model.solve(num_threads=2)
        found.append(abs(model.a.value - slope) < 1e-4)
threads = [threading.Thread(target=work, args=(k,)) for k in range(6)]
for t in threads: t.start()
for t in threads: t.join()
print(len(found), all(found))
"""
    warm.script(text).require(0, "60 True")


def test_loaded_by_threads_at_once(place: Place) -> None:
    text = """
import threading, arael
found = []
def work():
    model = arael.load("line.arael")()
    model.read("line.json")
    found.append(model.solve().status)
threads = [threading.Thread(target=work) for _ in range(6)]
for t in threads: t.start()
for t in threads: t.join()
print(len(found), set(found))
"""
    place.script(text, timeout=300).require(0, "6 {'converged'}")
    assert place.half_built() == []
