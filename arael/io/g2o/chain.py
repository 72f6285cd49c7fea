"""Start values of a graph that has no vertices: poses composed along the edges."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.g2o.kinds import Kind

Array = NDArray[Any]
Pose = tuple[float, ...]


def poses_along(kind: Kind, count: int, edges: Sequence[tuple[int, int]], measured: Array) -> Array:
    """Poses (count, size) as the file would have them, the first at the origin.

    A spanning tree from the first pose takes edges from a pose to the next one (odometry) first, in
    file order, and others only where those do not lead on. Each part of a graph that is not
    connected starts at the origin.

    Parameters
    ----------
    kind : of the graph
    count : number of poses
    edges : rows of both ends of each edge
    measured : (m, size) pose of the second end in the frame of the first
    """
    compose, inverse, origin = (
        (_compose2, _inverse2, (0.0, 0.0, 0.0))
        if kind.size == 3
        else (_compose3, _inverse3, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    )
    steps: list[Pose] = [tuple(row) for row in measured.tolist()]
    incident: list[list[int]] = [[] for _ in range(count)]
    for i, (a, b) in enumerate(edges):
        incident[a].append(i)
        incident[b].append(i)
    placed: list[Pose | None] = [None] * count
    for start in range(count):
        if placed[start] is not None:
            continue
        placed[start] = origin
        odometry, others = deque([start]), deque([start])
        while odometry or others:
            near = bool(odometry)
            row = odometry.popleft() if near else others.popleft()
            here = placed[row]
            assert here is not None
            for i in incident[row]:
                a, b = edges[i]
                if near and b != a + 1:
                    continue
                other = b if a == row else a
                if placed[other] is not None:
                    continue
                placed[other] = compose(here, steps[i] if a == row else inverse(steps[i]))
                odometry.append(other)
                others.append(other)
                if not near:
                    others.appendleft(row)  # its other edges wait until odometry leads no further
                    break
    return np.array(placed, dtype=np.float64).reshape(count, kind.size)


def _compose2(a: Pose, b: Pose) -> Pose:
    x, y, th = a
    c, s = math.cos(th), math.sin(th)
    heading = math.remainder(th + b[2], 2 * math.pi)
    return (x + c * b[0] - s * b[1], y + s * b[0] + c * b[1], heading)


def _inverse2(a: Pose) -> Pose:
    x, y, th = a
    c, s = math.cos(th), math.sin(th)
    return (-c * x - s * y, s * x - c * y, -th)


def _compose3(a: Pose, b: Pose) -> Pose:
    x, y, z = _rotate(a[3:], b[:3])
    q = _product(a[3:], b[3:])
    norm = math.sqrt(sum(v * v for v in q))
    return (a[0] + x, a[1] + y, a[2] + z, *(v / norm for v in q))


def _inverse3(a: Pose) -> Pose:
    qx, qy, qz, qw = a[3:]
    back = (-qx, -qy, -qz, qw)
    x, y, z = _rotate(back, a[:3])
    return (-x, -y, -z, *back)


def _product(a: Pose, b: Pose) -> Pose:
    """Quaternion product, scalar last."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotate(q: Pose, v: Pose) -> Pose:
    """``v + 2 w (u x v) + 2 u x (u x v)`` with u the vector part."""
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )
