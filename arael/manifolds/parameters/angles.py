"""Parameters stored as angles: Euler angles and the planar heading."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import rotation
from arael.manifolds.linear import Vector, add, flatten, matrix
from arael.manifolds.parameters.kind import (
    AXES,
    Caches,
    ParameterType,
    Tangents,
    by_columns,
    diagonal,
    difference,
)
from arael.symbolic.graph import Graph
from arael.symbolic.operators import Scalar
from arael.symbolic.scalars.composed import wrap


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
        "R": by_columns(g, (roll, pitch, yaw)),
    }


EULER = ParameterType(
    "euler",
    3,
    3,
    (0.0, 0.0, 0.0),
    add,
    diagonal,
    _euler_caches,
    _euler_cache_tangents,
    difference,
    (("sin", 3), ("cos", 3), ("R", 9)),
    AXES,
    AXES,
)


def _retract_angle(g: Graph, stored: Sequence[int], delta: Sequence[int]) -> Vector:
    return [wrap(Scalar(g, stored[0]) + Scalar(g, delta[0])).node]


def _local_angle(g: Graph, base: Sequence[int], stored: Sequence[int]) -> Vector:
    return [wrap(Scalar(g, stored[0]) - Scalar(g, base[0])).node]


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


ANGLE = ParameterType(
    "angle",
    1,
    1,
    (0.0,),
    _retract_angle,
    diagonal,
    _angle_caches,
    _angle_cache_tangents,
    _local_angle,
    (("sin", 1), ("cos", 1), ("R", 4)),
    ("",),
    ("",),
)
