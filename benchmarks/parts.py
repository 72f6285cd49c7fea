"""One problem in parts on a local cluster: ``python -m benchmarks.parts [loop grid bundle]``.

For 2, 4 and 8 processes with a part each: boundary, time of an iteration, bytes of an iteration,
largest memory of a worker beside that of a solve in one process. Then the constants of the cost
model of `docs/internals/scale_out.md`, and what the model says of the same runs.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import THREADS

for variable in THREADS:
    os.environ.setdefault(variable, "1")

import arael  # noqa: E402

GRID = """
struct Node { param h: real; param s: vec2 }
struct Link {
    a: ref Node in root.nodes; b: ref Node in root.nodes; d: real
    constraint apart { 10 * (b.h * (1 + 0.1 * b.s.x) - a.h * (1 + 0.1 * a.s.y) - d) }
    constraint smooth { 3 * (a.s - b.s) }
}
struct Pin { node: ref Node in root.nodes; h: real
    constraint at { [node.h - h, node.s - [1, 1]] } }
root Field { nodes: list of Node; links: list of Link; pins: list of Pin }
"""

BUNDLE = """
struct Camera { param c: vec3; param q: quaternion }
struct Seen {
    camera: ref Camera in root.cameras; u: vec2
    constraint projected {
        let d = camera.q.rotation_matrix()' * (parent.x - camera.c)
        ([d.x / d.z, d.y / d.z] - u) / 0.002
    }
}
struct Point { param x: vec3; seen: list of Seen }
root Bundle { cameras: list of Camera; points: list of Point }
"""


def loop(folder: Path) -> tuple[Any, Path]:
    """40,000 planar poses on a loop, with chords, 10 times the memory of parameters in edges."""
    n = 40_000
    rng = np.random.default_rng(1)
    kind = arael.load("pose_graph_2d")
    graph: Any = kind()
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    at = 2000 * np.stack((np.cos(turn), np.sin(turn)), 1)
    heading = (turn + 3 * np.pi / 2) % (2 * np.pi) - np.pi
    a = np.concatenate([np.arange(n)] + [np.arange(0, n - 40, 2)] * 8)
    step = np.concatenate(
        [np.ones(n)] + [np.full(len(range(0, n - 40, 2)), 3 + 4 * k) for k in range(8)]
    )
    b = (a + step.astype(int)) % n
    c, s = np.cos(heading[a]), np.sin(heading[a])
    d = at[b] - at[a]
    t = np.stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]), 1)
    turned = (heading[b] - heading[a] + np.pi) % (2 * np.pi) - np.pi
    graph.poses.extend(t=at + rng.normal(0, 0.05, at.shape), th=heading + rng.normal(0, 0.01, n))
    graph.edges.extend(
        a=a,
        b=b,
        t=t + rng.normal(0, 0.01, t.shape),
        th=turned + rng.normal(0, 0.005, len(a)),
        u=np.tile(np.diag([100.0, 100, 200]), (len(a), 1, 1)),
    )
    graph.anchors.extend(pose=[0], t=at[:1], th=heading[:1])
    return _written(graph, folder / "loop.npz"), folder / "loop.npz"


def grid(folder: Path) -> tuple[Any, Path]:
    """150 by 150 nodes of three scalars."""
    n = 150
    rng = np.random.default_rng(2)
    field: Any = arael.loads(GRID, name="grid.arael")()
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    h = (np.sin(x / 5) + 0.03 * y + 1).ravel()
    number = np.arange(n * n).reshape(n, n)
    a = np.concatenate((number[:, :-1].ravel(), number[:-1].ravel()))
    b = np.concatenate((number[:, 1:].ravel(), number[1:].ravel()))
    a, b = np.tile(a, 5), np.tile(b, 5)
    field.nodes.extend(h=h + rng.normal(0, 0.3, n * n), s=np.ones((n * n, 2)))
    field.links.extend(a=a, b=b, d=1.1 * (h[b] - h[a]) + rng.normal(0, 0.05, len(a)))
    field.pins.extend(node=number[::50, ::50].ravel(), h=h[number[::50, ::50].ravel()])
    return _written(field, folder / "grid.npz"), folder / "grid.npz"


def bundle(folder: Path) -> tuple[Any, Path]:
    """300 cameras along a road, 30,000 points, each seen by the cameras near it."""
    cameras, points = 300, 30_000
    rng = np.random.default_rng(3)
    scene: Any = arael.loads(BUNDLE, name="bundle.arael")()
    at = np.stack((np.linspace(0, 600, cameras), np.zeros(cameras), np.zeros(cameras)), 1)
    q = np.tile([1.0, 0, 0, 0], (cameras, 1))
    where = np.stack(
        (rng.uniform(0, 600, points), rng.uniform(-5, 5, points), rng.uniform(8, 20, points)), 1
    )
    moved = at + rng.normal(0, 0.05, at.shape)
    moved[[0, 1]] = at[[0, 1]]
    scene.cameras.extend(c=moved, q=q)
    for k in (0, 1):
        scene.cameras[k].c.fixed = scene.cameras[k].q.fixed = True
    near = np.abs(where[:, None, 0] - at[None, :, 0]) < 10
    owner, camera = np.nonzero(near)
    d = where[owner] - at[camera]
    scene.points.extend(x=where + rng.normal(0, 0.1, where.shape))
    scene._store.tables["points.seen"].extend(
        len(owner),
        owner,
        camera=camera,
        u=d[:, :2] / d[:, 2:] + rng.normal(0, 0.002, (len(owner), 2)),
    )
    return _written(scene, folder / "bundle.npz"), folder / "bundle.npz"


def _written(model: Any, path: Path) -> Any:
    model.write(path)
    return type(model)


CASES = {"loop": loop, "grid": grid, "bundle": bundle}


def alone(name: str, path: str) -> None:
    """Solve in this process and print seconds of an iteration, attempts, cost and memory."""
    kind = {
        "loop": lambda: arael.load("pose_graph_2d"),
        "grid": lambda: arael.loads(GRID, name="grid.arael"),
        "bundle": lambda: arael.loads(BUNDLE, name="bundle.arael"),
    }[name]()
    before = _memory()
    model: Any = kind()
    model.read(path)
    result = model.solve(solver="sparse", passes=[], max_iters=6)
    inside = sum(v for k, v in result.timing.items() if k not in ("prepare", "analyse", "total"))
    print(
        json.dumps(
            {
                "seconds": inside / result.iterations,
                "iterations": result.iterations,
                "cost": result.cost,
                "memory": _memory() - before,
                "phases": result.timing,
            }
        )
    )


def _memory() -> float:
    """Largest memory of this process so far, in MB."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.partition("VmHWM:")[2].split()[0]) / 1024


def in_parts(name: str, kind: Any, path: Path, parts: int) -> dict[str, Any]:
    """Solve on a cluster of so many processes."""
    import distributed

    from arael.distributed import solve

    stamps: list[float] = []
    with (
        distributed.LocalCluster(
            n_workers=parts,
            threads_per_worker=1,
            dashboard_address=":0",
            silence_logs=50,
            memory_limit=0,
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        client.run(_ready)
        before = client.run(_memory)
        found = solve(
            kind,
            path,
            partition=parts,
            client=client,
            passes=[],
            max_iters=6,
            observer=lambda record: stamps.append(time.perf_counter()),
        )
        after = client.run(_memory)
    iterations = found.result.iterations
    traffic = found.traffic
    gaps = np.diff(stamps)
    return {
        "parts": found.split.parts,
        "share": found.split.share,
        "between": found.split.between,
        "size": found.split.size,
        "largest_boundary": int(found.split.boundary.max()),
        "split_seconds": found.seconds,
        "seconds": statistics.median(gaps) if len(gaps) else float("nan"),
        "iterations": iterations,
        "cost": found.result.cost,
        "out": traffic.out / iterations,
        "back": traffic.back / iterations,
        "reduced": traffic.reduced / iterations,
        "rounds": traffic.rounds / iterations,
        "memory": max(after[w] - before[w] for w in after),
        "phases": found.result.timing,
    }


def _ready() -> None:
    import arael.distributed.parts.requests  # noqa: F401


def main(names: list[str]) -> None:
    """Run the cases named, or all."""
    with tempfile.TemporaryDirectory() as place:
        for name in names or list(CASES):
            kind, path = CASES[name](Path(place))
            one = subprocess.run(
                [sys.executable, "-m", "benchmarks.parts", "--alone", name, str(path)],
                check=True,
                capture_output=True,
                text=True,
            )
            print(name, "alone", one.stdout.strip(), flush=True)
            for parts in (2, 4, 8):
                print(name, json.dumps(in_parts(name, kind, path, parts)), flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--alone"]:
        alone(sys.argv[2], sys.argv[3])
    else:
        main(sys.argv[1:])
