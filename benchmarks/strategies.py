"""Attempts that each strategy takes on each problem: ``python -m benchmarks strategies``.

Sets of NIST's collection from both starts, public pose graphs from the start of the file with false
loop closures behind a loss and without, bundles, and generated problems. A number is marked where
the solve did not end as converged at the least cost that a strategy found.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import arael
from benchmarks import nist
from benchmarks.cases import DATA
from benchmarks.measure import table
from benchmarks.problems import pose_graph_model
from benchmarks.systems import Plan

STRATEGIES: dict[str, dict[str, Any]] = {
    "auto": {},
    "dogleg": {"strategy": "dogleg"},
    "damped, gain": {"strategy": "damped"},
    "damped, nielsen": {"strategy": "damped", "damping": "nielsen"},
    "damped, ladder": {"strategy": "damped", "damping": "ladder"},
}
MODELS = Path(__file__).parents[1] / "models"
LIMIT = 500
ROSENBROCK = """
root A {
    param x: real
    param y: real
    constraint c { [10*(y - x*x), 1 - x] }
}
"""
LINE = """
struct Point { x: real
    y: real
    constraint fit loss LOSS { (root.a * x + root.b - y) / 0.1 }
}
root A { param a: real = 1.5
    param b: real = 2
    points: list of Point }
"""
LOSSES = ("huber", "cauchy", "geman_mcclure", "tukey")

Make = Callable[[], Any]


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Return the report's lines."""
    rows = []
    totals = {name: [0, 0] for name in STRATEGIES}
    with tempfile.TemporaryDirectory() as folder:
        for name, make in problems(Path(folder), plan.quick):
            found = {key: make().solve(**s, max_iters=LIMIT) for key, s in STRATEGIES.items()}
            least = min(result.end_cost for result in found.values())
            cells = []
            for key, result in found.items():
                bad = not result.converged or result.end_cost > least * (1 + 1e-5) + 1e-20
                cells.append(f"{result.iterations}{' !' if bad else ''}")
                totals[key][0] += result.iterations
                totals[key][1] += bad
            rows.append([name, *cells])
    rows.append(["all", *(f"{attempts}, {bad} !" for attempts, bad in totals.values())])
    return [
        "## strategies",
        "",
        f"Attempts, at most {LIMIT}; marked where the solve did not converge to the least cost.",
        "",
        *table(["problem", *STRATEGIES], rows),
    ]


def problems(folder: Path, quick: bool) -> Iterator[tuple[str, Make]]:
    """Names of the problems, and what makes one at its start."""
    yield from _generated(folder, 1 if quick else 5)
    if quick:
        return
    yield from _regressions(folder)
    yield from _graphs(folder)
    for file in sorted(DATA.glob("bundle_adjustment/*-pre.txt")):
        yield file.stem, lambda file=file: _read("bundle_adjustment", file)


def _generated(folder: Path, draws: int) -> Iterator[tuple[str, Make]]:
    kind = _load(folder, "rosenbrock", ROSENBROCK)
    for draw in range(draws):
        x, y = np.random.default_rng(draw).uniform(-3, 3, 2)
        yield f"Rosenbrock {draw}", lambda kind=kind, x=x, y=y: kind(x=x, y=y)
    for loss in LOSSES:
        kind = _load(folder, loss, LINE.replace("LOSS", f"{loss}(3)"))
        for draw in range(draws):
            rng = np.random.default_rng(draw)
            x = np.linspace(0, 5, 40)
            y = 2 * x + 1 + 0.1 * rng.normal(size=40)
            y[:: 3 + draw] += 5 * rng.normal(size=len(y[:: 3 + draw]))

            def line(kind: Any = kind, x: Any = x, y: Any = y) -> Any:
                model = kind()
                model.points.extend(x=x, y=y)
                return model

            yield f"line, {loss} {draw}", line


def _regressions(folder: Path) -> Iterator[tuple[str, Make]]:
    for name in nist.FORMULAS:
        file = DATA / "nist" / f"{name}.dat"
        if not file.exists():
            continue
        values, _, data = nist.parsed(file.read_text())
        kind = _load(folder, name, nist.model_text(name, len(values)))
        for start in (0, 1):
            at = values[:, start]
            yield (
                f"{name} {start + 1}",
                lambda kind=kind, at=at, data=data: nist.filled(kind, at, data),
            )


def _graphs(folder: Path) -> Iterator[tuple[str, Make]]:
    for file in sorted(DATA.glob("pose_graph_?d/*.g2o")):
        name = pose_graph_model(file)
        yield file.stem, lambda name=name, file=file: _read(name, file)
    for stem, name in (("intel", "pose_graph_2d"), ("tinyGrid3D", "pose_graph_3d")):
        file = DATA / name / f"{stem}.g2o"
        if not file.exists():
            continue
        text = (MODELS / f"{name}.arael").read_text()
        for loss in LOSSES:
            clause = f"constraint between loss {loss}(3) {{"
            kind = _load(folder, f"{name}_{loss}", text.replace("constraint between {", clause))
            yield f"{stem}, {loss}", lambda kind=kind, file=file: _with_false_closures(kind, file)


def _with_false_closures(kind: Any, file: Path) -> Any:
    """A pose graph of which one measurement in a hundred, and at least two, are wrong."""
    graph = _filled(kind, file)
    rng = np.random.default_rng(0)
    count, poses = max(2, len(graph.edges) // 100), len(graph.poses)
    a = rng.integers(0, poses, count)
    b = (a + rng.integers(2, poses - 2, count)) % poses
    u = np.median(np.asarray(graph.edges.u), axis=0)
    columns: dict[str, Any] = {"u": np.repeat(u[None], count, axis=0)}
    if u.shape[0] == 3:
        columns |= {"t": rng.normal(size=(count, 2)), "th": rng.uniform(-3, 3, count)}
    else:
        q = rng.normal(size=(count, 4))
        columns |= {
            "t": rng.normal(size=(count, 3)),
            "q": q / np.linalg.norm(q, axis=1, keepdims=True),
        }
    graph.edges.extend(
        a=[graph.poses[int(k)] for k in a], b=[graph.poses[int(k)] for k in b], **columns
    )
    return graph


def _read(model: str, file: Path) -> Any:
    return _filled(arael.load(model), file)


def _filled(kind: Any, file: Path) -> Any:
    model = kind()
    model.read(file)
    return model


def _load(folder: Path, name: str, text: str) -> Any:
    path = folder / f"{name}.arael"
    path.write_text(text)
    return arael.load(path)
