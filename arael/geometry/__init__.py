"""Cameras, clocks, rotations, quaternions and covariances, vectorised over arrays."""

from arael.geometry.camera import PinholeCamera, level_axes
from arael.geometry.clocks import clock_offset
from arael.geometry.covariances import (
    compose_covariance,
    decompose_covariance,
    ellipsoid,
    whiten,
)
from arael.geometry.preintegration import Preintegrated, preintegrate
from arael.geometry.quaternions import (
    quat_conjugate,
    quat_exp,
    quat_from_euler,
    quat_from_matrix,
    quat_log,
    quat_product,
    quat_rotate,
    quat_slerp,
    quat_to_euler,
    quat_to_matrix,
)
from arael.geometry.rotation_vectors import rotation_from_vector, rotation_vector
from arael.geometry.rotations import (
    euler_angles,
    rotation_matrix,
    skew,
    vee,
    wrap_angle,
)

__all__ = [
    "PinholeCamera",
    "Preintegrated",
    "clock_offset",
    "compose_covariance",
    "decompose_covariance",
    "ellipsoid",
    "euler_angles",
    "level_axes",
    "preintegrate",
    "quat_conjugate",
    "quat_exp",
    "quat_from_euler",
    "quat_from_matrix",
    "quat_log",
    "quat_product",
    "quat_rotate",
    "quat_slerp",
    "quat_to_euler",
    "quat_to_matrix",
    "rotation_from_vector",
    "rotation_matrix",
    "rotation_vector",
    "skew",
    "vee",
    "whiten",
    "wrap_angle",
]
