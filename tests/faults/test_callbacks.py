"""Exceptions in observers, drivers of lambda, traces and bound functions reach the caller."""
# ruff: noqa: E501 - scripts

from __future__ import annotations

import pytest

from tests.faults.processes import Place

pytestmark = pytest.mark.slow

EXCEPTIONS = ["ValueError('mine')", "KeyboardInterrupt('mine')", "SystemExit(7)", "MemoryError('mine')",
              "RecursionError('mine')", "Mine('mine')", "StopIteration('mine')", "GeneratorExit('mine')"]  # fmt: skip

HEAD = """
import sys, threading, warnings
warnings.simplefilter("ignore")
import numpy as np
import arael
class Mine(BaseException): pass
def make(path="line.arael", **more):
    model = arael.load(path, interpret=True, **more)()
    if path == "line.arael":
        x = np.linspace(-1, 1, 40)
        model.data.extend(x=x, y=np.exp(x))
    return model
def expect(call, kind):
    try:
        found = call()
    except BaseException as error:
        cause = error
        while cause is not None and type(cause) is not kind:
            cause = cause.__cause__ or cause.__context__
        assert type(cause) is kind, repr(error)
        return error
    raise AssertionError(f"nothing was raised: {found}")
"""

PLACES = {
    "observer": "model.solve(observer=raising)",
    "driver": "model.solve(damping=raising)",
    "trace": "model.solve(trace=raising)",
}


@pytest.mark.parametrize("where", PLACES)
def test_in_callbacks(warm: Place, where: str) -> None:
    """The model stays usable, with finite values, and the next solve ends as if nothing had been."""
    text = (
        HEAD
        + f"""
model = make()
for text in {EXCEPTIONS!r}:
    error = eval(text)
    def raising(*args):
        raise error
    if isinstance(error, KeyboardInterrupt):  # taken for Ctrl-C, which ends a solve early
        assert {PLACES[where]}.status == "aborted"
    else:
        expect(lambda: {PLACES[where]}, type(error))
    assert np.isfinite(model.cost())
    model.a.value = model.b.value = 0
    assert model.solve().status == "converged", text
print("as before")
"""
    )
    warm.script(text).require(0, "as before")


def test_observers_that_change_the_model(warm: Place) -> None:
    """Refused by name, or without effect on the solve under way; never a crash."""
    text = (
        HEAD
        + """
def add(record): model.data.append(x=1.0, y=2.0)
def clear(record): model.data.clear()
def move(record): model.a.value = 7.0
def again(record): model.solve()
def read(record): model.read("line.json")
def residual(record): model.residuals.add(arael.runtime_residual("a - 1"))
def forget(record): model.session.release()
def answer(record): return "odd"
def mutate(record):
    for name in dir(record):
        if not name.startswith("_"):
            try: setattr(record, name, None)
            except (AttributeError, TypeError): pass
for observer in (add, clear, move, again, read, residual, forget, answer, mutate):
    model = make()
    try:
        print(observer.__name__, model.solve(observer=observer).status)
    except arael.AraelError as error:
        print(observer.__name__, error.diagnostics[0].code)
    assert np.isfinite(model.a.value)
    fresh = make()
    assert fresh.solve().status == "converged"
print("all done")
"""
    )
    warm.script(text, timeout=60).require(0, "all done")


NATIVE = """\
extern fn f(x)
    derivs [2 * x]
struct Point { x: real; y: real }
root Native {
    param a: real = 1
    data: list of Point
    fit data as e { f(a) * e.x - e.y }
}
"""


@pytest.mark.parametrize("interpret", [True, False])
def test_in_bound_functions(place: Place, interpret: bool) -> None:
    """What a bound function raises is what the solve raises; the parameters are finite after it."""
    (place.folder / "native.arael").write_text(NATIVE)
    text = (
        HEAD
        + f"""
calls = 0
error = None
def f(x):
    global calls
    calls += 1
    if error is not None and calls > 30:  # in the second evaluation
        raise error
    return x * x
model = arael.load("native.arael", interpret={interpret}, functions={{"f": f}})()
model.data.extend(x=np.linspace(1, 2, 20), y=np.linspace(4, 8, 20))
assert model.solve().status == "converged"
for text in {EXCEPTIONS[:6]!r}:
    model.a.value = 1
    error, calls = eval(text), 0
    if isinstance(error, KeyboardInterrupt):  # raised, or the end of the solve as by Ctrl-C
        try:
            assert model.solve().status == "aborted"
        except BaseException as found:
            assert "mine" in f"{{found!r}} {{found.__cause__!r}}"
    else:
        expect(lambda: model.solve(), type(error))
    assert np.isfinite(model.a.value)
    calls = 60
    expect(lambda: model.cost(), type(error))
    calls = 60
    expect(lambda: model.jacobian(), type(error))
    error = None
    model.a.value = 1
    assert model.solve().status == "converged", text
print("as before")
"""
    )
    place.script(text, timeout=120).require(0, "as before")


def test_bound_functions_that_return_nonsense(place: Place) -> None:
    (place.folder / "native.arael").write_text(NATIVE)
    text = (
        HEAD
        + """
for value in (None, "1", [1, 2], np.zeros(3), 1j, float("nan"), float("inf"), 10**400, object()):
    model = arael.load("native.arael", interpret=True, functions={"f": lambda x: value})()
    model.data.extend(x=[1.0, 2.0], y=[4.0, 8.0])
    try:
        result = model.solve()
    except (arael.AraelError, TypeError, ValueError, OverflowError) as error:
        assert str(error)
        continue
    raise AssertionError(f"{value!r}: {result}")
print("all refused")
"""
    )
    place.script(text).require(0, "all refused")


def test_keyboard_interrupt_in_a_thread_pool(warm: Place) -> None:
    """Ctrl-C in a solve on several threads ends it with the best state, and threads still work."""
    text = (
        HEAD
        + """
import os, signal
model = arael.load("slow.arael", interpret=True)()
seen = []
def observer(record):
    seen.append(record)
    if len(seen) == 5:
        os.kill(os.getpid(), signal.SIGINT)
try:
    print(model.solve(observer=observer, num_threads=4).status)
except KeyboardInterrupt:
    print("interrupted")
assert len(seen) < 30 and model.a.value < 1000
print(model.solve(num_threads=4).status)
"""
    )
    done = warm.script(text).require(0, "aborted", "interrupted")
    assert "converged" in done.out or "max_iterations" in done.out
