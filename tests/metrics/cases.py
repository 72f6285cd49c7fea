"""Pairs of synthetic trajectories, made from a seed, for figures that can be compared."""

from __future__ import annotations

import numpy as np

from arael.io import Trajectory


def pair(seed: int) -> tuple[Trajectory, Trajectory]:
    """A reference of 60 poses, and an estimate of some 40 with noise, another scale and frame."""
    rng = np.random.default_rng(seed)
    reference = Trajectory(rng.standard_normal((60, 3)).cumsum(axis=0), turns(rng, 60), times(rng))
    rows = np.sort(rng.choice(60, 42, replace=False))
    assert reference.times is not None
    noisy = reference.quaternions[rows] + 0.1 * rng.standard_normal((42, 4))
    return reference, Trajectory(
        1.3 * reference.positions[rows] @ frame(rng).T + 0.1 * rng.standard_normal((42, 3)) + 2.0,
        noisy / np.linalg.norm(noisy, axis=1)[:, None],
        reference.times[rows] + 0.004 * rng.standard_normal(42),
    )


def times(rng: np.random.Generator) -> np.ndarray:
    """Increasing times, 0.1 s apart on average."""
    return np.cumsum(rng.uniform(0.05, 0.15, 60))


def turns(rng: np.random.Generator, count: int) -> np.ndarray:
    """Random unit quaternions."""
    q = rng.standard_normal((count, 4))
    return q / np.linalg.norm(q, axis=1)[:, None]


def frame(rng: np.random.Generator) -> np.ndarray:
    """A random rotation matrix."""
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


ALIGNMENTS = ("none", "rigid", "similarity", "scale", "origin", "first 10")
DELTAS = ((1, "frames"), (5, "frames"), (4.0, "m"), (60.0, "deg"), (1.0, "rad"))
SEEDS = (1, 2, 3)
