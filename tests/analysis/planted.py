"""Small calibrations, each healthy or with one planted deficiency."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.geometry import quat_exp, quat_product, quat_rotate
from tests.interpreted import Load

Floats = NDArray[np.float64]

HAND_EYE = """
struct Motion {
    a_t: vec3
    a_q: quat
    b_t: vec3
    b_q: quat
    constraint loop {
        let a = transform(a_t, a_q)
        let b = transform(b_t, b_q)
        ((a * root.X).inverse() * (root.X * b)).log() / 1e-3
    }
}
root HandEye { param X: transform = [0, 0, 0, 1, 0, 0, 0]; motions: list of Motion }
"""
LEVER = """
struct Fix {
    q:    quat
    at:   vec3
    seen: vec3
    constraint antenna { (at + rotation_matrix(q) * root.lever + root.base - seen) / 0.01 }
}
root Vehicle {
    param lever: vec3 = [0, 0, 0]
    param base:  vec3 = [0, 0, 0]
    fixes: list of Fix
}
"""
BEARINGS = """
struct Pose { param pos: vec2; param th: angle }
struct Tree { param pos: vec2 }
struct Sight {
    pose: ref Pose in root.poses
    tree: ref Tree in root.trees
    bearing: real
    constraint sight {
        let d = pose.th.rotation_matrix()' * (tree.pos - pose.pos)
        rad_diff(atan2(d.y, d.x), bearing) / 0.002
    }
}
struct Step {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    length: real
    constraint odometry { (norm(b.pos - a.pos) - length) / 0.02 }
}
root Garden {
    poses: list of Pose
    trees: list of Tree
    sights: list of Sight
    steps: list of Step
}
"""
DECAY = """
struct Sample {
    t: real [s]
    y: real
    constraint decay { (root.a * exp(-t / root.tau) + root.c - y) / 0.01 }
}
root Decay {
    param a: real = 1
    param tau: real [s] = 8
    param c: real = 0.1
    samples: list of Sample
}
"""
RANGER = """
struct Shot {
    distance: real
    reading:  real
    constraint scale { (root.gain * distance + root.offset - reading) / 0.01 }
}
root Ranger { param gain: real = 1; param offset: real = 0; shots: list of Shot }
"""
SHUTTER = """
struct Frame { velocity: vec2; start: vec2 }
struct Feature {
    frame: ref Frame in root.frames
    place: vec2
    line:  real
    pixel: vec2
    constraint seen {
        let p = place - frame.start - frame.velocity * (line * root.delay)
        (root.f * p + root.c - pixel) / 0.3
    }
}
root Camera {
    param f: real = 500
    param c: vec2 = [320, 240]
    param delay: real = 1e-5
    frames: list of Frame
    features: list of Feature
}
"""
CAMERA = """
struct View { param board: transform }
struct Corner {
    view:  ref View in root.views
    on:    vec3
    pixel: vec2
    constraint lens {
        let p = view.board * on
        let u = [p.x, p.y] / p.z
        let s = dot(u, u)
        (root.f .* u * (1 + s * (root.k[0] + s * root.k[1])) + root.c - pixel) / 0.2
    }
}
root Lens {
    param f: vec2 = [500, 500]
    param c: vec2 = [320, 240]
    param k: vec2 = [0, 0]
    views: list of View
    corners: list of Corner
}
"""
CLOCK = """
struct Ping {
    t:      real [s]
    beacon: vec3
    length: real
    constraint distance { (norm(root.at - beacon) + root.clock - length) / 0.5 }
}
root Receiver { param at: vec3 = [0, 0, 0]; param clock: real = 0; ranges: list of Ping }
"""
GRAPH = """
struct Pose { param pos: vec2; param th: angle; anchor: vec3?
    constraint hold when anchor { [pos - [anchor.x, anchor.y], th - anchor.z] / 0.01 } }
struct Edge {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    d: vec2
    turn: real
    constraint odometry {
        [(a.th.rotation_matrix()' * (b.pos - a.pos) - d) / 0.05,
         rad_diff(rad_diff(b.th, a.th), turn) / 0.01]
    }
}
root Graph { poses: list of Pose; edges: list of Edge }
"""
TWO_GAINS = """
struct Point { x: real; y: real
    constraint line { (root.gain * root.response * x + root.offset - y) / 0.01 } }
root Sensor {
    param gain: real = 1
    param response: real = 1
    param offset: real = 0
    points: list of Point
}
"""


def _solved(model: Any) -> Any:
    # Parameters without any effect keep their values.
    model.solve(min_diagonal=1e-12)
    return model


def hand_eye(load: Load, rng: np.random.Generator, axes: Any = (1, 1, 1)) -> Any:
    """A X = X B with turns about the `axes` that are 1, and no motion along z if these are z."""
    n = 20
    turn = quat_exp(rng.normal(0, 0.8, (n, 3)) * axes)
    move = rng.uniform(-0.5, 0.5, (n, 3)) * (1, 1, axes[0])
    x_t, x_q = np.array([0.05, -0.03, 0.12]), quat_exp([0.1, -0.2, 1.0])
    back = x_q * (1, -1, -1, -1)
    b_q = quat_product(quat_product(np.tile(back, (n, 1)), turn), np.tile(x_q, (n, 1)))
    b_t = quat_rotate(back, quat_rotate(turn, np.tile(x_t, (n, 1))) + move - x_t)
    b_q = quat_product(b_q, quat_exp(rng.normal(0, 1e-3, (n, 3))))
    b_t = b_t + rng.normal(0, 1e-3, (n, 3))
    model: Any = load(HAND_EYE)()
    model.motions.extend(a_t=move, a_q=turn, b_t=b_t, b_q=b_q)
    return _solved(model)


def lever(load: Load, rng: np.random.Generator, axes: Any = (1, 1, 1)) -> Any:
    """An antenna on a vehicle that turns about the `axes` that are 1."""
    n = 30
    q, at = quat_exp(rng.normal(0, 0.8, (n, 3)) * axes), rng.uniform(-10, 10, (n, 3))
    seen = at + quat_rotate(q, np.tile([0.4, 0.1, 1.2], (n, 1))) + [2.0, -1.0, 0.5]
    model: Any = load(LEVER)()
    model.fixes.extend(q=q, at=at, seen=seen + rng.normal(0, 0.01, (n, 3)))
    return _solved(model)


def garden(load: Load, rng: np.random.Generator, odometry: bool = True) -> Any:
    """Bearings to trees from a path whose first pose is known; `odometry` has the scale."""
    t = np.linspace(0, 1, 8)
    pos, th = np.column_stack([5 * t, 2 * np.sin(3 * t)]), 1.5 * t
    trees = rng.uniform([-2, -6], [7, 8], (10, 2))
    model: Any = load(BEARINGS)()
    start = rng.normal(0, 0.02, (8, 3)) * (t > 0)[:, None]
    model.poses.extend(pos=pos + start[:, :2], th=th + start[:, 2])
    model.trees.extend(pos=trees + rng.normal(0, 0.02, trees.shape))
    model.poses[0].pos.fixed = model.poses[0].th.fixed = True
    a, b = (k.ravel() for k in np.meshgrid(np.arange(8), np.arange(10), indexing="ij"))
    d = trees[b] - pos[a]
    bearing = np.arctan2(d[:, 1], d[:, 0]) - th[a] + rng.normal(0, 0.002, len(a))
    model.sights.extend(pose=a, tree=b, bearing=bearing)
    if odometry:
        length = np.linalg.norm(np.diff(pos, axis=0), axis=1) + rng.normal(0, 0.02, 7)
        model.steps.extend(a=np.arange(7), b=np.arange(1, 8), length=length)
    return _solved(model)


def decay(load: Load, rng: np.random.Generator, span: float = 30.0) -> Any:
    """An exponential with a time constant of 10 s, sampled over `span` seconds."""
    t = np.linspace(0, span, 60)
    y = 1.5 * np.exp(-t / 10) + 0.3 + rng.normal(0, 0.01, 60)
    model: Any = load(DECAY)()
    model.samples.extend(t=t, y=y)
    return _solved(model)


def ranger(
    load: Load, rng: np.random.Generator, distances: Any = (0.5, 8.0), noise: float = 0.01
) -> Any:
    """A range finder with gain and offset, at distances between two."""
    d = np.linspace(*distances, 40)
    model: Any = load(RANGER)()
    model.shots.extend(distance=d, reading=1.02 * d - 0.05 + rng.normal(0, noise, 40))
    return _solved(model)


def shutter(load: Load, rng: np.random.Generator, speed: float = 1.0) -> Any:
    """A camera that reads its lines one after another, at a `speed`."""
    n = 6
    velocity, start = speed * rng.normal(0, 1, (n, 2)), rng.normal(0, 0.1, (n, 2))
    frame = np.repeat(np.arange(n), 15)
    place, line = rng.uniform(-0.4, 0.4, (len(frame), 2)), rng.uniform(0, 480, len(frame))
    p = place - start[frame] - velocity[frame] * (line * 3e-5)[:, None]
    model: Any = load(SHUTTER)()
    model.frames.extend(velocity=velocity, start=start)
    pixel = 510 * p + [318, 243] + rng.normal(0, 0.3, p.shape)
    model.features.extend(frame=frame, place=place, line=line, pixel=pixel)
    return _solved(model)


def camera(
    load: Load, rng: np.random.Generator, seen: float = 1.0, bad: float = 1.0, views: int = 10
) -> Any:
    """A lens from pictures of a board, of which the middle part `seen` is used; `bad` scales the
    noise of view 3."""  # fmt: skip
    board = np.array([[0.03 * i, 0.03 * j, 0.0] for i in range(-4, 5) for j in range(-3, 4)])
    turn = quat_exp(rng.normal(0, 0.35, (views, 3)))
    place = rng.uniform([-0.1, -0.08, 0.3], [0.1, 0.08, 0.5], (views, 3))
    view = np.repeat(np.arange(views), len(board))
    on = np.tile(board, (views, 1))
    p = quat_rotate(turn[view], on) + place[view]
    u = p[:, :2] / p[:, 2:]
    s = (u**2).sum(axis=1, keepdims=True)
    exact = [510, 506] * u * (1 - 0.25 * s + 0.08 * s**2) + [318, 243]
    noise = 0.2 * np.where(view == 3, bad, 1.0)[:, None]
    pixel = exact + noise * rng.normal(size=exact.shape)
    inside = (np.abs(pixel - [320, 240]) < np.array([320, 240]) * seen).all(axis=1)
    inside &= np.bincount(view, inside, views)[view] >= 8
    used = np.unique(view[inside])
    model: Any = load(CAMERA)()
    model.views.extend(board=np.hstack([place, turn])[used])
    model.corners.extend(
        view=np.searchsorted(used, view[inside]), on=on[inside], pixel=pixel[inside]
    )
    return _solved(model)


def clock(load: Load, rng: np.random.Generator, correlation: float = 0.0) -> Any:
    """Ranges to beacons with a clock whose error is correlated from one to the next."""
    n = 120
    error = rng.normal(0, 0.5, n)
    for k in range(1, n):
        error[k] = correlation * error[k - 1] + np.sqrt(1 - correlation**2) * error[k]
    beacon = rng.uniform(-100, 100, (n, 3))
    at = np.array([3.0, -2.0, 1.0])
    model: Any = load(CLOCK)()
    model.ranges.extend(
        t=np.arange(n) * 1.0,
        beacon=beacon,
        length=np.linalg.norm(at - beacon, axis=1) + 20 + error,
    )
    return _solved(model)


def graph(load: Load, rng: np.random.Generator, anchored: bool = True) -> Any:
    """A ring of poses with odometry, and one anchor or none."""
    n = 12
    th = 2 * np.pi * np.arange(n) / n
    pos = 3 * np.column_stack([np.sin(th), 1 - np.cos(th)])
    model: Any = load(GRAPH)()
    for k in range(n):
        model.poses.append(pos=pos[k], th=th[k], anchor=[0, 0, 0] if anchored and not k else None)
    for k in range(n):
        b = (k + 1) % n
        c, s = np.cos(th[k]), np.sin(th[k])
        d = np.array([[c, s], [-s, c]]) @ (pos[b] - pos[k]) + rng.normal(0, 0.05, 2)
        model.edges.append(
            a=model.poses[k], b=model.poses[b], d=d, turn=2 * np.pi / n + rng.normal(0, 0.01)
        )
    return _solved(model)


def sensor(load: Load, rng: np.random.Generator) -> Any:
    """A sensor with two gains of which only the product has an effect."""
    x = np.linspace(-1, 2, 40)
    model: Any = load(TWO_GAINS)()
    model.points.extend(x=x, y=1.3 * x + 0.4 + rng.normal(0, 0.01, 40))
    return _solved(model)


HEALTHY: dict[str, Callable[[Load, np.random.Generator], Any]] = {
    "hand_eye": hand_eye,
    "lever": lever,
    "garden": garden,
    "decay": decay,
    "ranger": ranger,
    "shutter": shutter,
    "camera": camera,
    "clock": clock,
    "graph": graph,
}
"""Problems without a deficiency."""

PLANTED: dict[str, Callable[[Load, np.random.Generator], Any]] = {
    "planar motion": lambda load, rng: hand_eye(load, rng, (0, 0, 1)),
    "one rotation axis": lambda load, rng: lever(load, rng, (1, 0, 0)),
    "no scale": lambda load, rng: garden(load, rng, odometry=False),
    "short time span": lambda load, rng: decay(load, rng, 1.0),
    "one distance only": lambda load, rng: ranger(load, rng, (2.0, 2.0)),
    "rolling shutter unseen": lambda load, rng: shutter(load, rng, 0.0),
    "few corners": lambda load, rng: camera(load, rng, 0.25),
    "correlated clock": lambda load, rng: clock(load, rng, 0.9),
    "gauge left free": lambda load, rng: graph(load, rng, anchored=False),
    "two parameters for one effect": sensor,
    "wrong sigma": lambda load, rng: ranger(load, rng, noise=0.03),
    "one bad view": lambda load, rng: camera(load, rng, bad=5.0),
}
"""The deficiencies by name."""

NAMED: dict[str, tuple[set[str], list[str], dict[str, set[str]]]] = {
    "planar motion": ({"unseen"}, ["X.translation.z"], {"motions.a_q": {"x", "y"}}),
    "one rotation axis": ({"unseen"}, ["lever.x", "base.x"], {"fixes.q": {"y", "z"}}),
    "no scale": ({"gauge"}, ["grow or shrink together"], {}),
    "short time span": ({"unseen"}, ["tau", "`a`", "`c`"], {"samples.t": {""}}),
    "one distance only": ({"unseen"}, ["gain", "offset"], {"shots.distance": {""}}),
    "rolling shutter unseen": ({"unseen"}, ["delay"], {"frames.velocity": {"x", "y"}}),
    "few corners": ({"coverage"}, ["projections of `m", "% of the picture"], {}),
    "correlated clock": ({"order"}, ["neighbours in time"], {}),
    "gauge left free": ({"gauge"}, ["along x", "along y", "turn together"], {}),
    "two parameters for one effect": ({"redundant"}, ["gain", "response"], {}),
    "wrong sigma": ({"scale"}, ["Shot.scale"], {}),
    "one bad view": ({"group"}, ["`views[3]`"], {}),
}
"""What each deficiency must be called: topics, parameters in the words, what is missing."""
