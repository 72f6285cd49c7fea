"""Systems of rows for tests of the solver by levels: points in the plane, held by distances."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import PythonRows

Array = NDArray[np.float64]


def linear(matrix: Array, right: Array) -> PythonRows:
    """Rows matrix x - right."""
    matrix, right = np.asarray(matrix, float), np.asarray(right, float)
    return PythonRows(
        lambda x: matrix @ x - right,
        lambda x: matrix,
        n=matrix.shape[1],
        m=matrix.shape[0],
        pattern=matrix != 0,
    )


def distances(points: int, pairs: Any, lengths: Any, extra: Any = ()) -> PythonRows:
    """Rows |p - q| - length for pairs of points, then x[k] - value for those of `extra`."""
    pairs = np.asarray(pairs, dtype=int).reshape(-1, 2)
    lengths = np.asarray(lengths, dtype=float)
    extra = list(extra)
    m = len(pairs)

    def residuals(x: Array) -> Array:
        p = x.reshape(-1, 2)
        gaps = np.hypot(*(p[pairs[:, 1]] - p[pairs[:, 0]]).T) - lengths
        return np.concatenate([gaps, [x[k] - v for k, v in extra]])

    def entries(x: Array) -> Array:
        p = x.reshape(-1, 2)
        d = p[pairs[:, 1]] - p[pairs[:, 0]]
        d /= np.hypot(*d.T)[:, None]
        return np.concatenate([np.hstack([-d, d]).ravel(), np.ones(len(extra))])

    pattern = [[2 * a, 2 * a + 1, 2 * b, 2 * b + 1] for a, b in pairs]
    pattern += [[k] for k, _ in extra]
    return PythonRows(residuals, entries, n=2 * points, m=m + len(extra), pattern=pattern)


def rectangles(count: int, width: float = 1.0) -> tuple[PythonRows, Array]:
    """A chain of rectangles, side by side: all edges but shared ones with diagonals as distances.

    Points 2k (below) and 2k + 1 (above); the first two are held in place. Returns the rows and a
    solution.
    """
    points = 2 * (count + 1)
    k = np.arange(count)
    pairs = np.concatenate(
        [
            np.stack([2 * k, 2 * k + 2], 1),
            np.stack([2 * k + 1, 2 * k + 3], 1),
            np.stack([2 * k + 2, 2 * k + 3], 1),
            np.stack([2 * k, 2 * k + 3], 1),
        ]
    )
    x = np.empty((points, 2))
    x[0::2] = np.stack([np.arange(count + 1) * width, np.zeros(count + 1)], 1)
    x[1::2] = x[0::2] + np.array([0, 1])
    lengths = np.hypot(*(x[pairs[:, 1]] - x[pairs[:, 0]]).T)
    held = [(0, 0.0), (1, 0.0), (2, 0.0), (3, 1.0)]
    return distances(points, pairs, lengths, held), x.ravel()


def chain(links: int) -> tuple[PythonRows, Array]:
    """Points joined by links of length 1, the first one held at the origin; a zigzag solution."""
    k = np.arange(links)
    x = np.zeros((links + 1, 2))
    x[1:] = np.cumsum(np.stack([np.cos(0.5 * (-1.0) ** k), np.sin(0.5 * (-1.0) ** k)], 1), 0)
    pairs = np.stack([k, k + 1], 1)
    return distances(links + 1, pairs, np.ones(links), [(0, 0.0), (1, 0.0)]), x.ravel()
