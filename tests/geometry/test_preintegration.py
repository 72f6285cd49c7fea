"""Preintegration against a loop over samples and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import arael
from arael.geometry import preintegrate

NOISE = {"gyro_noise": 2e-3, "accel_noise": 3e-2}
DT = 0.01


def samples(n: int = 2, k: int = 7) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    return rng.normal(0, 2.0, (n, k, 3)), rng.normal([0, 0, 9.81], 5.0, (n, k, 3))


def by_hand(gyro: np.ndarray, accel: np.ndarray) -> tuple[Rotation, np.ndarray, np.ndarray]:
    """Rotation, velocity and position of one interval, sample by sample."""
    turned, v, p = Rotation.identity(), np.zeros(3), np.zeros(3)
    for w, a in zip(gyro, accel, strict=True):
        force = turned.apply(a)
        p, v = p + v * DT + 0.5 * force * DT**2, v + force * DT
        turned = turned * Rotation.from_rotvec(w * DT)
    return turned, v, p


def quaternion(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def change(gyro, accel, d_gyro, d_accel, h: float = 1e-6) -> np.ndarray:
    """Derivative (9,) of rotation (on its right), velocity and position along a change."""
    base = by_hand(gyro, accel)[0]
    ends = []
    for sign in (1, -1):
        turned, v, p = by_hand(gyro + sign * h * d_gyro, accel + sign * h * d_accel)
        ends.append(np.concatenate([(base.inv() * turned).as_rotvec(), v, p]))
    return (ends[0] - ends[1]) / (2 * h)


def test_motion_is_that_of_the_samples() -> None:
    gyro, accel = samples()
    bias_g, bias_a = np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.1, -0.4])
    found = preintegrate(gyro, accel, DT, gyro_bias=bias_g, accel_bias=bias_a, **NOISE)
    for k in range(2):
        turned, v, p = by_hand(gyro[k] - bias_g, accel[k] - bias_a)
        assert (quaternion(found.rotation[k]).inv() * turned).magnitude() < 1e-12
        np.testing.assert_allclose(found.velocity[k], v, atol=1e-13)
        np.testing.assert_allclose(found.position[k], p, atol=1e-14)
    np.testing.assert_allclose(found.duration, 0.07)


def test_derivatives_by_the_biases() -> None:
    gyro, accel = samples()
    found = preintegrate(gyro, accel, DT, **NOISE)
    none = np.zeros(3)
    for axis in np.eye(3):
        k = int(np.argmax(axis))
        by_gyro = change(gyro[1], accel[1], -axis, none)
        by_accel = change(gyro[1], accel[1], none, -axis)
        np.testing.assert_allclose(found.rotation_by_gyro[1, :, k], by_gyro[:3], atol=1e-9)
        np.testing.assert_allclose(found.velocity_by_gyro[1, :, k], by_gyro[3:6], atol=1e-8)
        np.testing.assert_allclose(found.position_by_gyro[1, :, k], by_gyro[6:], atol=1e-9)
        np.testing.assert_allclose(found.velocity_by_accel[1, :, k], by_accel[3:6], atol=1e-9)
        np.testing.assert_allclose(found.position_by_accel[1, :, k], by_accel[6:], atol=1e-9)


def test_covariance_is_that_of_the_noise_of_each_sample() -> None:
    gyro, accel = samples(1, 5)
    found = preintegrate(gyro, accel, DT, **NOISE)
    expected = np.zeros((9, 9))
    for i in range(5):
        for axis in np.eye(3):
            one = np.zeros((5, 3))
            one[i] = axis
            zero = np.zeros((5, 3))
            by_gyro = change(gyro[0], accel[0], one, zero) * NOISE["gyro_noise"]
            by_accel = change(gyro[0], accel[0], zero, one) * NOISE["accel_noise"]
            expected += (np.outer(by_gyro, by_gyro) + np.outer(by_accel, by_accel)) / DT
    np.testing.assert_allclose(found.covariance[0], expected, rtol=1e-6, atol=1e-12)
    whiten = found.columns()["whiten"][0]
    np.testing.assert_allclose(whiten @ expected @ whiten.T, np.eye(9), atol=1e-3)


def test_samples_of_no_duration_change_nothing() -> None:
    gyro, accel = samples(1, 4)
    dt = np.array([[DT, DT, DT, 0.0]])
    short = preintegrate(gyro[:, :3], accel[:, :3], DT, **NOISE)
    padded = preintegrate(gyro, accel, dt, **NOISE)
    for name, value in short.columns().items():
        np.testing.assert_allclose(padded.columns()[name], value, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(
    ("gyro", "noise", "message"),
    [
        (np.zeros((4, 3)), NOISE, r"as `gyro`, of shape \(4, 3\)"),
        (np.zeros((1, 3, 3)), NOISE, r"as `gyro`, of shape \(1, 3, 3\)"),
        (np.zeros((1, 4, 3)), {**NOISE, "gyro_noise": 0.0}, "a positive noise density, found 0.0"),
    ],
)
def test_wrong_arguments(gyro, noise, message: str) -> None:
    with pytest.raises(arael.AraelError, match=message):
        preintegrate(gyro, np.zeros((1, 4, 3)), DT, **noise)
