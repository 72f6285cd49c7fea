"""Transforms on graph nodes, against SciPy's matrix exponential and rotations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from arael.manifolds import rigid, sphere
from arael.symbolic import series
from arael.symbolic.graph import Graph
from tests.symbolic.programs import Array, central, inputs, jacobian, run

numbers = st.floats(-2.0, 2.0, allow_subnormal=False)
SIZES = [0.0, 1e-9, 1e-3, 0.19, 0.21, 1.0, 3.1]


def stored(seed: int, scaled: bool) -> Array:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    return np.concatenate([rng.normal(size=3), q, [0.5 + rng.random()] * scaled])


def as_matrix(x: Array) -> Array:
    found = np.eye(4)
    found[:3, :3] = Rotation.from_quat(x[[4, 5, 6, 3]]).as_matrix() * (x[7] if len(x) == 8 else 1)
    found[:3, 3] = x[:3]
    return found


def hat(twist: Array) -> Array:
    found = np.zeros((4, 4))
    x, y, z = twist[3:6]
    found[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    found[:3, 3] = twist[:3]
    return found


@pytest.mark.parametrize("size", SIZES)
def test_exponential_is_that_of_se3(size: float) -> None:
    twist = np.array([0.3, -1.2, 2.0, *(size * np.array([2, -3, 6]) / 7)])
    g = Graph()
    found = run(g, rigid.exp(g, inputs(g, 6)), twist)
    np.testing.assert_allclose(as_matrix(found), expm(hat(twist)), atol=1e-14)


@pytest.mark.parametrize("scaled", [False, True])
@pytest.mark.parametrize("size", SIZES)
def test_logarithm_undoes_the_exponential(size: float, scaled: bool) -> None:
    twist = np.array([0.3, -1.2, 2.0, *(size * np.array([2, -3, 6]) / 7), *([0.4] * scaled)])
    g = Graph()
    found = run(g, rigid.log(g, rigid.exp(g, inputs(g, len(twist)))), twist)
    np.testing.assert_allclose(found, twist, atol=2e-14)


@pytest.mark.sweep(3, slow=("3.1",))
@pytest.mark.parametrize("size", SIZES)
def test_derivative_of_the_logarithm(size: float) -> None:
    twist = np.array([0.3, -1.2, 2.0, *(size * np.array([2, -3, 6]) / 7)])
    g = Graph()
    x = inputs(g, 6)
    there_and_back = rigid.log(g, rigid.exp(g, x))
    np.testing.assert_allclose(jacobian(g, there_and_back, x, twist), np.eye(6), atol=1e-11)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.booleans())
def test_algebra_is_that_of_matrices(seed: int, scaled: bool) -> None:
    a, b = stored(seed, scaled), stored(seed + 1, scaled)
    point = np.random.default_rng(seed).normal(size=3)
    n = len(a)
    g = Graph()
    x, y, p = inputs(g, n, "a"), inputs(g, n, "b"), inputs(g, 3, "p")
    r = rigid.matrix_of(g, x)
    given_ = [*a, *b, *point]
    ma, mb = as_matrix(a), as_matrix(b)

    def value(nodes: list[int]) -> Array:
        return run(g, nodes, given_)

    np.testing.assert_allclose(as_matrix(value(rigid.compose(g, x, y))), ma @ mb, atol=1e-13)
    np.testing.assert_allclose(as_matrix(value(rigid.inverse(g, x, r))) @ ma, np.eye(4), atol=1e-13)
    between = as_matrix(value(rigid.between(g, x, y, r)))
    np.testing.assert_allclose(between, np.linalg.solve(ma, mb), atol=1e-13)
    homogeneous = [n for row in rigid.homogeneous(g, x, r) for n in row]
    np.testing.assert_allclose(value(homogeneous).reshape(4, 4), ma, atol=1e-14)
    np.testing.assert_allclose(value(rigid.apply(g, x, r, p)), (ma @ [*point, 1])[:3], atol=1e-14)
    back = value(rigid.apply_inverse(g, x, r, p))
    np.testing.assert_allclose(back, np.linalg.solve(ma, [*point, 1])[:3], atol=1e-13)


@pytest.mark.parametrize(
    "d", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (0.6, 0, -0.8), (0.36, 0.48, 0.8)]
)
def test_basis_of_the_tangent_plane(d: tuple[float, ...]) -> None:
    g = Graph()
    basis = sphere.basis(g, inputs(g, 3))
    u, v = run(g, [n for row in basis for n in row], d).reshape(3, 2).T
    frame = np.stack([u, v, np.array(d)])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(np.cross(u, v), d, atol=1e-15)


@settings(max_examples=30, deadline=None)
@given(st.tuples(numbers, numbers), st.integers(0, 100))
def test_a_step_goes_its_length_along_the_sphere(delta: tuple[float, ...], seed: int) -> None:
    d = stored(seed, False)[:3]
    d /= np.linalg.norm(d)
    g = Graph()
    x, e = inputs(g, 3, "d"), inputs(g, 2, "e")
    there = run(g, sphere.move(g, x, e), [*d, *delta])
    length = np.linalg.norm(delta)
    assert np.linalg.norm(there) == pytest.approx(1, abs=1e-15)
    assert there @ d == pytest.approx(np.cos(length), abs=1e-13)


@pytest.mark.parametrize("name", ["cosine", "sinc", "half_versine", "sine_rest", "cotangent_rest"])
def test_series_meet_their_closed_forms(name: str) -> None:
    g = Graph()
    (x,) = inputs(g, 1)
    f = getattr(series, name)(g, x)
    for below in (0.04, 0.03):
        left, right = run(g, [f], [np.nextafter(below, 0)]), run(g, [f], [0.04])
        if below == 0.04:
            np.testing.assert_allclose(left, right, rtol=2e-13)
    for t2 in (1e-3, 0.0399, 0.0401, 1.0, 6.0):
        difference = central(g, [f], [t2])
        np.testing.assert_allclose(jacobian(g, [f], [x], [t2]), difference, rtol=2e-6)
    assert np.isfinite(jacobian(g, [f], [x], [0.0])).all()
