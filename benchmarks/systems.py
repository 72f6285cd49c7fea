"""arael beside its peers: one problem, one start, one cost by which every answer is scored."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arael.scenes import benchmark_config, make_scene
from benchmarks import problems
from benchmarks.measure import environment, table

PEERS = ("arael", "gtsam", "ceres", "g2o", "rust")
DATA = Path(os.environ.get("ARAEL_DATA", Path(__file__).parents[2] / "shared" / "data"))
TIMEOUT = 900
CLOSE = 1e-3
"""Answers whose cost is more than this above the best, relatively, are marked."""


@dataclass(frozen=True)
class Case:
    """A problem of a suite, and between which numbers of iterations the slope is taken."""

    suite: str
    name: str
    path: Path
    short: int
    long: int


@dataclass(frozen=True)
class Outcome:
    """What one system made of one problem; no slopes where it has no such problem."""

    slopes: tuple[float, ...] = ()
    memory: float = 0.0
    cost: float = float("nan")
    iterations: int = 0
    version: str = ""
    settings: str = ""

    @property
    def median(self) -> float:
        """Seconds per iteration."""
        return statistics.median(self.slopes)


def run(suite: str, peers: tuple[str, ...], python: str, threads: int = 1) -> list[str]:
    """Measure a suite; return the report's lines.

    Parameters
    ----------
    peers : which of `PEERS`
    python : the interpreter that has the peers' packages
    """
    rows, systems = [], {}
    with tempfile.TemporaryDirectory() as folder:
        cases = list(_cases(suite, Path(folder)))
        for case in cases:
            sys.stderr.write(f"  {case.name} ...\n")
            found = {p: _measure(p, case, python, Path(folder), threads) for p in peers}
            rows.append((case, found))
            systems |= {o.version: o.settings for o in found.values() if o.slopes}
    return _report(suite, rows, systems, threads)


def _cases(suite: str, folder: Path) -> list[Case]:
    if suite == "pose_graph":
        names = ("2d/M3500", "2d/intel", "3d/sphere2500", "3d/parking-garage")
        paths = [DATA / f"pose_graph_{n}.g2o" for n in names]
        return [Case(suite, p.stem, p, 1, 5) for p in paths if p.exists()]
    if suite == "bundle":
        names = ("problem-49-7776-pre", "synth-16-22106")
        paths = [DATA / "bundle_adjustment" / f"{n}.txt" for n in names]
        return [Case(suite, p.stem, p, 2, 6) for p in paths if p.exists()]
    sizes = (60, 300, 900) if suite == "slam" else (60, 300, 500)
    found = []
    for poses in sizes:
        path = folder / f"{suite}-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses)), path)
        found.append(Case(suite, f"{poses} poses", path, 2, 8))
    return found


def _measure(peer: str, case: Case, python: str, folder: Path, threads: int) -> Outcome:
    out = folder / "answer.npz"
    runner = sys.executable if peer in ("arael", "rust") else python
    command = [runner, "-m", f"benchmarks.peers.{peer}_peer", case.suite, str(case.path)]
    command += [str(case.short), str(case.long), "7", str(out)]
    env = environment(ARAEL_BENCH_THREADS=str(threads), PYTHONPATH=str(Path(__file__).parents[1]))
    try:
        done = subprocess.run(
            command, env=env, capture_output=True, text=True, timeout=TIMEOUT, check=True
        )
        said = json.loads(done.stdout.strip().splitlines()[-1])
    except (subprocess.SubprocessError, ValueError, IndexError) as error:
        tail = (getattr(error, "stderr", None) or str(error)).strip().splitlines()[-1:]
        sys.stderr.write(f"    {peer}: {' '.join(tail)}\n")
        return Outcome()
    if "absent" in said:
        return Outcome()
    with np.load(out) as answer:
        cost = problems.cost(case.suite, str(case.path), dict(answer))
    return Outcome(
        tuple(said["slopes"]),
        said["memory"],
        cost,
        said["iterations"],
        said["version"],
        said["settings"],
    )


def _report(
    suite: str,
    rows: list[tuple[Case, dict[str, Outcome]]],
    systems: dict[str, str],
    threads: int,
) -> list[str]:
    peers = list(rows[0][1]) if rows else []
    times, ratios, costs, memory = [], [], [], []
    for case, found in rows:
        best = min((o.cost for o in found.values() if o.slopes), default=float("nan"))
        times.append([case.name, *(_time(o) for o in found.values())])
        ours = found.get("arael", Outcome())
        others = [o for p, o in found.items() if p != "arael"]
        ratios.append(
            [case.name]
            + [f"{o.median / ours.median:.1f}" if o.slopes and ours.slopes else "-" for o in others]
        )
        costs.append([case.name, *(_cost(o, best) for o in found.values())])
        memory.append(
            [case.name, *(f"{o.memory:.0f}" if o.slopes else "-" for o in found.values())]
        )
    heads = [suite, *peers]
    return [
        f"## {suite}, {threads} thread{'s' if threads > 1 else ''}",
        "",
        *(f"- {version}: {settings}" for version, settings in systems.items()),
        "",
        "Milliseconds per iteration, median (min-max) of 7 slopes:",
        "",
        *table(heads, times),
        "",
        "Time per iteration relative to arael's:",
        "",
        *table([suite, *peers[1:]], ratios),
        "",
        "Cost of the answer by the reference, and iterations to it; `!` more than 0.1 % above the "
        "best:",
        "",
        *table(heads, costs),
        "",
        "Peak resident memory of the process, MB:",
        "",
        *table(heads, memory),
    ]


def _time(outcome: Outcome) -> str:
    if not outcome.slopes:
        return "-"
    low, high = 1e3 * min(outcome.slopes), 1e3 * max(outcome.slopes)
    return f"{1e3 * outcome.median:.2f} ({low:.2f}-{high:.2f})"


def _cost(outcome: Outcome, best: float) -> str:
    if not outcome.slopes:
        return "-"
    mark = " !" if outcome.cost > best * (1 + CLOSE) else ""
    return f"{outcome.cost:.4f}{mark} ({outcome.iterations})"
