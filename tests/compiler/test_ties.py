"""Derived parameters: no freedom of their own, derivatives through them, read from Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.analysis.gradients import check_gradients
from arael.diagnostics.records import AraelError
from arael.loading import load
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

MODEL = """
const K = 3

struct Pose {
    param x: vec2
    param y = K * x + [1, 2]
    param z = y.x - x.y
    goal: vec2
    constraint c { [y - goal, sin(z)] }
    constraint d { x - y.value }
}

root Chain {
    param a: real = 1
    param b = 2 * a + 1
    param half = b / 2
    poses: list of Pose
    first: ref Pose in root.poses
    constraint e { [b - 7, first.y.x - half, root.half] }
}
"""


def chain(tmp_path: Path) -> Model:
    path = tmp_path / "chain.arael"
    path.write_text(MODEL)
    model = load(path)()
    model.poses.extend(x=[[1, 2], [0.5, -1]], goal=[[3, 4], [0, 1]])
    model.first = model.poses[0]
    return model


def test_kernels_interpreter_and_differences_agree(tmp_path: Path) -> None:
    model = chain(tmp_path)
    check_against_oracle(model)
    check_against_differences(model)
    assert all(check.agrees for check in check_gradients(model._problem()))


def test_derived_parameters_are_read_and_not_solved_for(tmp_path: Path) -> None:
    model = chain(tmp_path)
    assert (model.b, model.half) == (3, 1.5)
    np.testing.assert_allclose(model.poses.y, [[4, 8], [2.5, -1]])
    assert model.poses[1].z == pytest.approx(3.5)
    names = ["a", "poses[0].x.x", "poses[0].x.y", "poses[1].x.x", "poses[1].x.y"]
    assert model.parameter_names() == names
    rows = model.jacobian()
    np.testing.assert_allclose(rows.residuals[:3], [3 - 7, 4 - 1.5, 1.5])
    np.testing.assert_allclose(rows.dense()[:3], [[2, 0, 0, 0, 0], [-1, 3, 0, 0, 0], [1] + [0] * 4])
    with pytest.raises(AttributeError, match="`b` is a formula"):
        model.b = 4


def test_a_solve_is_that_of_the_model_with_the_formulas_written_out(tmp_path: Path) -> None:
    """A line through two points by its slope alone: y = a x + (2 a + 1)."""
    path = tmp_path / "line.arael"
    path.write_text("""
struct Point { x: real; y: real }
root Line {
    param a: real = 0
    param b = 2 * a + 1
    points: list of Point
    fit points as p { a * p.x + b - p.y }
}
""")
    model = load(path, interpret=True)()
    x, y = np.array([0.0, 1, 2, 4]), np.array([3.0, 4, 4.5, 7])
    model.points.extend(x=x, y=y)
    model.solve()
    design = x + 2
    assert model.a.value == pytest.approx(design @ (y - 1) / (design @ design))
    assert model.b == pytest.approx(2 * model.a.value + 1)
    assert model.covariance().matrix.shape == (1, 1)


def test_data_cannot_give_a_derived_parameter(tmp_path: Path) -> None:
    path = tmp_path / "chain.arael"
    path.write_text(MODEL)
    model = load(path, interpret=True)()
    with pytest.raises(AraelError, match="y"):
        model.poses.append(x=[1, 2], goal=[3, 4], y=[4, 8])
