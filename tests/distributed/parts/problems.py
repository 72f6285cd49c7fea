"""Problems to be solved in parts: a loop, a grid, a bundle, a chain of epochs."""

from __future__ import annotations

from typing import Any

import numpy as np

import arael
from arael.io import npz, npz_writer
from arael.model import Model

GRID = """
struct Node { param h: real; param s: vec2 }
struct Link {
    a: ref Node in root.nodes
    b: ref Node in root.nodes
    d: real
    constraint apart loss cauchy(2) { b.h * (1 + 0.1 * b.s.x) - a.h * (1 + 0.1 * a.s.y) - d }
    constraint smooth { 0.3 * (a.s - b.s) }
}
struct Pin { node: ref Node in root.nodes; h: real
    constraint at { [node.h - h, node.s - [1, 1]] } }
root Field { nodes: list of Node; links: list of Link; pins: list of Pin }
"""

BUNDLE = """
struct Camera { session: int = 0; param c: vec2; param th: angle }
struct Seen {
    camera: ref Camera in root.cameras
    u: real
    constraint projected loss huber(3) {
        let d = camera.th.rotation_matrix()' * (parent.x - camera.c)
        (root.focal * d.y / d.x - u) / 0.01
    }
}
struct Point { param x: vec2; seen: list of Seen }
root Bundle {
    param focal: real = 1
    cameras: list of Camera
    points: list of Point
    prior focal ~ normal(1, 0.05)
}
"""

CHAIN = """
struct Satellite { at: vec2 }
struct Epoch {
    prev: ref Epoch in root.epochs?
    param p: vec2
    param clock: real
    constraint moved when prev { [p - prev.p - [1, 0.1], 3 * (clock - prev.clock)] }
}
struct Range {
    epoch: ref Epoch in root.epochs
    satellite: ref Satellite in root.satellites
    rho: real
    good: bool = true
    constraint pseudo when good loss huber(2) {
        (norm(epoch.p - satellite.at) + epoch.clock - rho) / 0.1
    }
    constraint high when epoch.p.y > 1 { 0.2 * (epoch.p.y - 1) }
}
root Receiver { satellites: list of Satellite; epochs: list of Epoch; ranges: list of Range }
"""


FLEET = """
struct Pose { session: int = 0; param t: vec2; param th: angle }
struct Edge {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    t: vec2
    th: real
    used: bool = true
    constraint between when used loss huber(3) {
        [(a.th.rotation_matrix()' * (b.t - a.t) - t) / 0.02, sin(b.th - a.th - th) / 0.01]
    }
    constraint far when used and norm(b.t - a.t) > 2 { 0.1 * (norm(b.t - a.t) - 2) }
}
struct Anchor {
    pose: ref Pose in root.poses
    t: vec2
    th: real
    constraint held { [(pose.t - t) / 0.01, sin(pose.th - th) / 0.01] }
}
root Fleet {
    poses: list of Pose
    edges: list of Edge
    anchors: list of Anchor
}
"""


def loop(n: int = 60) -> Model:
    """A loop of planar poses with some chords."""
    rng = np.random.default_rng(1)
    graph: Any = arael.load("pose_graph_2d", interpret=True)()
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    at = 10 * np.stack((np.cos(turn), np.sin(turn)), 1)
    heading = (turn + 3 * np.pi / 2) % (2 * np.pi) - np.pi
    a = np.concatenate((np.arange(n), np.arange(0, n - 7, 11)))
    b = np.concatenate(((np.arange(n) + 1) % n, np.arange(0, n - 7, 11) + 6))
    c, s = np.cos(heading[a]), np.sin(heading[a])
    d = at[b] - at[a]
    t = np.stack((c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0]), 1)
    turned = (heading[b] - heading[a] + np.pi) % (2 * np.pi) - np.pi
    graph.poses.extend(t=at + rng.normal(0, 0.2, at.shape), th=heading + rng.normal(0, 0.05, n))
    graph.edges.extend(
        a=a,
        b=b,
        t=t + rng.normal(0, 0.02, t.shape),
        th=turned + rng.normal(0, 0.01, len(a)),
        u=np.tile(np.diag([50.0, 50, 100]), (len(a), 1, 1)),
    )
    graph.anchors.extend(pose=[0], t=at[:1], th=heading[:1])
    return graph


def grid(n: int = 8) -> Model:
    """A grid of nodes, some of which are fixed."""
    rng = np.random.default_rng(2)
    field: Any = arael.loads(GRID, name="grid.arael", interpret=True)()
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    h = (np.sin(x) + 0.3 * y + 1).ravel()
    number = np.arange(n * n).reshape(n, n)
    a = np.concatenate((number[:, :-1].ravel(), number[:-1].ravel()))
    b = np.concatenate((number[:, 1:].ravel(), number[1:].ravel()))
    field.nodes.extend(h=h + rng.normal(0, 0.5, n * n), s=np.ones((n * n, 2)))
    noise = rng.normal(0, 0.05, len(a)) + 3 * (rng.random(len(a)) < 0.05)
    field.links.extend(a=a, b=b, d=1.1 * (h[b] - h[a]) + noise)
    field.pins.extend(node=[0, n * n - 1], h=h[[0, -1]])
    field.nodes[5].h.fixed = True
    field.nodes[n * n // 2].h.fixed = True
    field.nodes[n * n // 2].s.fixed = True
    return field


def bundle(cameras: int = 12, points: int = 40) -> Model:
    """Planar cameras along a line, each of which sees the points near it; two sessions."""
    rng = np.random.default_rng(3)
    scene: Any = arael.loads(BUNDLE, name="bundle.arael", interpret=True)()
    x = np.linspace(0, 20, cameras)
    at = np.stack((np.zeros(cameras), x), 1)
    where = np.stack((rng.uniform(4, 8, points), rng.uniform(0, 20, points)), 1)
    start = at + rng.normal(0, 0.05, at.shape)
    start[[0, -1]] = at[[0, -1]]
    scene.cameras.extend(
        c=start, th=rng.normal(0, 0.01, cameras), session=(np.arange(cameras) > 5).astype(int)
    )
    for k in (0, cameras - 1):
        scene.cameras[k].c.fixed = True
    for k in range(points):
        row = scene.points.append(x=where[k] + rng.normal(0, 0.1, 2))
        for c in np.flatnonzero(np.abs(x - where[k, 1]) < 4):
            d = where[k] - at[c]
            row.seen.append(camera=int(c), u=d[1] / d[0] + rng.normal(0, 0.01))
    return scene


def chain(n: int = 50) -> Model:
    """Epochs of a receiver: optional refs, guards over data and parameters, fixed rows."""
    rng = np.random.default_rng(4)
    receiver: Any = arael.loads(CHAIN, name="chain.arael", interpret=True)()
    satellites = np.array([[0.0, 40], [60, 30], [-20, 20], [30, -50]])
    receiver.satellites.extend(at=satellites)
    true = np.stack((np.arange(n) * 1.0, 0.1 * np.arange(n)), 1)
    clock = 0.3 * np.sin(np.arange(n) / 5)
    prev = np.arange(n) - 1
    prev[n // 2] = -1
    receiver.epochs.extend(prev=prev, p=true + rng.normal(0, 0.5, true.shape), clock=np.zeros(n))
    e, s = np.repeat(np.arange(n), 4), np.tile(np.arange(4), n)
    rho = np.linalg.norm(true[e] - satellites[s], axis=1) + clock[e] + rng.normal(0, 0.1, len(e))
    rho[::17] += 4
    receiver.ranges.extend(epoch=e, satellite=s, rho=rho, good=np.arange(len(e)) % 9 != 0)
    receiver.ranges.append(epoch=n // 2, satellite=0, rho=30.0, good=False)
    receiver.epochs[3].p.fixed = True
    # Both halves are joined by one more ref.
    receiver.epochs[n // 2].prev = n // 2 - 1
    return receiver


def fleet(sizes: tuple[int, ...] = (60, 23, 3), unused: bool = True) -> Model:
    """Loops of planar poses that have nothing to do with each other, in a shuffled order of rows.

    Their starts differ in quality, so that they end after different numbers of attempts. `unused`:
    with a measurement between the first and the last that is not in use.
    """
    rng = np.random.default_rng(8)
    graph: Any = arael.loads(FLEET, name="fleet.arael", interpret=True)()
    total = sum(sizes)
    place = rng.permutation(total)
    first = 0
    rows: list[dict[str, Any]] = [{} for _ in range(total)]
    edges, anchors = [], []
    for number, n in enumerate(sizes):
        turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
        at = 10 * np.stack((np.cos(turn), np.sin(turn)), 1)
        heading = turn + np.pi / 2
        noise = (1.0, 0.05, 0.3)[number % 3]
        mine = place[first : first + n]
        for k in range(n):
            rows[mine[k]] = {
                "t": at[k] + rng.normal(0, noise, 2),
                "th": float(np.arctan2(np.sin(heading[k]), np.cos(heading[k])))
                + rng.normal(0, noise / 4),
                "session": (first + k) // 9,
            }
            j = (k + 1) % n
            c, s = np.cos(heading[k]), np.sin(heading[k])
            d = at[j] - at[k]
            t = np.array([c * d[0] + s * d[1], c * d[1] - s * d[0]]) + rng.normal(0, 0.02, 2)
            edges.append((mine[k], mine[j], t, heading[j] - heading[k] + rng.normal(0, 0.01)))
        anchors.append((mine[0], at[0], heading[0]))
        first += n
    for row in rows:
        graph.poses.append(**row)
    for a, b, t, th in edges:
        graph.edges.append(a=int(a), b=int(b), t=t, th=th)
    if unused:  # its guard is false: it joins no loops
        graph.edges.append(a=int(place[0]), b=int(place[-1]), t=[1, 0], th=0.5, used=False)
    for pose, t, th in anchors:
        graph.anchors.append(pose=int(pose), t=t, th=th)
    # It is not solved for, so that the cost of its anchor is constant.
    graph.poses.append(t=[0, 0], th=0.0)
    graph.poses[total].t.fixed = graph.poses[total].th.fixed = True
    graph.anchors.append(pose=total, t=[0.01, 0], th=0.0)
    return graph


def tracks(lengths: tuple[int, ...] = (31, 4, 1, 17, 9)) -> Model:
    """The chain in pieces that have nothing to do with each other, some far from their ends."""
    receiver: Any = chain(sum(lengths))
    begins = np.cumsum((0, *lengths[:-1]))
    for epoch in begins:
        receiver.epochs[int(epoch)].prev = None
    receiver.epochs[int(begins[3])].p = [30.0, -8.0]
    receiver.epochs[int(begins[4]) + 2].p.fixed = True
    return receiver


def fields(*sizes: int) -> Model:
    """Grids of different sizes that have nothing to do with each other, in turn in the tables."""
    sizes = sizes or (5, 3, 4)
    field: Any = arael.loads(GRID, name="grid.arael", interpret=True)()
    ones: list[Any] = [grid(n) for n in sizes]
    count = len(sizes)
    order = np.argsort(np.concatenate([np.arange(n * n) for n in sizes]), kind="stable")
    place = np.argsort(order)
    first = np.cumsum([0, *(n * n for n in sizes)])
    h = np.concatenate([one.nodes.h for one in ones])
    field.nodes.extend(h=h[order], s=np.ones((len(h), 2)))
    for k in range(count):
        links, pins = ones[k].links, ones[k].pins
        a, b = (np.array([getattr(link, end).index for link in links]) for end in "ab")
        field.links.extend(a=place[first[k] + a], b=place[first[k] + b], d=links.d)
        at = np.array([pin.node.index for pin in pins])
        field.pins.extend(node=place[first[k] + at], h=pins.h)
    return field


PROBLEMS = {"loop": loop, "grid": grid, "bundle": bundle, "chain": chain, "fleet": fleet}


def arrays_of(model: Any) -> dict[str, Any]:
    """The data of a model as an archive has it."""
    return dict(npz_writer.arrays_of(model._store))


def with_arrays(model: Any, arrays: dict[str, Any]) -> Any:
    """Another instance of a model, with that data."""
    found = type(model)()
    npz.adopt(found._store, dict(arrays), "arrays")
    return found
