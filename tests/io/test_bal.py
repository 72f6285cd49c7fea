"""Bundle adjustment files in and out, and the known optimum of a real one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import arael
from arael.diagnostics.records import AraelError
from arael.runtime.store import rotations
from tests.public_data import public

SMALL = """2 1 2
0 0 -1.5 2.0
1 0 3.25 -4.5
{cameras}
0.5
-0.25
-8
"""
CAMERAS = np.array([[0.1, -0.2, 0.3, 1, 2, -3, 500, 1e-3, -2e-5], [0, 0, 0, 0, 0.5, 0, 400, 0, 0]])


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.txt"
    path.write_text(SMALL.format(cameras="\n".join(map(repr, CAMERAS.ravel().tolist()))))
    return path


def model() -> Any:
    return arael.load("bundle_adjustment")()


def reprojection(camera: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Pixel of a point, written from the definition of the data set."""
    p = Rotation.from_rotvec(camera[:3]).apply(point) + camera[3:6]
    u = -p[:2] / p[2]
    r2 = u @ u
    return camera[6] * (1 + camera[7] * r2 + camera[8] * r2**2) * u


def test_residuals_are_those_of_the_definition(small: Path) -> None:
    problem = model()
    problem.read(small)
    point = np.array([0.5, -0.25, -8])
    pixels = np.array([[-1.5, 2.0], [3.25, -4.5]])
    expected = [reprojection(c, point) - p for c, p in zip(CAMERAS, pixels, strict=True)]
    assert problem.cost() == pytest.approx(np.sum(np.square(expected)), rel=1e-12)
    assert problem.jacobian().residuals == pytest.approx(np.ravel(expected), rel=1e-10)


def test_written_and_read_again_it_is_the_same(small: Path, tmp_path: Path) -> None:
    problem = model()
    problem.read(small)
    for name in ("out.txt", "out.bal", "out.bal.gz"):
        problem.write(tmp_path / name)
        again = model()
        again.read(tmp_path / name)
        assert again.cost() == pytest.approx(problem.cost(), rel=1e-12)
        assert again.cameras.r.value == pytest.approx(problem.cameras.r.value, abs=1e-15)
        assert again.observations.pixel.tolist() == problem.observations.pixel.tolist()


def test_rotation_vectors() -> None:
    rng = np.random.default_rng(0)
    v = rng.standard_normal((50, 3))
    v[:3] = [[0, 0, 0], [1e-9, 0, 0], [np.pi - 1e-7, 0, 0]]
    q = rotations.quaternion_from_vector(v)
    assert q == pytest.approx(Rotation.from_rotvec(v).as_quat()[:, [3, 0, 1, 2]], abs=1e-15)
    inside = v[np.linalg.norm(v, axis=1) < np.pi]
    back = rotations.vector_from_quaternion(rotations.quaternion_from_vector(inside))
    assert back == pytest.approx(inside, abs=1e-12)


def test_real_problem_from_its_start() -> None:
    problem = model()
    problem.read(public("bundle_adjustment/problem-49-7776-pre.txt"))
    assert problem.cost() == pytest.approx(1701825, rel=1e-6)
    result = problem.solve()
    assert result.status == "converged"
    assert result.end_cost < 26690


def test_generated_problem() -> None:
    problem = model()
    problem.read(public("bundle_adjustment/synth-16-22106.txt"))
    result = problem.solve()
    assert result.end_cost == pytest.approx(29926.0, abs=0.05)


def test_only_a_model_of_that_shape_takes_it(small: Path) -> None:
    with pytest.raises(AraelError, match=r"E0722.*not a bundle adjustment"):
        arael.load("linear")().read(small)
