"""Rotations stored as unit quaternions, and moved in the body frame."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import quaternion, rotation
from arael.manifolds.linear import Vector, flatten, matrix
from arael.manifolds.parameters.kind import AXES, Caches, ParameterType, Tangents, by_columns
from arael.symbolic.graph import Graph

NO_TURN = (1.0, 0.0, 0.0, 0.0)
PARTS = (".w", *AXES)


def _retract_rotation(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    """``q q(R(delta))``, delta small Euler angles in the body frame; normalised."""
    turned = quaternion.product(g, stored, rotation.quaternion_of_euler(g, delta))
    return quaternion.normalized(g, turned)


def retract_quaternion(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    """``q exp(delta/2)``, delta a rotation vector in the body frame; normalised."""
    return quaternion.normalized(g, quaternion.product(g, stored, quaternion.exp(g, delta)))


def _local_rotation(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    """Euler angles of ``q0* q``."""
    return rotation.euler_angles(g, quaternion.rotation_matrix(g, _turn(g, base, stored)))


def _local_quaternion(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    """``2 log(q0* q)``, a rotation vector of length at most pi."""
    return quaternion.log(g, _turn(g, base, stored))


def _turn(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    return quaternion.product(g, quaternion.conj(g, base), stored)


def quaternion_tangent(g: Graph, stored: Sequence[int], caches: Caches) -> Tangents:
    """Return ``q (0, e_k) / 2``, of Euler angles as of rotation vectors: they agree near zero."""
    half, zero = g.const(0.5), g.const(0.0)
    by = []
    for k in range(3):
        step = [zero] * 4
        step[k + 1] = half
        by.append(quaternion.product(g, stored, step))
    return by_columns(g, by)


def quaternion_caches(g: Graph, stored: Sequence[int]) -> Caches:
    """Rotation matrix, body to world."""
    return {"R": flatten(quaternion.rotation_matrix(g, stored))}


def quaternion_cache_tangents(
    g: Graph, stored: Sequence[int], caches: Caches
) -> dict[str, Tangents]:
    """``R [e_k]x``: columns of R exchanged, which costs nothing."""
    zero = g.const(0.0)
    by: list[list[int]] = [[], [], []]
    for first, second, third in matrix(caches["R"], 3, 3):
        by[0] += [zero, third, g.op("neg", second)]
        by[1] += [g.op("neg", third), zero, first]
        by[2] += [second, g.op("neg", first), zero]
    return {"R": by_columns(g, by)}


ROTATION = ParameterType(
    "rotation",
    4,
    3,
    NO_TURN,
    _retract_rotation,
    quaternion_tangent,
    quaternion_caches,
    quaternion_cache_tangents,
    _local_rotation,
    (("R", 9),),
    PARTS,
    AXES,
)

QUATERNION = ParameterType(
    "quaternion",
    4,
    3,
    NO_TURN,
    retract_quaternion,
    quaternion_tangent,
    quaternion_caches,
    quaternion_cache_tangents,
    _local_quaternion,
    (("R", 9),),
    PARTS,
    AXES,
)
