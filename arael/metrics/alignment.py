"""Alignment of one trajectory to another: rigid, similarity, or by the first pose."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.trajectory import Trajectory
from arael.runtime.store import rotations

Array = NDArray[np.float64]
_EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A similarity transformation: ``scale * rotation @ x + translation``.

    Attributes
    ----------
    rotation : (3, 3)
    translation : (3,) [m]
    scale : 1 unless it was estimated
    """

    rotation: Array
    translation: Array
    scale: float = 1.0

    def apply(self, trajectory: Trajectory) -> Trajectory:
        """The trajectory after the transformation; velocities are rotated and scaled."""
        turn = rotations.quaternion_from_matrix(self.rotation)
        moved = self.scale * trajectory.positions @ self.rotation.T + self.translation
        speeds = trajectory.velocities
        return replace(
            trajectory,
            positions=moved,
            quaternions=_product(turn, trajectory.quaternions),
            velocities=None if speeds is None else self.scale * speeds @ self.rotation.T,
        )


def umeyama(points: Array, targets: Array, with_scale: bool = False) -> Alignment:
    """The similarity that maps points to targets with the least sum of squared distances.

    S. Umeyama, "Least-squares estimation of transformation parameters between two point patterns",
    IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (1991), equations 34 to 43.

    Parameters
    ----------
    points, targets : (N, 3)
    with_scale : whether the scale is estimated; otherwise it is 1

    Raises
    ------
    AraelError
        E0729: another number of points, or points on a line or in one place, for which the rotation
        is not determined.
    """
    return _fitted(points, targets, with_scale)


def _fitted(points: Array, targets: Array, with_scale: bool, turned: bool = True) -> Alignment:
    """As `umeyama`; without `turned` the rotation need not be determined."""
    points, targets = np.asarray(points, np.float64), np.asarray(targets, np.float64)
    if points.shape != targets.shape or points.ndim != 2 or not len(points):
        raise _wrong(f"expected as many points, found {points.shape} and {targets.shape}")
    middle, target_middle = points.mean(axis=0), targets.mean(axis=0)
    centred = points - middle
    variance = float((centred**2).sum()) / len(points)
    covariance = (targets - target_middle).T @ centred / len(points)
    u, d, vt = np.linalg.svd(covariance)
    # Of points on a line the second singular value is rounding, in proportion to the first.
    known = np.count_nonzero(d > _EPSILON * max(1.0, 16 * d[0]))
    if known < (points.shape[1] - 1 if turned else 1):
        raise _wrong(
            "the positions are in one place or on a line: no rotation is determined",
            "align by the first pose (`--origin`), or do not align",
        )
    signs = np.ones(len(d))
    if np.linalg.det(u) * np.linalg.det(vt) < 0:
        signs[-1] = -1.0  # a rotation, not a reflection
    rotation = (u * signs) @ vt
    scale = float(d @ signs) / variance if with_scale else 1.0
    return Alignment(rotation, target_middle - scale * rotation @ middle, scale)


def align(
    estimate: Trajectory,
    reference: Trajectory,
    *,
    scale: bool = False,
    only_scale: bool = False,
    first: int | None = None,
) -> tuple[Trajectory, Alignment]:
    """Align a trajectory to a reference with as many poses.

    Parameters
    ----------
    scale : estimate the scale as well
    only_scale : change the scale alone
    first : use this many poses from the start; None: all

    Returns
    -------
    the aligned trajectory and the transformation

    Raises
    ------
    AraelError
        E0729 another number of poses, or positions that determine no rotation (with `only_scale`:
        no scale).
    """
    found = _fitted(
        estimate.positions[:first],
        reference.positions[:first],
        scale or only_scale,
        turned=not only_scale,
    )
    if only_scale:
        found = Alignment(np.eye(3), np.zeros(3), found.scale)
    return found.apply(estimate), found


def align_origin(estimate: Trajectory, reference: Trajectory) -> tuple[Trajectory, Alignment]:
    """Move a trajectory rigidly so that its first pose is that of the reference."""
    if not len(estimate) or not len(reference):
        raise _wrong("a trajectory without poses cannot be aligned")
    start, goal = estimate.matrices[0], reference.matrices[0]
    rotation = goal[:3, :3] @ start[:3, :3].T
    found = Alignment(rotation, goal[:3, 3] - rotation @ start[:3, 3])
    return found.apply(estimate), found


def _product(a: Array, b: Array) -> Array:
    """Product of a quaternion (4,) with quaternions (N, 4)."""
    w, v, x, u = a[0], a[1:], b[:, :1], b[:, 1:]
    scalar = w * x - (u @ v)[:, None]
    return np.hstack([scalar, w * u + x * v + np.cross(v, u)])


def _wrong(message: str, help: str = "") -> AraelError:
    return AraelError(
        Diagnostic("E0729", message, origin="alignment", help=(help,) if help else ())
    )
