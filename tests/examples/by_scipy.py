"""The optimum of a scene by SciPy, on residuals written independently of the compiler."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import least_squares

from tests.scenes import slam_residuals as by_hand


def refined_cost(data: dict[str, Any], instance: Any, known_map: Any = None) -> float:
    """The lowest sum of squares that SciPy's dense trust-region solver finds from a solution.

    Parameters
    ----------
    data : columns of the scene
    instance : the solved model
    known_map : landmarks (m, 3) that are data; None: they are solved for, and there is GPS

    The drift residuals are left out: they are measured from where the last pass began, with sigmas
    of a thousand metres.
    """
    parts = [np.array(instance.poses.pos.value), np.array(instance.poses.ea.value)]
    if known_map is None:
        parts.append(np.array(instance.landmarks.pos.value))
    ends = np.cumsum([part.size for part in parts])[:-1]

    def residuals(x: np.ndarray) -> np.ndarray:
        split = np.split(x, ends)
        pos, ea, *rest = (p.reshape(s.shape) for p, s in zip(split, parts, strict=True))
        landmarks = rest[0] if rest else known_map
        found = [
            by_hand.bearing(data, pos, ea, landmarks),
            by_hand.tilt(data, ea),
            by_hand.odometry(data, pos, ea),
        ]
        if known_map is None:
            found.append(by_hand.gps(data, pos))
        return np.concatenate([part.ravel() for part in found])

    start = np.concatenate([part.ravel() for part in parts])
    best = least_squares(residuals, start, xtol=1e-13, ftol=1e-15, gtol=1e-13)
    return float(2 * best.cost)
