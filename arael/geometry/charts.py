"""Derivatives of retractions away from zero: from one tangent space to that of a moved value.

A parameter `x` is moved by a tangent vector `d` to ``x [+] d``. Derivatives of a model are those by
a further, small step there: ``(x [+] d) [+] e`` at e = 0. A minimiser that keeps `x` and varies `d`
needs those by `d`. They differ by the matrix D(d) with ``x [+] (d + h) = (x [+] d) [+] D h`` to
first order, which is the identity at d = 0 and wherever values are simply added to.

Formulas: right Jacobians of SO(3) and SE(3) in J. Sola, J. Deray, D. Atchuthan, "A micro Lie
theory for state estimation in robotics" (2018), equations 143 and 179; the latter here by
differentiating ``V(phi) rho``.
"""

from __future__ import annotations

import numpy as np

from arael.geometry.arrays import Array
from arael.geometry.rotation_vectors import rotation_from_vector
from arael.geometry.rotations import skew

# Below this squared angle, series; they and the closed forms are then exact to rounding.
_SMALL = 0.04


def chart_derivative(kind: str, stored: Array, delta: Array) -> Array:
    """(n, k, k) matrices D of parameters of one kind.

    Parameters
    ----------
    kind : ``real``, ``vec``, ``euler``, ``angle``, ``rotation``, ``quaternion``, ``direction``,
        ``transform`` or ``similarity``
    stored : (n, s) values that delta starts from; read for directions only
    delta : (n, k) tangent vectors; angles in radians
    """
    if kind == "rotation":
        return euler_rates(delta)
    if kind == "quaternion":
        return right_jacobian(delta)
    if kind == "direction":
        return _along_sphere(stored, delta)
    if kind in ("transform", "similarity"):
        return _twist(delta)
    return np.broadcast_to(np.eye(delta.shape[1]), (len(delta), delta.shape[1], delta.shape[1]))


def right_jacobian(phi: Array) -> Array:
    """(n, 3, 3) right Jacobian of SO(3): ``exp(phi + h) = exp(phi) exp(D h)`` to first order.

    ``I - (1 - cos t)/t^2 [phi]x + (t - sin t)/t^3 [phi]x^2`` with t = |phi|.
    """
    versine, rest, _, _ = _coefficients(phi)
    once = skew(phi)
    found: Array = np.eye(3) - versine[:, None, None] * once + rest[:, None, None] * (once @ once)
    return found


def rotation_step_matrix(phi: Array) -> Array:
    """(n, 3, 3) left Jacobian V of SO(3), which ``exp(rho, phi)`` moves by: ``V(phi) rho``."""
    versine, rest, _, _ = _coefficients(phi)
    once = skew(phi)
    found: Array = np.eye(3) + versine[:, None, None] * once + rest[:, None, None] * (once @ once)
    return found


def _coefficients(phi: Array) -> tuple[Array, Array, Array, Array]:
    """``a = (1 - cos t)/t^2``, ``b = (t - sin t)/t^3``, and their derivatives by t^2."""
    s = np.square(phi).sum(axis=-1)
    near = s < _SMALL
    t2 = np.where(near, 1.0, s)
    t = np.sqrt(t2)
    sin, cos = np.sin(t), np.cos(t)
    a, b = 2 * np.square(np.sin(t / 2)) / t2, (t - sin) / (t * t2)
    # d/ds of f(t) is f'(t) / (2 t).
    da = (sin / t - 2 * a) / (2 * t2)
    db = ((1 - cos) / t2 - 3 * b) / (2 * t2)
    series = [
        np.polynomial.polynomial.polyval(s, c)
        for c in (
            [1 / 2, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800],
            [1 / 6, -1 / 120, 1 / 5040, -1 / 362880, 1 / 39916800],
            [-1 / 24, 2 / 720, -3 / 40320, 4 / 3628800, -5 / 479001600],
            [-1 / 120, 2 / 5040, -3 / 362880, 4 / 39916800, -5 / 6227020800],
        )
    ]
    found = [np.where(near, one, other) for one, other in zip(series, (a, b, da, db), strict=True)]
    return found[0], found[1], found[2], found[3]


def euler_rates(rpy: Array) -> Array:
    """Angular velocity in the body frame per rate of roll, pitch, yaw, by columns."""
    (sr, sp), (cr, cp) = np.sin(rpy[:, :2]).T, np.cos(rpy[:, :2]).T
    one, zero = np.ones_like(sr), np.zeros_like(sr)
    roll = np.stack([one, zero, zero], axis=-1)
    pitch = np.stack([zero, cr, -sr], axis=-1)
    yaw = np.stack([-sp, cp * sr, cp * cr], axis=-1)
    return np.stack([roll, pitch, yaw], axis=-1)


def _twist(delta: Array) -> Array:
    """Of ``T exp(rho, phi)``, and of a scale ``e^sigma`` beside it, which V does not contain."""
    rho, phi = delta[:, :3], delta[:, 3:6]
    versine, rest, by_versine, by_rest = (c[:, None, None] for c in _coefficients(phi))
    turn = right_jacobian(phi)
    k, r = skew(phi), skew(rho)
    once = np.cross(phi, rho)
    twice = np.cross(phi, once)
    # V rho = rho + a phi x rho + b phi x (phi x rho), by phi.
    moved = (
        -versine * r
        + 2 * by_versine * once[:, :, None] * phi[:, None, :]
        + rest * (-skew(once) - k @ r)
        + 2 * by_rest * twice[:, :, None] * phi[:, None, :]
    )
    back = np.swapaxes(rotation_from_vector(phi), 1, 2)
    shrunk = np.exp(-delta[:, 6]) if delta.shape[1] == 7 else np.ones(len(delta))
    found = np.zeros((len(delta), delta.shape[1], delta.shape[1]))
    found[:, :3, :3] = shrunk[:, None, None] * turn  # R' V is the right Jacobian
    found[:, :3, 3:6] = shrunk[:, None, None] * (back @ moved)
    found[:, 3:6, 3:6] = turn
    if delta.shape[1] == 7:
        found[:, 6, 6] = 1.0
    return found


def _along_sphere(stored: Array, delta: Array) -> Array:
    """Of ``cos t d + sin t / t B delta``, in the basis of the tangent plane there; t = |delta|."""
    s = np.square(delta).sum(axis=-1)
    t = np.sqrt(s)
    sinc = np.sinc(t / np.pi)
    near = s < _SMALL
    series = np.polynomial.polynomial.polyval(s, [-1 / 6, 2 / 120, -3 / 5040, 4 / 362880])
    by_sinc = np.where(near, series, (np.cos(t) - sinc) / (2 * np.where(near, 1.0, s)))
    basis = tangent_basis(stored)
    along = np.einsum("nij,nj->ni", basis, delta)
    moved = np.cos(t)[:, None] * stored + sinc[:, None] * along
    by_delta = (
        -sinc[:, None, None] * stored[:, :, None] * delta[:, None, :]
        + 2 * by_sinc[:, None, None] * along[:, :, None] * delta[:, None, :]
        + sinc[:, None, None] * basis
    )
    found: Array = np.swapaxes(tangent_basis(moved), 1, 2) @ by_delta
    return found


def tangent_basis(d: Array) -> Array:
    """(n, 3, 2) the basis in which tangent vectors of directions are given.

    T. Duff and others, "Building an Orthonormal Basis, Revisited", Journal of Computer Graphics
    Techniques 6 (2017).
    """
    x, y, z = d.T
    sign = np.where(z < 0, -1.0, 1.0)
    a = -1 / (sign + z)
    b = x * y * a
    u = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    v = np.stack([b, sign + y * y * a, -y], axis=-1)
    return np.stack([u, v], axis=-1)
