"""A path of 200 poses around obstacles, as a model with refs and as a CasADi expression."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

TEXT = """
struct Knot {
    param p: vec2
    next: ref Knot in root.knots?
    prev: ref Knot in root.knots?
    held: bool = false
    place: vec2 = [0, 0]
    constraint smooth when next and prev { (next.p - 2 * p + prev.p) * 100 }
    constraint short when next { next.p - p }
    require at when held { p == place }
}
struct Near {
    knot: ref Knot in root.knots
    obstacle: ref Obstacle in root.obstacles
    require clear { norm(knot.p - obstacle.centre) >= obstacle.radius }
}
struct Obstacle {
    centre: vec2
    radius: real
}
root Path {
    knots: list of Knot
    obstacles: list of Obstacle
    pairs: list of Near
}
"""

OBSTACLES = (
    ((2.0, 0.2), 0.8),
    ((4.5, -0.3), 1.0),
    ((7.0, 0.5), 0.9),
    ((8.5, -0.8), 0.7),
)


def start(count: int) -> np.ndarray:
    """(count, 2) a flat arc that runs through the obstacles."""
    x = np.linspace(0, 10, count)
    return np.column_stack((x, 0.3 * np.sin(math.pi * x / 10)))


def build(loaded: Any, count: int) -> Any:
    """An instance at its start."""
    model = loaded()
    x = start(count)
    numbers = np.arange(count)
    model.knots.extend(
        p=x,
        next=np.where(numbers + 1 < count, numbers + 1, -1),
        prev=numbers - 1,
        held=(numbers == 0) | (numbers == count - 1),
        place=np.where((numbers == 0)[:, None], [0.0, 0.0], [10.0, 0.0]),
    )
    model.obstacles.extend(
        centre=[centre for centre, _ in OBSTACLES], radius=[radius for _, radius in OBSTACLES]
    )
    of = len(OBSTACLES)
    model.pairs.extend(knot=np.repeat(numbers, of), obstacle=np.tile(np.arange(of), count))
    return model


def casadi(ca: Any, count: int) -> dict[str, Any]:
    """The same as arguments of ``nlpsol`` and of its call."""
    x = ca.SX.sym("x", 2, count)
    bends = 100 * (x[:, 2:] - 2 * x[:, 1:-1] + x[:, :-2])
    moves = x[:, 1:] - x[:, :-1]
    g = [x[:, 0], x[:, -1] - ca.DM([10, 0])]
    for centre, radius in OBSTACLES:
        off = x - ca.repmat(ca.DM(centre), 1, count)
        g.append((ca.sqrt(ca.sum1(off**2)) - radius).T)
    size = len(OBSTACLES) * count
    return {
        "nlp": {
            "x": ca.vec(x),
            "f": ca.sumsqr(bends) + ca.sumsqr(moves),
            "g": ca.vertcat(*g),
        },
        "call": {
            "x0": start(count).ravel(),
            "lbg": [0.0] * (4 + size),
            "ubg": [0.0] * 4 + [math.inf] * size,
        },
    }
