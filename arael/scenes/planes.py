"""A synthetic map of planes: poses along a path between walls, floors and ceilings.

Every plane has an anchor pose and is visible from the poses around it. Walls are at a random
bearing, 2 to 8 m from their anchor and slightly tilted; every fifth plane is a floor 1 m below or a
ceiling 1.5 m above. A pose observes a plane within its range with probability 0.9, if it is at
least 0.2 m in front of it; normal and distance are measured with noise, and so is the odometry.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

from arael.geometry import rotation_matrix
from arael.scenes.columns import Columns
from arael.scenes.evaluate import motions
from arael.scenes.trajectory import TrajectoryName, trajectory

Array = NDArray[np.float64]
Index = NDArray[np.int64]

NEAR, FAR = 2.0, 8.0
"""Distance of a wall from its anchor pose [m]."""
FLOOR, CEILING = 1.0, 1.5
"""Distance of floors and ceilings from the path [m]."""
FRONT = 0.2
"""Smallest distance of an observation [m]."""
SEEN = 0.9
REACH = 15
"""A plane is visible from this many poses before and after its anchor."""


@dataclass(frozen=True)
class PlaneConfig:
    """Options of `make_plane_scene`.

    Attributes
    ----------
    poses, planes : numbers; None: one plane for two poses
    trajectory, seed : as in `SceneConfig`
    normal_sigma, distance_sigma : noise of an observation [rad, m]
    odometry_pos_sigma, odometry_ea_sigma : noise of the odometry per axis [m, rad]
    start_pos, start_ea : standard deviation of the poses' start per axis [m, rad]
    start_normal, start_distance : the same of the planes' [rad, m]
    """

    poses: int = 300
    planes: int | None = None
    trajectory: TrajectoryName = "s-curve"
    seed: int = 42
    normal_sigma: float = float(np.deg2rad(0.5))
    distance_sigma: float = 0.02
    odometry_pos_sigma: float = 0.05
    odometry_ea_sigma: float = float(np.deg2rad(0.5))
    start_pos: float = 0.05
    start_ea: float = 0.01
    start_normal: float = 0.02
    start_distance: float = 0.1

    def __post_init__(self) -> None:
        if self.poses < 2:
            raise ValueError(f"poses: expected at least 2, found {self.poses}")
        if self.planes is not None and self.planes < 1:
            raise ValueError(f"planes: expected at least 1, found {self.planes}")

    @property
    def plane_count(self) -> int:
        """Number of planes to generate."""
        return max(self.poses // 2, 4) if self.planes is None else self.planes


@dataclass(frozen=True)
class PlaneScene:
    """A scene of n poses and m planes, all of them observed.

    Attributes
    ----------
    pos, ea : (n, 3) true poses [m, rad]
    normals, offsets : (m, 3) and (m,) true planes ``n.x + c = 0``
    seen_pose, seen_plane : (k,) pose and plane of each observation
    seen_normal, seen_distance : (k, 3) and (k,) the measurements, in the body frame
    delta_pos, delta_ea : (n - 1, 3) measured motion from pose to pose
    start_pos, start_ea, start_normals, start_offsets : initial values
    """

    config: PlaneConfig
    pos: Array
    ea: Array
    normals: Array
    offsets: Array
    seen_pose: Index
    seen_plane: Index
    seen_normal: Array
    seen_distance: Array
    delta_pos: Array
    delta_ea: Array
    start_pos: Array
    start_ea: Array
    start_normals: Array
    start_offsets: Array

    @property
    def columns(self) -> Columns:
        """Columns for the standard model ``plane_slam``, as `fill` takes them."""
        count = len(self.pos)
        return {
            "poses.pos": self.start_pos,
            "poses.ea": self.start_ea,
            "planes.n": self.start_normals,
            "planes.c": self.start_offsets,
            "observations.pose": self.seen_pose,
            "observations.plane": self.seen_plane,
            "observations.n": self.seen_normal,
            "observations.c": self.seen_distance,
            "pose_pairs.prev": np.arange(count - 1),
            "pose_pairs.cur": np.arange(1, count),
            "pose_pairs.delta_pos": self.delta_pos,
            "pose_pairs.delta_ea": self.delta_ea,
            "anchors.pose": np.zeros(1, dtype=np.int64),
            "anchors.pos": self.pos[:1],
            "anchors.ea": self.ea[:1],
        }


def make_plane_scene(config: PlaneConfig | None = None) -> PlaneScene:
    """Generate the scene of `config`, reproducibly."""
    config = config or PlaneConfig()
    placing, seeing, measuring, starting = Generator(PCG64(config.seed)).spawn(4)
    pos, ea = trajectory(config.trajectory, config.poses)
    rotation = rotation_matrix(ea)
    normals, offsets, anchors = _place(config, pos, placing)
    pose, plane = _visible(config, pos, normals, offsets, anchors, seeing)

    used, plane = np.unique(plane, return_inverse=True)
    normals, offsets = normals[used], offsets[used]
    body = np.einsum("kji,kj->ki", rotation[pose], normals[plane])
    distance = np.einsum("ki,ki->k", normals[plane], pos[pose]) + offsets[plane]
    delta_pos, delta_ea = motions(pos, rotation)
    start_normals = tilted(normals, config.start_normal, starting)
    shift = starting.normal(0.0, config.start_distance, len(offsets))
    return PlaneScene(
        config=config,
        pos=pos,
        ea=ea,
        normals=normals,
        offsets=offsets,
        seen_pose=pose,
        seen_plane=plane.astype(np.int64),
        seen_normal=tilted(body, config.normal_sigma, measuring),
        seen_distance=distance + measuring.normal(0.0, config.distance_sigma, len(distance)),
        delta_pos=delta_pos + measuring.normal(0.0, config.odometry_pos_sigma, delta_pos.shape),
        delta_ea=delta_ea + measuring.normal(0.0, config.odometry_ea_sigma, delta_ea.shape),
        start_pos=pos + starting.normal(0.0, config.start_pos, pos.shape),
        start_ea=ea + starting.normal(0.0, config.start_ea, ea.shape),
        start_normals=start_normals,
        # The error of the initial plane does not grow with its distance from the origin.
        start_offsets=offsets
        + shift
        + np.einsum("ki,ki->k", normals - start_normals, pos[anchors[used]]),
    )


def tilted(vectors: Array, sigma: float, rng: Generator) -> Array:
    """Unit vectors (n, 3) tilted about two axes across by angles of deviation `sigma` [rad]."""
    noise = rng.normal(0.0, sigma, vectors.shape)
    across = noise - vectors * np.einsum("ki,ki->k", noise, vectors)[:, None]
    moved = vectors + across
    unit: Array = moved / np.linalg.norm(moved, axis=1, keepdims=True)
    return unit


def _place(config: PlaneConfig, pos: Array, rng: Generator) -> tuple[Array, Array, Index]:
    count = config.plane_count
    # Anchors evenly along the path, so that every part of it has walls.
    anchors = (np.arange(count) * config.poses // count).astype(np.int64)
    bearing = rng.uniform(0, 2 * np.pi, count)
    normals = np.column_stack([np.cos(bearing), np.sin(bearing), np.zeros(count)])
    distance = rng.uniform(NEAR, FAR, count)
    level = np.arange(count) % 5 == 4
    below = rng.random(count) < 0.5
    normals[level] = 0.0
    normals[level, 2] = np.where(below[level], 1.0, -1.0)
    distance[level] = np.where(below[level], FLOOR, CEILING)
    normals = tilted(normals, float(np.deg2rad(2.0)), rng)
    return normals, distance - np.einsum("ki,ki->k", normals, pos[anchors]), anchors


def _visible(
    config: PlaneConfig, pos: Array, normals: Array, offsets: Array, anchors: Index, rng: Generator
) -> tuple[Index, Index]:
    """Pose and plane (k,) of every observation, by plane."""
    steps = np.arange(-REACH, REACH + 1)
    plane = np.repeat(np.arange(len(anchors)), len(steps))
    pose = (anchors[:, None] + steps).ravel()
    inside = (pose >= 0) & (pose < config.poses) & (rng.random(len(pose)) < SEEN)
    pose, plane = pose[inside], plane[inside]
    front = np.einsum("ki,ki->k", normals[plane], pos[pose]) + offsets[plane] > FRONT
    return pose[front], plane[front]
