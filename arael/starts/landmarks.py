"""Positions of landmarks from poses and measurements."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.store import Store
from arael.starts.arithmetic import planar
from arael.starts.columns import has_landmarks, poses_of, rotation_column

Array = NDArray[np.float64]

# Least information of a direction relative to the best known one of the landmark, by which it
# counts as measured: two bearings that differ by 0.1 degrees are below.
_LEAST = 1e-6


def place_landmarks(store: Store) -> None:
    """Place the free landmarks of a pose graph where its poses see them.

    The weighted linear least-squares solution of each landmark for the present poses, where a
    bearing counts as the distance from its line. What is not measured of a position stays.
    """
    if not has_landmarks(store) or not store.tables["landmarks"].size:
        return
    tables, name = store.tables, rotation_column(store)
    poses, landmarks = poses_of(tables["poses"], name), tables["landmarks"]
    count, d = landmarks.size, poses.dimension
    weight, right = np.zeros((count, d, d)), np.zeros((count, d))

    def add(rows: Any, information: Array, target: Array) -> None:
        there = rows >= 0
        np.add.at(weight, rows[there], information[there])
        np.add.at(right, rows[there], np.einsum("nij,nj->ni", information, target)[there])

    seen = tables["observations"]
    at = poses[seen.target_rows("a")]
    u = _copied(seen, "u") @ at.rotation.transpose(0, 2, 1)
    moved = np.einsum("nij,nj->ni", at.rotation, _copied(seen, "t"))
    add(seen.target_rows("b"), u.transpose(0, 2, 1) @ u, at.position + moved)

    if d == 2 and "bearings" in tables:
        lines = tables["bearings"]
        at = poses[lines.target_rows("a")]
        across = (at.rotation @ planar(_copied(lines, "th")))[:, :, 1]
        square = _copied(lines, "isigma") ** 2
        add(
            lines.target_rows("b"),
            square[:, None, None] * across[:, :, None] * across[:, None, :],
            at.position,
        )
    if "landmark_anchors" in tables:
        known = tables["landmark_anchors"]
        u = _copied(known, "u")
        add(known.target_rows("landmark"), u.transpose(0, 2, 1) @ u, _copied(known, "t"))

    column = landmarks.column("t")
    free = landmarks.free_as_a_whole("t").reshape(count, -1)
    left = right - np.einsum("nij,nj->ni", weight, column)
    finite = np.isfinite(weight).all(axis=(1, 2)) & np.isfinite(left).all(axis=1)
    back = np.linalg.pinv(np.where(finite[:, None, None], weight, 0.0), _LEAST, hermitian=True)
    found = column + np.einsum("nij,nj->ni", back, np.where(finite[:, None], left, 0.0))
    np.copyto(column, found, where=free)


def _copied(table: Any, path: str) -> Array:
    return np.array(table.column(path), dtype=np.float64, order="C")
