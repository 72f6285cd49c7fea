"""Preintegration of inertial measurements: many samples as one relative motion.

Formulas: Forster, Carlone, Dellaert, Scaramuzza, *On-Manifold Preintegration for Real-Time
Visual-Inertial Odometry*, IEEE Transactions on Robotics 33 (2017), section VI and appendix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from arael.diagnostics.arguments import wrong_argument
from arael.geometry.arrays import Array, as_array, as_numbers
from arael.geometry.quaternions import quat_from_matrix
from arael.geometry.rotation_vectors import rotation_from_vector
from arael.geometry.rotations import skew


@dataclass(frozen=True)
class Preintegrated:
    """Relative motions over n intervals, in the body frame at the start of each.

    Attributes
    ----------
    duration : (n,) [s]
    rotation : unit quaternions (n, 4), body at the end to body at the start
    velocity, position : changes (n, 3) without gravity [m/s], [m]; position also without the
        velocity at the start
    gyro_bias, accel_bias : biases (n, 3) that were subtracted [rad/s], [m/s^2]
    rotation_by_gyro, velocity_by_gyro, position_by_gyro : derivatives (n, 3, 3) by the bias of the
        gyroscope; of the rotation on its right, as a rotation vector
    velocity_by_accel, position_by_accel : derivatives (n, 3, 3) by the bias of the accelerometer
    covariance : (n, 9, 9) of rotation [rad] (on its right), velocity, position
    """

    duration: Array
    rotation: Array
    velocity: Array
    position: Array
    gyro_bias: Array
    accel_bias: Array
    rotation_by_gyro: Array
    velocity_by_gyro: Array
    velocity_by_accel: Array
    position_by_gyro: Array
    position_by_accel: Array
    covariance: Array

    def columns(self) -> dict[str, Array]:
        """Columns of a model: all but the covariance, and `whiten` (n, 9, 9).

        ``whiten @ r`` has unit covariance for a residual r with that covariance.
        """
        found = {name: getattr(self, name) for name in self.__dataclass_fields__}
        lower = np.linalg.cholesky(found.pop("covariance"))
        found["whiten"] = np.linalg.inv(lower)
        return found


def _right_jacobian(v: Array) -> Array:
    """Right Jacobians (..., 3, 3) of SO(3) at rotation vectors (..., 3)."""
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    k = skew(v)
    safe = np.where(angle < 1e-2, 1.0, angle)
    # The difference of angle and sine cancels near zero.
    second = np.where(angle < 1e-2, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    found: Array = np.eye(3) - 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * k + second * (k @ k)
    return found


def preintegrate(
    gyro: ArrayLike,
    accel: ArrayLike,
    dt: ArrayLike,
    *,
    gyro_bias: ArrayLike = (0.0, 0.0, 0.0),
    accel_bias: ArrayLike = (0.0, 0.0, 0.0),
    gyro_noise: float,
    accel_noise: float,
) -> Preintegrated:
    """Integrate n intervals of k samples each, with derivatives by the biases and covariance.

    Parameters
    ----------
    gyro, accel : (n, k, 3) angular rates [rad/s] and specific forces [m/s^2] in the body frame,
        constant during each sample
    dt : duration of the samples [s]: one number, or (n, k); samples of zero duration change
        nothing, so that intervals of fewer samples are padded with them
    gyro_bias, accel_bias : (3,) or (n, 3), subtracted from the samples
    gyro_noise, accel_noise : noise densities [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]

    Raises
    ------
    AraelError
        E1031 or E0828 for arrays of other shapes, or a noise that is not positive.
    """
    rates, forces = as_array(gyro, (3,), "gyro"), as_array(accel, (3,), "accel")
    if rates.ndim != 3 or rates.shape != forces.shape:
        shape = f"an array (n, k, 3) as `gyro`, of shape {rates.shape}"
        raise wrong_argument("preintegrate", "accel", shape, forces)
    for name, density in (("gyro_noise", gyro_noise), ("accel_noise", accel_noise)):
        found = as_numbers(density, name)
        if found.shape != () or not found > 0:
            raise wrong_argument("preintegrate", name, "a positive noise density", density)
    n, count = rates.shape[:2]
    durations = as_numbers(dt, "dt")
    if durations.shape not in ((), (n, count)):
        raise wrong_argument("preintegrate", "dt", f"a number or an array {(n, count)}", durations)
    steps = np.broadcast_to(durations, (n, count))
    bias_g = np.broadcast_to(as_array(gyro_bias, (3,), "gyro_bias"), (n, 3)).copy()
    bias_a = np.broadcast_to(as_array(accel_bias, (3,), "accel_bias"), (n, 3)).copy()

    turned = np.tile(np.eye(3), (n, 1, 1))
    v, p = np.zeros((n, 3)), np.zeros((n, 3))
    r_g, v_g, v_a, p_g, p_a = (np.zeros((n, 3, 3)) for _ in range(5))
    covariance = np.zeros((n, 9, 9))
    for i in range(count):
        h = steps[:, i, None]
        hh = h[:, :, None]
        w, a = rates[:, i] - bias_g, forces[:, i] - bias_a
        step = rotation_from_vector(w * h)
        back = np.swapaxes(step, 1, 2)
        by_rate = _right_jacobian(w * h) * hh
        lever = turned @ skew(a)  # minus the derivative of the force by a turn of the body

        # The transition of the error (rotation, velocity, position), and of the noise into it.
        move = np.tile(np.eye(9), (n, 1, 1))
        move[:, :3, :3] = back
        move[:, 3:6, :3] = -lever * hh
        move[:, 6:, :3] = -0.5 * lever * hh**2
        move[:, 6:, 3:6] = np.eye(3) * hh
        noise = np.zeros((n, 9, 6))
        noise[:, :3, :3] = by_rate * gyro_noise
        noise[:, 3:6, 3:] = turned * hh * accel_noise
        noise[:, 6:, 3:] = 0.5 * turned * hh**2 * accel_noise
        # A density of q has the variance q^2 / dt in a sample of duration dt.
        noise /= np.sqrt(np.where(hh > 0, hh, 1.0))
        covariance = move @ covariance @ np.swapaxes(move, 1, 2)
        covariance += noise @ np.swapaxes(noise, 1, 2)

        # In the order that uses the values at the start of the sample.
        p_a = p_a + v_a * hh - 0.5 * turned * hh**2
        p_g = p_g + v_g * hh - 0.5 * lever @ r_g * hh**2
        v_a = v_a - turned * hh
        v_g = v_g - lever @ r_g * hh
        r_g = back @ r_g - by_rate

        force = np.einsum("nij,nj->ni", turned, a)
        p = p + v * h + 0.5 * force * h**2
        v = v + force * h
        turned = turned @ step
    return Preintegrated(
        duration=steps.sum(axis=1),
        rotation=quat_from_matrix(turned),
        velocity=v,
        position=p,
        gyro_bias=bias_g,
        accel_bias=bias_a,
        rotation_by_gyro=r_g,
        velocity_by_gyro=v_g,
        velocity_by_accel=v_a,
        position_by_gyro=p_g,
        position_by_accel=p_a,
        covariance=covariance,
    )
