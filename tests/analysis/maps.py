"""Small maps for the tests of covariance and rank."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import arael

PLANAR = """
struct Pose {
    param t:  vec2 [m]
    param th: angle
}
struct Edge {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    t:  vec2 [m]
    th: real [rad]
    isigma: real = 10
    constraint between {
        [(a.th.rotation_matrix()' * (b.t - a.t) - t) * isigma,
         rad_diff(rad_diff(b.th, a.th), th) * isigma]
    }
}
struct Fix {
    pose: ref Pose in root.poses
    t: vec2 [m]
    isigma: real = 4
    constraint fix { (pose.t - t) * isigma }
}
root Map {
    poses: list of Pose
    edges: list of Edge
    fixes: list of Fix
}
"""


SEEN = """
struct Point { param pos: vec3 [m] }
struct Pair {
    a: ref Point in root.points
    b: ref Point in root.points
    ratio: real = 1
    constraint parallel { cross(b.pos - a.pos, b.pos.value - a.pos.value) }
    constraint distance when ratio > 0 { norm(b.pos - a.pos) - norm(b.pos.value - a.pos.value) }
}
root Cloud { points: list of Point; pairs: list of Pair }
"""


def planar(folder: Path, count: int = 8, fixes: int = 2, precision: str = "f64", seed: int = 1):
    """A loop of poses with noisy odometry, closed, and some absolute fixes."""
    path = folder / "planar.arael"
    path.write_text(PLANAR, encoding="utf-8")
    model = arael.load(path, interpret=True, precision=precision)()
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * np.arange(count) / count
    t = 3 * np.column_stack([np.cos(angle), np.sin(angle)])
    th = np.angle(np.exp(1j * (angle + np.pi / 2)))
    for k in range(count):
        model.poses.append(t=t[k] + 0.05 * rng.normal(size=2), th=th[k] + 0.02 * rng.normal())
    pairs = [(k, (k + 1) % count) for k in range(count)] + [(0, count // 2)]
    for a, b in pairs:
        c, s = np.cos(th[a]), np.sin(th[a])
        between = np.array([[c, s], [-s, c]]) @ (t[b] - t[a])
        model.edges.append(
            a=model.poses[a],
            b=model.poses[b],
            t=between + 0.1 * rng.normal(size=2),
            th=np.angle(np.exp(1j * (th[b] - th[a] + 0.1 * rng.normal()))),
        )
    for k in range(fixes):
        at = k * count // max(fixes, 1)
        model.fixes.append(pose=model.poses[at], t=t[at] + 0.25 * rng.normal(size=2))
    return model


def cloud(folder: Path, distances: bool):
    """Points tied by the directions between them, and by distances if asked."""
    path = folder / "cloud.arael"
    path.write_text(SEEN, encoding="utf-8")
    model = arael.load(path, interpret=True)()
    for pos in np.random.default_rng(2).normal(size=(5, 3)):
        model.points.append(pos=pos)
    for a in range(5):
        for b in range(a):
            ratio = 1.0 if distances else 0.0
            model.pairs.append(a=model.points[a], b=model.points[b], ratio=ratio)
    return model
