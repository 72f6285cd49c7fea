"""One problem in parts on a local cluster, beside one process: ``python -m benchmarks parts``.

A loop, a grid and a bundle with 2, 4 and 8 processes of a part each: time of an iteration, bytes
moved, boundary, memory of the largest process. Then what the cost model of
`docs/internals/scale_out.md` gives for the same runs, from constants that are measured apart, and
for 100 and 1,000 workers.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import arael
from benchmarks.measure import child, table
from benchmarks.systems import Plan

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


def loop(folder: Path, n: int = 40_000) -> tuple[Any, Path]:
    """Planar poses on a loop with chords: ten times the memory of parameters in edges."""
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


def grid(folder: Path, n: int = 150) -> tuple[Any, Path]:
    """Nodes of three scalars, n by n."""
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


def bundle(folder: Path, cameras: int = 300, points: int = 30_000) -> tuple[Any, Path]:
    """Cameras along a road, and points, each seen by the cameras near it."""
    rng = np.random.default_rng(3)
    scene: Any = arael.loads(BUNDLE, name="bundle.arael")()
    at = np.stack((np.linspace(0, 2.0 * cameras, cameras), np.zeros(cameras), np.zeros(cameras)), 1)
    q = np.tile([1.0, 0, 0, 0], (cameras, 1))
    where = np.stack(
        (
            rng.uniform(0, 2.0 * cameras, points),
            rng.uniform(-5, 5, points),
            rng.uniform(8, 20, points),
        ),
        1,
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


CASES: dict[str, Callable[..., tuple[Any, Path]]] = {"loop": loop, "grid": grid, "bundle": bundle}
SMALL: dict[str, dict[str, int]] = {
    "loop": {"n": 2_000},
    "grid": {"n": 30},
    "bundle": {"cameras": 30, "points": 1_000},
}
PARTS = (2, 4, 8)
SOLVES = 2
"""Solves of each cell: iterations of all count."""
ATTEMPTS = 6
OBSERVATIONS = 1e8
WORKERS = (100, 1_000)


# --- one process -------------------------------------------------------------------------------


def _kind(name: str) -> Any:
    texts = {"grid": GRID, "bundle": BUNDLE}
    return (
        arael.loads(texts[name], name=f"{name}.arael")
        if name in texts
        else arael.load("pose_graph_2d")
    )


class Stamps:
    """An observer that notes the time of attempts.

    Attributes
    ----------
    gaps : seconds from one accepted attempt to the next one of the same solve
    spent : processor seconds of the processes from the first accepted attempts to the ends
    """

    def __init__(self, clocks: Callable[[], list[float]]) -> None:
        self.gaps: list[float] = []
        self.spent: Any = 0.0
        self._clocks = clocks
        self._began: list[float] = []
        self._last: float | None = None

    def begin(self) -> None:
        """Begin another solve; its first iteration analyses patterns and does not count."""
        self._last = None

    def end(self) -> None:
        """Note the processor time at the end of a solve."""
        self.spent = self.spent + np.array(self._clocks()) - self._began

    def __call__(self, record: Any) -> None:
        if not record["accepted"]:
            return
        if self._last is not None:
            self.gaps.append(time.perf_counter() - self._last)
        else:
            self._began = self._clocks()
        self._last = time.perf_counter()

    @property
    def median(self) -> float:
        """The middle gap."""
        return statistics.median(self.gaps) if self.gaps else float("nan")

    @property
    def processor(self) -> float:
        """Processor seconds of an iteration: of the caller and of the busiest worker."""
        caller, *workers = self.spent / max(len(self.gaps), 1)
        return float(caller + max(workers, default=0.0))


def _own_clock() -> list[float]:
    return [time.process_time()]


def alone(name: str, path: str) -> dict[str, Any]:
    """Seconds of an iteration in this process, its memory, and its work in parts.

    The work is measured twice: of this process alone, and of as many at once as there are cores,
    which share caches, memory and often the units of a core.
    """
    kind = _kind(name)
    before, memory = _memory(), 0.0
    stamps = Stamps(_own_clock)
    for _ in range(SOLVES):
        model: Any = kind()
        model.read(path)
        stamps.begin()
        result = model.solve(solver="sparse", passes=[], max_iters=ATTEMPTS, observer=stamps)
        stamps.end()
        memory = memory or _memory() - before
    cores = os.cpu_count() or 1
    with ProcessPoolExecutor(
        cores, mp_context=get_context("spawn"), initializer=_on_all_cores
    ) as pool:
        at_once = list(pool.map(work_in_parts, [name] * cores, [path] * cores))
    return {
        "seconds": stamps.median,
        "processor": stamps.processor,
        "iterations": result.iterations,
        "cost": result.cost,
        "memory": memory,
        "work": work_in_parts(name, path),
        "work_at_once": {
            parts: [max(found) for found in zip(*(one[parts] for one in at_once), strict=True)]
            for parts in PARTS
        },
    }


def _on_all_cores() -> None:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, range(os.cpu_count() or 1))


def work_in_parts(name: str, path: str) -> dict[int, tuple[float, float]]:
    """Processor seconds of an iteration in parts, all in this process.

    Returns, by the number of parts, those of the parts, which can be shared out, and those of the
    caller and of the boundary, which cannot.
    """
    from arael.distributed.parts.executors import Call, InProcess
    from arael.distributed.parts.requests import solve_boundary
    from arael.distributed.parts.solve import prepare
    from arael.distributed.parts.solve import run as run_in_parts

    class Clocked(InProcess):
        seconds = 0.0

        def ask(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
            began = time.process_time()
            found = super().ask(function, calls)
            # A worker that solves the boundary does so while the others wait.
            if function is not solve_boundary:
                self.seconds += time.process_time() - began
            return found

    found = {}
    for parts in PARTS:
        executor = Clocked()
        clocks: list[tuple[float, float]] = []

        def note(record: Any, executor: Any = executor, clocks: Any = clocks) -> None:
            if record["accepted"]:
                clocks.append((time.process_time(), executor.seconds))

        prepared = prepare(_kind(name)()._compiled, path, parts, None)
        run_in_parts(prepared, executor, passes=[], max_iters=ATTEMPTS, observer=note)
        whole, divided = np.diff(np.array(clocks), axis=0).T
        found[parts] = float(np.median(divided)), float(np.median(whole - divided))
    return found


def _memory() -> float:
    """Largest memory of this process so far, in MB."""
    text = Path("/proc/self/status").read_text(encoding="ascii")
    return int(text.partition("VmHWM:")[2].split()[0]) / 1024


# --- a cluster ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cell:
    """A problem in so many parts, with a process each.

    Attributes
    ----------
    between, largest : scalars of the whole boundary, and of the part with most
    seconds : of an iteration
    processor : processor seconds of an iteration, of the caller and of the busiest worker
    caller, reduced : bytes of an iteration, to and from the caller, and of S
    rounds : of an iteration
    memory : growth of the largest worker, MB
    off : difference of the cost to that of one process, relative
    """

    parts: int
    size: int
    instances: int
    between: int
    largest: int
    seconds: float
    processor: float
    caller: float
    reduced: float
    rounds: float
    memory: float
    off: float


def in_parts(kind: Any, path: Path, parts: int, cost: float) -> Cell:
    """Solve on a cluster of so many processes."""
    from arael.distributed import solve

    with _cluster(parts) as client:
        stamps = Stamps(lambda: [time.process_time(), *client.run(time.process_time).values()])
        client.run(_ready)
        before = client.run(_memory)
        after: dict[str, float] = {}
        for _ in range(SOLVES):
            stamps.begin()
            found = solve(
                kind,
                path,
                partition=parts,
                client=client,
                passes=[],
                max_iters=ATTEMPTS,
                observer=stamps,
            )
            stamps.end()
            # Of the first solve: workers keep the parts of two.
            after = after or client.run(_memory)
    iterations, traffic, split = found.result.iterations, found.traffic, found.split
    return Cell(
        split.parts,
        split.size,
        int(split.instances.sum()),
        split.between,
        int(split.boundary.max()),
        stamps.median,
        stamps.processor,
        (traffic.out + traffic.back) / iterations,
        traffic.reduced / iterations,
        traffic.rounds / iterations,
        max(after[w] - before[w] for w in after),
        abs(found.result.cost / cost - 1),
    )


def _cluster(processes: int) -> Any:
    # imported here: an optional part
    import distributed

    stack = ExitStack()
    cluster = stack.enter_context(
        distributed.LocalCluster(
            n_workers=processes,
            threads_per_worker=1,
            dashboard_address=":0",
            silence_logs=50,
            memory_limit=0,
        )
    )
    client = stack.enter_context(
        distributed.Client(cluster, set_as_default=False, direct_to_workers=True)
    )
    return _Open(stack, client)


class _Open:
    def __init__(self, stack: Any, client: Any) -> None:
        self._stack, self._client = stack, client

    def __enter__(self) -> Any:
        return self._client

    def __exit__(self, *error: object) -> None:
        self._stack.close()


def _ready() -> None:
    import arael.distributed.parts.requests  # noqa: F401


def echo(values: Any) -> Any:
    """A request that does nothing."""
    return values


def messages() -> tuple[float, float]:
    """Seconds of a request to one of two workers, and bytes a second of arrays there and back."""
    from arael.distributed.parts.executors import Call, OnDask

    size = 125_000
    with _cluster(2) as client:
        executor = OnDask(client)
        found = {}
        for n in (1, size):
            args = (np.zeros(n),)
            calls = [Call(part, args, partial(tuple, args)) for part in (0, 1)]
            runs = []
            for _ in range(60):
                began = time.perf_counter()
                executor.ask(echo, calls)
                runs.append(time.perf_counter() - began)
            found[n] = statistics.median(runs[10:])
    return found[1] / 2, 4 * 8 * size / (found[size] - found[1])


# --- the model ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    """The cost model: T = D_p / min(p, cores) + C_p + R p t + bytes / v.

    Attributes
    ----------
    message : t, seconds of a request
    rate : v, bytes a second
    cores : that compute at a time
    """

    message: float
    rate: float
    cores: int

    def parts_of(
        self, cell: Cell, divided: float, caller: float
    ) -> tuple[float, float, float, float]:
        """Seconds of the parts, of the caller and the boundary, of messages and of bytes."""
        moved = cell.caller + cell.reduced
        return (
            divided / min(cell.parts, self.cores),
            caller,
            cell.rounds * cell.parts * self.message,
            moved / self.rate,
        )


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure and return the report's lines."""
    load = [os.getloadavg()[0]]
    one: dict[str, Any] = {}
    cells: dict[str, list[Cell]] = {}
    with tempfile.TemporaryDirectory() as place:
        for name, make in CASES.items():
            kind, path = make(Path(place), **SMALL[name] if plan.quick else {})
            one[name] = child("parts", "--alone", name, path)
            cells[name] = [in_parts(kind, path, p, one[name]["cost"]) for p in PARTS]
    model = Model(*messages(), os.cpu_count() or 1)
    load.append(os.getloadavg()[0])
    return [
        "## parts",
        "",
        "One problem on a local cluster with as many processes as parts, and in one process "
        '(`solver="sparse"`, one thread). An iteration is the median time between accepted '
        f"attempts of {SOLVES} solves without the first, which analyses patterns. Bytes are those "
        "of arrays in an iteration. Processor seconds are those of the caller and of the busiest "
        "worker: about what an iteration would take if every process had a core. Memory is the "
        "growth of the largest process. The boundary is "
        "solved by the caller as long as all S take 4 MB or less. Load average before and after, "
        f"on {model.cores} cores, with that of this run: {load[0]:.1f}, {load[1]:.1f}.",
        "",
        *_measured(one, cells),
        "",
        "### Cost model",
        "",
        "    T = D_p / min(p, cores) + C_p + R p t + bytes / v",
        "",
        f"with R rounds, t = {1e3 * model.message:.2f} ms a request and v = "
        f"{model.rate / 1e6:.0f} MB/s, measured apart with requests that do nothing, of 8 bytes "
        "and of 1 MB, to two workers. Processor time of an iteration in p parts that are all in "
        "one process, measured apart too: D_p is that of the parts, C_p that of the caller and of "
        f"the boundary. The model takes D_p where {model.cores} such processes run at once, one a "
        "core, as the workers do; beside it is what it is alone. Nothing is fitted, and every row "
        "is a check.",
        "",
        *_checked(one, cells, model),
        "",
        "### 100 and 1,000 workers",
        "",
        "Extrapolated, not measured. Assumed: t and v as above, one core per worker, D_8 alone, "
        "growing with the observations and dividing evenly; C_8 growing with the scalars; 40 bytes "
        "a scalar to and from the caller; a boundary that grows with the number of parts (loop, "
        f"bundle), or as 2 (sqrt(p) - 1) sides (grid). {OBSERVATIONS:.0e} observations:",
        "",
        *_extrapolated(one, cells, model),
    ]


def _measured(one: dict[str, Any], cells: dict[str, list[Cell]]) -> list[str]:
    rows: list[list[object]] = []
    for name, found in cells.items():
        first = found[0]
        what = f"{name}, {first.size:,} scalars, {first.instances:,} observations"
        alone_ = one[name]
        rows.append(
            [
                what,
                "1 process",
                *("", "", f"{alone_['seconds']:.3f}", "1"),
                *(f"{alone_['processor']:.3f}", "1", "", "", ""),
                *(f"{alone_['memory']:.0f}", ""),
            ]
        )
        for cell in found:
            rows.append(
                [
                    "",
                    cell.parts,
                    f"{cell.between} ({100 * cell.between / cell.size:.2g} %)",
                    cell.largest,
                    f"{cell.seconds:.3f}",
                    f"{cell.seconds / alone_['seconds']:.2f}",
                    f"{cell.processor:.3f}",
                    f"{cell.processor / alone_['processor']:.2f}",
                    f"{cell.rounds:.1f}",
                    f"{cell.caller / 1e6:.1f}",
                    f"{cell.reduced / 1e6:.2f}",
                    f"{cell.memory:.0f}",
                    f"{cell.off:.0e}",
                ]
            )
    head = [
        "problem",
        "parts",
        "boundary",
        "largest b_p",
        "iteration, s",
        "ratio",
        "processor, s",
        "ratio",
    ]
    head += ["rounds", "caller, MB", "S, MB", "memory, MB", "cost differs by"]
    return table(head, rows)


def _checked(one: dict[str, Any], cells: dict[str, list[Cell]], model: Model) -> list[str]:
    rows = []
    for name, found in cells.items():
        for cell in found:
            divided, caller = one[name]["work_at_once"][str(cell.parts)]
            shares = model.parts_of(cell, divided, caller)
            rows.append(
                [
                    name,
                    cell.parts,
                    f"{one[name]['processor']:.3f}",
                    f"{one[name]['work'][str(cell.parts)][0]:.3f}",
                    f"{divided:.3f}",
                    *(f"{share:.3f}" for share in shares),
                    f"{sum(shares):.3f}",
                    f"{cell.seconds:.3f}",
                    f"{cell.seconds / sum(shares):.2f}",
                ]
            )
    head = [
        "problem",
        "parts",
        "one process, s",
        "D_p alone, s",
        "D_p, s",
        "work",
        "C_p",
        "messages",
    ]
    head += ["bytes", "model, s"]
    return table([*head, "measured, s", "ratio"], rows)


def boundary_of(name: str, cells: list[Cell], size: float, parts: int) -> tuple[float, float]:
    """Scalars of the boundary of a larger problem in more parts, and of a part's boundary."""
    last = cells[-1]
    if name != "grid":
        return parts * last.between / last.parts, last.largest
    side = float(np.sqrt(size / 3)) * 3
    return 2 * (float(np.sqrt(parts)) - 1) * side, 4 * side / float(np.sqrt(parts))


def _extrapolated(one: dict[str, Any], cells: dict[str, list[Cell]], model: Model) -> list[str]:
    rows: list[list[object]] = []
    for name, found in cells.items():
        last = found[-1]
        times = OBSERVATIONS / last.instances
        size = last.size * times
        divided, caller = (times * part for part in one[name]["work"][str(last.parts)])
        for parts in WORKERS:
            between, largest = boundary_of(name, found, size, parts)
            reduced = 8.0 * parts * largest**2
            rows.append(
                [
                    name,
                    parts,
                    f"{size:.1e}",
                    f"{between:.1e}",
                    f"{largest:.0f}",
                    f"{reduced / 1e9:.2g}",
                    f"{divided / parts:.2g}",
                    f"{caller:.2g}",
                    f"{last.rounds * parts * model.message:.2g}",
                    f"{40 * size / model.rate:.2g}",
                    f"{reduced / model.rate:.2g}",
                ]
            )
    head = ["problem", "workers", "scalars", "boundary", "b_p", "S, GB", "work, s", "caller, s"]
    return table([*head, "messages, s", "bytes of the caller, s", "bytes of S, s"], rows)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--alone"]:
        print(json.dumps(alone(sys.argv[2], sys.argv[3])))
    else:
        print("\n".join(run(Plan((), sys.executable, (1,), "--quick" in sys.argv), None)))
