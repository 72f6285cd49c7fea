"""Matrix literals, slices and conversions of rotations: kernels, interpreter, NumPy and SciPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arael.analysis.gradients import check_gradients
from arael.loading import load
from arael.model import Model
from tests.compiler.test_kernels import check_against_differences, check_against_oracle

MODEL = """
const A = [[1, 2, 3], [4, 5, 6]]

struct Pair { R: mat3; t: vec3; M: mat<4,4>; q: quat; w: vec3 }

root Turns {
    param x: vec3       = [0.3, -0.2, 0.5]
    param q: quaternion = exp([0.1, 0.2, -0.4])
    param T: transform  = transform(rotation_matrix([0.1, 0.2, 0.3]), [1, 2, 3])
    wide: mat<2,3> = A
    flip: mat2     = [[0, 1], [-1, 0]]
    start: transform = transform([[0, -1, 0, 3], [1, 0, 0, 4], [0, 0, 1, 5], [0, 0, 0, 1]])
    half: quat = quaternion([[-1, 0, 0], [0, -1, 0], [0, 0, 1]])
    pairs: list of Pair

    constraint literal { [[x.x, 0, 1], [0, x.y, x.z], [x[0:2], 2]] * x }
    constraint part {
        let M = [[x.x, x.y, 1], [x.z, 2, x.x]]
        [M[:, 1], M[0, :] .* x, M[0:2, 1:3] * x[1:], trace(M[:, :2]), wide * x, flip * x[:2]]
    }
    constraint back {
        [rotation_vector(mat3(q) * mat3(T)'), quaternion(mat3(q)).vec,
         (transform(T.matrix()).inverse() * transform(mat3(q), x)).log(),
         (transform(x, q * quaternion(mat3(T))).inverse() * start).log(),
         similarity(mat3(q), x, 2).inverse() * x]
    }
    fit pairs as p {
        [transform(p.R, p.t) * x, transform(p.M) * x, transform(p.q, p.t).inverse() * x,
         rotation_vector(p.R) - x, rotation_vector(p.q) - p.w + 1e-3 * x]
    }
}
"""


def turns(tmp_path: Path, precision: str = "f64") -> Model:
    path = tmp_path / "turns.arael"
    path.write_text(MODEL.replace("root Turns", f"root Turns : {precision}"))
    model = load(path)()
    r = Rotation.from_rotvec(np.random.default_rng(2).normal(size=(7, 3)))
    t = np.arange(21).reshape(7, 3) / 7
    whole = np.tile(np.eye(4), (7, 1, 1))
    whole[:, :3, :3], whole[:, :3, 3] = r.as_matrix(), t
    q = np.roll(r.as_quat(), 1, axis=1)
    model.pairs.extend(R=r.as_matrix(), t=t, M=whole, q=q, w=r.as_rotvec())
    return model


@pytest.mark.slow
def test_kernels_interpreter_and_differences_agree(tmp_path: Path) -> None:
    model = turns(tmp_path)
    check_against_oracle(model)
    check_against_differences(model)
    assert all(check.agrees for check in check_gradients(model._problem()))


@pytest.mark.slow
def test_single_precision(tmp_path: Path) -> None:
    single, double = turns(tmp_path, "f32"), turns(tmp_path)
    check_against_oracle(single, 1e-5)
    assert single.cost() == pytest.approx(double.cost(), rel=1e-5)


def test_values_are_those_of_numpy_and_scipy(tmp_path: Path) -> None:
    model = turns(tmp_path)
    x = np.array([0.3, -0.2, 0.5])
    q = Rotation.from_rotvec([0.1, 0.2, -0.4])
    turn = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1])
    rows = model.jacobian().residuals
    expected = np.array([[0.3, 0, 1], [0, -0.2, 0.5], [0.3, -0.2, 2]]) @ x
    np.testing.assert_allclose(rows[:3], expected, atol=1e-15)
    m = np.array([[0.3, -0.2, 1], [0.5, 2, 0.3]])
    wide, flip = np.array([[1, 2, 3], [4, 5, 6]]), np.array([[0, 1], [-1, 0]])
    parts = [m[:, 1], m[0] * x, m[:2, 1:3] @ x[1:], [np.trace(m[:, :2])], wide @ x, flip @ x[:2]]
    np.testing.assert_allclose(rows[3:15], np.concatenate(parts), atol=1e-14)
    np.testing.assert_allclose(rows[15:18], (q * turn.inv()).as_rotvec(), atol=1e-14)
    np.testing.assert_allclose(rows[18:21], q.as_quat()[:3], atol=1e-15)
    np.testing.assert_allclose(rows[33:36], 0, atol=1e-14)  # R' (x - x) / 2
    fit = rows[36:].reshape(7, 15)
    r = Rotation.from_matrix(np.asarray(model.pairs.R))
    t = np.asarray(model.pairs.t)
    np.testing.assert_allclose(fit[:, :3], r.apply(x) + t, atol=1e-14)
    np.testing.assert_allclose(fit[:, 3:6], r.apply(x) + t, atol=1e-14)
    np.testing.assert_allclose(fit[:, 6:9], r.inv().apply(x - t), atol=1e-14)
    np.testing.assert_allclose(fit[:, 9:12], r.as_rotvec() - x, atol=1e-14)
    np.testing.assert_allclose(fit[:, 12:], [1e-3 * x] * 7, atol=1e-14)


def test_defaults_are_matrices_and_rotations(tmp_path: Path) -> None:
    model = turns(tmp_path)
    np.testing.assert_array_equal(model.wide, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(model.flip, [[0, 1], [-1, 0]])
    s = np.sqrt(0.5)
    np.testing.assert_allclose(model.start, [3, 4, 5, s, 0, 0, s], atol=1e-15)
    np.testing.assert_allclose(np.abs(model.half), [0, 0, 0, 1], atol=1e-15)
    turn = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1]).as_quat()
    np.testing.assert_allclose(model.T.value, [1, 2, 3, turn[3], *turn[:3]], atol=1e-15)


NEAR = """
root Near {
    param v: vec3
    constraint vector { rotation_vector(mat3(exp(v))) }
    constraint twist { transform(transform(exp(v), [0, 0, 0]).matrix()).log() }
    constraint same { (quaternion(mat3(exp(v))) * exp(v).conj()).vec }
}
"""


@pytest.mark.sweep(4)
@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("about", ["zero", "pi", "120 degrees"])
def test_conversions_are_accurate_at_zero_and_at_the_half_turn(
    about: str, apart: float, tmp_path: Path
) -> None:
    """The vector of the matrix of the rotation of v is v, and its derivative the identity."""
    path = tmp_path / "near.arael"
    path.write_text(NEAR)
    kind = load(path, interpret=True)
    angle = {"zero": apart, "pi": np.pi - max(apart, 1e-6), "120 degrees": 2 * np.pi / 3 + apart}
    for axis in ([1, 0, 0], [0, 0, -1], [0.6, -0.8, 0], [2 / 3, 1 / 3, -2 / 3]):
        v = angle[about] * np.array(axis)
        model = kind(v=v)
        rows = model.jacobian()
        np.testing.assert_allclose(rows.residuals[:3], v, rtol=1e-14, atol=3e-16)
        np.testing.assert_allclose(rows.residuals[6:9], v, rtol=1e-14, atol=3e-16)
        np.testing.assert_allclose(rows.residuals[9:], 0, atol=5e-16)
        dense = rows.dense()
        np.testing.assert_allclose(dense[:3], np.eye(3), atol=2e-9)
        np.testing.assert_allclose(dense[6:9], np.eye(3), atol=2e-9)
        np.testing.assert_allclose(dense[9:], 0, atol=1e-9)
