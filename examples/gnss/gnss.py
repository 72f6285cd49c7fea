"""A thousand epochs of a satellite receiver, solved in one model, epoch by epoch.

    python gnss.py [--epochs 1000] [--seed 3] [--save gnss.npz] [--plot gnss.png]

The model is `gnss.arael` in this folder; the constellation is generated.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("gnss.arael")

EARTH, ORBIT = 6.371e6, 2.656e7
SIGMA = 2.0
"""Standard deviation of the pseudorange of a satellite at the zenith [m]."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drive:
    """Pseudoranges of a receiver that drives.

    Attributes
    ----------
    epoch : epoch (m,) of each pseudorange
    satellite : positions (m, 3) [m]
    range, sigma : pseudoranges and standard deviations (m,) [m]
    delayed : (m,) whether a reflection made it too long
    true_pos, true_clock : of the epochs, (n, 3) and (n,) [m]
    axes : east, north, up at the start (3, 3)
    """

    epoch: NDArray[np.int64]
    satellite: Array
    range: Array
    sigma: Array
    delayed: NDArray[np.bool_]
    true_pos: Array
    true_clock: Array
    axes: Array


def make_drive(epochs: int = 1000, seed: int = 3) -> Drive:
    """Generate 30 satellites on six orbits, and a receiver that drives a circle of 400 m.

    Two of a hundred pseudoranges are reflected, and too long by 20 to 100 m.
    """
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, 30)
    t = np.arange(epochs, dtype=np.float64)
    latitude, longitude = np.deg2rad(47.0), np.deg2rad(8.0)
    up = np.array([
        np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)
    ])  # fmt: skip
    east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    north = np.cross(up, east)
    turn = 2 * np.pi * t / epochs
    away = 400 * (np.sin(turn)[:, None] * east + (1 - np.cos(turn))[:, None] * north)
    pos = EARTH * up + away
    clock = 3e4 + 20 * t + np.cumsum(rng.normal(0, 3, epochs))

    node = np.repeat(np.arange(6), 5) * np.pi / 3
    angle = phase + 2 * np.pi * t[:, None] / 43082  # half a sidereal day
    tilt = np.deg2rad(55)
    x, y = np.cos(angle), np.sin(angle)
    satellites = ORBIT * np.stack([
        x * np.cos(node) - y * np.cos(tilt) * np.sin(node),
        x * np.sin(node) + y * np.cos(tilt) * np.cos(node),
        y * np.sin(tilt),
    ], axis=-1)  # fmt: skip
    sight = satellites - pos[:, None]
    distance = np.linalg.norm(sight, axis=2)
    sine = sight @ up / distance  # of the elevation
    epoch, number = np.nonzero(sine > np.sin(np.deg2rad(10)))
    sigma = SIGMA / sine[epoch, number]
    measured = distance[epoch, number] + clock[epoch] + rng.normal(0, sigma)
    delayed = rng.random(len(epoch)) < 0.02
    measured += delayed * rng.uniform(20, 100, len(epoch))
    return Drive(
        epoch, satellites[epoch, number], measured, sigma, delayed, pos, clock,
        np.array([east, north, up]),
    )  # fmt: skip


def problem(drive: Drive) -> Any:
    """The problem at its start: all receivers at the centre of the earth."""
    model: Any = arael.load(MODEL)()
    model.epochs.extend(len(drive.true_pos))
    model.epochs.satellites.extend(
        parent=drive.epoch, pos=drive.satellite, range=drive.range, isigma=1 / drive.sigma
    )
    return model


def found_delays(model: Any) -> NDArray[np.bool_]:
    """Pseudoranges (m,) with residuals of more than 4 standard deviations."""
    residuals = np.asarray(model.residual_values("Satellite.pseudorange").whitened)
    return np.abs(residuals).reshape(-1) > 4


def report(model: Any, drive: Drive, result: Any) -> list[str]:
    """Lines on the solution and on the residuals."""
    wrong = (np.asarray(model.epochs.pos.value) - drive.true_pos) @ drive.axes.T
    level = np.median(np.linalg.norm(wrong[:, :2], axis=1))
    height = np.median(np.abs(wrong[:, 2]))
    clock = np.asarray(model.epochs.clock.value) - drive.true_clock
    found = found_delays(model)
    right = np.count_nonzero(found & drive.delayed)
    values = np.asarray(model.residual_values("Satellite.pseudorange").whitened).reshape(-1)
    return [
        f"{len(drive.true_pos)} epochs, {len(drive.range)} pseudoranges",
        f"{result.status}, {result.components.summary()}, {result.iterations} iterations",
        f"median errors: {level:.2f} m level, {height:.2f} m height, "
        f"{np.median(np.abs(clock)):.2f} m clock",
        f"residuals: median {np.median(np.abs(values)):.2f} sigmas, "
        f"{np.count_nonzero(found)} beyond 4 sigmas, of which {right} are reflections "
        f"(there are {np.count_nonzero(drive.delayed)})",
    ]


def plot(model: Any, drive: Drive, path: Path) -> str:
    """Draw the positions, and the residuals by epoch."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    centre = drive.true_pos[0]
    true = (drive.true_pos - centre) @ drive.axes.T
    found = (np.asarray(model.epochs.pos.value) - centre) @ drive.axes.T
    values = np.asarray(model.residual_values("Satellite.pseudorange").whitened).reshape(-1)
    late = found_delays(model)

    @styled
    def draw() -> Any:
        figure, (left, right) = new_figure(10.0, 4.2, columns=2)
        left.plot(*true[:, :2].T, color=GREY, lw=4, alpha=0.5, label="path")
        left.plot(*found[:, :2].T, ".", color=BLUE, ms=2, label="epochs, solved")
        left.set_aspect("equal", adjustable="datalim")
        left.set_xlabel("east [m]")
        left.set_ylabel("north [m]")
        left.set_title("a thousand independent epochs")
        left.legend(loc="center")
        right.plot(drive.epoch[~late], values[~late], ".", color=GREY, ms=1)
        right.plot(
            drive.epoch[late], values[late], ".", color=ORANGE, ms=3, label="beyond 4 sigmas"
        )
        right.set_xlabel("epoch")
        right.set_ylabel("residual [sigmas]")
        right.set_title("residuals show reflections")
        right.legend(loc="best")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a drive, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--epochs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    drive = make_drive(args.epochs, args.seed)
    model = problem(drive)
    if args.save:
        model.write(args.save)
    result = model.solve()
    print("\n".join(report(model, drive, result)))
    if args.plot:
        print("wrote", plot(model, drive, args.plot))


if __name__ == "__main__":
    main()
