"""A pose graph as arrays for initialisation, in two or three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.components import graph_components
from arael.starts.arithmetic import marginal_of

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Poses:
    """Rigid transforms, body to world (of an edge: second end to first end).

    Attributes
    ----------
    rotation : (n, d, d), orthogonal with determinant 1
    position : (n, d)
    """

    rotation: Array
    position: Array

    def __len__(self) -> int:
        return len(self.position)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.position.shape[1])

    def __getitem__(self, rows: Ints | Bools) -> Poses:
        return Poses(self.rotation[rows], self.position[rows])

    def __matmul__(self, other: Poses) -> Poses:
        """Compose row by row: first `other`, then this."""
        moved = np.einsum("nij,nj->ni", self.rotation, other.position)
        return Poses(self.rotation @ other.rotation, self.position + moved)

    def inverse(self) -> Poses:
        """Inverse of each transform."""
        back = self.rotation.transpose(0, 2, 1)
        return Poses(back, -np.einsum("nij,nj->ni", back, self.position))

    @classmethod
    def identity(cls, count: int, dimension: int) -> Poses:
        """Return `count` identities."""
        return cls(np.tile(np.eye(dimension), (count, 1, 1)), np.zeros((count, dimension)))


@dataclass(frozen=True)
class Anchors:
    """Absolute measurements of poses.

    Attributes
    ----------
    pose : (k,) row of the measured pose
    measured : the measured values
    position_weight, rotation_weight : (k,) inverse standard deviations, [1/m] and [1/rad]
    """

    pose: Ints
    measured: Poses
    position_weight: Array
    rotation_weight: Array

    @classmethod
    @lru_cache(maxsize=2)
    def none(cls, dimension: int) -> Anchors:
        """Return an empty set of absolute measurements."""
        empty = np.empty(0)
        poses = Poses(np.empty((0, dimension, dimension)), np.empty((0, dimension)))
        return cls(np.empty(0, np.int64), poses, empty, empty)


@dataclass(frozen=True)
class PoseGraph:
    """Poses and measurements of one pose relative to another.

    Attributes
    ----------
    poses : current values
    a, b : (m,) rows of the two poses of each edge
    measured : pose of `b` in the frame of `a`
    information : (m, k, k), inverse covariance of position and rotation vector (k = 3 or 6)
    fixed_position, fixed_rotation : (n,) masks of fixed parts
    anchors : absolute measurements
    coupled : whether the information of some edge couples position and rotation
    """

    poses: Poses
    a: Ints
    b: Ints
    measured: Poses
    information: Array
    fixed_position: Bools
    fixed_rotation: Bools
    anchors: Anchors
    coupled: bool = True

    @cached_property
    def component(self) -> Ints:
        """(n,) connected component of each pose, named by its first pose."""
        return graph_components(len(self.poses), self.a, self.b)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.poses.dimension

    def without(self, holding: Ints) -> Ints:
        """First poses of the components that contain none of the poses `holding`."""
        held = np.zeros(len(self.poses), np.bool_)
        held[self.component[holding]] = True
        first = self.component == np.arange(len(self.poses))
        return np.flatnonzero(first & ~held)

    @property
    def rotation_information(self) -> Array:
        """(m, r, r) information of the measured rotations alone, positions marginalised.

        The Schur complement of the positions: the inverse of the rotations' covariance.
        """
        d = self.dimension
        whole = self.information
        if not self.coupled:  # as in most files
            return whole[:, d:, d:]
        found, left = marginal_of(whole)
        if left is not None:
            # Of what has overflowed, no decomposition exists.
            found[left] = np.nan
            left &= np.isfinite(whole).all(axis=(1, 2))
            # The information of a position may be singular: hence the pseudo-inverse.
            some = whole[left]
            back = np.linalg.pinv(some[:, :d, :d], hermitian=True)
            found[left] = some[:, d:, d:] - some[:, d:, :d] @ back @ some[:, :d, d:]
        return found
