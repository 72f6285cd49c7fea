"""Association of the poses of two trajectories by time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.trajectory import Trajectory

Ints = NDArray[np.int64]


def associate(
    reference: Trajectory,
    estimate: Trajectory,
    *,
    max_diff: float = 0.01,
    offset: float = 0.0,
) -> tuple[Trajectory, Trajectory]:
    """The poses of two trajectories that belong together, as trajectories of one length.

    Each pose of the trajectory with fewer poses gets the one of the other that is closest in time.
    Without times in either, poses belong together in order.

    Parameters
    ----------
    max_diff : the largest difference of times [s]
    offset : added to the times of the estimate [s]

    Raises
    ------
    AraelError
        E0729: only one has times, no times are close enough, or without times the numbers of poses
        differ.
    """
    if reference.times is None or estimate.times is None:
        if (reference.times is None) != (estimate.times is None):
            which = "reference" if reference.times is None else "estimate"
            raise _wrong(
                f"the {which} has no times, the other trajectory has",
                "give both as TUM or EuRoC; `arael convert --times` adds times to a KITTI file",
            )
        if len(reference) != len(estimate):
            raise _wrong(
                f"without times poses belong together in order, but the reference has "
                f"{len(reference)} and the estimate {len(estimate)}"
            )
        return reference, estimate
    shifted = estimate.times + offset
    from_estimate = len(estimate) <= len(reference)
    short, long = (shifted, reference.times) if from_estimate else (reference.times, shifted)
    few, many = nearest(short, long, max_diff)
    if not len(short) or not len(long):
        which = "estimate" if len(reference) else "reference"
        raise _wrong(f"the {which} has no poses")
    if not len(few):
        apart = (
            f"the reference covers {reference.times[0]:.6f} to {reference.times[-1]:.6f} s, the "
            f"estimate {shifted[0]:.6f} to {shifted[-1]:.6f} s"
        )
        raise _wrong(
            f"no poses are within {max_diff:g} s of each other",
            "raise `--max-diff` (`max_diff=`), or give the offset of the clocks by `--offset`",
            apart,
        )
    rows = (many, few) if from_estimate else (few, many)
    return reference.rows(rows[0]), estimate.rows(rows[1])


def nearest(
    short: NDArray[np.float64], long: NDArray[np.float64], most: float
) -> tuple[Ints, Ints]:
    """Rows of times and of those of `long` that are closest to them, no further than `most`.

    Of two times at the same distance the earlier is taken.

    Parameters
    ----------
    short, long : (N,), (M,) [s]
    """
    if not len(short) or not len(long):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    order = np.argsort(long, kind="stable")
    times = long[order]
    after = np.minimum(np.searchsorted(times, short, side="right"), len(times) - 1)
    before = np.maximum(after - 1, 0)
    to_after, to_before = np.abs(times[after] - short), np.abs(short - times[before])
    chosen = np.where(to_after < to_before, after, before)
    kept = np.flatnonzero(np.minimum(to_after, to_before) <= most)
    return kept, order[chosen[kept]]


def _wrong(message: str, help: str = "", note: str = "") -> AraelError:
    return AraelError(
        Diagnostic(
            "E0729",
            message,
            origin="trajectories",
            notes=(note,) if note else (),
            help=(help,) if help else (),
        )
    )
