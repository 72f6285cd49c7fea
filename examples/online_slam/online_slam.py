"""A robot drives rounds past landmarks, and has an estimate after every pose.

    python online_slam.py [--poses 300] [--seed 42] [--lag 30] [--plot FILE]

The model is `online_slam.arael` in this folder. Each step appends a pose, its odometry and what it
sees, and calls `update()`; with `--lag` only the newest poses are kept, by `marginalise`.

"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("online_slam.arael")
ROUND = 100
"""Poses of a round."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drive:
    """What a robot measures, with the truth.

    Attributes
    ----------
    pos, th : true poses (n, 2) [m], (n,) [rad]
    landmarks : their true positions (k, 2) [m]
    moved, turned : odometry (n - 1, 2) [m] in the frame of the earlier pose, (n - 1,) [rad]
    sights : per pose, landmarks that it sees and where, (m,) and (m, 2) [m] in its frame
    """

    pos: Array
    th: Array
    landmarks: Array
    moved: Array
    turned: Array
    sights: list[tuple[NDArray[np.int64], Array]]


@dataclass
class Track:
    """Estimates of the newest pose at each step.

    Attributes
    ----------
    pos : where it was estimated (n, 2) [m]
    sigma : its covariance (n, 2, 2) [m^2]
    times : milliseconds of processor time for append, update and covariance
    full : steps that were solved in full
    """

    pos: list[Array] = field(default_factory=list)
    sigma: list[Array] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    full: int = 0


def turn(th: float) -> Array:
    """Rotation matrix of a heading."""
    c, s = np.cos(th), np.sin(th)
    return np.array([[c, -s], [s, c]])


def make_drive(poses: int = 300, landmarks: int = 40, seed: int = 42) -> Drive:
    """Generate rounds on a closed curve."""
    rng = np.random.default_rng(seed)
    t = 2 * np.pi * np.arange(poses) / ROUND
    pos = np.column_stack([30 * np.sin(t) + 6 * np.sin(3 * t), 20 * (1 - np.cos(t))])
    ahead = np.column_stack([30 * np.cos(t) + 18 * np.cos(3 * t), 20 * np.sin(t)])
    th = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    marks = pos[rng.integers(0, min(poses, ROUND), landmarks)] + rng.normal(0, 5, (landmarks, 2))
    moved = np.array([turn(a).T @ d for a, d in zip(th, np.diff(pos, axis=0), strict=False)])
    sights = []
    for p, a in zip(pos, th, strict=True):
        local = (marks - p) @ turn(a)
        near = np.flatnonzero(np.linalg.norm(local, axis=1) < 8)
        sights.append((near, local[near] + rng.normal(0, 0.2, (len(near), 2))))
    return Drive(
        pos,
        th,
        marks,
        moved.reshape(-1, 2) + rng.normal(0, 0.05, (poses - 1, 2)),
        np.diff(th) + rng.normal(0, 0.01, poses - 1),
        sights,
    )


def follow(slam: Any, drive: Drive, lag: int | None = None) -> Iterator[Track]:
    """Append a pose after the other with all that it measures; yields after each update."""
    track, known = Track(), {}  # type: tuple[Track, dict[int, Any]]
    pos, th = np.zeros(2), 0.0
    for k in range(len(drive.pos)):
        if k:
            last = slam.poses[-1]
            moved, turned = drive.moved[k - 1], drive.turned[k - 1]
            pos = last.pos.value + turn(last.th.value) @ moved
            th = last.th.value + turned
        began = time.thread_time()
        pose = slam.poses.append(pos=pos, th=th)
        if k:
            slam.steps.append(a=last, b=pose, moved=moved, turned=turned)
        else:
            slam.starts.append(pose=pose)
        for mark, seen in zip(*drive.sights[k], strict=True):
            if int(mark) not in known:
                known[int(mark)] = slam.landmarks.append(pos=pos + turn(th) @ seen)
            slam.sights.append(pose=pose, landmark=known[int(mark)], seen=seen)
        result = slam.update()
        sigma = slam.marginal(pose)
        track.times.append(1e3 * (time.thread_time() - began))
        track.pos.append(np.array(pose.pos.value))
        track.sigma.append(sigma[:2, :2])
        track.full += result.full
        if lag is not None and len(slam.poses) > lag:
            leave(slam, known)
        yield track


def leave(slam: Any, known: dict[int, Any]) -> None:
    """Keep what the oldest pose knew as a prior, with landmarks that no other pose sees."""
    oldest = slam.poses[0]
    seen = {sight.landmark for sight in slam.sights if sight.pose != oldest}
    lost = [mark for mark, row in known.items() if row not in seen]
    slam.marginalise([oldest, *(known.pop(mark) for mark in lost)])


def report(slam: Any, drive: Drive, track: Track) -> str:
    """A line on the newest pose."""
    k = len(track.pos) - 1
    error = np.linalg.norm(track.pos[-1] - drive.pos[k])
    sigma = np.sqrt(np.linalg.eigvalsh(track.sigma[-1])[-1])
    recent = np.array(track.times[-ROUND // 2 :])
    return (
        f"pose {k:4}: {len(slam.poses)} poses, {len(slam.landmarks)} landmarks,"
        f" {len(slam.sights)} sights; off by {error:.2f} m, sigma {sigma:.2f} m;"
        f" {recent.mean():.2f} ms a step, at most {recent.max():.2f}"
    )


def ellipse(at: Array, sigma: Array, scale: float = 3.0) -> Array:
    """(2, 40) points of the ellipse of `scale` standard deviations."""
    values, axes = np.linalg.eigh(sigma)
    t = np.linspace(0, 2 * np.pi, 40)
    circle = np.stack([np.cos(t), np.sin(t)])
    return at[:, None] + scale * axes @ (np.sqrt(np.maximum(values, 0))[:, None] * circle)


def plot(slam: Any, drive: Drive, track: Track, path: Path) -> str:
    """Draw the map with ellipses of three standard deviations, and the times of the steps."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    landmarks = np.asarray(slam.landmarks.pos.value)

    @styled
    def draw() -> Any:
        figure, (axes, times) = new_figure(9.0, 4.5, columns=2)
        axes.plot(*drive.pos.T, color=GREY, lw=4, alpha=0.5, label="path")
        axes.plot(*np.array(track.pos).T, color=BLUE, lw=1, label="newest pose at each step")
        axes.plot(*landmarks.T, ".", color=INK, ms=4, label="landmarks")
        for k in range(0, len(track.pos), 10):
            axes.plot(*ellipse(track.pos[k], track.sigma[k]), color=ORANGE, lw=0.8)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.legend(loc="best")
        times.plot(track.times, ".", color=BLUE, ms=3)
        times.set_xlabel("pose")
        times.set_ylabel("append, update, covariance [ms]")
        return figure

    return save(draw(), path)


def main() -> None:
    """Drive, and print a line each half round."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=300)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--lag", type=int, help="keep this many poses")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    drive = make_drive(args.poses, seed=args.seed)
    slam: Any = arael.load(MODEL)()
    for track in follow(slam, drive, args.lag):
        if len(track.pos) % (ROUND // 2) == 0:
            print(report(slam, drive, track))
    if args.plot:
        print("wrote", plot(slam, drive, track, args.plot))


if __name__ == "__main__":
    main()
