"""The toy problems that the solver's tests share."""

from __future__ import annotations

import numpy as np

from arael.runtime.layout import Layout
from arael.runtime.store import Store
from tests.runtime import toy
from tests.runtime.toy import ROOT, Raw, Slot, Step

SELF = Slot((), "")


def line(precision: str = "f64", passes=()) -> Layout:
    """y = a x + b through points, weighted by 1/sigma of the root."""
    root = toy.table("", toy.param("a"), toy.param("b"), toy.data("sigma", default=1.0))
    points = toy.table("data", toy.data("x"), toy.data("y"))
    e = toy.entity(root)
    fit = toy.group(
        "Toy.fit",
        "data",
        [Slot((), "data"), ROOT],
        [(1, 0)],
        [e],
        lambda s, d, u: [(s[0][0] * d[0] + s[0][1] - d[1]) / u[0]],
        raw=[Raw(0, "x"), Raw(0, "y")],
        uniform=[Raw(1, "sigma")],
    )
    return toy.layout([root, points], [e], [fit], precision, passes)


def line_store(layout: Layout, n: int = 20) -> Store:
    store = Store(layout)
    x = np.linspace(0, 3, n)
    noise = np.random.Generator(np.random.PCG64(1)).normal(size=n)
    store.tables["data"].extend(n, x=x, y=2 * x - 1 + 0.1 * noise)
    return store


def root_only(names: int, formula, precision: str = "f64", low=(), high=()) -> Layout:
    """One vector `x` on the root and one constraint on it."""
    root = toy.table("", toy.param("x", names, low, high))
    e = toy.entity(root)
    only = toy.group("Toy.all", "", [SELF], [(0, 0)], [e], lambda s, d, u: formula(s[0]))
    return toy.layout([root], [e], [only], precision)


def at(layout: Layout, *x: float) -> Store:
    store = Store(layout)
    store.tables[""].column("x")[...] = np.array(x) if len(x) > 1 else x[0]
    return store


def rosenbrock(**settings) -> Layout:
    return root_only(2, lambda x: [10 * (x[1] - x[0] * x[0]), 1 - x[0]], **settings)


def powell() -> Layout:
    """Powell's singular function: minimum 0 at the origin, where J'J is singular."""
    return root_only(
        4,
        lambda x: [
            x[0] + 10 * x[1],
            (x[2] - x[3]) * 5**0.5,
            (x[1] - 2 * x[2]) * (x[1] - 2 * x[2]),
            10**0.5 * (x[0] - x[3]) * (x[0] - x[3]),
        ],
    )


def chain(precision: str = "f64") -> Layout:
    """Planar poses (pos, heading) with odometry between pairs and a prior on the first."""
    root = toy.table("", toy.data("weight", default=100.0))
    poses = toy.table("poses", toy.param("pos", 2), toy.param("heading", kind="angle"))
    pairs = toy.table(
        "pairs",
        toy.ref("a", "poses"),
        toy.ref("b", "poses"),
        toy.data("d", (3,)),
    )

    def refresh(g, old, step):
        moved = [a + b for a, b in zip(old, step, strict=True)]
        return [
            *moved[:2],
            toy.atan2(toy.sin(moved[2]), toy.cos(moved[2])),
            toy.sin(moved[2]),
            toy.cos(moved[2]),
        ]

    e = toy.entity(poses, refresh)

    def odometry(s, d, u):
        a, b = s
        dx, dy = b[0] - a[0], b[1] - a[1]
        s_t, c_t = b[3] * a[4] - b[4] * a[3], b[4] * a[4] + b[3] * a[3]
        return [
            a[4] * dx + a[3] * dy - d[0],
            a[4] * dy - a[3] * dx - d[1],
            toy.atan2(
                s_t * toy.cos(d[2]) - c_t * toy.sin(d[2]), c_t * toy.cos(d[2]) + s_t * toy.sin(d[2])
            ),
        ]

    def along(s):
        return [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, s[4], s[3] * -1.0]]

    odo = toy.group(
        "Pairs.odometry",
        "pairs",
        [Slot((Step("ref", "a"),), "poses"), Slot((Step("ref", "b"),), "poses"), Slot((), "pairs")],
        [(0, 0), (1, 0)],
        [e],
        odometry,
        raw=[Raw(2, "d", k) for k in range(3)],
        chain={0: along, 1: along},
    )
    drift = toy.group(
        "Poses.drift",
        "poses",
        [Slot((), "poses"), ROOT],
        [(0, 0)],
        [e],
        lambda s, d, u: [(s[0][k] - d[k]) / u[0] for k in range(3)],
        raw=[Raw(0, "pos", 0), Raw(0, "pos", 1), Raw(0, "heading")],
        uniform=[Raw(1, "weight")],
        chain={0: along},
    )
    return toy.layout([root, poses, pairs], [e], [odo, drift], precision)


def chain_store(layout: Layout, n: int = 12, loops: bool = True) -> Store:
    """A circle walked once, noisy start."""
    rng = np.random.Generator(np.random.PCG64(2))
    heading = 2 * np.pi * np.arange(n) / n
    pos = np.stack([np.sin(heading), 1 - np.cos(heading)], axis=1) * n / 6
    store = Store(layout)
    wrapped = np.angle(np.exp(1j * (heading + rng.normal(size=n) * 0.05)))
    store.tables["poses"].extend(n, pos=pos + rng.normal(size=(n, 2)) * 0.05, heading=wrapped)
    a = np.arange(n if loops else n - 1)
    b = (a + 1) % n
    c, s = np.cos(heading[a]), np.sin(heading[a])
    d = pos[b] - pos[a]
    measured = np.stack(
        [
            c * d[:, 0] + s * d[:, 1],
            c * d[:, 1] - s * d[:, 0],
            np.angle(np.exp(1j * (heading[b] - heading[a]))),
        ],
        axis=1,
    )
    measured += rng.normal(size=measured.shape) * 0.01
    store.tables["pairs"].extend(len(a), a=a, b=b, d=measured)
    return store
