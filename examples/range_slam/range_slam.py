"""SLAM from distances: path, beacons and scale of the ranges, from odometry and ranges alone.

    python range_slam.py [--seed 42]                                    a generated field
    python range_slam.py --plaza FOLDER                                 the public set Plaza1
                         [--save problem.npz] [--plot range_slam.png]

The model is `range_slam.arael` in this folder. The beacons' starts are found by multilateration
over the path of the odometry.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("range_slam.arael")

Array = NDArray[np.float64]

SCALE = 1.04
"""Scale of the ranges of the generated field."""


@dataclass(frozen=True)
class Field:
    """Odometry and ranges, with the truth.

    Attributes
    ----------
    moved, turned : steps (n - 1, 2) [m] in the frame of the earlier pose, and turns (n - 1,) [rad]
    sigma : standard deviations (n - 1, 3) of forward, sideways [m] and turn [rad]
    start : x [m], y [m], heading [rad] of the first pose, which are known
    pose, beacon, range : of the ranges (m,): rows of poses and of beacons, distances [m]
    true_path, true_beacons : positions (n, 2) and (k, 2) [m]
    ids : names (k,) of the beacons
    range_sigma : standard deviation of good ranges [m]
    """

    moved: Array
    turned: Array
    sigma: Array
    start: Array
    pose: NDArray[np.int64]
    beacon: NDArray[np.int64]
    range: Array
    true_path: Array
    true_beacons: Array
    ids: NDArray[np.int64]
    range_sigma: float


def dead_reckoning(field: Field) -> tuple[Array, Array]:
    """Positions (n, 2) [m] and headings (n,) [rad] of the odometry alone."""
    th = field.start[2] + np.concatenate([[0.0], np.cumsum(field.turned)])
    c, s = np.cos(th[:-1]), np.sin(th[:-1])
    x, y = field.moved.T
    steps = np.column_stack([c * x - s * y, s * x + c * y])
    return np.vstack([field.start[:2], field.start[:2] + np.cumsum(steps, axis=0)]), th


def make_field(poses: int = 240, seed: int = 42) -> Field:
    """Generate a robot that mows a field among four beacons; 10 of 100 ranges are too long."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, poses)
    # Lanes that are driven to and fro, as a mower does, closer than the beacons are apart.
    path = np.column_stack([25 * np.sin(2 * np.pi * 5 * t), 40 * t - 20 + 3 * np.cos(9 * t)])
    beacons = np.array([[-32.0, -14], [30, -22], [-22, 27], [34, 16]])
    d = np.gradient(path, axis=0)
    th = np.unwrap(np.arctan2(d[:, 1], d[:, 0]))
    steps, c, s = np.diff(path, axis=0), np.cos(th[:-1]), np.sin(th[:-1])
    moved = np.column_stack([c * steps[:, 0] + s * steps[:, 1], c * steps[:, 1] - s * steps[:, 0]])
    sigma = np.tile([0.05, 0.02, 0.01], (poses - 1, 1))
    moved += rng.normal(size=moved.shape) * sigma[:, :2]
    turned = np.diff(th) + rng.normal(size=poses - 1) * sigma[:, 2]
    pose = np.repeat(np.arange(poses), 2)
    beacon = rng.integers(0, 4, 2 * poses)
    seen = SCALE * np.linalg.norm(path[pose] - beacons[beacon], axis=1)
    seen += rng.normal(0, 0.3, len(seen)) + (rng.random(len(seen)) < 0.1) * rng.uniform(
        3, 20, len(seen)
    )
    start = np.array([*path[0], th[0]])
    return Field(
        moved, turned, sigma, start, pose, beacon, seen, path, beacons, np.arange(4), 0.3
    )  # fmt: skip


def read_plaza(folder: Path) -> Field:
    """Read Plaza1 (Djugash et al. 2009): odometry at 5 Hz, ranges to four beacons, RTK truth.

    A pose is made at the time of each range; the odometry between two ranges is summed, with the
    motion at constant speed between samples.
    """
    from scipy.io import loadmat

    data = loadmat(folder / "Plaza1_.mat")
    odometry, ranges, truth, places = (data[name] for name in ("DR", "TD", "GT", "TL"))
    ranges = ranges[np.argsort(ranges[:, 0], kind="stable")]
    times = np.concatenate([truth[:1, 0], odometry[:, 0]])
    way = np.concatenate([[0.0], np.cumsum(odometry[:, 1])])
    heading = truth[0, 3] + np.concatenate([[0.0], np.cumsum(odometry[:, 2])])
    # Positions at the samples, each step along the mean heading, then at the times of the ranges.
    middle = (heading[1:] + heading[:-1]) / 2
    steps = odometry[:, 1:2] * np.column_stack([np.cos(middle), np.sin(middle)])
    at = np.vstack([[0, 0], np.cumsum(steps, axis=0)])
    when = ranges[:, 0]
    pos = np.column_stack([np.interp(when, times, at[:, k]) for k in (0, 1)])
    th = np.interp(when, times, heading)
    length = np.abs(np.diff(np.interp(when, times, way)))
    dt = np.diff(when)
    c, s, d = np.cos(th[:-1]), np.sin(th[:-1]), np.diff(pos, axis=0)
    moved = np.column_stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]])
    # Random walks: of the distance with the way, of the heading with the time.
    sigma = np.column_stack([
        0.005 + 0.03 * np.sqrt(length), 0.005 + 0.03 * np.sqrt(length), 1e-4 + 0.003 * np.sqrt(dt)
    ])  # fmt: skip
    true = np.column_stack([np.interp(when, truth[:, 0], truth[:, k]) for k in (1, 2)])
    ids = places[:, 0].astype(np.int64)
    beacon = np.array([np.flatnonzero(ids == i)[0] for i in ranges[:, 2]])
    start = np.array([*true[0], th[0]])
    return Field(
        moved, np.diff(th), sigma, start, np.arange(len(when)), beacon, ranges[:, 3], true,
        places[:, 1:], ids, 0.6,
    )  # fmt: skip


def multilaterate(points: Array, ranges: Array, rounds: int = 20) -> tuple[Array, float]:
    """Place (d,) from which the ranges (n,) to the points (n, d) are least wrong, and their scale.

    At scale 1 the squares, ``|p|^2 - r^2 = 2 p.b - |b|^2``, are linear in b and ``|b|^2``. From
    there, Gauss-Newton steps in place and scale, with weights 1 / |residual| against wild ranges.

    Raises
    ------
    ValueError
        The points lie on a line (a plane in space): the mirror image has the same ranges.
    """
    centre = points.mean(axis=0)
    p = points - centre
    if np.linalg.matrix_rank(p, tol=1e-6 * np.linalg.norm(p)) < p.shape[1]:
        raise ValueError("the points lie on a line: two places have the same ranges")
    rows = np.column_stack([2 * p, -np.ones(len(p))])
    place = np.linalg.lstsq(rows, np.sum(p * p, axis=1) - ranges**2, rcond=None)[0][:-1]
    scale = 1.0
    for _ in range(rounds):
        away = np.linalg.norm(p - place, axis=1)
        wrong = scale * away - ranges
        weights = 1 / np.sqrt(np.maximum(np.abs(wrong), 0.05))[:, None]
        rows = np.column_stack([scale * (place - p) / away[:, None], away])
        step = np.linalg.lstsq(rows * weights, -wrong * weights[:, 0], rcond=None)[0]
        place, scale = place + step[:-1], scale + step[-1]
    return place + centre, float(scale)


def beacon_starts(field: Field) -> tuple[Array, float]:
    """Starts (k, 2) of the beacons [m] and of the scale, from the path of the odometry."""
    path, _ = dead_reckoning(field)
    mine = [field.beacon == k for k in range(len(field.ids))]
    found = [multilaterate(path[field.pose[m]], field.range[m]) for m in mine]
    return np.array([place for place, _ in found]), float(np.median([s for _, s in found]))


def problem(field: Field) -> Any:
    """The problem at its start: the odometry's path, multilaterated beacons."""
    pos, th = dead_reckoning(field)
    beacons, scale = beacon_starts(field)
    slam: Any = arael.load(MODEL)(scale=scale, range_sigma=field.range_sigma)
    slam.poses.extend(pos=pos, th=th)
    slam.poses[0].pos.fixed = True
    slam.poses[0].th.fixed = True
    slam.beacons.extend(id=field.ids, pos=beacons)
    n = np.arange(len(field.moved))
    slam.steps.extend(
        a=n,
        b=n + 1,
        moved=field.moved,
        turned=field.turned,
        moved_isigma=1 / field.sigma[:, :2],
        turned_isigma=1 / field.sigma[:, 2],
    )
    slam.ranges.extend(pose=field.pose, beacon=field.beacon, range=field.range)
    return slam


def aligned(found: Array, true: Array) -> tuple[Array, Array]:
    """Rotation (2, 2) and shift (2,) of `found` (n, 2) with the least squares to `true` (n, 2)."""
    a, b = found - found.mean(axis=0), true - true.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn, true.mean(axis=0) - turn @ found.mean(axis=0)


def rms(found: Array, true: Array) -> float:
    """Root mean square distance [m] of the best rigid alignment of two paths."""
    turn, shift = aligned(found, true)
    away = found @ turn.T + shift - true
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))


def report(slam: Any, field: Field, result: Any) -> list[str]:
    """Lines on the solution."""
    reckoned = dead_reckoning(field)[0]
    starts = beacon_starts(field)[0]
    path, beacons = np.asarray(slam.poses.pos.value), np.asarray(slam.beacons.pos.value)
    turn, shift = aligned(path, field.true_path)
    away = np.linalg.norm(beacons @ turn.T + shift - field.true_beacons, axis=1)
    before = np.linalg.norm(starts - field.true_beacons, axis=1)
    return [
        f"{len(path)} poses, {len(field.range)} ranges to {len(beacons)} beacons",
        f"{result.status} after {result.iterations} iterations: "
        f"{result.start_cost:.1f} -> {result.end_cost:.1f}",
        f"path: RMS {rms(path, field.true_path):.3f} m; "
        f"odometry alone {rms(reckoned, field.true_path):.3f} m",
        f"beacons: {' '.join(f'{d:.2f}' for d in away)} m; at the start "
        f"{' '.join(f'{d:.2f}' for d in before)} m",
        f"scale of the ranges: {float(slam.scale):.4f}",
    ]


def plot(slam: Any, field: Field, path: Path) -> str:
    """Draw path and beacons."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    found, beacons = np.asarray(slam.poses.pos.value), np.asarray(slam.beacons.pos.value)
    turn, shift = aligned(found, field.true_path)
    found, beacons = found @ turn.T + shift, beacons @ turn.T + shift

    @styled
    def draw() -> Any:
        figure, (axes,) = new_figure(8.0, 5.0)
        axes.plot(*field.true_path.T, color=GREY, lw=4, alpha=0.4, label="path")
        axes.plot(*dead_reckoning(field)[0].T, color=ORANGE, lw=0.8, label="odometry alone")
        axes.plot(*found.T, color=BLUE, lw=1, label="path, solved")
        axes.plot(*field.true_beacons.T, "o", color=GREY, ms=10, alpha=0.5, label="beacons")
        axes.plot(*beacon_starts(field)[0].T, "x", color=ORANGE, ms=7, label="beacons, start")
        axes.plot(*beacons.T, "+", color=INK, ms=9, label="beacons, solved")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title("a path and four beacons from distances")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a field, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plaza", type=Path, metavar="FOLDER", help="folder of Plaza1_.mat")
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    field = read_plaza(args.plaza) if args.plaza else make_field(seed=args.seed)
    slam = problem(field)
    if args.save:
        slam.write(args.save)
    result = slam.solve()
    print("\n".join(report(slam, field, result)))
    if args.plot:
        print("wrote", plot(slam, field, args.plot))


if __name__ == "__main__":
    main()
