"""Rotations and quaternions against SciPy, against each other, and at their singular points."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation, Slerp

from arael import geometry as g
from arael.diagnostics.records import AraelError

RNG = np.random.default_rng(11)
EA = RNG.uniform([-3, -1.5, -3], [3, 1.5, 3], (40, 3))
Q = RNG.normal(size=(40, 4))
Q /= np.linalg.norm(Q, axis=1, keepdims=True)


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def test_euler_angles_are_yaw_pitch_roll() -> None:
    expected = Rotation.from_euler("ZYX", EA[:, ::-1]).as_matrix()
    assert g.rotation_matrix(EA) == pytest.approx(expected)
    assert g.euler_angles(expected) == pytest.approx(EA)
    assert g.rotation_matrix(EA[3]) == pytest.approx(expected[3])
    assert g.rotation_matrix(EA.reshape(4, 10, 3))[2, 5] == pytest.approx(expected[25])


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_gimbal_lock_keeps_the_rotation(pitch: float) -> None:
    r = g.rotation_matrix([0.4, pitch, 1.1])
    found = g.euler_angles(r)
    assert found[0] == 0
    assert g.rotation_matrix(found) == pytest.approx(r, abs=1e-9)


def test_rotation_vectors_against_the_matrix_exponential() -> None:
    vectors = RNG.uniform(-1.8, 1.8, (20, 3))
    vectors[0] = 0
    vectors[1] = [1e-9, 0, 0]
    for v, r in zip(vectors, g.rotation_from_vector(vectors), strict=True):
        assert r == pytest.approx(expm(g.skew(v)), abs=1e-12)
    assert g.rotation_vector(g.rotation_from_vector(vectors)) == pytest.approx(vectors, abs=1e-12)


def test_skew_and_vee() -> None:
    v, u = RNG.normal(size=(2, 10, 3))
    assert np.einsum("kij,kj->ki", g.skew(v), u) == pytest.approx(np.cross(v, u))
    assert g.vee(g.skew(v)) == pytest.approx(v)


def test_wrap_angle() -> None:
    assert g.wrap_angle([0, 3.5, -3.5, 7, np.pi]) == pytest.approx(
        [0, 3.5 - 2 * np.pi, 2 * np.pi - 3.5, 7 - 2 * np.pi, -np.pi]
    )


def test_quaternions_against_scipy() -> None:
    p, q = Q[:20], Q[20:]
    product = scipy_of(p) * scipy_of(q)
    assert scipy_of(g.quat_product(p, q)).as_matrix() == pytest.approx(product.as_matrix())
    assert g.quat_to_matrix(q) == pytest.approx(scipy_of(q).as_matrix())
    v = RNG.normal(size=(20, 3))
    assert g.quat_rotate(q, v) == pytest.approx(scipy_of(q).apply(v))
    assert g.quat_log(q) == pytest.approx(scipy_of(q).as_rotvec())
    assert g.quat_to_matrix(g.quat_conjugate(q)) == pytest.approx(scipy_of(q).inv().as_matrix())
    assert g.quat_to_euler(g.quat_from_euler(EA)) == pytest.approx(EA)


def test_matrices_to_quaternions_and_back() -> None:
    found = g.quat_from_matrix(g.quat_to_matrix(Q).reshape(4, 10, 3, 3)).reshape(40, 4)
    assert (found[:, 0] >= 0).all()
    assert found == pytest.approx(np.where(Q[:, :1] < 0, -Q, Q))


def test_exponential_and_logarithm() -> None:
    vectors = RNG.uniform(-1.8, 1.8, (20, 3))
    vectors[0] = 0
    vectors[1] = [0, 1e-14, 0]
    vectors[2] = [0, 0, np.pi]
    q = g.quat_exp(vectors)
    assert np.linalg.norm(q, axis=1) == pytest.approx(1)
    assert g.quat_log(q) == pytest.approx(vectors, abs=1e-15)
    assert g.quat_log(-q[3:]) == pytest.approx(vectors[3:])
    assert g.quat_to_matrix(q) == pytest.approx(g.rotation_from_vector(vectors))


def test_slerp_against_scipy() -> None:
    t = np.linspace(0, 1, 7)
    for p, q in zip(Q[:10], Q[10:20], strict=True):
        both = Rotation.from_quat(np.roll(np.array([p, q]), -1, axis=-1))
        expected = Slerp([0, 1], both)(t).as_matrix()
        found = g.quat_slerp(p[None], q[None], t)
        assert g.quat_to_matrix(found) == pytest.approx(expected)


def test_shapes_are_checked() -> None:
    with pytest.raises(AraelError, match=r"`ea` must have shape \(\.\.\., 3\), found shape \(3, 9"):
        g.rotation_matrix(np.zeros((3, 9)))
    with pytest.raises(AraelError, match="not an array of numbers") as error:
        g.quat_log(["a", "b", "c", "d"])
    assert error.value.diagnostics[0].code == "E1031"
