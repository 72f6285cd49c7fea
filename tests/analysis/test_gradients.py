"""Derivatives against central differences, through `check_gradients`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.analysis.gradients import check_gradients
from arael.loading import load
from arael.runtime.problem import Problem
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


SCALES = """
struct Fit {{
    param a: real
    param b: real
    t: real
    constraint shape {{ {formula} }}
}}
root World {{ fits: list of Fit }}
"""


def fitted(tmp_path: Path, formula: str, precision: str, **columns: object) -> Problem:
    path = tmp_path / "scales.arael"
    path.write_text(SCALES.format(formula=formula), encoding="utf-8")
    model = load(path, precision=precision, interpret=True)()
    model.fits.extend(**columns)
    return problem_of(model)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize(
    ("formula", "scale"),
    [
        ("exp(-a * 1e8) * sin(b * 3e8) - t", 1e-8),
        ("a * b * b - t * 1e-24", 1e-8),
        ("exp(-a / 1e8) * sin(b / 3e7) - t", 1e8),
        ("a * b + b * b * b - t", 1e8),
        ("exp(-a) * sin(3 * b) - t", 0.0),
        ("(exp(-a) * sin(3 * b) - t) * 1e-9", 1.0),
    ],
)
def test_right_derivatives_agree_at_any_magnitude(
    tmp_path: Path, formula: str, scale: float, precision: str
) -> None:
    rng = np.random.default_rng(3)
    a, b = scale * rng.uniform(0.5, 2, size=(2, 20))
    (check,) = check_gradients(fitted(tmp_path, formula, precision, a=a, b=b, t=1.0))
    assert check.agrees, check
    assert check.conclusive, check
    assert check.bound < (1e-3 if precision == "f32" else 1e-6)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize(
    ("formula", "scale"),
    [
        ("a * b * b - t * 1e-24", 1e-8),
        ("exp(-a / 1e8) * sin(b / 3e7) - t", 1e8),
        ("(exp(-a) * sin(3 * b) - t) * 1e-9", 1.0),
    ],
)
def test_a_derivative_that_is_off_by_a_percent_is_found_at_any_magnitude(
    tmp_path: Path, formula: str, scale: float, precision: str
) -> None:
    problem = fitted(tmp_path, formula, precision, a=[1.3 * scale], b=[0.7 * scale], t=1.0)
    residuals, entries = problem.evaluation.group_rows(0)

    class Wrong:
        """The evaluation, with one wrong Jacobian entry."""

        interpreters = problem.evaluation.interpreters
        state_arrays = problem.evaluation.state_arrays

        def group_rows(self, number: int) -> tuple[np.ndarray, np.ndarray]:
            return residuals, entries * 1.01

    problem.evaluation = Wrong()  # type: ignore[assignment]
    (check,) = check_gradients(problem)
    assert not check.agrees
    assert 0.005 < check.difference < 0.02
    assert check.bound < 1e-3


def test_a_derivative_lost_in_rounding_is_not_called_wrong(tmp_path: Path) -> None:
    """1 - 1e-24 is 1: no difference shows the derivative, and the bound tells."""
    problem = fitted(tmp_path, "a * b * b - t", "f64", a=[1e-8], b=[1e-8], t=1.0)
    (check,) = check_gradients(problem)
    assert check.agrees
    assert not check.conclusive


def test_a_jump_is_reported(tmp_path: Path) -> None:
    formula = "(if a < 1 then 0 else 1) + b - t"
    problem = fitted(tmp_path, formula, "f64", a=[1.0], b=[1.0], t=1.0)
    (check,) = check_gradients(problem)
    assert not check.agrees
