"""The mathematics of the parameter types, as graph programs.

A parameter is stored as some scalars and moved by a tangent vector `delta`, possibly a shorter one.
Derivatives are always taken at delta = 0, since deltas are folded into the stored value after every
accepted step. What is costly to compute from the stored value alone (sines, rotation matrices) is
cached once per entity; constraints read the caches as inputs.
"""

from __future__ import annotations

import re

from arael.manifolds.parameters.angles import ANGLE, EULER
from arael.manifolds.parameters.direction import DIRECTION
from arael.manifolds.parameters.kind import Caches, ParameterType, Tangents, plain
from arael.manifolds.parameters.rigid import SIMILARITY, TRANSFORM
from arael.manifolds.parameters.rotations import QUATERNION, ROTATION

__all__ = ["PARAMETERS", "Caches", "ParameterType", "Tangents", "parameter_type"]

_SHORTEST_VECTOR, _LONGEST_VECTOR = 1, 64
_VECTOR_NAME = re.compile(r"vec(\d{1,3})\Z", re.ASCII)

PARAMETERS: dict[str, ParameterType] = {
    kind.name: kind
    for kind in (
        plain("real", 1),
        EULER,
        ROTATION,
        QUATERNION,
        ANGLE,
        DIRECTION,
        TRANSFORM,
        SIMILARITY,
    )
}


def parameter_type(name: str) -> ParameterType:
    """Return the parameter type called `name`: one of `PARAMETERS`, or ``vec<n>`` written ``vec7``.

    Raises
    ------
    KeyError
        If there is no such type.
    """
    known = PARAMETERS.get(name)
    if known is not None:
        return known
    vector = _VECTOR_NAME.match(name)
    if vector is None or not _SHORTEST_VECTOR <= int(vector[1]) <= _LONGEST_VECTOR:
        raise KeyError(name)
    return plain(name, int(vector[1]))
