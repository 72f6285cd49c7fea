"""The problems of every suite in which arael stands beside its peers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from arael.scenes import PlaneConfig, benchmark_config, make_plane_scene, make_scene
from benchmarks import problems
from benchmarks.bundles import write_bundle

DATA = Path(os.environ.get("ARAEL_DATA", Path(__file__).parents[2] / "shared" / "data"))


@dataclass(frozen=True)
class Case:
    """A problem of a suite.

    Attributes
    ----------
    short, long : the slope of time is taken between runs of these numbers of iterations
    limit : iterations of the run whose answer is compared
    large : measured again with more threads
    """

    suite: str
    name: str
    path: Path
    short: int = 2
    long: int = 8
    limit: int = 100
    large: bool = False


def cases(suite: str, folder: Path, quick: bool) -> Iterator[Case]:
    """Make the cases of a suite one by one, generated ones in `folder`.

    Those of public data may have a path where there is no file.
    """
    yield from SUITES[suite](folder, quick)


def _slam(folder: Path, quick: bool) -> Iterator[Case]:
    sizes = (("s-curve", 60),) if quick else (("s-curve", 60), ("s-curve", 300), ("s-curve", 900))
    closed = (("loop", 60),) if quick else (("loop", 300), ("eight", 300))
    for path, poses in (*sizes, *closed):
        name = f"{poses} poses" if path == "s-curve" else f"{poses} poses, {path}"
        file = folder / f"slam-{path}-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses, trajectory=path)), file)  # type: ignore[arg-type]
        yield Case("slam", name, file, limit=60, large=quick or poses == 900)


def _localization(folder: Path, quick: bool) -> Iterator[Case]:
    for poses in (60,) if quick else (60, 300, 500):
        file = folder / f"localization-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses)), file)
        yield Case("localization", f"{poses} poses", file, limit=60, large=quick or poses == 500)


def _pose_graph(folder: Path, quick: bool) -> Iterator[Case]:
    names = ["2d/intel", "3d/smallGrid3D"]
    if not quick:
        names = ["2d/M3500", "2d/intel", "3d/sphere2500", "3d/parking-garage", "3d/sphere_slambook"]
    for name in names:
        file = DATA / f"pose_graph_{name}.g2o"
        large = name in ("3d/sphere2500", "3d/smallGrid3D")
        yield Case("pose_graph", file.stem, file, 1, 5, limit=60, large=large)


def _bundle(folder: Path, quick: bool) -> Iterator[Case]:
    names = ["problem-49-7776-pre"] if quick else ["problem-49-7776-pre", "synth-16-22106"]
    for name in names:
        file = DATA / "bundle_adjustment" / f"{name}.txt"
        yield Case("bundle", name, file, 2, 6, limit=200)
    for cameras in (20,) if quick else (100, 300):
        points = 2000 if quick else 50_000
        file = folder / f"bundle-{cameras}.txt"
        seen = write_bundle(file, cameras, points)
        name = f"{cameras} cameras, {points} points, {seen} observations"
        yield Case("bundle", name, file, 1, 4, limit=20, large=cameras != 100)


def _plane(folder: Path, quick: bool) -> Iterator[Case]:
    for poses in (60,) if quick else (60, 300, 900):
        file = folder / f"plane-{poses}.npz"
        problems.write_planes(make_plane_scene(PlaneConfig(poses)), file)
        yield Case("plane", f"{poses} poses", file, limit=60, large=quick or poses == 900)


SUITES = {
    "slam": _slam,
    "localization": _localization,
    "pose_graph": _pose_graph,
    "bundle": _bundle,
    "plane": _plane,
}
