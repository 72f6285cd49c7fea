"""Landmarks with their errors and uncertainties, one line each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LandmarkLine:
    """One landmark.

    Attributes
    ----------
    index : its number
    error : error of its position in the frame of the closest pose [m]
    relative : the same relative to `distance`
    distance : its distance from the closest pose [m]
    sigma : one-sigma semi-axes relative to that pose, descending [m]
    frines : number of observations
    """

    index: int
    error: float
    relative: float
    distance: float
    sigma: tuple[float, float, float]
    frines: int

    def __str__(self) -> str:
        sigma = ",".join(f"{s:.3f}" for s in self.sigma)
        return (
            f"LM {self.index}: |d|={self.error:.3f}m rel={100 * self.relative:.2f}% "
            f"dist={self.distance:.1f}m sigma=({sigma})m frines={self.frines}"
        )


def landmark_lines(
    error: NDArray[np.float64],
    distance: NDArray[np.float64],
    chosen: NDArray[np.int64],
    axes: NDArray[np.float64],
    frines: NDArray[np.int64],
) -> list[LandmarkLine]:
    """Lines on the landmarks `chosen` (k,) with ellipsoid `axes` (k, 3); the rest (m,) of all."""
    return [
        LandmarkLine(
            index=int(k),
            error=float(error[k]),
            relative=float(error[k] / distance[k]),
            distance=float(distance[k]),
            sigma=(float(row[0]), float(row[1]), float(row[2])),
            frines=int(frines[k]),
        )
        for k, row in zip(chosen, axes, strict=True)
    ]


def spread(relative: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Choose `count` landmarks from the best to the worst, evenly spaced in rank."""
    order = np.argsort(relative, kind="stable")
    ranks = np.linspace(0, len(order) - 1, min(count, len(order))).round().astype(np.int64)
    return order[ranks]
