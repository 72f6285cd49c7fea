"""A laser scanner on a robot with wheels: place, scale of the wheels, offset of the clocks.

    python wheel_calibration.py [--seed 1] [--plot wheel_calibration.png] [--data FOLDER]

The odometer samples at 100 Hz, the scanner at 10 Hz by a clock of its own.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import clock_offset

Array = NDArray[np.float64]

HERE = Path(__file__).parent
STEP_SIGMA, TURN_SIGMA = 3e-3, 1e-3
"""Noise of a motion of the scanner [m], [rad]."""
SPEED_NOISE, RATE_NOISE = 5e-4, 1e-4
"""Noise of the odometer and its gyroscope, of a path [m/sqrt(s)] and an angle [rad/sqrt(s)]."""


@dataclass(frozen=True)
class Drive:
    """Measurements, and the truth.

    Attributes
    ----------
    t, pos, yaw : path of the odometer, (n,), (n, 2), (n,)
    t0, t1 : times of two scans by the clock of the scanner (m,)
    step, turn : what lies between them (m, 2), (m,)
    truth : lever (2), mount, scale, offset
    """

    t: Array
    pos: Array
    yaw: Array
    t0: Array
    t1: Array
    step: Array
    turn: Array
    truth: Array


def turned(angle: Array, v: Array) -> Array:
    """Vectors (..., 2) turned by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], axis=-1)


def simulate(motions: int = 1165, seed: int = 1) -> Drive:
    """A drive with turns and changes of speed."""
    rng = np.random.default_rng(seed)
    truth = np.array([0.31, -0.08, 0.25, 1.023, 0.0473])
    lever, mount, scale, offset = truth[:2], *truth[2:]
    end = 0.1 * motions + 4.0
    fine = np.arange(0.0, end, 0.002)
    phase = rng.uniform(0, 2 * np.pi, 4)
    speed = 0.8 + 0.4 * np.sin(1.3 * fine + phase[0]) + 0.2 * np.sin(3.1 * fine + phase[1])
    rate = 0.7 * np.sin(0.9 * fine + phase[2]) + 0.4 * np.sin(2.7 * fine + phase[3])

    def integral(v: Array) -> Array:
        return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(fine))])

    yaw = integral(rate)
    pos = np.stack([integral(speed * np.cos(yaw)), integral(speed * np.sin(yaw))], axis=1)

    def at(times: Array) -> tuple[Array, Array]:
        found = [np.interp(times, fine, column) for column in (*pos.T, yaw)]
        return np.stack(found[:2], axis=1), found[2]

    # The odometer: distances too short by the scale, with noise that adds up.
    t = np.arange(0.0, end - 0.01, 0.01)
    p, heading = at(t)
    ahead = np.linalg.norm(np.diff(p, axis=0), axis=1) / scale
    ahead += SPEED_NOISE * np.sqrt(0.01) * rng.normal(size=len(ahead))
    drift = np.cumsum(RATE_NOISE * np.sqrt(0.01) * rng.normal(size=len(t)))
    course = np.arctan2(*np.diff(p, axis=0).T[::-1]) + drift[:-1]
    moves = ahead[:, None] * np.stack([np.cos(course), np.sin(course)], axis=1)
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(moves, axis=0)])

    t0 = 1.5 + 0.1 * np.arange(motions)
    t1 = t0 + 0.1
    (p0, yaw0), (p1, yaw1) = at(t0 + offset), at(t1 + offset)
    turn = yaw1 - yaw0
    moved = turned(turn, np.tile(lever, (motions, 1))) + turned(-yaw0, p1 - p0) - lever
    step = turned(np.full(motions, -mount), moved) + STEP_SIGMA * rng.normal(size=(motions, 2))
    turn = turn + TURN_SIGMA * rng.normal(size=motions)
    return Drive(t, path, heading + drift, t0, t1, step, turn, truth)


def start(drive: Drive) -> Array:
    """Lever, mount, scale and offset (5,) without a guess.

    The offset is that at which the turning rates agree. For a known offset the motions are linear
    in the cosine and sine of the mount, the lever and the scale, up to a common factor: the right
    singular vector of the least singular value.
    """
    middle, rate = (drive.t0 + drive.t1) / 2, drive.turn / (drive.t1 - drive.t0)
    offset = clock_offset(
        (drive.t[1:] + drive.t[:-1]) / 2, np.diff(drive.yaw) / np.diff(drive.t), middle, rate, 1.0
    )
    pos0, pos1 = (
        np.stack([np.interp(t + offset, drive.t, column) for column in drive.pos.T], axis=1)
        for t in (drive.t0, drive.t1)
    )
    yaw0, yaw1 = (np.interp(t + offset, drive.t, drive.yaw) for t in (drive.t0, drive.t1))
    d = turned(-yaw0, pos1 - pos0)
    c, s = np.cos(yaw1 - yaw0) - 1, np.sin(yaw1 - yaw0)
    x, y = drive.step.T
    rows = np.stack([
        np.stack([x, -y, -c, s, -d[:, 0]], axis=1), np.stack([y, x, -s, -c, -d[:, 1]], axis=1)
    ])  # fmt: skip
    found = np.linalg.svd(rows.reshape(-1, 5), full_matrices=False)[2][-1]
    found *= np.sign(found[4]) / np.hypot(found[0], found[1])
    return np.array([*found[2:4], np.arctan2(found[1], found[0]), found[4], offset])


def calibration(drive: Drive, first: Array | None = None) -> Any:
    """The problem at a start, by default that of `start`."""
    first = start(drive) if first is None else first
    over = drive.t1[0] - drive.t0[0]
    model: Any = arael.load(HERE / "wheel_calibration.arael")(
        step_sigma=np.hypot(STEP_SIGMA, SPEED_NOISE * np.sqrt(over)),
        turn_sigma=np.hypot(TURN_SIGMA, RATE_NOISE * np.sqrt(over)),
        lever=first[:2], mount=first[2], scale=first[3], offset=first[4],
    )  # fmt: skip
    model.track.extend(t=drive.t, pos=drive.pos, yaw=drive.yaw)
    model.motions.extend(t0=drive.t0, t1=drive.t1, step=drive.step, turn=drive.turn)
    return model


def solution(model: Any) -> Array:
    """Lever, mount, scale and offset of a model (5,)."""
    one = (model.mount, model.scale, model.offset)
    return np.array([*model.lever.value, *(float(x.value) for x in one)])


def covariance(model: Any) -> Array:
    """Their covariance (5, 5)."""
    found: Array = model.covariance().marginal(["lever", "mount", "scale", "offset"])
    return found


def report(model: Any, result: Any, drive: Drive) -> list[str]:
    """Lines on a solution."""
    residuals = model.jacobian().shape[0]
    found, sigma = solution(model), np.sqrt(np.diag(covariance(model)))
    off = np.abs(found - drive.truth)
    lines = [
        f"{len(drive.t0)} motions of the scanner, {len(drive.t)} rows of the odometer",
        f"{result.status}: cost {result.end_cost:.1f} of {residuals} residuals",
    ]
    for name, k, factor, unit in (
        ("lever x", 0, 1e3, "mm"), ("lever y", 1, 1e3, "mm"), ("mount", 2, 1e3, "mrad"),
        ("scale", 3, 1e3, "1e-3"), ("offset", 4, 1e3, "ms"),
    ):  # fmt: skip
        lines.append(
            f"  {name:8} {factor * found[k]:9.3f} {unit:5}"
            f"  error {factor * off[k]:6.3f}  sigma {factor * sigma[k]:6.3f}"
        )
    return lines


def plot(drive: Drive, model: Any, path: Path) -> str:
    """Draw the path, the turning rates before and after, and the residuals in sigmas."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    @styled
    def draw() -> Any:
        figure, (way, rates) = new_figure(10.0, 4.2, columns=2)
        way.plot(*(drive.pos * drive.truth[3]).T, color=BLUE, lw=1)
        way.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="path of the odometer")
        rate = np.diff(drive.yaw) / np.diff(drive.t)
        middle = (drive.t0 + drive.t1) / 2
        seen = drive.turn / (drive.t1 - drive.t0)
        rates.plot(drive.t[1:], rate, color=GREY, lw=1, label="odometer")
        rates.plot(middle, seen, ".", color=ORANGE, ms=5, label="scanner, its own clock")
        shifted = middle + float(model.offset.value)
        rates.plot(shifted, seen, ".", color=BLUE, ms=5, label="scanner, offset solved for")
        rates.set(xlim=(10, 13), xlabel="time [s]", ylabel="rad/s", title="turning rates")
        rates.legend(loc="upper right", fontsize=8)
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate a drive, calibrate, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problem here, for `arael solve`")
    args = parser.parse_args(arguments)

    drive = simulate(seed=args.seed)
    model = calibration(drive)
    if args.data:
        args.data.mkdir(parents=True, exist_ok=True)
        model.write(args.data / "wheel_calibration.json")
    print("\n".join(report(model, model.solve(), drive)))
    if args.plot:
        print("wrote", plot(drive, model, args.plot))


if __name__ == "__main__":
    main()
