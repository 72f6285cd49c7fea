"""A path and a map of trees, from odometry, ranges and bearings.

    python landmark_slam_2d.py [--seed 42]                              a generated park
    python landmark_slam_2d.py --victoria FILE                          the public set Victoria Park
                               [--save park.npz] [--plot FILE]

The model is `landmark_slam_2d.arael` in this folder. The start is solved in parts.

"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("landmark_slam_2d.arael")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Park:
    """Odometry and sights, with the truth of a generated park.

    Attributes
    ----------
    moved, turned : steps (n - 1, 2) [m] in the frame of the earlier pose, turns (n - 1,) [rad]
    sigma : standard deviations (n - 1, 2) of a step [m] and a turn [rad]
    pose, landmark : rows (m,) of poses and of landmarks that were seen
    bearing, range : of the sights (m,) [rad], [m]
    ids : names (k,) of the landmarks
    true_path, true_landmarks : positions (n, 2), (k, 2) [m], or None
    """

    moved: Array
    turned: Array
    sigma: Array
    pose: NDArray[np.int64]
    landmark: NDArray[np.int64]
    bearing: Array
    range: Array
    ids: NDArray[np.int64]
    true_path: Array | None = None
    true_landmarks: Array | None = None


def into_frame(path: Array, th: Array, points: Array) -> Array:
    """Points (n, 2) of the world in the frames of poses (n, 2), (n,)."""
    d, c, s = points - path, np.cos(th), np.sin(th)
    return np.column_stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]])


def out_of_frame(path: Array, th: Array, points: Array) -> Array:
    """Points (n, 2) of the frames of poses in the world."""
    c, s = np.cos(th), np.sin(th)
    x, y = points.T
    return path + np.column_stack([c * x - s * y, s * x + c * y])


def dead_reckoning(park: Park) -> tuple[Array, Array]:
    """Positions (n, 2) [m] and headings (n,) [rad] of the odometry alone, from the origin."""
    return extended(park, np.zeros((1, 2)), np.zeros(1))


def extended(park: Park, path: Array, th: Array) -> tuple[Array, Array]:
    """Positions (n, 2) and headings (n,) of which the first are given, the rest by odometry."""
    done = len(th)
    more = th[-1] + np.cumsum(park.turned[done - 1 :])
    th = np.concatenate([th, more])
    steps = out_of_frame(np.zeros((len(more), 2)), th[done - 1 : -1], park.moved[done - 1 :])
    return np.vstack([path, path[-1] + np.cumsum(steps, axis=0)]), th


def first_sights(park: Park, path: Array, th: Array) -> Array:
    """Places (k, 2) of the landmarks [m] by the first sight of each from a path."""
    first = np.unique(park.landmark, return_index=True)[1]
    seen = park.range[first, None] * np.column_stack(
        [np.cos(park.bearing[first]), np.sin(park.bearing[first])]
    )
    return out_of_frame(path[park.pose[first]], th[park.pose[first]], seen)


def beginning(park: Park, poses: int) -> Park:
    """The first poses of a park, with what was seen from them."""
    seen = park.pose < poses
    known, landmark = np.unique(park.landmark[seen], return_inverse=True)
    return Park(
        park.moved[: poses - 1], park.turned[: poses - 1], park.sigma[: poses - 1],
        park.pose[seen], landmark, park.bearing[seen], park.range[seen], park.ids[known],
    )  # fmt: skip


def start_by_parts(park: Park, part: int = 300) -> tuple[Array, Array]:
    """Positions and headings from solves of the first 300 poses, the first 600, and so on.

    Each solve starts from the last, extended by odometry, so that loops are closed before the
    heading has drifted far: odometry alone is a start in another valley for long paths.
    """
    path, th = np.zeros((1, 2)), np.zeros(1)
    for poses in range(part, len(park.turned) + 1, part):
        slam = problem(beginning(park, poses), path, th)
        slam.solve(passes="fine", rel_precision=1e-4)
        path, th = np.array(slam.poses.pos.value), np.array(slam.poses.th.value)
    return path, th


def make_park(poses: int = 300, landmarks: int = 40, seed: int = 42) -> Park:
    """Generate two rounds through a park; some sights are of another tree."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 4 * np.pi, poses)
    path = np.column_stack([40 * np.sin(t), 25 * (1 - np.cos(t)) + 6 * np.sin(3 * t) ** 2])
    d = np.gradient(path, axis=0)
    th = np.unwrap(np.arctan2(d[:, 1], d[:, 0]))
    # The first pose is the origin, which looks along x.
    path, th = into_frame(path[:1].repeat(poses, 0), th[:1].repeat(poses), path), th - th[0]
    trees = path[rng.integers(0, poses, landmarks)] + rng.normal(0, 9, (landmarks, 2))
    moved, turned = into_frame(path[:-1], th[:-1], path[1:]), np.diff(th)
    sigma = np.tile([0.05, 0.01], (poses - 1, 1))
    moved = moved + rng.normal(size=moved.shape) * sigma[:, :1]
    turned = turned + rng.normal(size=poses - 1) * sigma[:, 1]

    pairs = np.stack(np.meshgrid(np.arange(poses), np.arange(landmarks)), axis=-1).reshape(-1, 2)
    local = into_frame(path[pairs[:, 0]], th[pairs[:, 0]], trees[pairs[:, 1]])
    away = np.linalg.norm(local, axis=1)
    seen = (away > 1) & (away < 20) & (local[:, 0] > 0) & (rng.random(len(away)) < 0.6)
    pose, landmark = pairs[seen].T
    order = np.lexsort([landmark, pose])
    pose, landmark = pose[order], landmark[order]
    local, away = local[seen][order], away[seen][order]
    bearing = np.arctan2(local[:, 1], local[:, 0]) + rng.normal(0, np.deg2rad(2), len(pose))
    measured = away + rng.normal(0, 0.3, len(pose))
    ids, landmark = np.unique(landmark, return_inverse=True)
    true = trees[ids]
    # A wrong sight is of a tree that was seen before, so that it is not the start of one.
    first = np.unique(landmark, return_index=True)[1]
    other = rng.integers(0, len(ids), len(pose))
    wrong = (first[other] < np.arange(len(pose))) & (rng.random(len(pose)) < 0.04)
    wrong[first] = False
    landmark = np.where(wrong, other, landmark)
    return Park(moved, turned, sigma, pose, landmark, bearing, measured, ids, path, true)


def read_victoria(path: Path) -> Park:
    """Read Victoria Park in the format of GTSAM's examples.

    ``ODOMETRY i j x y turn`` and six entries of a covariance; ``LANDMARK pose id x y`` in the frame
    of the pose; numbers of poses have gaps. Sights that are given twice count once.
    """
    odometry, sights, number = [], {}, {0: 0}
    for line in path.read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        numbers = [float(word) for word in words]
        if kind == "ODOMETRY":
            number[int(numbers[1])] = len(number)
            odometry.append([*numbers[2:5], np.sqrt(numbers[5]), np.sqrt(numbers[8])])
        elif kind == "LANDMARK":
            sights[number[int(numbers[0])], int(numbers[1])] = numbers[2:4]
    steps = np.array(odometry)
    rows = np.array(list(sights), dtype=np.int64)
    local = np.array(list(sights.values()))
    order = np.lexsort([rows[:, 1], rows[:, 0]])
    rows, local = rows[order], local[order]
    ids, landmark = np.unique(rows[:, 1], return_inverse=True)
    return Park(
        moved=steps[:, :2],
        turned=steps[:, 2],
        sigma=steps[:, 3:],
        pose=rows[:, 0],
        landmark=landmark,
        bearing=np.arctan2(local[:, 1], local[:, 0]),
        range=np.linalg.norm(local, axis=1),
        ids=ids,
    )


def problem(park: Park, path: Array | None = None, th: Array | None = None) -> Any:
    """The problem from a start of its first poses, by default that of `start_by_parts`."""
    if path is None or th is None:
        path, th = start_by_parts(park)
    path, th = extended(park, path, th)
    slam: Any = arael.load(MODEL)()
    slam.poses.extend(pos=path, th=th)
    slam.poses[0].pos.fixed = True
    slam.poses[0].th.fixed = True
    slam.landmarks.extend(id=park.ids, pos=first_sights(park, path, th))
    n = np.arange(len(park.moved))
    slam.steps.extend(
        a=n,
        b=n + 1,
        moved=park.moved,
        turned=park.turned,
        moved_isigma=1 / park.sigma[:, 0],
        turned_isigma=1 / park.sigma[:, 1],
    )
    slam.sights.extend(
        pose=park.pose, landmark=park.landmark, bearing=park.bearing, range=park.range
    )
    return slam


def rms(found: Array, true: Array) -> float:
    """Root mean square distance [m]."""
    return float(np.sqrt(np.mean(np.sum((found - true) ** 2, axis=1))))


def report(slam: Any, park: Park, result: Any) -> list[str]:
    """Lines on the solution."""
    path = np.asarray(slam.poses.pos.value)
    reckoned, _ = dead_reckoning(park)
    bearing, distance = np.abs(slam.residual_values("Sight.sight").whitened).T
    lines = [
        f"{len(path)} poses, {len(park.ids)} landmarks, {len(park.pose)} sights",
        f"{result.status} after {result.iterations} iterations: "
        f"{result.start_cost:.1f} -> {result.end_cost:.2f}",
        f"median residual: {np.rad2deg(np.median(bearing) * slam.bearing_sigma):.2f} deg, "
        f"{np.median(distance) * slam.range_sigma:.3f} m",
    ]
    if park.true_path is None or park.true_landmarks is None:
        away = np.linalg.norm(path - reckoned, axis=1).max()
        return [*lines, f"odometry alone is up to {away:.1f} m from the solved path"]
    landmarks = np.asarray(slam.landmarks.pos.value)
    first = first_sights(park, *dead_reckoning(park))
    return [
        *lines,
        f"path: RMS {rms(path, park.true_path):.3f} m; "
        f"odometry alone {rms(reckoned, park.true_path):.3f} m",
        f"landmarks: RMS {rms(landmarks, park.true_landmarks):.3f} m; "
        f"by odometry and first sights {rms(first, park.true_landmarks):.3f} m",
    ]


def plot(slam: Any, park: Park, path: Path) -> str:
    """Draw path and landmarks."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    found, landmarks = np.asarray(slam.poses.pos.value), np.asarray(slam.landmarks.pos.value)

    @styled
    def draw() -> Any:
        figure, (axes,) = new_figure(8.0, 6.0)
        if park.true_path is not None:
            axes.plot(*park.true_path.T, color=GREY, lw=4, alpha=0.5, label="path")
        axes.plot(*dead_reckoning(park)[0].T, color=ORANGE, lw=0.8, label="odometry alone")
        axes.plot(*found.T, color=BLUE, lw=1, label="path, solved")
        axes.plot(*landmarks.T, ".", color=INK, ms=4, label="landmarks")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title("a path among trees")
        axes.legend(loc="best")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a park."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--victoria", type=Path, metavar="FILE", help="victoria_park.txt")
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    park = read_victoria(args.victoria) if args.victoria else make_park(seed=args.seed)
    slam = problem(park)
    if args.save:
        slam.write(args.save)
    result = slam.solve()
    print("\n".join(report(slam, park, result)))
    if args.plot:
        print("wrote", plot(slam, park, args.plot))


if __name__ == "__main__":
    main()
