"""arael's linear solvers and precisions among themselves, on problems of the suites."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

from arael.scenes import PlaneConfig, benchmark_config, make_plane_scene, make_scene
from benchmarks import problems
from benchmarks.cases import DATA, Case
from benchmarks.measure import table
from benchmarks.systems import Outcome, Plan, run_system


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure all pairs; return the report's lines."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = [
            "## backends",
            "",
            "Milliseconds per iteration at one thread, each run in a process of its own. The cost "
            "is that of the answer by the f64 reference.",
        ]
        sizes = (30, 60) if plan.quick else (60, 200, 500)
        sweep = [_scene(folder, "localization", poses) for poses in sizes]
        lines += ["", *_pair(plan, folder, sweep, {"band": "band"}, {"dense": "dense"})]
        sizes = (15, 30) if plan.quick else (60, 100, 200)
        sweep = [_scene(folder, "slam", poses) for poses in sizes]
        lines += ["", *_pair(plan, folder, sweep, {"sparse": "sparse"}, {"dense": "dense"})]
        every = list(_every(folder, plan.quick))
        lines += ["", *_pair(plan, folder, every, {"sparse": "sparse"}, {"cholmod": "cholmod"})]
        poses = 60 if plan.quick else 300
        scenes = [_scene(folder, suite, poses) for suite in ("slam", "localization")]
        lines += ["", *_pair(plan, folder, scenes, {"f32": "auto"}, {"f64": "auto"})]
    return lines


def _pair(
    plan: Plan, folder: Path, found: list[Case], one: dict[str, str], other: dict[str, str]
) -> list[str]:
    """Lines of a table of two variants: name and solver each; a name may be a precision."""
    (a, first), (b, second) = [*one.items(), *other.items()]
    rows = []
    for case in found:
        reference = problems.Reference(case.suite, str(case.path))
        outcomes: list[Outcome] = []
        for name, solver in ((a, first), (b, second)):
            env = {"ARAEL_BENCH_SOLVER": solver}
            if name in ("f32", "f64"):
                env["ARAEL_BENCH_PRECISION"] = name
            outcomes.append(run_system("arael", case, reference, plan, 1, folder, **env))
        x, y = outcomes
        costs = [_text(o, f"{o.cost:.7g}") for o in outcomes]
        times = [_text(o, f"{1e3 * o.median:.2f}") for o in outcomes]
        ratio = y.median / x.median if x.median else math.nan
        shown = f"{ratio:.2f}" if math.isfinite(ratio) else "-"
        rows.append((f"{case.suite}: {case.name}", *times, shown, *costs))
    heads = ("problem", f"{a} [ms]", f"{b} [ms]", f"{b} / {a}", f"cost, {a}", f"cost, {b}")
    return table(heads, rows)


def _text(outcome: Outcome, shown: str) -> str:
    return shown if outcome.slopes else outcome.reason


def _scene(folder: Path, suite: str, poses: int) -> Case:
    path = folder / f"scene-{poses}.npz"
    if not path.exists():
        problems.write_scene(make_scene(benchmark_config(poses)), path)
    return Case(suite, f"{poses} poses", path, 1, 4, limit=40)


def _every(folder: Path, quick: bool) -> Iterator[Case]:
    """A problem of every suite."""
    poses = 60 if quick else 300
    yield _scene(folder, "slam", poses)
    yield _scene(folder, "localization", poses)
    graphs = ("2d/intel",) if quick else ("2d/M3500", "3d/sphere2500", "3d/parking-garage")
    for name in graphs:
        path = DATA / f"pose_graph_{name}.g2o"
        if path.exists():
            yield Case("pose_graph", path.stem, path, 1, 4)
    path = DATA / "bundle_adjustment" / "problem-49-7776-pre.txt"
    if path.exists() and not quick:
        yield Case("bundle", path.stem, path, 1, 4, limit=20)
    path = folder / f"plane-{poses}.npz"
    problems.write_planes(make_plane_scene(PlaneConfig(poses)), path)
    yield Case("plane", f"{poses} poses", path, 1, 4, limit=40)
