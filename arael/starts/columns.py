"""Pose graphs in a model's columns: read as arrays, and poses written back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.bounds import ends_of
from arael.runtime.store import Store, Table
from arael.starts.arithmetic import all_there, angles, information_of, matrices, planar, quaternions
from arael.starts.graph import Anchors, PoseGraph, Poses

__all__ = [
    "angles", "graph_of", "has_landmarks", "planar", "poses_of", "put", "quaternions",
    "residuals_of", "rotation_column",
]  # fmt: skip

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
    # Kept with the layout, on which alone it depends.
    kept = store.layout.__dict__
    found = kept.get("_rotation_column")
    if found is None:
        found = kept["_rotation_column"] = _rotation_column(store)
    return str(found)


def _rotation_column(store: Store) -> str:
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


def graph_of(store: Store, name: str = "") -> PoseGraph:
    """The pose graph of a model, as copies in f64; `name` is its `rotation_column`, if known.

    Measurements whose ref to a pose is null measure nothing, and are left out.
    """
    name = name or rotation_column(store)
    poses, edges = store.tables["poses"], store.tables["edges"]
    information, coupled = information_of(_copied(edges, "u"))
    a, b, measured = edges.target_rows("a"), edges.target_rows("b"), poses_of(edges, name)
    if not all_there(a, b):
        there = (a >= 0) & (b >= 0)
        a, b, measured, information = a[there], b[there], measured[there], information[there]
    return PoseGraph(
        poses_of(poses, name),
        a.copy(),
        b.copy(),
        measured,
        information,
        ~poses.free_as_a_whole("t"),
        ~poses.free_as_a_whole(name),
        _anchors(store, name),
        coupled,
    )


def residuals_of(store: Store) -> int:
    """Number of residuals of the measurements between poses and landmarks."""
    edges = store.tables["edges"]
    count = edges.size * edges.data["u"].shape[0]
    if has_landmarks(store):
        seen = store.tables["observations"]
        count += seen.size * seen.data["u"].shape[0]
        count += store.tables["bearings"].size if "bearings" in store.tables else 0
    return count


def has_landmarks(store: Store) -> bool:
    """Whether the model has landmarks, as the standard models have.

    These are the collections ``landmarks`` with the parameter ``t``, and ``observations`` with the
    refs ``a`` to a pose and ``b`` to a landmark, the measured ``t``, and the factor ``u``.
    """
    if not {"landmarks", "observations"} <= store.tables.keys():
        return False
    position = store.tables["poses"].data["t"].shape
    landmarks, seen = store.tables["landmarks"], store.tables["observations"]
    target: Any = seen.data["b"].target if "b" in seen.data else None
    return (
        _has(landmarks, {"t": position}, "param")
        and _has(seen, {"t": position, "u": (*position, *position)}, "data")
        and _leads_to_poses(seen, "a")
        and target is not None
        and target.table == "landmarks"
    )


def put(store: Store, found: Poses, name: str = "", graph: PoseGraph | None = None) -> None:
    """Write poses into the model, within bounds, except fixed parts.

    `name` is its `rotation_column`, if known; `graph` its pose graph, which knows what is fixed.
    """
    name = name or rotation_column(store)
    table = store.tables["poses"]
    values = angles(found.rotation) if name == "th" else quaternions(found.rotation)
    free = (
        (table.free_as_a_whole("t"), table.free_as_a_whole(name))
        if graph is None
        else (~graph.fixed_position, ~graph.fixed_rotation)
    )
    for path, new, moves in (("t", found.position, free[0]), (name, values, free[1])):
        low, high = ends_of(table, table.data[path])
        if low is not None:
            new = np.maximum(new, low.reshape(-1, *new.shape[1:]))
        if high is not None:
            new = np.minimum(new, high.reshape(-1, *new.shape[1:]))
        np.copyto(table.column(path), new, where=moves.reshape(-1, *[1] * (new.ndim - 1)))


def poses_of(table: Table, name: str, prefix: str = "") -> Poses:
    """Poses of a table as transforms; `name` is the column of their rotations."""
    rotation = _copied(table, f"{prefix}{name}")
    turned = planar(rotation) if name == "th" else matrices(rotation)
    return Poses(turned, _copied(table, f"{prefix}t"))


def _copied(table: Table, path: str) -> Array:
    """A column as an array of its own, f64."""
    return np.array(table.column(path), dtype=np.float64, order="C")


def _anchors(store: Store, name: str) -> Anchors:
    """Absolute measurements, in a collection ``anchors`` as in the standard models."""
    rotation, position, _ = _KINDS[name]
    table = store.tables.get("anchors")
    if (
        table is None
        or not table.size
        or not _has(table, {"t": position, name: rotation}, "data")
        or not _leads_to_poses(table, "pose")
    ):
        return Anchors.none(position[0])
    pose = table.target_rows("pose")
    there = pose >= 0
    weights = [_weights(table, path) for path in ("t_isigma", "th_isigma")]
    if "u" in table.data and table.data["u"].shape == _KINDS[name][2]:
        d = position[0]
        square = np.einsum("nij,nij->nj", u := _copied(table, "u"), u)
        weights[0] *= np.sqrt(square[:, :d].mean(axis=1))
        weights[1] *= np.sqrt(square[:, d:].mean(axis=1))
    measured = poses_of(table, name)
    if {"offset_t", f"offset_{name}"} <= table.data.keys():  # of a sensor, in the axes of its pose
        measured = measured @ poses_of(table, name, "offset_").inverse()
    return Anchors(pose[there], measured[there], *(w[there] for w in weights))


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
