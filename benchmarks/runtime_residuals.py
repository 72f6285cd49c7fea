"""How long many small residuals given as text take: to derive, to solve first, to solve again."""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

import arael

MODEL = """
struct Point {
    param pos: vec2
    constraint keep { (pos - pos.value) * 1e-3 }
}

root Chain {
    points: list of Point
}
"""
COUNT = 100
LOOP = ("linearise", "factor", "first_factor", "solve", "cost")


def main() -> None:
    """Print medians in milliseconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "chain.arael"
        path.write_text(MODEL, encoding="utf-8")
        chain = arael.load(path)()
    rng = np.random.default_rng(0)
    x = np.arange(COUNT + 1)
    chain.points.extend(pos=np.stack([x, rng.normal(size=COUNT + 1)], axis=1))
    chain.residuals.add("points[0].pos", label="anchor")
    adding = []
    for k in range(COUNT):
        a, b = f"points[{k}].pos", f"points[{k + 1}].pos"
        text = f"hypot({b}.x - {a}.x, {b}.y - {a}.y) - w * {1 + k % 3}"
        began = time.perf_counter()
        chain.residuals.add(text, label=f"d{k}", data={"w": 1.0})
        adding.append(time.perf_counter() - began)
    began = time.perf_counter()
    chain.solve()
    first = time.perf_counter() - began
    again, inner = [], []
    for k in range(20):
        chain.residuals["d3"].set_data(w=1.0 + 0.5 * (k % 2))
        began = time.perf_counter()
        timing = chain.solve().timing
        again.append(time.perf_counter() - began)
        inner.append(
            sum(
                timing.get(k, 0.0) for k in ("linearise", "factor", "first_factor", "solve", "cost")
            )
        )
    exchanged, solved = [], []
    for k in range(20):
        text = f"norm(points[{k}].pos - points[{k + 2}].pos) - 1.7 * {1 + k % 3}"
        began = time.perf_counter()
        chain.residuals.add(text, label="extra")
        exchanged.append(time.perf_counter() - began)
        began = time.perf_counter()
        chain.solve()
        solved.append(time.perf_counter() - began)
        chain.residuals.remove("extra")
    print(f"parse and differentiate, each   {1e3 * statistics.median(adding):8.2f} ms")
    print(f"first solve                     {1e3 * first:8.2f} ms")
    print(f"solve after a change            {1e3 * statistics.median(again):8.2f} ms")
    print(f"  of which in the loop          {1e3 * statistics.median(inner):8.2f} ms")
    print(f"add one to a hundred            {1e3 * statistics.median(exchanged):8.2f} ms")
    print(f"solve after it                  {1e3 * statistics.median(solved):8.2f} ms")


if __name__ == "__main__":
    main()
