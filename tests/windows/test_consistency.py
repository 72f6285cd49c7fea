"""Covariances of a sliding window agree with the errors: normalised estimation error squared."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import arael

MODEL = """
fn wrapped(x) = atan2(sin(x), cos(x))
struct Pose {
    param p: vec2
    param a: angle
}
struct Mark { param q: vec2 }
struct Step {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    d: vec2
    t: real
    constraint step { (a.a.rotation_matrix().transpose() * (b.p - a.p) - d) / 0.15 }
    constraint turn { wrapped(b.a - a.a - t) / 0.06 }
}
struct Sight {
    pose: ref Pose in root.poses
    mark: ref Mark in root.marks
    d: vec2
    constraint sight {
        (pose.a.rotation_matrix().transpose() * (mark.q - pose.p) - d) / 0.3
    }
}
struct Start {
    pose: ref Pose in root.poses
    p: vec2
    a: real
    constraint start { (pose.p - p) / 1e-2 }
    constraint heading { wrapped(pose.a - a) / 1e-3 }
}
root Drive {
    poses:  deque of Pose
    marks:  arena of Mark
    steps:  deque of Step
    sights: deque of Sight
    starts: list of Start
}
"""
WINDOW, REACH, RADIUS = 3, 5.0, 5.0
MARKS = np.random.default_rng(7).uniform([-8, -3], [8, 13], (40, 2))


def turned(a: float) -> Any:
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


def errors(kind: Any, seed: int, at: tuple[int, ...]) -> list[float]:
    """Squared errors of the newest pose, normalised by its covariance, at some steps."""
    rng = np.random.default_rng(seed)
    way = np.arange(at[-1] + 1) * 2 * np.pi / 24
    truth = np.column_stack([RADIUS * np.sin(way), RADIUS * (1 - np.cos(way)), way])
    model, known, found = kind(), {}, []
    for k, (*p, a) in enumerate(truth):
        if k == 0:
            pose = model.poses.append(p=p, a=a)
            model.starts.append(pose=pose, p=rng.normal(p, 1e-2), a=rng.normal(a, 1e-3))
        else:
            last, (*q, b) = model.poses[-1], truth[k - 1]
            d, t = rng.normal(turned(b).T @ np.subtract(p, q), 0.15), rng.normal(a - b, 0.06)
            heading = last.a.value
            pose = model.poses.append(p=last.p.value + turned(heading) @ d, a=heading + t)
            model.steps.append(a=last, b=pose, d=d, t=t)
        for i, q in enumerate(MARKS):
            z = turned(a).T @ (q - p)
            if np.linalg.norm(z) < REACH:
                z = rng.normal(z, 0.3)
                if i not in known:
                    known[i] = model.marks.append(q=pose.p.value + turned(pose.a.value) @ z)
                model.sights.append(pose=pose, mark=known[i], d=z)
        model.solve()
        if len(model.poses) > WINDOW:
            seen = {s.mark.row for s in model.sights if s.pose.row > 0}
            unseen = [i for i, mark in known.items() if mark.row not in seen]
            model.marginalise([model.poses[0], *(known.pop(i) for i in unseen)])
        if k in at:
            e = np.append(pose.p.value - p, np.angle(np.exp(1j * (pose.a.value - a))))
            found.append(float(e @ np.linalg.solve(model.covariance().marginal(pose), e)))
    return found


def check(interpret: bool, runs: int, at: tuple[int, ...]) -> None:
    kind = arael.loads(MODEL, name="drive", interpret=interpret)
    total = np.sum([errors(kind, seed, at) for seed in range(runs)], axis=0)
    low, high = chi2.ppf([0.005, 0.995], 3 * runs)
    assert (total > low).all()
    assert (total < high).all()


@pytest.mark.slow
def test_errors_are_within_their_bounds_in_a_few_runs() -> None:
    check(True, 5, (5, 8))


@pytest.mark.slow
def test_errors_are_within_their_bounds_over_200_runs() -> None:
    check(False, 200, (6, 14, 22, 29))
