"""A camera and an IMU with clocks of their own: mounting, offset, gravity, biases, line delay.

    python camera_imu.py [--seed 1] [--plot camera_imu.png] [--data FOLDER]

The IMU samples at 100 Hz, the camera takes ten pictures a second of a target with known corners.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

import arael
from arael.geometry import clock_offset

Array = NDArray[np.float64]

HERE = Path(__file__).parent
PIXEL_SIGMA, GYRO_SIGMA, ACC_SIGMA = 0.15, 1e-3, 2e-2
"""Noise of a pixel, of an angular rate [rad/s] and of a specific force [m/s^2]."""
FOCAL, CENTRE = 300.0, np.array([320.0, 240.0])
"""Focal length and principal point of the camera in pixels, half its width and height."""
STEP = 0.05
"""Time between control points [s]."""
SPAN = 0.2
"""Largest offset that is considered, either way [s]."""
NAMES = ("mount", "lever", "gravity", "gyro_bias", "acc_bias", "line_delay", "offset")


def target() -> Array:
    """Corners (24, 3) on two planes, like the sides of an open book."""
    u, v = np.meshgrid(np.linspace(0.1, 0.55, 3), np.linspace(-0.45, 0.45, 4))
    left = np.stack([-u, v, 0.5 * u], axis=-1).reshape(-1, 3)
    return np.concatenate([left, left * [-1, 1, 1]])


@dataclass(frozen=True)
class Recording:
    """Measurements, and the truth.

    Attributes
    ----------
    t, gyro, acc : samples of the IMU, (n,), (n, 3), (n, 3)
    times, corner, pixel : corners in pictures, (m,) by the clock of the camera, (m,), (m, 2)
    mount : rotation from the camera to the IMU
    truth : lever (3), gravity (3), biases (3 + 3), line delay, offset
    """

    t: Array
    gyro: Array
    acc: Array
    times: Array
    corner: NDArray[np.int64]
    pixel: Array
    mount: Rotation
    truth: Array


class Motion:
    """A smooth motion of the IMU in front of the target, from sums of sines."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._frequency = rng.uniform(1.0, 2.4, (2, 6))
        self._phase = rng.uniform(0, 2 * np.pi, (2, 6))
        self._size = np.array([0.12, 0.12, 0.10, 0.22, 0.22, 0.22])

    def _sums(self, t: Array, derivative: int = 0) -> Array:
        angle = self._frequency * t[:, None, None] + self._phase + derivative * np.pi / 2
        found: Array = (self._frequency**derivative * np.sin(angle)).sum(axis=1) * self._size
        return found

    def place(self, t: Array) -> Array:
        """Positions (n, 3) [m]."""
        return self._sums(t)[:, :3] + [0.0, 0.0, -1.3]

    def acceleration(self, t: Array) -> Array:
        """Accelerations (n, 3) [m/s^2]."""
        return self._sums(t, 2)[:, :3]

    def turn(self, t: Array) -> Rotation:
        """Rotations from the IMU to the target."""
        return Rotation.from_rotvec(self._sums(t)[:, 3:])

    def rate(self, t: Array) -> Array:
        """Angular rates (n, 3) in the frame of the IMU [rad/s]."""
        late, early = self.turn(t + 1e-5), self.turn(t - 1e-5)
        found: Array = (early.inv() * late).as_rotvec() / 2e-5
        return found


def simulate(seconds: float = 20.0, seed: int = 1, line_delay: float = 30e-6) -> Recording:
    """A hand moves camera and IMU in front of the target."""
    rng = np.random.default_rng(seed)
    motion, corners = Motion(rng), target()
    mount = Rotation.from_euler("xyz", [4, -7, 88], degrees=True)
    lever, gravity = np.array([0.05, -0.03, 0.02]), np.array([0.6, 9.65, 1.65])
    gyro_bias, acc_bias = np.array([0.01, -0.02, 0.015]), np.array([0.1, -0.05, 0.08])
    offset = 0.0237

    t = np.arange(0.0, seconds + 0.005, 0.01)
    gyro = motion.rate(t) + gyro_bias + GYRO_SIGMA * rng.normal(size=(len(t), 3))
    acc = motion.turn(t).inv().apply(motion.acceleration(t) - gravity) + acc_bias
    acc += ACC_SIGMA * rng.normal(size=acc.shape)

    frames = np.arange(0.4, seconds - 0.4, 0.1)
    times = np.repeat(frames, len(corners))
    corner = np.tile(np.arange(len(corners)), len(frames))
    pixel = np.tile(CENTRE, (len(times), 1))
    for _ in range(6):  # the line decides about the time, and this about the line
        at = times + offset + line_delay * pixel[:, 1]
        body = motion.turn(at).inv().apply(corners[corner] - motion.place(at))
        seen = mount.inv().apply(body - lever)
        pixel = FOCAL * seen[:, :2] / seen[:, 2:] + CENTRE
    pixel += PIXEL_SIGMA * rng.normal(size=pixel.shape)
    truth = np.array([*lever, *gravity, *gyro_bias, *acc_bias, line_delay, offset])
    seen_by_it = (np.abs(pixel - CENTRE) < CENTRE).all(axis=1)
    sights = times[seen_by_it], corner[seen_by_it], pixel[seen_by_it]
    return Recording(t, gyro, acc, *sights, mount, truth)


def camera_poses(recording: Recording) -> tuple[Array, Rotation, Array]:
    """Times of pictures, rotations to the target and positions of the camera in its frame.

    Direct linear transform of each picture with most of the corners, as if its lines were of one
    time.
    """
    corners = target()
    frames, seen = np.unique(recording.times, return_counts=True)
    frames = frames[seen >= 0.75 * len(corners)]
    points = np.column_stack([corners, np.ones(len(corners))])
    turns, places = [], []
    for frame in frames:
        mine = recording.times == frame
        x, y = ((recording.pixel[mine] - CENTRE) / FOCAL).T
        p, zero = points[recording.corner[mine]], np.zeros((mine.sum(), 4))
        rows = np.vstack([
            np.hstack([p, zero, -x[:, None] * p]), np.hstack([zero, p, -y[:, None] * p])
        ])  # fmt: skip
        found = np.linalg.svd(rows, full_matrices=False)[2][-1].reshape(3, 4)
        found *= np.sign(np.linalg.det(found[:, :3]))
        u, size, v = np.linalg.svd(found[:, :3])
        turns.append((u @ v).T)
        places.append(-(u @ v).T @ found[:, 3] / size.mean())
    return frames, Rotation.from_matrix(turns), np.array(places)


@dataclass(frozen=True)
class Start:
    """Values that a solve begins with: offset, mounting, control points, gravity."""

    offset: float
    mount: Rotation
    turns: Rotation
    pos: Array
    gravity: Array


def knot_times(recording: Recording) -> Array:
    """Times of the control points, one of them before the first sample, one behind the last."""
    t = recording.t
    return t[0] + STEP * np.arange(-1, np.ceil((t[-1] - t[0]) / STEP - 1e-9) + 2)


def start(recording: Recording) -> Start:
    """Values to begin with, without a guess.

    The offset is that at which angular rates of camera and IMU have the same magnitude; the
    mounting turns those of the camera into those of the IMU. Control points are poses of the
    camera; gravity is the opposite of the mean specific force.
    """
    frames, turns, places = camera_poses(recording)
    spline = RotationSpline(frames, turns)
    rates = spline(frames, 1)
    seen, own = np.linalg.norm(rates, axis=1), np.linalg.norm(recording.gyro, axis=1)
    offset = clock_offset(recording.t, own, frames, seen, SPAN)
    gyro = CubicSpline(recording.t, recording.gyro)(frames + offset)
    mount, _ = Rotation.align_vectors(gyro, rates)
    body = Slerp(frames + offset, turns * mount.inv())
    inside = np.clip(knot_times(recording), frames[0] + offset, frames[-1] + offset)
    place = np.stack([np.interp(inside, frames + offset, x) for x in places.T], axis=1)
    covered = (recording.t >= inside[0]) & (recording.t <= inside[-1])
    force = body(recording.t[covered]).apply(recording.acc[covered])
    return Start(offset, mount, body(inside), place, -force.mean(axis=0))


def scalar_first(turn: Rotation) -> Array:
    """Quaternions w, x, y, z."""
    return np.roll(turn.as_quat(), 1, axis=-1)


def problem(recording: Recording) -> Any:
    """The problem at its start."""
    first = start(recording)
    model: Any = arael.load(HERE / "camera_imu.arael")(
        focal=FOCAL, centre=CENTRE, pixel_sigma=PIXEL_SIGMA, gyro_sigma=GYRO_SIGMA,
        acc_sigma=ACC_SIGMA, mount=scalar_first(first.mount), gravity=first.gravity,
        offset=first.offset,
    )  # fmt: skip
    model.knots.extend(t=knot_times(recording), pos=first.pos, turn=scalar_first(first.turns))
    model.samples.extend(t=recording.t, gyro=recording.gyro, acc=recording.acc)
    model.corners.extend(pos=target())
    model.sights.extend(time=recording.times, corner=recording.corner, pixel=recording.pixel)
    return model


def errors(model: Any, recording: Recording) -> Array:
    """Errors of the parameters in the order of `NAMES`, the mounting as a rotation vector (17,)."""
    mount = Rotation.from_quat(np.roll(np.asarray(model.mount.value), -1))
    turned = (recording.mount.inv() * mount).as_rotvec()
    found = [np.atleast_1d(np.asarray(getattr(model, name).value)) for name in NAMES[1:]]
    return np.concatenate([turned, np.concatenate(found) - recording.truth])


def covariance(model: Any) -> Array:
    """Covariance of `errors` (17, 17)."""
    found: Array = model.covariance().marginal(list(NAMES))
    return found


def report(model: Any, result: Any, recording: Recording) -> list[str]:
    """Lines on a solution."""
    residuals, variables = model.jacobian().shape
    off, sigma = np.abs(errors(model, recording)), np.sqrt(np.diag(covariance(model)))
    lines = [
        f"{len(recording.t)} samples of the IMU, {len(recording.times)} corners in "
        f"{len(np.unique(recording.times))} pictures, {len(model.knots)} control points",
        f"{result.status}: cost {result.end_cost:.1f} of {residuals - variables} degrees of "
        "freedom",
    ]
    units = ("mrad", "mm", "mm/s^2", "mrad/s", "mm/s^2", "us", "us")
    ends = np.array([3, 6, 9, 12, 15, 16, 17])
    for name, unit, a, b in zip(NAMES, units, [0, *ends[:-1]], ends, strict=True):
        factor = 1e6 if unit == "us" else 1e3
        wrong, spread = (factor * np.sqrt(np.mean(v[a:b] ** 2)) for v in (off, sigma))
        lines.append(f"  {name:10}  error {wrong:7.3f}  sigma {spread:7.3f} {unit}")
    return lines


def plot(recording: Recording, model: Any, path: Path) -> str:
    """Draw errors of pixels by their lines, and errors of the solution in standard deviations."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    global_shutter = problem(recording)
    global_shutter.line_delay.fixed = True
    global_shutter.solve()
    without, within = (m.residual_values("Sight.seen").raw[:, 0] for m in (global_shutter, model))
    off = errors(model, recording) / np.sqrt(np.diag(covariance(model)))
    sizes = np.array([3, 3, 3, 3, 3, 1, 1])

    @styled
    def draw() -> Any:
        figure, (pixels, wrong) = new_figure(10.0, 4.2, columns=2)
        lines = recording.pixel[:, 1]
        pixels.plot(lines, without, ".", color=ORANGE, ms=2, label="all lines at one time")
        pixels.plot(lines, within, ".", color=BLUE, ms=2, label="delay of lines solved for")
        pixels.set(xlabel="line", ylabel="columns", title="errors of corners")
        pixels.legend(loc="upper center", fontsize=8, markerscale=3)
        wrong.axvspan(-2, 2, color=GREY, alpha=0.2, lw=0)
        wrong.plot(off, np.repeat(np.arange(len(NAMES)), sizes), "o", color=INK, ms=4)
        wrong.set_yticks(np.arange(len(NAMES)), [name.replace("_", " ") for name in NAMES])
        wrong.set(xlim=(-4, 4), xlabel="standard deviations", title="errors of the solution")
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate a recording, calibrate, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problem here, for `arael solve`")
    args = parser.parse_args(arguments)

    recording = simulate(seed=args.seed)
    model = problem(recording)
    if args.data:
        args.data.mkdir(parents=True, exist_ok=True)
        model.write(args.data / "camera_imu.json")
    print("\n".join(report(model, model.solve(), recording)))
    if args.plot:
        print("wrote", plot(recording, model, args.plot))


if __name__ == "__main__":
    main()
