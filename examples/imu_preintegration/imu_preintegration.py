"""Scale, gravity, velocities and biases from one camera and preintegrated inertial measurements.

    python imu_preintegration.py [--seconds 20] [--seed 42] [--save run.npz] [--plot FILE]

The model is `visual_inertial.arael`, which imports `imu.arael`; `arael.geometry.preintegrate` makes
one relative motion of the samples between two pictures.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import (
    Preintegrated,
    preintegrate,
    quat_conjugate,
    quat_exp,
    quat_from_matrix,
    quat_log,
    quat_product,
    quat_to_matrix,
    rotation_from_vector,
    rotation_matrix,
)

MODEL = Path(__file__).with_name("visual_inertial.arael")

RATE = 200
"""Samples in a second."""
SAMPLES = 80
"""Samples between two pictures."""
SCALE = 0.4
"""Units of the camera in a metre."""
GRAVITY = 9.81
GYRO_NOISE, ACCEL_NOISE = 2e-4, 2e-3
POS_SIGMA, Q_SIGMA = 0.002, 0.002

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """Samples and sights, with the truth.

    Attributes
    ----------
    gyro, accel : samples (n - 1, k, 3) between pictures [rad/s], [m/s^2]
    seen_pos, seen_q : poses of the camera (n, 3), (n, 4), positions in its units
    pos, q, vel : true states (n, 3) [m], (n, 4), (n, 3) [m/s] in the frame of the camera
    gyro_bias, accel_bias : true biases (3,)
    down : true direction of gravity (3,)
    """

    gyro: Array
    accel: Array
    seen_pos: Array
    seen_q: Array
    pos: Array
    q: Array
    vel: Array
    gyro_bias: Array
    accel_bias: Array
    down: Array


def make_run(seconds: float = 20.0, seed: int = 42) -> Run:
    """Generate a hand-held camera that is carried around and turned."""
    rng = np.random.default_rng(seed)
    pictures = int(seconds * RATE / SAMPLES) + 1
    count, dt = (pictures - 1) * SAMPLES, 1 / RATE
    t = (np.arange(count) + 0.5) * dt
    force = np.column_stack([2 * np.sin(1.1 * t), 1.5 * np.cos(0.8 * t), np.sin(1.7 * t + 1)])
    rate = np.column_stack([0.5 * np.sin(0.9 * t), 0.4 * np.cos(1.3 * t), 0.6 * np.sin(0.5 * t)])
    # The frame of the camera is tilted: down is not -z.
    tilt = rotation_matrix(np.array([0.3, -0.4, 0.0]))
    down = tilt @ np.array([0.0, 0.0, -1.0])

    # Rates and forces are constant during a sample, so that the sums below are the exact motion.
    turned, p, v = np.eye(3), np.zeros(3), np.array([-1.8, 0.0, -0.3])
    gyro, accel, states = np.empty((count, 3)), np.empty((count, 3)), []
    for i in range(count):
        if i % SAMPLES == 0:
            states.append((p, turned, v))
        a = tilt @ force[i]
        gyro[i], accel[i] = rate[i], turned.T @ (a - GRAVITY * down)
        p, v = p + v * dt + 0.5 * a * dt**2, v + a * dt
        turned = turned @ rotation_from_vector(rate[i] * dt)
    states.append((p, turned, v))
    pos, turns, vel = (np.array(column) for column in zip(*states, strict=True))
    q = quat_from_matrix(turns)

    gyro_bias, accel_bias = rng.normal(0, 0.02, 3), rng.normal(0, 0.1, 3)
    gyro += gyro_bias + rng.normal(0, GYRO_NOISE * np.sqrt(RATE), gyro.shape)
    accel += accel_bias + rng.normal(0, ACCEL_NOISE * np.sqrt(RATE), accel.shape)
    seen_pos = SCALE * pos + rng.normal(0, POS_SIGMA, pos.shape)
    seen_q = quat_product(q, quat_exp(rng.normal(0, Q_SIGMA, pos.shape)))
    return Run(
        gyro=gyro.reshape(-1, SAMPLES, 3),
        accel=accel.reshape(-1, SAMPLES, 3),
        seen_pos=seen_pos,
        seen_q=seen_q,
        pos=pos,
        q=q,
        vel=vel,
        gyro_bias=gyro_bias,
        accel_bias=accel_bias,
        down=down,
    )


def start(run: Run) -> tuple[Array, Array]:
    """Start of the biases of the gyroscope (3,), and of the direction of gravity (3,).

    The attitudes of the camera give the mean rate; the mean force, turned into the frame of the
    camera, is that against gravity when the motion averages out.
    """
    turn = quat_log(quat_product(quat_conjugate(run.seen_q[:-1]), run.seen_q[1:]))
    bias = np.mean(run.gyro.mean(axis=1) - turn * RATE / SAMPLES, axis=0)
    up = np.einsum("nij,nj->i", quat_to_matrix(run.seen_q[:-1]), run.accel.mean(axis=1))
    return bias, -up / np.linalg.norm(up)


def motions(run: Run) -> Preintegrated:
    """The samples between pictures, integrated at the start of the biases."""
    return preintegrate(
        run.gyro,
        run.accel,
        1 / RATE,
        gyro_bias=start(run)[0],
        gyro_noise=GYRO_NOISE,
        accel_noise=ACCEL_NOISE,
    )


def problem(run: Run) -> Any:
    """The problem at its start: poses of the camera, scale 1."""
    bias, down = start(run)
    model: Any = arael.load(MODEL)(down=down, pos_sigma=POS_SIGMA, q_sigma=Q_SIGMA)
    n = len(run.seen_pos)
    velocity = np.gradient(run.seen_pos, SAMPLES / RATE, axis=0)
    model.states.extend(
        n, nav={"pos": run.seen_pos, "q": run.seen_q, "vel": velocity, "gyro_bias": bias}
    )
    k = np.arange(n - 1)
    model.imu.extend(a=k, b=k + 1, **motions(run).columns())
    model.sights.extend(state=np.arange(n), pos=run.seen_pos, q=run.seen_q)
    return model


def report(model: Any, run: Run, result: Any) -> list[str]:
    """Lines on the solution."""
    covariance = model.covariance()
    scale, sigma = float(model.scale), np.sqrt(covariance.marginal("scale").item())
    nav = model.states.nav
    away = np.linalg.norm(np.asarray(nav.pos.value) - run.pos, axis=1)
    speed = np.linalg.norm(np.asarray(nav.vel.value) - run.vel, axis=1)
    angle = np.arccos(np.clip(np.asarray(model.down.value) @ run.down, -1, 1))
    gyro = np.abs(np.asarray(nav.gyro_bias.value).mean(axis=0) - run.gyro_bias).max()
    accel = np.abs(np.asarray(nav.accel_bias.value).mean(axis=0) - run.accel_bias).max()
    return [
        f"{len(run.pos)} pictures, {run.gyro.size // 3} inertial samples",
        f"{result.status} after {result.iterations} iterations: "
        f"{result.start_cost:.4g} -> {result.end_cost:.1f}",
        f"scale {scale:.4f} +- {sigma:.4f}, true {SCALE}",
        f"gravity: {np.rad2deg(angle):.3f} deg from the truth",
        f"biases: {gyro:.1e} rad/s and {accel:.1e} m/s^2 from the truth",
        f"RMS of positions {np.sqrt(np.mean(away**2)):.4f} m, "
        f"of velocities {np.sqrt(np.mean(speed**2)):.4f} m/s",
    ]


def plot(model: Any, run: Run, path: Path) -> str:
    """Draw the path, and the speeds."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    nav = model.states.nav
    pos, vel = np.asarray(nav.pos.value), np.asarray(nav.vel.value)
    t = np.arange(len(pos)) * SAMPLES / RATE

    @styled
    def draw() -> Any:
        figure, (left, right) = new_figure(10.0, 4.0, columns=2)
        left.plot(*run.pos[:, :2].T, color=GREY, lw=4, alpha=0.5, label="path")
        left.plot(*run.seen_pos[:, :2].T, ".", color=ORANGE, ms=3, label="camera, its units")
        left.plot(*pos[:, :2].T, color=BLUE, lw=1.2, label="solved")
        left.set_aspect("equal", adjustable="datalim")
        left.set_xlabel("x [m]")
        left.set_ylabel("y [m]")
        left.set_title("one camera and an inertial sensor")
        left.legend(loc="best")
        for k, name in enumerate("xyz"):
            right.plot(t, run.vel[:, k], color=GREY, lw=4, alpha=0.5)
            right.plot(t, vel[:, k], lw=1.2, label=name)
        right.set_xlabel("time [s]")
        right.set_ylabel("velocity [m/s]")
        right.set_title("velocities, not measured by any sensor")
        right.legend(loc="best")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a run, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    run = make_run(args.seconds, args.seed)
    model = problem(run)
    if args.save:
        model.write(args.save)
    result = model.solve()
    print("\n".join(report(model, run, result)))
    if args.plot:
        print("wrote", plot(model, run, args.plot))


if __name__ == "__main__":
    main()
