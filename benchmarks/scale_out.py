"""Many problems on worker processes: rate beside one process, overhead of a problem, constants.

Each run is a process of its own. One process solves the problems one after another, by the function
that workers call; a cluster of one or two workers gets the same files. Two single processes at once
show what the machine gives without a cluster.
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

from benchmarks.measure import THREADS, environment, table
from benchmarks.systems import Plan

for variable in THREADS:
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

import arael  # noqa: E402
from benchmarks import components  # noqa: E402

POSES = 2500
LARGE, SMALL = 60, 1000
GROUPS = (1, 10, 100)
RUNS = 3


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure and return the report's lines."""
    large, small, runs = (12, 100, 1) if plan.quick else (LARGE, SMALL, RUNS)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        _write("large", folder / "large", large)
        _write("small", folder / "small", small)
        found: dict[str, list[Any]] = {}
        for _ in range(runs):  # by turns: a slow minute is one of each
            for name, words in _plans(folder):
                found.setdefault(name, []).append(_measured(words))
    return [*_rates(found, large), "", *_overheads(found, small)]


def _plans(folder: Path) -> list[tuple[str, list[list[str]]]]:
    large, small = str(folder / "large"), str(folder / "small")
    out = str(folder / "out")
    plans = [
        ("one process", [["alone", "large", large]]),
        ("two processes, no cluster", [["alone", "large", large]] * 2),
        ("1 worker", [["cluster", "large", large, "1", "1", ""]]),
        ("2 workers", [["cluster", "large", large, "2", "1", ""]]),
    ]
    for group in GROUPS:
        words = ["cluster", "small", small, "1", str(group)]
        plans.append((f"group {group}", [[*words, ""]]))
        plans.append((f"group {group}, files", [[*words, out]]))
    return plans


def _measured(words: list[list[str]]) -> Any:
    """Results of processes that run at once: those of the slowest."""
    going = [
        subprocess.Popen(
            [sys.executable, "-m", "benchmarks.scale_out", *some],
            env=environment(),
            stdout=subprocess.PIPE,
            text=True,
            cwd=Path(__file__).parents[1],
        )
        for some in words
    ]
    found = [json.loads(one.communicate()[0].strip().splitlines()[-1]) for one in going]
    return max(found, key=lambda one: one["seconds"])


def _rates(found: dict[str, list[Any]], count: int) -> list[str]:
    def each(name: str) -> list[float]:
        return [one["seconds"] / count * 1e3 for one in found[name]]

    def middle(what: str, runs: list[Any]) -> float:
        return statistics.median(run[what] / count * 1e3 for run in runs)

    one = each("one process")
    rows = []
    for name, processes in (
        ("one process", 1),
        ("two processes, no cluster", 1),
        ("1 worker", 1),
        ("2 workers", 2),
    ):
        # Of the same round: load that changes in between counts for both.
        shares = [a / b / processes for a, b in zip(one, each(name), strict=True)]
        share = statistics.median(shares)
        of = f"{share:.2f} ({min(shares):.2f}-{max(shares):.2f})"
        start = statistics.median(run.get("start", 0.0) for run in found[name])
        ship = statistics.median(run.get("ship", 0.0) for run in found[name])
        rows.append(
            (
                name,
                f"{statistics.median(each(name)):.1f}",
                of,
                f"{middle('worker_cpu', found[name]):.1f}",
                f"{middle('client_cpu', found[name]):.1f}",
                f"{start:.1f}" if start else "",
                f"{ship:.2f}" if ship else "",
            )
        )
    return [
        "## scale-out",
        "",
        f"{count} pose graphs of {POSES} poses, without result files. "
        f"Milliseconds a problem by the wall clock, medians of {len(one)} rounds. Share: of the "
        f"rate of one process, by the number of workers (smallest and largest of the rounds); two "
        f"processes without a cluster solve all problems each. Processor time of all workers, and "
        f"of the client with the scheduler, is that of a problem. Start of the cluster and first "
        f"problem, which loads the model, are apart.",
        "",
        *table(
            (
                "",
                "ms a problem",
                "share",
                "workers, CPU ms",
                "client, CPU ms",
                "start, s",
                "first problem, s",
            ),
            rows,
        ),
    ]


def _overheads(found: dict[str, list[Any]], count: int) -> list[str]:
    rows = []
    for group in GROUPS:
        for files in ("", ", files"):
            runs = found[f"group {group}{files}"]

            def middle(name: str, runs: list[Any] = runs) -> float:
                return statistics.median(one[name] / count * 1e3 for one in runs)

            rows.append(
                (
                    f"{group}{files}",
                    runs[0]["together"],
                    f"{middle('seconds'):.2f}",
                    f"{middle('solve'):.3f}",
                    f"{middle('overhead'):.2f}",
                    f"{middle('read'):.2f}",
                    f"{middle('covariance'):.2f}",
                    f"{middle('write'):.2f}",
                    f"{middle('worker_cpu'):.2f}",
                    f"{middle('client_cpu'):.2f}",
                )
            )
    return [
        f"{count} epochs of a GNSS receiver, four unknowns each, on one worker: milliseconds a "
        f"problem. Overhead: all but the solve. Processor time of the worker, and of the client "
        f"with the scheduler, which are one process here.",
        "",
        *table(
            (
                "group",
                "together",
                "all",
                "solve",
                "overhead",
                "read",
                "sigmas",
                "write",
                "worker, CPU",
                "client, CPU",
            ),
            rows,
        ),
    ]


def kind_of(name: str) -> Any:
    """The model of a set of problems."""
    if name == "large":
        return arael.load("pose_graph_2d", precision="f64")
    return arael.loads(components.MODEL, name="track.arael", precision="f64")


def _write(name: str, folder: Path, count: int) -> None:
    folder.mkdir()
    kind = kind_of(name)
    if name == "small":
        for number, epoch in enumerate(components.scene(count)):
            components.filled(kind, [epoch]).write(folder / f"{number}.npz")
        return
    for number in range(count):
        graph(kind, number).write(folder / f"{number}.npz")


def graph(kind: Any, seed: int) -> Any:
    """Poses on a circle with chords to poses near them."""
    rng = np.random.default_rng(seed)
    n = POSES
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    at = n / 6 * np.stack((np.cos(turn), np.sin(turn)), 1)
    heading = (turn + 3 * np.pi / 2) % (2 * np.pi) - np.pi
    a = np.tile(np.arange(n), 5)
    b = (a + np.repeat([1, 3, 7, 12, 20], n)) % n
    c, s = np.cos(heading[a]), np.sin(heading[a])
    d = at[b] - at[a]
    t = np.stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]), 1)
    turned = (heading[b] - heading[a] + np.pi) % (2 * np.pi) - np.pi
    model = kind()
    model.poses.extend(t=at + rng.normal(0, 0.3, at.shape), th=heading + rng.normal(0, 0.1, n))
    model.edges.extend(
        a=a,
        b=b,
        t=t + rng.normal(0, 0.05, t.shape),
        th=turned + rng.normal(0, 0.02, len(a)),
        u=np.tile(np.diag([20.0, 20, 50]), (len(a), 1, 1)),
    )
    model.anchors.extend(pose=[0], t=at[:1], th=heading[:1])
    return model


def alone(name: str, folder: Path) -> dict[str, float]:
    """Solve all problems one after another in this process."""
    import msgspec

    from arael.compiler.cache import digest
    from arael.distributed import compiled, contents
    from arael.distributed.groups import solve_group
    from arael.distributed.work import Settings, Task

    data = msgspec.msgpack.encode(compiled.content_of(kind_of(name).compiled))
    vouched = digest(data)
    contents.arrive(vouched, data)
    tasks = [Task(path.name, str(path), "") for path in sorted(folder.glob("*.npz"))]
    solve_group(vouched, tasks[:1], Settings(), 1)
    began, used = time.perf_counter(), time.process_time()
    rows = [solve_group(vouched, [task], Settings(), 1)[0] for task in tasks]
    seconds = time.perf_counter() - began
    assert all(row.converged for row in rows)
    return {"seconds": seconds, "worker_cpu": time.process_time() - used, "client_cpu": 0.0}


def cluster(name: str, folder: Path, workers: int, group: int, output: str) -> dict[str, float]:
    """Solve all problems on a local cluster."""
    from arael.distributed import connect
    from arael.distributed import map as solve_all

    kind = kind_of(name)
    paths = sorted(folder.glob("*.npz"))
    out = tempfile.mkdtemp(dir=folder.parent) if output else None
    began = time.perf_counter()
    with connect(workers=workers) as client:
        started = time.perf_counter()
        # Every worker has loaded the model when the clock starts.
        first = list(solve_all(kind, paths[: 4 * workers], client))
        loaded = time.perf_counter()
        assert len({future.result().worker for future in first}) == workers
        before = client.run(time.process_time)
        mine = time.process_time()
        ready = time.perf_counter()
        rows = [
            future.result() for future in solve_all(kind, paths, client, output=out, group=group)
        ]
        seconds = time.perf_counter() - ready
        mine = time.process_time() - mine
        after = client.run(time.process_time)
    assert all(row.converged for row in rows), [row.message for row in rows if not row.converged]
    phases = {
        phase: sum(row.seconds.get(phase, 0.0) for row in rows)
        for phase in ("read", "solve", "covariance", "write")
    }
    return {
        "seconds": seconds,
        "start": started - began,
        "ship": loaded - started,
        "overhead": seconds - phases["solve"],
        "worker_cpu": sum(after[w] - before[w] for w in after),
        "client_cpu": mine,
        "together": max(row.together for row in rows),
        **phases,
    }


if __name__ == "__main__":
    what, name, place, *rest = sys.argv[1:]
    if what == "alone":
        print(json.dumps(alone(name, Path(place))))
    else:
        workers, group, output = rest
        print(json.dumps(cluster(name, Path(place), int(workers), int(group), output)))
