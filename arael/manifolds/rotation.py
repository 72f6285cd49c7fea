"""Rotation matrices and Euler angles on graph nodes.

Convention: R = Rz(yaw) Ry(pitch) Rx(roll) maps body to world; Euler angles are listed roll, pitch,
yaw (rad); a rotation vector is axis times angle (rad).
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds import quaternion
from arael.manifolds.linear import Matrix, Vector
from arael.symbolic.graph import Graph


def sines(g: Graph, angles: Sequence[int]) -> tuple[Vector, Vector]:
    """Sines and cosines of `angles`."""
    return [g.op("sin", a) for a in angles], [g.op("cos", a) for a in angles]


def from_sines(g: Graph, sin: Sequence[int], cos: Sequence[int]) -> Matrix:
    """Rz(yaw) Ry(pitch) Rx(roll) from the sines and cosines of roll, pitch, yaw."""
    (sr, sp, sy), (cr, cp, cy) = sin, cos
    mul, add, sub = "mul", "add", "sub"
    sp_sr, sp_cr = g.op(mul, sp, sr), g.op(mul, sp, cr)
    return [
        [
            g.op(mul, cy, cp),
            g.op(sub, g.op(mul, cy, sp_sr), g.op(mul, sy, cr)),
            g.op(add, g.op(mul, cy, sp_cr), g.op(mul, sy, sr)),
        ],
        [
            g.op(mul, sy, cp),
            g.op(add, g.op(mul, sy, sp_sr), g.op(mul, cy, cr)),
            g.op(sub, g.op(mul, sy, sp_cr), g.op(mul, cy, sr)),
        ],
        [g.op("neg", sp), g.op(mul, cp, sr), g.op(mul, cp, cr)],
    ]


def rotation_matrix(g: Graph, rpy: Sequence[int]) -> Matrix:
    """Rotation matrix of roll, pitch, yaw (rad)."""
    return from_sines(g, *sines(g, rpy))


def rotation_matrix2(g: Graph, angle: int) -> Matrix:
    """Planar rotation by `angle` (rad), counter-clockwise."""
    return planar(g, g.op("sin", angle), g.op("cos", angle))


def planar(g: Graph, sin: int, cos: int) -> Matrix:
    """Planar rotation from sine and cosine of the angle."""
    return [[cos, g.op("neg", sin)], [sin, cos]]


def euler_angles(g: Graph, m: Matrix) -> Vector:
    """Roll, pitch, yaw (rad) of a rotation matrix; roll and yaw are undetermined at pitch +-90 deg.

    roll = atan2(M21, M22), pitch = atan2(-M20, hypot(M00, M10)), yaw = atan2(M10, M00). Neither
    needs the matrix to be exactly orthonormal.
    """
    level = g.op(
        "sqrt",
        g.op("add", g.op("mul", m[0][0], m[0][0]), g.op("mul", m[1][0], m[1][0])),
    )
    return [
        g.op("atan2", m[2][1], m[2][2]),
        g.op("atan2", g.op("neg", m[2][0]), level),
        g.op("atan2", m[1][0], m[0][0]),
    ]


def rotation_vector(g: Graph, m: Matrix) -> Vector:
    """Rotation vector (rad) of a rotation matrix, of length at most pi.

    By way of the quaternion, so it is accurate near the identity and near the half turn alike.
    """
    return quaternion.log(g, quaternion.from_rotation_matrix(g, m))


def quaternion_of_euler(g: Graph, rpy: Sequence[int]) -> Vector:
    """Return the unit quaternion qz(yaw) qy(pitch) qx(roll) of roll, pitch, yaw (rad)."""
    half = g.const(0.5)
    (sr, sp, sy), (cr, cp, cy) = sines(g, [g.op("mul", half, a) for a in rpy])
    zero = g.const(0.0)
    roll, pitch, yaw = [cr, sr, zero, zero], [cp, zero, sp, zero], [cy, zero, zero, sy]
    return quaternion.product(g, quaternion.product(g, yaw, pitch), roll)
