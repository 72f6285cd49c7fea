"""Errors of an estimate against the truth, after alignment of the undetermined frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arael.geometry import euler_angles

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Alignment:
    """The map ``x -> scale * rotation @ x + translation`` on rows x of an (n, 3) array."""

    scale: float
    rotation: Array
    translation: Array

    def apply(self, points: Array) -> Array:
        """Image (n, 3) of `points` (n, 3)."""
        moved: Array = self.scale * points @ self.rotation.T + self.translation
        return moved


def rigid(source: Array, target: Array) -> Alignment:
    """Rotation and translation that bring `source` (n, 3) closest to `target` (n, 3)."""
    return _umeyama(source, target, scaled=False)


def similarity(source: Array, target: Array) -> Alignment:
    """Like `rigid`, with a scale."""
    return _umeyama(source, target, scaled=True)


def _umeyama(source: Array, target: Array, scaled: bool) -> Alignment:
    """S. Umeyama, Least-squares estimation of transformation parameters, PAMI 13(4), 1991."""
    if source.shape != target.shape or source.ndim != 2:
        raise ValueError(f"expected two (n, d) arrays, found {source.shape} and {target.shape}")
    mean_s, mean_t = source.mean(axis=0), target.mean(axis=0)
    s, t = source - mean_s, target - mean_t
    u, d, vt = np.linalg.svd(t.T @ s)
    sign = np.ones(source.shape[1])
    if np.linalg.det(u) * np.linalg.det(vt) < 0:  # a reflection is not a motion
        sign[-1] = -1.0
    rotation = (u * sign) @ vt
    spread = float(np.sum(s * s))
    scale = float(d @ sign) / spread if scaled and spread > 0 else 1.0
    return Alignment(scale, rotation, mean_t - scale * rotation @ mean_s)


def rms_distance(estimate: Array, truth: Array) -> float:
    """Root of the mean squared distance between rows of two (n, 3) arrays."""
    return float(np.sqrt(np.mean(np.sum((estimate - truth) ** 2, axis=1))))


def closest_pose(landmarks: Array, poses: Array) -> tuple[Index, Array]:
    """Index (m,) of the pose closest to each landmark, and its distance (m,) [m]."""
    distance, index = cKDTree(poses).query(landmarks)
    return index.astype(np.int64), distance


def seen_from(index: Index, poses: Array, rotations: Array, points: Array) -> Array:
    """Vectors (m, 3) from pose ``index[k]`` to ``points[k]``, in that pose's frame.

    Differences of such vectors between estimate and truth need no alignment: they are invariant
    under rigid motions.

    Parameters
    ----------
    index : (m,) rows of `poses`
    poses, rotations : (n, 3) and (n, 3, 3), body to world
    points : (m, 3)
    """
    vectors: Array = np.einsum("kji,kj->ki", rotations[index], points - poses[index])
    return vectors


def motions(poses: Array, rotations: Array) -> tuple[Array, Array]:
    """Motion from each pose to the next in its frame: positions (n-1, 3), roll, pitch, yaw."""
    back = np.swapaxes(rotations[:-1], 1, 2)
    return (
        np.einsum("kij,kj->ki", back, np.diff(poses, axis=0)),
        euler_angles(back @ rotations[1:]),
    )


@dataclass(frozen=True)
class Errors:
    """Errors of an estimate against the truth.

    Attributes
    ----------
    pose_rms : RMS position error of the poses after similarity alignment [m]
    scale : that alignment's scale; 1 if the estimate has the true size
    landmark : (m,) position error of each landmark after rigid alignment of the poses [m]
    scaled_landmark : (m,) the same after similarity alignment of the poses [m]
    distance : (m,) its distance from the closest pose [m]
    closest : (m,) that pose
    """

    pose_rms: float
    scale: float
    landmark: Array
    scaled_landmark: Array
    distance: Array
    closest: Index

    @property
    def relative(self) -> Array:
        """Landmark errors relative to their distance from the closest pose (m,)."""
        return self.landmark / self.distance

    @property
    def landmark_relative_median(self) -> float:
        """Median of `relative`."""
        return float(np.median(self.relative))

    @property
    def scaled_relative_median(self) -> float:
        """Median of the landmarks' relative errors after removing the scale."""
        return float(np.median(self.scaled_landmark / self.distance))


def errors_against_truth(
    poses: Array, landmarks: Array, true_poses: Array, true_landmarks: Array
) -> Errors:
    """Compare estimated `poses` (n, 3) and `landmarks` (m, 3) with the truth [m]."""
    scaled = similarity(poses, true_poses)
    moved = rigid(poses, true_poses)
    closest, distance = closest_pose(true_landmarks, true_poses)
    return Errors(
        pose_rms=rms_distance(scaled.apply(poses), true_poses),
        scale=scaled.scale,
        landmark=np.linalg.norm(moved.apply(landmarks) - true_landmarks, axis=1),
        scaled_landmark=np.linalg.norm(scaled.apply(landmarks) - true_landmarks, axis=1),
        distance=distance,
        closest=closest,
    )
