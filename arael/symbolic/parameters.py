"""The mathematics of the parameter types, as graph programs.

A parameter is stored as some scalars and moved by a tangent vector `delta`, possibly a shorter one.
Derivatives are always taken at delta = 0, since deltas are folded into the stored value after every
accepted step. What is costly to compute from the stored value alone (sines, rotation matrices) is
cached once per entity; constraints read the caches as inputs.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from arael.symbolic import quaternion, rotation
from arael.symbolic.graph import Graph
from arael.symbolic.linear import Vector, add, flatten, matrix
from arael.symbolic.scalars.angles import wrap

Tangents = list[dict[int, int]]
"""Per scalar, its derivative by each component of delta that it depends on, as a node."""

Caches = dict[str, Vector]

_SHORTEST_VECTOR, _LONGEST_VECTOR = 1, 64
_VECTOR_NAME = re.compile(r"vec(\d{1,3})\Z", re.ASCII)


@dataclass(frozen=True)
class ParameterType:
    """One type of parameter.

    Attributes
    ----------
    name : as the language spells it
    storage : number of scalars stored
    tangent_width : number of scalars solved for
    neutral : stored value of a parameter that was given none
    retract : (graph, stored, delta) -> stored value moved by delta
    tangent : (graph, stored) -> derivative of the stored scalars by delta, at delta = 0
    caches : (graph, stored) -> values worth keeping per entity, by name; matrices row by row
    cache_tangents : (graph, stored, caches) -> derivative of each cached value by delta at 0
    cache_names : the names in `caches` with their numbers of scalars
    """

    name: str
    storage: int
    tangent_width: int
    neutral: tuple[float, ...]
    retract: Callable[[Graph, Sequence[int], Sequence[int]], Vector]
    tangent: Callable[[Graph, Sequence[int]], Tangents]
    caches: Callable[[Graph, Sequence[int]], Caches]
    cache_tangents: Callable[[Graph, Sequence[int], Caches], dict[str, Tangents]]
    cache_names: tuple[tuple[str, int], ...] = ()

    @property
    def flat(self) -> bool:
        """Whether the stored value is simply added to."""
        return self.retract is add


def _diagonal(g: Graph, stored: Sequence[int]) -> Tangents:
    one = g.const(1.0)
    return [{k: one} for k in range(len(stored))]


def _no_caches(g: Graph, stored: Sequence[int]) -> Caches:
    return {}


def _no_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    return {}


def _plain(name: str, width: int) -> ParameterType:
    return ParameterType(
        name, width, width, (0.0,) * width, add, _diagonal, _no_caches, _no_tangents
    )


def _columns_to_tangents(g: Graph, by: Sequence[Sequence[int]]) -> Tangents:
    """From the derivatives by each component of delta, to those of each scalar; zeros left out."""
    return [
        {k: entry for k, entry in enumerate(entries) if g.value(entry) != 0}
        for entries in zip(*by, strict=True)
    ]


# Euler angles


def _euler_caches(g: Graph, stored: Sequence[int]) -> Caches:
    sin, cos = rotation.sines(g, stored)
    return {"sin": sin, "cos": cos, "R": flatten(rotation.from_sines(g, sin, cos))}


def _euler_cache_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    """From the cached sines and R alone.

    dR/droll = R [ex]x, since Rx stands last; dR/dpitch = R [(0, cos roll, -sin roll)]x, the pitch
    axis seen from the body; dR/dyaw = [ez]x R, since Rz stands first.
    """
    sin, cos = caches["sin"], caches["cos"]
    r = matrix(caches["R"], 3, 3)
    zero = g.const(0.0)
    roll: list[int] = []
    pitch: list[int] = []
    for first, second, third in r:
        roll += [zero, third, g.op("neg", second)]
        along = g.op("add", g.op("mul", sin[0], second), g.op("mul", cos[0], third))
        pitch += [g.op("neg", along), g.op("mul", sin[0], first), g.op("mul", cos[0], first)]
    yaw = [*(g.op("neg", entry) for entry in r[1]), *r[0], zero, zero, zero]
    return {
        "sin": [{k: cos[k]} for k in range(3)],
        "cos": [{k: g.op("neg", sin[k])} for k in range(3)],
        "R": _columns_to_tangents(g, (roll, pitch, yaw)),
    }


# Unit quaternions


def _retract_rotation(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    """``q q(R(delta))``, delta small Euler angles in the body frame; normalised."""
    turned = quaternion.product(g, stored, rotation.quaternion_of_euler(g, delta))
    return quaternion.normalized(g, turned)


def _retract_quaternion(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    """``q exp(delta/2)``, delta a rotation vector in the body frame; normalised."""
    return quaternion.normalized(g, quaternion.product(g, stored, quaternion.exp(g, delta)))


def _quaternion_tangent(g: Graph, stored: Sequence[int]) -> Tangents:
    """Return ``q (0, e_k) / 2``, of Euler angles as of rotation vectors: they agree near zero."""
    half, zero = g.const(0.5), g.const(0.0)
    by = []
    for k in range(3):
        step = [zero] * 4
        step[k + 1] = half
        by.append(quaternion.product(g, stored, step))
    return _columns_to_tangents(g, by)


def _quaternion_caches(g: Graph, stored: Sequence[int]) -> Caches:
    return {"R": flatten(quaternion.rotation_matrix(g, stored))}


def _quaternion_cache_tangents(
    g: Graph, stored: Sequence[int], caches: Caches
) -> dict[str, Tangents]:
    """``R [e_k]x``: columns of R exchanged, which costs nothing."""
    zero = g.const(0.0)
    by: list[list[int]] = [[], [], []]
    for first, second, third in matrix(caches["R"], 3, 3):
        by[0] += [zero, third, g.op("neg", second)]
        by[1] += [g.op("neg", third), zero, first]
        by[2] += [second, g.op("neg", first), zero]
    return {"R": _columns_to_tangents(g, by)}


# Planar angle


def _retract_angle(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    return [wrap(g, g.op("add", stored[0], delta[0]))]


def _angle_caches(g: Graph, stored: Sequence[int]) -> Caches:
    (sin,), (cos,) = rotation.sines(g, stored)
    return {"sin": [sin], "cos": [cos], "R": flatten(rotation.planar(g, sin, cos))}


def _angle_cache_tangents(g: Graph, stored: Sequence[int], caches: Caches) -> dict[str, Tangents]:
    (sin,), (cos,) = caches["sin"], caches["cos"]
    minus_sin, minus_cos = g.op("neg", sin), g.op("neg", cos)
    return {
        "sin": [{0: cos}],
        "cos": [{0: minus_sin}],
        "R": [{0: minus_sin}, {0: minus_cos}, {0: cos}, {0: minus_sin}],
    }


_NO_TURN = (1.0, 0.0, 0.0, 0.0)

PARAMETERS: dict[str, ParameterType] = {
    "real": _plain("real", 1),
    "euler": ParameterType(
        "euler",
        3,
        3,
        (0.0, 0.0, 0.0),
        add,
        _diagonal,
        _euler_caches,
        _euler_cache_tangents,
        (("sin", 3), ("cos", 3), ("R", 9)),
    ),
    "rotation": ParameterType(
        "rotation",
        4,
        3,
        _NO_TURN,
        _retract_rotation,
        _quaternion_tangent,
        _quaternion_caches,
        _quaternion_cache_tangents,
        (("R", 9),),
    ),
    "quaternion": ParameterType(
        "quaternion",
        4,
        3,
        _NO_TURN,
        _retract_quaternion,
        _quaternion_tangent,
        _quaternion_caches,
        _quaternion_cache_tangents,
        (("R", 9),),
    ),
    "angle": ParameterType(
        "angle",
        1,
        1,
        (0.0,),
        _retract_angle,
        _diagonal,
        _angle_caches,
        _angle_cache_tangents,
        (("sin", 1), ("cos", 1), ("R", 4)),
    ),
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
    return _plain(name, int(vector[1]))
