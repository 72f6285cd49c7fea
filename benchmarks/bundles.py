"""Generated bundles in BAL's format: cameras on a ring that look outwards, points around them.

Every point has an anchor camera, lies 4 to 12 m before it, and is seen by a geometrically
distributed number of the cameras around; pixels have noise of one pixel, the start is off by a
little in all parameters. No residual holds the whole: as in the public sets, seven directions are
free.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

from arael.runtime.store.rotations import quaternion_from_vector, vector_from_quaternion

Array = NDArray[np.float64]

FOCAL, K1, K2 = 800.0, -0.05, 0.01
SPACING = 0.5
"""Between cameras along the ring [m]."""
OBSERVATIONS = 6.0
"""Cameras that see a point, on average."""


def write_bundle(path: Path, cameras: int, points: int, seed: int = 42) -> int:
    """Write a bundle; return the number of its observations."""
    rng = Generator(PCG64(seed))
    rotation, centre = _ring(cameras)
    anchor = rng.integers(0, cameras, points)
    local = np.column_stack(
        [rng.uniform(-3, 3, points), rng.uniform(-2, 2, points), -rng.uniform(4, 12, points)]
    )
    world = np.einsum("kji,kj->ki", rotation[anchor], local) + centre[anchor]
    camera, point = _seen(rng, anchor, cameras)
    body = np.einsum("kij,kj->ki", rotation[camera], world[point] - centre[camera])
    before = body[:, 2] < -1.0
    wide = np.abs(body[:, :2]).max(axis=1) < -body[:, 2]
    camera, point, body = (part[before & wide] for part in (camera, point, body))
    # A point needs two rays.
    enough = np.bincount(point, minlength=points)[point] >= 2
    camera, point, body = camera[enough], point[enough], body[enough]
    used, point = np.unique(point, return_inverse=True)
    pixel = _project(body) + rng.normal(0.0, 1.0, (len(body), 2))

    vectors = vector_from_quaternion(_quaternions(rotation)) + rng.normal(0, 0.003, (cameras, 3))
    start = centre + rng.normal(0, 0.02, (cameras, 3))
    turned = _matrices(quaternion_from_vector(vectors))
    shift = -np.einsum("kij,kj->ki", turned, start)
    lens = np.array([FOCAL, K1, K2]) * (1 + rng.normal(0, [0.01, 0.0, 0.0], (cameras, 3)))
    world = world[used] + rng.normal(0, 0.05, (len(used), 3))
    _write(path, camera, point, pixel, np.hstack([vectors, shift, lens]), world)
    return len(camera)


def write_bal(path: Path, bundle: Any) -> None:
    """Write an instance of `bundle_adjustment` in BAL's format."""
    cameras = bundle.cameras
    vectors = vector_from_quaternion(np.asarray(cameras.r.value, dtype=np.float64))
    lens = np.column_stack([cameras[name].value for name in ("f", "k1", "k2")])
    rows = np.hstack([vectors, cameras.t.value, lens])
    seen = bundle._store.tables["observations"]
    camera, point = seen.target_rows("camera"), seen.target_rows("point")
    pixel = np.array(bundle.observations.pixel)
    _write(path, camera, point, pixel, rows, np.array(bundle.points.pos.value), "{!r}")


def _write(
    path: Path,
    camera: NDArray[np.int64],
    point: NDArray[np.int64],
    pixel: Array,
    cameras: Array,
    points: Array,
    form: str = "{:.6f}",
) -> None:
    """Write a file; pixels (n, 2) in a form, cameras (n, 9) and points (n, 3) exactly."""
    pair = f"{form} {form}"
    with path.open("w", encoding="ascii") as file:
        file.write(f"{len(cameras)} {len(points)} {len(camera)}\n")
        for c, p, (x, y) in zip(camera, point, pixel, strict=True):
            file.write(f"{c} {p} {pair.format(float(x), float(y))}\n")
        for row in [*cameras, *points]:
            file.write("\n".join(repr(float(v)) for v in row) + "\n")


def _ring(cameras: int) -> tuple[Array, Array]:
    """World-to-camera rotations (n, 3, 3) and centres (n, 3); cameras look along their -z."""
    angle = 2 * np.pi * np.arange(cameras) / cameras
    radius = SPACING * cameras / (2 * np.pi)
    out = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(cameras)])
    right = np.column_stack([np.sin(angle), -np.cos(angle), np.zeros(cameras)])
    up = np.tile([0.0, 0.0, 1.0], (cameras, 1))
    return np.stack([right, up, -out], axis=1), radius * out


def _seen(
    rng: Generator, anchor: NDArray[np.int64], cameras: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Camera and point of every sighting: the anchor and cameras around it, no pair twice."""
    points = len(anchor)
    reach = min(cameras // 2, 20)
    count = np.minimum(1 + rng.geometric(1 / (OBSERVATIONS - 1), points), 2 * reach)
    point = np.repeat(np.arange(points), count)
    nth = np.arange(len(point)) - np.repeat(np.cumsum(count) - count, count)
    # 0, 1, -1, 2, -2 ... with now and then one left out.
    step = (nth + 1) // 2 * np.where(nth % 2, 1, -1)
    kept = (nth == 0) | (rng.random(len(point)) < 0.97)
    return ((anchor[point] + step) % cameras)[kept], point[kept]


def _project(body: Array) -> Array:
    plane: Array = -body[:, :2] / body[:, 2:]
    square = np.einsum("ki,ki->k", plane, plane)
    return FOCAL * (1 + square * (K1 + K2 * square))[:, None] * plane


def _quaternions(matrices: Array) -> Array:
    """Unit quaternions (n, 4), w x y z, of rotations with a trace over -1."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrices).as_quat()[:, [3, 0, 1, 2]])


def _matrices(quaternions: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix())
