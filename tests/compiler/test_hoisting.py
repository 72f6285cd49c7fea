"""What does not depend on parameters is made once, in f64, and rounded once."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arael.loading import load
from arael.solving import problem_of

SMALL_ANGLES = """
struct Seen {
    t: real
    u: real
    constraint c {
        [root.p.x * (1 - cos(t)), root.p.y * cos(t), root.p.z * u, root.p.x * (t * u)]
    }
}
root World : f32 { param p: vec3; seen: list of Seen }
"""


def test_differences_of_lanes_do_not_cancel_in_f32(tmp_path: Path) -> None:
    """1 - cos t is not made of a rounded cos t in the kernel, though cos t is there."""
    path = tmp_path / "small.arael"
    path.write_text(SMALL_ANGLES)
    model = load(path)(p=[1.0, 1.0, 1.0])
    t, u = np.array([1e-1, 1e-2, 1e-3, 1e-4]), np.array([1.0, 0.3, 0.7, 3.0])
    model.seen.extend(t=t, u=u)
    problem = problem_of(model)
    t, u = t.astype(np.float32).astype(float), u.astype(np.float32).astype(float)
    residuals, _ = problem.evaluation.group_rows(0)
    np.testing.assert_allclose(residuals[:, 0], 2 * np.sin(t / 2) ** 2, rtol=1e-6)
    np.testing.assert_allclose(residuals[:, 3], t * u, rtol=1e-6)


def test_products_of_lanes_are_not_streamed() -> None:
    """isigma * scale stands beside isigma: it is made again by the kernel, not read."""
    bearing = next(
        group for group in load("slam").layout.groups if group.label == "PointFrine.bearing"
    )
    assert bearing.data_count == 14
