"""What a solve of few unknowns takes beside its iterations, and a solve after a small edit.

Run by itself with ``measure``, it measures the tree of arael that ``PYTHONPATH`` names.
"""

from __future__ import annotations

import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

CURVE = """
struct Sample {
    x: real
    y: real
    constraint fit { y - root.a * exp(-root.b * x) }
}
root Curve {
    param a: real = 1
    param b: real = 1
    samples: list of Sample
}
"""
CHAIN = """
struct Point {
    param pos: vec2
    constraint keep { (pos - pos.value) * 1e-3 }
}
struct Link {
    a: ref Point in root.points
    b: ref Point in root.points
    d: vec2
    constraint tie { b.pos - a.pos - d }
}
root Chain {
    points: list of Point
    links: arena of Link
}
"""
Times = dict[str, list[float]]


def run(plan: Any, picture: Path | None = None) -> list[str]:
    """Measure in a process of its own; return the report's lines."""
    from benchmarks.measure import child, table

    found = child("small", "measure", *(["quick"] if plan.quick else []))
    return [
        "## small",
        "",
        "Medians in milliseconds: of the whole call of `solve`, and of preparation and analysis in "
        "it. First solves are of a new model each, after one that does not count unless the row "
        "says so. Edits are of a chain with as many links as the row says.",
        "",
        *table(
            ("what", "solve", "preparation and analysis"),
            [(what, f"{whole:.3f}", f"{before:.3f}") for what, (whole, before) in found.items()],
        ),
    ]


def measure(quick: bool) -> dict[str, tuple[float, float]]:
    """Milliseconds of `solve`, and of preparation and analysis in it, by what is done."""
    import arael

    runs = 5 if quick else 60
    found: dict[str, tuple[float, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {"curve": CURVE, "chain": CHAIN}.items():
            (Path(folder) / f"{name}.arael").write_text(text, encoding="utf-8")
        curve = arael.load(Path(folder) / "curve.arael")
        chain = arael.load(Path(folder) / "chain.arael")
        slow = arael.load(Path(folder) / "chain.arael", interpret=True)
    found["first solve of the process, 2 unknowns"] = _median([_solve(_curve(curve, 20))])
    found["first solve, 2 unknowns, 20 residuals"] = _first(lambda: _curve(curve, 20), runs)
    for points in (5, 25):
        for name, kind in {"kernels": chain, "expression machine": slow}.items():
            what = f"first solve, {2 * points} unknowns, {name}"
            found[what] = _first(lambda k=kind, n=points: _chain(k, n), runs)
    found |= _again(_curve(curve, 100), 10 * runs)
    for links in (50, 1000) if quick else (50, 1000, 10_000):
        found |= _edits(_chain(chain, links), links, runs if links < 10_000 else runs // 3)
    return found


def _curve(kind: Any, count: int) -> Any:
    model = kind()
    x = np.linspace(0, 2, count)
    model.samples.extend(x=x, y=2 * np.exp(-0.7 * x) + 0.01 * np.sin(40 * x))
    return model


def _chain(kind: Any, count: int) -> Any:
    model = kind()
    model.points.extend(pos=np.stack([np.arange(count), np.zeros(count)], axis=1) * 1.0)
    d = np.full((count - 1, 2), [1.1, 0.1])
    model.links.extend(a=np.arange(count - 1), b=np.arange(1, count), d=d)
    return model


def _solve(model: Any) -> tuple[float, float]:
    """Seconds of a solve by the clock, and of its preparation and analysis."""
    began = time.perf_counter()
    timing = model.solve().timing
    whole = time.perf_counter() - began
    return whole, timing["prepare"] + timing["analyse"]


def _median(times: list[tuple[float, float]]) -> tuple[float, float]:
    whole, before = (1e3 * statistics.median(column) for column in zip(*times, strict=True))
    return whole, before


def _first(make: Callable[[], Any], runs: int) -> tuple[float, float]:
    _solve(make())
    return _median([_solve(make()) for _ in range(runs)])


def _again(model: Any, runs: int) -> dict[str, tuple[float, float]]:
    _solve(model)
    times = []
    for k in range(runs):
        model.samples.y[k % 100] *= 1.001
        times.append(_solve(model))
    return {"solve again, data of 100 residuals changed": _median(times)}


def _edits(model: Any, links: int, runs: int) -> dict[str, tuple[float, float]]:
    for _ in range(3):
        _solve(model)
    added: list[Any] = []
    times: dict[str, list[tuple[float, float]]] = {}

    def row(k: int) -> None:
        at = k % (links - 2)
        link = {"a": model.points[at], "b": model.points[at + 1], "d": [1.1, 0.1]}
        added.append(model.links.append(**link))

    edits: dict[str, Callable[[int], None]] = {
        "nothing": lambda k: None,
        "one row appended": row,
        "one row removed": lambda k: model.links.remove(added.pop()),
        "a parameter fixed": lambda k: setattr(model.points[7].pos, "fixed", True),
        "a parameter freed": lambda k: setattr(model.points[7].pos, "fixed", False),
    }
    for k in range(runs):
        for what, edit in edits.items():
            edit(k)
            times.setdefault(what, []).append(_solve(model))
    for k in range(runs // 4 + 1):
        at = (7 * k) % (links - 6)
        model.links.append(a=model.points[at], b=model.points[at + 5], d=[5.5, 0.5])
        times.setdefault("one coupling added", []).append(_solve(model))
    return {f"{links} links, {what}": _median(one) for what, one in times.items()}


if __name__ == "__main__":
    if sys.argv[1:2] == ["measure"]:
        print(json.dumps(measure("quick" in sys.argv)))
    else:
        from benchmarks.systems import Plan

        print("\n".join(run(Plan())))
