"""Rigid transforms and similarities, moved by a twist in the body frame."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import rigid
from arael.manifolds.linear import Vector, matrix
from arael.manifolds.parameters.kind import (
    AXES,
    Caches,
    ParameterType,
    Tangents,
    shifted,
)
from arael.manifolds.parameters.rotations import (
    NO_TURN,
    PARTS,
    quaternion_cache_tangents,
    quaternion_caches,
    quaternion_tangent,
)
from arael.symbolic.graph import Graph

_TRANSLATION = tuple(f".translation{axis}" for axis in AXES)
_ROTATION = tuple(f".rotation{axis}" for axis in AXES)


def _retract(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    """``T exp(delta)``; the quaternion normalised."""
    return rigid.compose(g, stored, rigid.exp(g, delta), normalise=True)


def _local(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    """``log(T0^-1 T)``."""
    return rigid.log(g, rigid.between(g, base, stored, rigid.matrix_of(g, base)))


def _caches(g: Graph, stored: Sequence[int]) -> Caches:
    return quaternion_caches(g, stored[3:7])


def _tangent(g: Graph, stored: Sequence[int], caches: Caches) -> Tangents:
    """``dt = s R rho``, ``dq = q (0, phi) / 2``, ``ds = s sigma``."""
    scaled = len(stored) == 8
    rows = matrix(caches["R"], 3, 3)
    if scaled:
        rows = [[g.op("mul", stored[7], entry) for entry in row] for row in rows]
    found = [dict(enumerate(row)) for row in rows]
    found += shifted(quaternion_tangent(g, stored[3:7], caches), 3)
    return [*found, {6: stored[7]}] if scaled else found


def _cache_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    of_rotation = quaternion_cache_tangents(g, stored[3:7], caches)
    return {"R": shifted(of_rotation["R"], 3)}


def _parts(scaled: bool) -> tuple[tuple[str, int, int], ...]:
    rigid_parts = (("translation", 0, 3), ("rotation", 3, 3))
    return (*rigid_parts, ("scale", 6, 1)) if scaled else rigid_parts


TRANSFORM = ParameterType(
    "transform",
    7,
    6,
    (0.0, 0.0, 0.0, *NO_TURN),
    _retract,
    _tangent,
    _caches,
    _cache_tangents,
    _local,
    (("R", 9),),
    (*_TRANSLATION, *(f".rotation{part}" for part in PARTS)),
    (*_TRANSLATION, *_ROTATION),
    _parts(scaled=False),
)

SIMILARITY = ParameterType(
    "similarity",
    8,
    7,
    (0.0, 0.0, 0.0, *NO_TURN, 1.0),
    _retract,
    _tangent,
    _caches,
    _cache_tangents,
    _local,
    (("R", 9),),
    (*TRANSFORM.stored_names, ".scale"),
    (*TRANSFORM.tangent_names, ".scale"),
    _parts(scaled=True),
)
