"""Derivatives against central differences, through `check_gradients`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arael.diagnose.gradients import check_gradients
from arael.loading import load
from arael.solving import problem_of

GUARDED = """
struct Pose { param p: vec3 }
struct Seen {
    pose: ref Pose in root.poses
    z: vec3
    constraint ahead when pose.p.x > z.x { sin(pose.p - z) }
}
root World { poses: list of Pose; seen: list of Seen }
"""


def test_guards_are_asked_at_the_state_that_is_checked(tmp_path: Path) -> None:
    """Instances that act are those of now, whatever was evaluated before."""
    path = tmp_path / "guarded.arael"
    path.write_text(GUARDED)
    model = load(path)()
    rng = np.random.default_rng(0)
    model.poses.extend(p=rng.normal(size=(5, 3)))
    model.seen.extend(pose=rng.integers(5, size=40), z=rng.normal(size=(40, 3)))
    problem = problem_of(model)
    for _ in range(3):
        assert all(check.agrees for check in check_gradients(problem))
        acting = problem.evaluation.acting(0)
        assert 0 < acting.sum() < 40
        np.testing.assert_array_equal(problem.evaluation.interpreters[0].acting, acting)
        problem.evaluation.moved_by(rng.normal(size=problem.size))
