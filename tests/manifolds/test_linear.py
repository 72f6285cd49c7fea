"""Vectors and matrices against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.manifolds import linear
from arael.manifolds.inverse import det, inverse
from arael.symbolic.graph import Graph
from tests.symbolic.programs import complex_step, inputs, jacobian, run

rng = np.random.default_rng(11)


def test_vectors() -> None:
    a, b = rng.normal(size=(2, 3))
    g = Graph()
    u, v = inputs(g, 3, "u"), inputs(g, 3, "v")
    point = [*a, *b]
    for nodes, expected in (
        ([linear.dot(g, u, v)], [a @ b]),
        (linear.cross(g, u, v), np.cross(a, b)),
        (linear.add(g, u, v), a + b),
        (linear.sub(g, u, v), a - b),
        (linear.neg(g, u), -a),
        (linear.scale(g, v[0], u), b[0] * a),
        (linear.divide(g, u, v[0]), a / b[0]),
        ([linear.norm(g, u)], [np.linalg.norm(a)]),
        ([linear.norm(g, u[:1])], [abs(a[0])]),
        ([linear.norm2(g, u)], [a @ a]),
        (linear.unit(g, u), a / np.linalg.norm(a)),
        (linear.perp(g, u[:2]), [-a[1], a[0]]),
        (linear.flatten(linear.outer(g, u, v)), np.outer(a, b).ravel()),
    ):
        np.testing.assert_allclose(run(g, nodes, point), expected, rtol=1e-14)


def test_skew_is_the_cross_product_and_vee_its_inverse() -> None:
    g = Graph()
    u, v = inputs(g, 3, "u"), inputs(g, 3, "v")
    a, b = rng.normal(size=(2, 3))
    product = linear.matvec(g, linear.skew(g, u), v)
    np.testing.assert_allclose(run(g, product, [*a, *b]), np.cross(a, b), rtol=1e-14)
    assert linear.vee(g, linear.skew(g, u)) == u


def test_matrices() -> None:
    a, b = rng.normal(size=(2, 3)), rng.normal(size=(3, 4))
    g = Graph()
    ma = linear.matrix(inputs(g, 6, "a"), 2, 3)
    mb = linear.matrix(inputs(g, 12, "b"), 3, 4)
    point = [*a.ravel(), *b.ravel()]
    product = linear.matmul(g, ma, mb)
    assert (len(product), len(product[0])) == (2, 4)
    np.testing.assert_allclose(run(g, linear.flatten(product), point), (a @ b).ravel(), rtol=1e-13)
    assert linear.transpose(linear.transpose(ma)) == ma
    np.testing.assert_allclose(
        run(g, linear.flatten(linear.transpose(mb)), point), b.T.ravel(), rtol=0
    )


def test_structure_of_identity_and_zero_is_used() -> None:
    g = Graph()
    m = linear.matrix(inputs(g, 9), 3, 3)
    assert linear.matmul(g, linear.identity(g, 3), m) == m
    assert linear.matmul(g, m, linear.zeros(g, 3, 2)) == linear.zeros(g, 3, 2)
    assert linear.total(g, []) == g.const(0.0)


@pytest.mark.sweep(slow=("5", "6"))
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6])
def test_determinant_and_inverse(n: int) -> None:
    root = rng.normal(size=(n, n))
    values = root @ root.T + np.eye(n)  # definite: no pivot vanishes
    g = Graph()
    m = linear.matrix(inputs(g, n * n), n, n)
    nodes = linear.flatten(inverse(g, m))
    point = values.ravel()
    np.testing.assert_allclose(
        run(g, nodes, point), np.linalg.inv(values).ravel(), rtol=1e-10, atol=1e-12
    )
    slopes = jacobian(g, nodes, inputs(g, n * n), point)
    np.testing.assert_allclose(slopes, complex_step(g, nodes, point), rtol=1e-8, atol=1e-10)
    if n <= 4:
        assert run(g, [det(g, m)], point)[0] == pytest.approx(np.linalg.det(values), rel=1e-12)
        trace = linear.trace(g, m)
        assert run(g, [trace], point)[0] == pytest.approx(np.trace(values), rel=1e-14)


def test_small_inverses_need_no_pivot() -> None:
    g = Graph()
    m = linear.matrix(inputs(g, 4), 2, 2)
    found = run(g, linear.flatten(inverse(g, m)), [0.0, 2.0, 4.0, 0.0])
    np.testing.assert_array_equal(found, [0.0, 0.25, 0.5, 0.0])


def test_limits_of_determinant_and_inverse() -> None:
    g = Graph()
    with pytest.raises(ValueError, match="up to 4 x 4, not 5 x 5"):
        det(g, linear.identity(g, 5))
    with pytest.raises(ValueError, match="up to 6 x 6, not 7 x 7"):
        inverse(g, linear.identity(g, 7))
    with pytest.raises(ValueError, match="square"):
        inverse(g, linear.zeros(g, 2, 3))
    with pytest.raises(ValueError, match="do not fill"):
        linear.matrix([1, 2, 3], 2, 2)
