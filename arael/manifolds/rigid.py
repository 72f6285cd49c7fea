"""Rigid transforms and similarities on graph nodes.

A transform is listed translation (3), unit quaternion (4, scalar first) and, for a similarity, the
scale: ``x -> s R x + t``, body to world. A twist is listed rho (3), phi (3) and, for a similarity,
sigma. Formulas of se(3): J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation
in robotics" (2018), equations 172-177.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import quaternion
from arael.manifolds.linear import (
    Matrix,
    Vector,
    add,
    cross,
    divide,
    matvec,
    norm2,
    scale,
    sub,
    transpose,
)
from arael.symbolic import series
from arael.symbolic.graph import Graph

_SCALED = 8  # scalars of a similarity; a transform has no scale


def is_scaled(x: Sequence[int]) -> bool:
    """Whether `x` is a similarity."""
    return len(x) == _SCALED


def matrix_of(g: Graph, x: Sequence[int]) -> Matrix:
    """Rotation matrix R of a transform."""
    return quaternion.rotation_matrix(g, x[3:7])


def apply(g: Graph, x: Sequence[int], r: Matrix, point: Sequence[int]) -> Vector:
    """``s R point + t``; `r` is the rotation matrix of `x`."""
    turned = matvec(g, r, point)
    return add(g, scale(g, x[7], turned) if is_scaled(x) else turned, x[:3])


def apply_inverse(g: Graph, x: Sequence[int], r: Matrix, point: Sequence[int]) -> Vector:
    """``R' (point - t) / s``; `r` is the rotation matrix of `x`."""
    turned = matvec(g, transpose(r), sub(g, point, x[:3]))
    return divide(g, turned, x[7]) if is_scaled(x) else turned


def compose(
    g: Graph,
    a: Sequence[int],
    b: Sequence[int],
    r: Matrix | None = None,
    *,
    normalise: bool = False,
) -> Vector:
    """``a b``: first `b`, then `a`; `r` is the rotation matrix of `a` where it is at hand."""
    moved = apply(g, a, r or matrix_of(g, a), b[:3])
    turn = quaternion.product(g, a[3:7], b[3:7])
    if normalise:
        turn = quaternion.normalized(g, turn)
    return [*moved, *turn, *([g.op("mul", a[7], b[7])] if is_scaled(a) else [])]


def inverse(g: Graph, x: Sequence[int], r: Matrix) -> Vector:
    """Transform back; `r` is the rotation matrix of `x`."""
    zero = [g.const(0.0)] * 3
    back = [*apply_inverse(g, x, r, zero), *quaternion.conj(g, x[3:7])]
    return [*back, g.op("div", g.const(1.0), x[7])] if is_scaled(x) else back


def between(g: Graph, a: Sequence[int], b: Sequence[int], r: Matrix) -> Vector:
    """``a^-1 b``; `r` is the rotation matrix of `a`."""
    moved = apply_inverse(g, a, r, b[:3])
    turn = quaternion.product(g, quaternion.conj(g, a[3:7]), b[3:7])
    return [*moved, *turn, *([g.op("div", b[7], a[7])] if is_scaled(a) else [])]


def exp(g: Graph, twist: Sequence[int]) -> Vector:
    """Transform of a twist: ``t = V(phi) rho``, ``q = exp(phi)``, ``s = e^sigma``.

    V = I + (1 - cos)/angle^2 [phi]x + (angle - sin)/angle^3 [phi]x^2. Without sigma this is the
    exponential of SE(3).
    """
    rho, phi = list(twist[:3]), list(twist[3:6])
    t2 = norm2(g, phi)
    once = cross(g, phi, rho)
    twice = cross(g, phi, once)
    moved = add(g, rho, scale(g, series.half_versine(g, t2), once))
    moved = add(g, moved, scale(g, series.sine_rest(g, t2), twice))
    turn = quaternion.exp(g, phi)
    return [*moved, *turn, *([g.op("exp", twist[6])] if len(twist) == 7 else [])]


def log(g: Graph, x: Sequence[int]) -> Vector:
    """Twist of a transform: the inverse of `exp`, phi of length at most pi.

    V^-1 = I - [phi]x / 2 + (1/angle^2 - cot(angle/2) / (2 angle)) [phi]x^2.
    """
    phi = quaternion.log(g, x[3:7])
    t = list(x[:3])
    once = cross(g, phi, t)
    twice = cross(g, phi, once)
    rest = scale(g, series.cotangent_rest(g, norm2(g, phi)), twice)
    rho = add(g, add(g, t, scale(g, g.const(-0.5), once)), rest)
    return [*rho, *phi, *([g.op("log", x[7])] if is_scaled(x) else [])]


def homogeneous(g: Graph, x: Sequence[int], r: Matrix) -> Matrix:
    """The 4 x 4 matrix of a transform; `r` is its rotation matrix."""
    zero, one = g.const(0.0), g.const(1.0)
    turned = [scale(g, x[7], row) for row in r] if is_scaled(x) else r
    rows = [[*row, t] for row, t in zip(turned, x[:3], strict=True)]
    return [*rows, [zero, zero, zero, one]]
