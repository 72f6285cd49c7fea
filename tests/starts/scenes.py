"""Pose graphs on surfaces, with noise of known strength: many loops, and odometry that drifts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.starts.columns import angles, planar, quaternions
from arael.starts.graph import Poses

Array = NDArray[np.float64]


def sphere(rings: int, around: int, radius: float = 10.0) -> Poses:
    """Rings from pole to pole, each looking along its way, with the normal as z."""
    lat = np.repeat(np.linspace(-1.3, 1.3, rings), around)
    lon = np.tile(np.arange(around) * 2 * np.pi / around, rings)
    c, s = np.cos(lon), np.sin(lon)
    normal = np.column_stack([np.cos(lat) * c, np.cos(lat) * s, np.sin(lat)])
    return _on_surface(radius * normal, np.column_stack([-s, c, 0 * c]), normal)


def torus(rings: int, around: int, major: float = 10.0, minor: float = 4.0) -> Poses:
    """Rings round the tube, one beside the other round the whole torus."""
    big = np.repeat(np.arange(rings) * 2 * np.pi / rings, around)
    small = np.tile(np.arange(around) * 2 * np.pi / around, rings)
    out = np.column_stack([np.cos(big), np.sin(big), 0 * big])
    up = np.array([0.0, 0.0, 1.0])
    normal = np.cos(small)[:, None] * out + np.sin(small)[:, None] * up
    along = -np.sin(small)[:, None] * out + np.cos(small)[:, None] * up
    return _on_surface(major * out + minor * normal, along, normal)


def grid(rows: int, columns: int) -> Poses:
    """Planar poses along the rows of a grid, each row in the other direction."""
    y, x = np.divmod(np.arange(rows * columns), columns)
    back = y % 2 == 1
    x = np.where(back, columns - 1 - x, x)
    return Poses(planar(np.where(back, np.pi, 0.0)), np.column_stack([x, y]).astype(float))


def neighbours(rings: int, around: int, closed: bool) -> NDArray[np.int64]:
    """Edges from each pose to the next, and to the one beside it in the next ring."""
    n = rings * around
    i = np.arange(n)
    beside = np.column_stack([i, (i + around) % n])[: n if closed else n - around]
    return np.concatenate([np.column_stack([i[:-1], i[1:]]), beside])


def measured(
    rng: np.random.Generator, truth: Poses, ends: NDArray[np.int64], turn: float, shift: float
) -> Poses:
    """Relative poses with normal noise of `turn` [rad] and `shift` [m] along each axis."""
    exact = truth[ends[:, 0]].inverse() @ truth[ends[:, 1]]
    vectors = rng.normal(0, turn, (len(ends), 1 if truth.dimension == 2 else 3))
    noise = Poses(rotations(vectors), rng.normal(0, shift, exact.position.shape))
    return Poses(exact.rotation @ noise.rotation, exact.position + noise.position)


def model_of(truth: Poses, ends: NDArray[np.int64], edges: Poses, turn: float, shift: float) -> Any:
    """The model with these edges, its poses at the truth and the first one fixed."""
    d = truth.dimension
    sigmas = np.array([shift] * d + [turn] * (1 if d == 2 else 3))
    graph = arael.load(f"pose_graph_{d}d")()
    graph.poses.extend(len(truth), **fields(truth))
    u = np.tile(np.diag(1 / sigmas), (len(ends), 1, 1))
    graph.edges.extend(len(ends), a=ends[:, 0], b=ends[:, 1], u=u, **fields(edges))
    graph.poses[0].t.fixed = True
    graph.poses[0]["th" if d == 2 else "q"].fixed = True
    return graph


def place(graph: Any, poses: Poses) -> None:
    """Put poses into a model."""
    for name, values in fields(poses).items():
        graph.poses[name].value[...] = values


def odometry(truth: Poses, edges: Poses) -> Poses:
    """Poses composed from each to the next, from the first one's true pose."""
    found = [truth[np.array([0])]]
    for i in range(len(truth) - 1):
        found.append(found[-1] @ edges[np.array([i])])
    return Poses(
        np.concatenate([p.rotation for p in found]), np.concatenate([p.position for p in found])
    )


def fields(poses: Poses) -> dict[str, Array]:
    """Columns of the model."""
    if poses.dimension == 2:
        return {"t": poses.position, "th": angles(poses.rotation)}
    return {"t": poses.position, "q": quaternions(poses.rotation)}


def rotations(vectors: Array) -> Array:
    """(n, 1) angles or (n, 3) rotation vectors -> rotations, by Rodrigues' formula."""
    if vectors.shape[1] == 1:
        return planar(vectors[:, 0])
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = (vectors / np.maximum(angle[:, 0], 1e-300)).T
    zero = 0 * x
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(-1, 3, 3)
    found: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return found


def _on_surface(position: Array, along: Array, normal: Array) -> Poses:
    return Poses(np.stack([along, np.cross(normal, along), normal], axis=-1), position)
