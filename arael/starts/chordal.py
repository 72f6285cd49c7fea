"""The chordal start: rotations relaxed to matrices, projected, then positions.

D. Martinec and T. Pajdla, "Robust rotation and translation estimation in multiview
reconstruction", CVPR 2007. L. Carlone, R. Tron, K. Daniilidis, F. Dellaert, "Initialization
techniques for 3D SLAM: a survey on rotation estimation and its use in pose graph optimization",
ICRA 2015.
In the plane a rotation relaxes to a complex number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.starts.arithmetic import (
    add_rows,
    held_of,
    position_blocks,
    projected,
    rotation_blocks,
    spatial_weights,
)
from arael.starts.graph import PoseGraph, Poses
from arael.starts.relaxation import Coupling, Relaxation

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Least eigenvalue of the weight of an edge, as part of its trace: keeps the relaxation convex if
# one axis is measured much better than the two others.
_LEAST = 1e-3


def chordal_poses(graph: PoseGraph, coupling: Coupling | None = None) -> Poses:
    """Poses of the chordal relaxation, each measurement weighted by its information.

    Two sparse linear solves with the same pattern. Poses that are fixed keep their values; a
    component without a fixed pose or an anchor keeps its first pose.

    Parameters
    ----------
    coupling : pattern of the problem, whose ordering is then used

    Raises
    ------
    SingularError
        If the measurements do not determine every pose.
    """
    relaxation = Relaxation(len(graph.poses), graph.dimension, graph.a, graph.b, coupling)
    rotation = _rotations(graph, relaxation)
    return Poses(rotation, _positions(graph, relaxation, rotation))


def _held(graph: PoseGraph, fixed: Bools, weight: Array) -> Bools:
    """Poses with a fixed part, and the first of each component without fixed or anchored ones."""
    return held_of(graph.component, fixed, graph.anchors.pose, weight)


def _rotations(graph: PoseGraph, relaxation: Relaxation) -> Array:
    """(n, d, d) rotations that minimise the weighted chordal distances, projected.

    The unknown is X = R', world to body, whose columns are independent of each other (in the plane
    one column is enough). The residual ``X_b - Rm' X_a`` has rows along the axes of `b`, in which
    the information is given, and ``|W^(1/2) (X_b - Rm' X_a)|^2 = theta' (tr(W) I - W) theta`` for a
    small error theta; so W = tr(information) / 2 I - information.
    """
    d, anchors = graph.dimension, graph.anchors
    columns = 1 if d == 2 else 3
    step = graph.measured.rotation
    weight = _chordal_weight(graph.rotation_information, d)
    blocks = rotation_blocks(np.ascontiguousarray(step), np.ascontiguousarray(weight))
    square = anchors.rotation_weight**2 / (1 if d == 2 else 2)
    target = anchors.measured.rotation.transpose(0, 2, 1)[:, :, :columns]
    own, right = _absolute(graph, square, target)
    held = _held(graph, graph.fixed_rotation, anchors.rotation_weight)
    at = graph.poses.rotation.transpose(0, 2, 1)[:, :, :columns]
    relaxed = relaxation.solved(blocks, own, right, held, at)
    found = _projected(relaxed)
    return np.where(held[:, None, None], graph.poses.rotation, found)


def _chordal_weight(information: Array, d: int) -> Array:
    """(m, d, d) weights of the chordal residual's rows from the information of rotations."""
    if d == 2:
        planar: Array = information * np.eye(2)
        return planar
    found, below = spatial_weights(np.ascontiguousarray(information), _LEAST)
    if below is not None:
        # What has overflowed has no eigenvalues; the linear system is refused with it.
        below &= np.isfinite(found).all(axis=(1, 2))
        trace = np.trace(information[below], axis1=1, axis2=2)
        values, vectors = np.linalg.eigh(found[below])
        values = np.maximum(values, _LEAST * trace[:, None])
        found[below] = (vectors * values[:, None, :]) @ vectors.transpose(0, 2, 1)
    return found


def _absolute(graph: PoseGraph, square: Array, target: Array) -> tuple[Array, Array]:
    """(n, d, d) diagonal blocks and (n, d, k) right-hand sides of absolute measurements."""
    n, d = len(graph.poses), graph.dimension
    own, right = np.zeros((n, d, d)), np.zeros((n, d, target.shape[2]))
    if len(square):
        weight = square[:, None, None]
        add_rows(own, graph.anchors.pose, weight * np.eye(d), 1.0)
        add_rows(right, graph.anchors.pose, np.ascontiguousarray(weight * target), 1.0)
    return own, right


def _projected(relaxed: Array) -> Array:
    """(n, d, d) nearest rotations, transposed: of 3 x 3 matrices, of planar columns by length."""
    found, left = projected(relaxed)
    if left is not None:
        u, _, vt = np.linalg.svd(relaxed[left])
        turned = np.ones((len(u), 3))
        turned[:, 2] = np.where(np.linalg.det(u) * np.linalg.det(vt) < 0, -1.0, 1.0)
        found[left] = ((u * turned[:, None, :]) @ vt).transpose(0, 2, 1)
    return found


def _positions(graph: PoseGraph, relaxation: Relaxation, rotation: Array) -> Array:
    """(n, d) positions that minimise the cost at these rotations: it is quadratic in them."""
    a, b, anchors = graph.a, graph.b, graph.anchors
    block, pull = position_blocks(
        graph.measured.rotation, graph.measured.position, graph.information, rotation, a, b
    )
    own, right = _absolute(graph, anchors.position_weight**2, anchors.measured.position[:, :, None])
    add_rows(right, b, pull, 1.0)
    add_rows(right, a, pull, -1.0)
    held = _held(graph, graph.fixed_position, anchors.position_weight)
    at = graph.poses.position[:, :, None]
    found = relaxation.solved((block, -block, block), own, right, held, at)[:, :, 0]
    return np.where(held[:, None], graph.poses.position, found)
