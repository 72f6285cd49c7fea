"""Rotations and quaternions against SciPy, and smooth where they should be."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from arael.manifolds import linear, quaternion, rotation
from arael.symbolic.graph import Graph
from tests.symbolic.programs import central, inputs, jacobian, run

Program = Callable[[Graph, list[int]], list[int]]
angles = st.floats(-3.1, 3.1, allow_subnormal=False)
vectors = st.tuples(angles, angles, angles)


def scalar_first(r: Rotation) -> np.ndarray:
    return np.roll(r.as_quat(), 1)


def of(program: Program, point: object, n: int = 3) -> np.ndarray:
    g = Graph()
    return run(g, program(g, inputs(g, n)), list(point))  # type: ignore[call-overload]


def euler_matrix(g: Graph, x: list[int]) -> list[int]:
    return linear.flatten(rotation.rotation_matrix(g, x))


def exp_matrix(g: Graph, x: list[int]) -> list[int]:
    return linear.flatten(quaternion.rotation_matrix(g, quaternion.exp(g, x)))


def matrix_vector(g: Graph, x: list[int]) -> list[int]:
    return rotation.rotation_vector(g, linear.matrix(x, 3, 3))


@settings(max_examples=60, deadline=None)
@given(vectors)
def test_euler_angles_make_the_documented_matrix(rpy: tuple[float, ...]) -> None:
    found = of(euler_matrix, rpy).reshape(3, 3)
    expected = Rotation.from_euler("ZYX", rpy[::-1]).as_matrix()
    np.testing.assert_allclose(found, expected, atol=1e-14)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-14)
    q = of(rotation.quaternion_of_euler, rpy)
    as_matrix = of(lambda g, x: linear.flatten(quaternion.rotation_matrix(g, x)), q, 4)
    np.testing.assert_allclose(as_matrix.reshape(3, 3), expected, atol=1e-14)


@settings(max_examples=60, deadline=None)
@given(st.tuples(angles, st.floats(-1.5, 1.5), angles))
def test_euler_angles_come_back(rpy: tuple[float, ...]) -> None:
    def back(g: Graph, x: list[int]) -> list[int]:
        return rotation.euler_angles(g, rotation.rotation_matrix(g, x))

    def by_quaternion(g: Graph, x: list[int]) -> list[int]:
        return rotation.euler_angles(
            g, quaternion.rotation_matrix(g, rotation.quaternion_of_euler(g, x))
        )

    np.testing.assert_allclose(of(back, rpy), rpy, atol=1e-13)
    np.testing.assert_allclose(of(by_quaternion, rpy), rpy, atol=1e-13)


@settings(max_examples=80, deadline=None)
@given(vectors)
def test_exponential_and_logarithm(v: tuple[float, ...]) -> None:
    r = Rotation.from_rotvec(v)
    np.testing.assert_allclose(of(exp_matrix, v).reshape(3, 3), r.as_matrix(), atol=1e-14)
    q = of(quaternion.exp, v)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    for sign in (1.0, -1.0):
        found = of(quaternion.log, sign * q, 4)
        assert np.linalg.norm(found) <= np.pi + 1e-12
        np.testing.assert_allclose(
            Rotation.from_rotvec(found).as_matrix(), r.as_matrix(), atol=1e-13
        )


@pytest.mark.sweep(3)
@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, 1e-4, 3e-3, 0.006, 0.07, 1.0, 2.2, 3.0])
def test_rotation_vectors_come_back_with_unit_derivative(angle: float) -> None:
    """Through both series and closed forms, and the joints between them."""
    axis = np.array([0.48, -0.6, 0.64])
    for program in (
        lambda g, x: rotation.rotation_vector(g, linear.matrix(exp_matrix(g, x), 3, 3)),
        lambda g, x: quaternion.log(g, quaternion.exp(g, x)),
    ):
        g = Graph()
        x = inputs(g, 3)
        nodes = program(g, x)
        np.testing.assert_allclose(run(g, nodes, angle * axis), angle * axis, rtol=1e-13)
        np.testing.assert_allclose(
            jacobian(g, nodes, x, angle * axis), np.eye(3), atol=2e-10 if angle > 2 else 1e-11
        )


def test_rotation_vector_at_and_near_half_turns() -> None:
    for axis in (*np.eye(3), np.array([0.6, 0.0, 0.8]), np.array([-1.0, 1.0, 1.0]) / 3**0.5):
        for angle in (np.pi, np.pi - 1e-9, 2.5):
            r = Rotation.from_rotvec(angle * axis).as_matrix()
            found = of(
                lambda g, x: rotation.rotation_vector(g, linear.matrix(x, 3, 3)), r.ravel(), 9
            )
            np.testing.assert_allclose(Rotation.from_rotvec(found).as_matrix(), r, atol=1e-13)
            assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-8)


@pytest.mark.parametrize("v", [(0.0, 0.0, 0.0), (1e-9, 0.0, 0.0), (0.03, -0.04, 0.02), (1, 2, -1)])
def test_derivative_of_the_exponential(v: tuple[float, ...]) -> None:
    g = Graph()
    x = inputs(g, 3)
    nodes = exp_matrix(g, x)
    np.testing.assert_allclose(jacobian(g, nodes, x, v), central(g, nodes, v), atol=1e-9)


def test_derivative_of_the_logarithm_at_the_identity() -> None:
    g = Graph()
    q = inputs(g, 4)
    found = jacobian(g, quaternion.log(g, q), q, [1.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(found, np.eye(4)[1:] * 2)


def test_quaternion_algebra() -> None:
    rng = np.random.default_rng(5)
    a, b = Rotation.random(2, random_state=8)
    v = rng.normal(size=3)
    g = Graph()
    p, q, x = inputs(g, 4, "p"), inputs(g, 4, "q"), inputs(g, 3)
    point = [*scalar_first(a), *scalar_first(b), *v]
    product = run(g, quaternion.product(g, p, q), point)
    expected = scalar_first(a * b)
    np.testing.assert_allclose(product * np.sign(product @ expected), expected, atol=1e-15)
    np.testing.assert_allclose(run(g, quaternion.rotate(g, p, x), point), a.apply(v), atol=1e-14)
    one = run(g, quaternion.product(g, p, quaternion.conj(g, p)), point)
    np.testing.assert_allclose(one, [1, 0, 0, 0], atol=1e-15)
    thrice = linear.scale(g, g.const(3.0), p)
    inverse = quaternion.product(g, thrice, quaternion.inverse(g, thrice))
    np.testing.assert_allclose(run(g, inverse, point), [1, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(
        run(g, quaternion.normalized(g, thrice), point), point[:4], atol=1e-15
    )


def test_planar_rotation() -> None:
    g = Graph()
    (x,) = inputs(g, 1)
    m = rotation.rotation_matrix2(g, x)
    np.testing.assert_allclose(
        run(g, linear.flatten(m), [0.3]),
        [np.cos(0.3), -np.sin(0.3), np.sin(0.3), np.cos(0.3)],
        rtol=1e-15,
    )
