"""Problems of the suite: every public file and the generated scenes, each from its own start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import arael
from arael.scenes import PlaneConfig, benchmark_config, make_plane_scene, make_scene
from benchmarks import cases as suites
from benchmarks import problems
from benchmarks.bundles import write_bal, write_bundle
from benchmarks.optimum import graphs

GRAPHS = (
    *("2d/M3500", "2d/M3500a", "2d/intel", "2d/kitti_00", "2d/ringCity"),
    *("3d/tinyGrid3D", "3d/smallGrid3D", "3d/parking-garage", "3d/sphere2500"),
    "3d/sphere_slambook",
)
BUNDLES = ("dubrovnik-3-7-pre", "problem-49-7776-pre", "synth-16-22106")


@dataclass(frozen=True)
class Problem:
    """A file, and the suite that says what it holds."""

    suite: str
    name: str
    path: Path


def all_problems(folder: Path, quick: bool) -> Iterator[Problem]:
    """Make the problems one by one, generated ones in `folder`; public ones may not be there."""
    yield from _public_graphs(folder, quick)
    yield from _bundles(folder, quick)
    yield from _generated_graphs(folder, quick)
    yield from _scenes(folder, quick)


def write_solved(problem: Problem, state: problems.State, folder: Path) -> Path | None:
    """The problem with another start as a file, where the cost does not depend on the start."""
    if problem.suite not in ("pose_graph", "bundle"):
        return None
    instance = problems.KINDS[problem.suite].load(str(problem.path))
    problems.KINDS[problem.suite].put(instance, state)
    if problem.suite == "pose_graph":
        path = folder / f"{problem.path.stem}-solved.g2o"
        arael.write(instance, path)
        return path
    path = folder / f"{problem.path.stem}-solved.txt"
    write_bal(path, instance)
    return path


def _public_graphs(folder: Path, quick: bool) -> Iterator[Problem]:
    for name in ("2d/intel", "3d/tinyGrid3D") if quick else GRAPHS:
        path = suites.DATA / f"pose_graph_{name}.g2o"
        if path.exists() and not graphs.has_vertices(path):
            path = graphs.with_odometry(path, folder)
        yield Problem("pose_graph", path.stem, path)


def _generated_graphs(folder: Path, quick: bool) -> Iterator[Problem]:
    for name, make in graphs.GRAPHS.items():
        if quick and name != "ring":
            continue
        path = folder / f"{name}.g2o"
        count = make(path)
        yield Problem("pose_graph", f"{name}, {count} poses", path)


def _bundles(folder: Path, quick: bool) -> Iterator[Problem]:
    for name in BUNDLES[:1] if quick else BUNDLES:
        path = suites.DATA / "bundle_adjustment" / f"{name}.txt"
        yield Problem("bundle", name.removesuffix("-pre"), path)
    for cameras, points in ((12, 300),) if quick else ((100, 10_000),):
        path = folder / f"bundle-{cameras}-{points}.txt"
        write_bundle(path, cameras, points)
        yield Problem("bundle", f"bundle, {cameras} cameras, {points} points", path)


def _scenes(folder: Path, quick: bool) -> Iterator[Problem]:
    for poses in (60,) if quick else (60, 300, 500):
        path = folder / f"localization-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses)), path)
        yield Problem("localization", f"localization, {poses} poses", path)
    for poses in (60,) if quick else (60, 300, 900):
        path = folder / f"plane-{poses}.npz"
        problems.write_planes(make_plane_scene(PlaneConfig(poses)), path)
        yield Problem("plane", f"plane, {poses} poses", path)
    for shape, poses in (("s-curve", 60),) if quick else _SCENES:
        path = folder / f"slam-{shape}-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses, trajectory=shape)), path)  # type: ignore[arg-type]
        yield Problem("slam", f"slam, {shape}, {poses} poses", path)


_SCENES = (("s-curve", 60), ("s-curve", 300), ("loop", 300), ("eight", 300), ("s-curve", 900))
