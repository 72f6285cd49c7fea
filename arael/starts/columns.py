"""Pose graphs in a model's columns: read as arrays, and poses written back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.store import Store, Table, rotations
from arael.starts.graph import Anchors, PoseGraph, Poses

Array = NDArray[np.float64]

# Column of the rotation -> its shape, the shapes of a position and of an edge's factor.
_KINDS: dict[str, tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]] = {
    "th": ((), (2,), (3, 3)),
    "q": ((4,), (3,), (6, 6)),
}


def rotation_column(store: Store) -> str:
    """Column of a pose's rotation, ``th`` or ``q``; "" if the model is not a pose graph.

    A pose graph has the collections ``poses`` with the parameters ``t`` and ``th`` or ``q``, and
    ``edges`` with the refs ``a`` and ``b`` to poses, the measured ``t`` and ``th`` or ``q``, and
    the upper Cholesky factor ``u`` of the information, as `pose_graph_2d` and `pose_graph_3d`.
    """
    if not {"poses", "edges"} <= store.tables.keys():
        return ""
    poses, edges = store.tables["poses"], store.tables["edges"]
    for name, (rotation, position, factor) in _KINDS.items():
        shapes = {"t": position, name: rotation}
        if (
            _has(poses, shapes, "param")
            and _has(edges, {**shapes, "u": factor}, "data")
            and all(_leads_to_poses(edges, end) for end in ("a", "b"))
        ):
            return name
    return ""


def graph_of(store: Store) -> PoseGraph:
    """The pose graph of a model, as copies in f64."""
    name = rotation_column(store)
    poses, edges = store.tables["poses"], store.tables["edges"]
    factor = edges.column("u").astype(np.float64)
    return PoseGraph(
        _poses(poses, name),
        edges.target_rows("a").copy(),
        edges.target_rows("b").copy(),
        _poses(edges, name),
        factor.transpose(0, 2, 1) @ factor,
        ~poses.free("t"),
        ~poses.free(name),
        _anchors(store, name),
    )


def put(store: Store, found: Poses) -> None:
    """Write poses into the model, except fixed parts."""
    name = rotation_column(store)
    table = store.tables["poses"]
    values = angles(found.rotation) if name == "th" else quaternions(found.rotation)
    for path, new in (("t", found.position), (name, values)):
        free = table.free(path)
        table.column(path)[free] = new[free]


def planar(angle: Array) -> Array:
    """(n,) angles -> (n, 2, 2) rotations."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def angles(rotation: Array) -> Array:
    """(n, 2, 2) rotations -> (n,) angles in [-pi, pi]."""
    found: Array = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    return found


def quaternions(rotation: Array) -> Array:
    """(n, 3, 3) rotations -> (n, 4) unit quaternions, scalar first."""
    found: Array = rotations.normalised(rotations.quaternion_from_matrix(rotation))
    return found


def _poses(table: Table, name: str) -> Poses:
    rotation = table.column(name).astype(np.float64)
    turned = planar(rotation) if name == "th" else rotations.matrix_from_quaternion(rotation)
    return Poses(turned, table.column("t").astype(np.float64))


def _anchors(store: Store, name: str) -> Anchors:
    """Absolute measurements, in a collection ``anchors`` as in the standard models."""
    rotation, position, _ = _KINDS[name]
    table = store.tables.get("anchors")
    if (
        table is None
        or not _has(table, {"t": position, name: rotation}, "data")
        or not _leads_to_poses(table, "pose")
    ):
        return Anchors.none(position[0])
    return Anchors(
        table.target_rows("pose").copy(),
        _poses(table, name),
        _weights(table, "t_isigma"),
        _weights(table, "th_isigma"),
    )


def _weights(table: Table, path: str) -> Array:
    """Inverse standard deviations; 1 if the model has no column for them."""
    if path not in table.data:
        return np.ones(table.size)
    return table.column(path).astype(np.float64)


def _has(table: Table, shapes: dict[str, tuple[int, ...]], role: str) -> bool:
    return all(
        path in table.data and table.data[path].shape == shape and table.data[path].role == role
        for path, shape in shapes.items()
    )


def _leads_to_poses(table: Table, path: str) -> bool:
    target: Any = table.data[path].target if path in table.data else None
    return target is not None and target.table == "poses"
