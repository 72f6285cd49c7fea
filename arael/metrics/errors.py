"""Absolute and relative errors of a trajectory, equal to those of evo (M. Grupp, 2017).

With reference poses Q and estimated poses P in SE(3), associated and aligned: the absolute error is
``E_i = P_i^-1 Q_i`` (the absolute trajectory error, ATE, is the root mean square of its
translation), the relative error ``E_i = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j)`` over pairs i, j (J. Sturm et
al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", 2012, equations 1 to 5).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.io.trajectory import Trajectory
from arael.metrics.pairs import DeltaUnit, pairs_of
from arael.runtime.store import rotations

Array = NDArray[np.float64]
Part = Literal[
    "translation", "rotation", "full", "angle_deg", "angle_rad", "distance", "distance_ratio"
]

PARTS = {
    "translation": "m",
    "rotation": "",
    "full": "",
    "angle_deg": "deg",
    "angle_rad": "rad",
    "distance": "m",
    "distance_ratio": "%",
}
"""What of an error is measured -> its unit."""


@dataclass(frozen=True)
class Statistics:
    """Statistics of errors: ``sse`` is the sum of squares, ``std`` that of the population."""

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    sse: float

    def to_dict(self) -> dict[str, float]:
        """Statistics by name."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of poses or of pairs of poses.

    Attributes
    ----------
    part : what of the error is measured, a key of `PARTS`
    unit : its unit, "" for norms of matrices
    values : (N,), each at least 0
    rows : rows of the associated poses: (N,) for absolute errors, (N, 2) of pairs for relative ones
    """

    part: str
    unit: str
    values: Array
    rows: NDArray[np.int64]

    @property
    def statistics(self) -> Statistics:
        """Statistics of `values`."""
        x = self.values
        square = x**2
        return Statistics(
            float(np.sqrt(square.mean())),
            float(x.mean()),
            float(np.median(x)),
            float(x.std()),
            float(x.min()),
            float(x.max()),
            float(square.sum()),
        )


def ate(reference: Trajectory, estimate: Trajectory, part: Part = "translation") -> Errors:
    """The absolute error of each pose of an estimate.

    Parameters
    ----------
    reference, estimate : trajectories with as many poses (see `associate` and `align`)
    part : ``translation`` [m]; ``angle_deg`` or ``angle_rad``, the angle of the rotation;
        ``rotation``, the Frobenius norm of ``R - I``; ``full``, that of ``E - I``; ``distance``, as
        ``translation``

    Raises
    ------
    AraelError
        E0729 another number of poses, none, or an unknown part.
    """
    _check(reference, estimate, part)
    if part == "distance_ratio":
        raise _wrong("`distance_ratio` is a part of relative errors only")
    if part in ("translation", "distance"):
        values = np.linalg.norm(estimate.positions - reference.positions, axis=1)
    else:
        values = _measured(_relative(estimate.matrices, reference.matrices), part)
    return Errors(part, PARTS[part], values, np.arange(len(reference)))


def rpe(
    reference: Trajectory,
    estimate: Trajectory,
    part: Part = "translation",
    *,
    delta: float = 1,
    unit: DeltaUnit = "frames",
    all_pairs: bool = False,
    tolerance: float = 0.1,
    pairs_from: Literal["estimate", "reference"] = "estimate",
) -> Errors:
    """The relative error of pairs of poses, the drift over a distance.

    Parameters
    ----------
    reference, estimate, part : as for `ate`; ``distance`` is the difference of the distances
        between the poses of a pair, ``distance_ratio`` the same in percent of that of the reference
    delta, unit : distance of the poses of a pair: ``frames``, ``m`` along the path, ``deg`` or
        ``rad``
    all_pairs : pairs from every pose, not only consecutive ones
    tolerance : with `all_pairs`, largest relative difference of the distance from `delta`
    pairs_from : trajectory on which distances are measured

    Raises
    ------
    AraelError
        E0729 another number of poses, no pair of that distance, or an unknown part, unit or source
        of pairs.
    """
    _check(reference, estimate, part)
    if pairs_from not in ("estimate", "reference"):
        raise _wrong(f"pairs are from 'estimate' or 'reference', found {pairs_from!r:.40}")
    source = reference if pairs_from == "reference" else estimate
    pairs = pairs_of(source, delta, unit, all_pairs=all_pairs, tolerance=tolerance)
    i, j = pairs.T
    if part in ("distance", "distance_ratio"):
        lengths = [
            np.linalg.norm(t.positions[j] - t.positions[i], axis=1) for t in (reference, estimate)
        ]
        values = np.abs(lengths[0] - lengths[1])
        if part == "distance_ratio":
            moved = np.flatnonzero(lengths[0])  # a ratio to no distance has no meaning
            if not len(moved):
                raise _wrong("no pair of poses of the reference is apart: there is no ratio")
            values, pairs = values[moved] / lengths[0][moved] * 100, pairs[moved]
        return Errors(part, PARTS[part], values, pairs)
    q, p = reference.matrices, estimate.matrices
    errors = _relative(_relative(q[i], q[j]), _relative(p[i], p[j]))
    return Errors(part, PARTS[part], _measured(errors, part), pairs)


def _relative(a: Array, b: Array) -> Array:
    """``a^-1 b`` of homogeneous matrices (N, 4, 4)."""
    found = np.zeros_like(a)
    turn = a[:, :3, :3].transpose(0, 2, 1)
    found[:, :3, :3] = turn @ b[:, :3, :3]
    found[:, :3, 3] = np.einsum("nij,nj->ni", turn, b[:, :3, 3] - a[:, :3, 3])
    found[:, 3, 3] = 1
    return found


def _measured(errors: Array, part: str) -> Array:
    """Norms or angles of errors (N, 4, 4)."""
    if part == "translation":
        return np.asarray(np.linalg.norm(errors[:, :3, 3], axis=1))
    if part == "full":
        return np.asarray(np.linalg.norm(errors - np.eye(4), axis=(1, 2)))
    if part == "rotation":
        return np.asarray(np.linalg.norm(errors[:, :3, :3] - np.eye(3), axis=(1, 2)))
    turns = rotations.quaternion_from_matrix(errors[:, :3, :3])
    angles = np.linalg.norm(rotations.vector_from_quaternion(turns), axis=1)
    return np.rad2deg(angles) if part == "angle_deg" else np.asarray(angles)


def _check(reference: Trajectory, estimate: Trajectory, part: str) -> None:
    if part not in PARTS:
        near = closest(part, PARTS)
        raise _wrong(
            f"errors have no part `{part}`",
            f"did you mean `{near[0]}`?" if near else f"parts are {', '.join(PARTS)}",
        )
    if len(reference) != len(estimate) or not len(reference):
        raise _wrong(
            f"expected as many poses, found {len(reference)} of the reference and {len(estimate)} "
            "of the estimate",
            "associate them by time first: `arael.metrics.associate`",
        )


def _wrong(message: str, help: str = "") -> AraelError:
    return AraelError(Diagnostic("E0729", message, origin="errors", help=(help,) if help else ()))
