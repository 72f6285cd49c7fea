"""Iterated closest points: two scans of a room are aligned, point to plane.

    python icp.py [--points 2000] [--seed 1] [--plot icp.png] [--data icp.json]

In each round a KD-tree finds the plane nearest to each point, and the model `icp.arael` is solved,
until the transform no longer changes. All rounds use one instance, which is analysed once.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import arael
from arael.geometry import rotation_from_vector, rotation_vector

Array = NDArray[np.float64]

MODEL = Path(__file__).with_name("icp.arael")
NOISE = 0.005
"""Noise of a point, in each direction [m]."""
NEIGHBOURS = 16
"""Points of the fixed scan that make a plane."""
FLAT = 1.1
"""A neighbourhood is a plane if it is no thicker than this many times the noise."""


@dataclass(frozen=True)
class Scans:
    """Two scans of a room, each in the frame of its scanner.

    Attributes
    ----------
    fixed, moved : points (n, 3), (m, 3) [m]
    t, v : true transform of the moved scan: translation [m], rotation vector [rad]
    """

    fixed: Array
    moved: Array
    t: Array
    v: Array


def room(rng: np.random.Generator, n: int) -> Array:
    """Points (n, 3) on the floor, two walls, a ramp and a pillar, uniform by area [m]."""
    u, v = rng.uniform(size=(2, n))
    turn = 2 * np.pi * u
    zero = np.zeros(n)
    surfaces = np.array([
        np.column_stack([5 * u, 4 * v, zero]),
        np.column_stack([zero, 4 * u, 2.5 * v]),
        np.column_stack([5 * u, zero, 2.5 * v]),
        np.column_stack([1.5 + 1.5 * u, 1 + 1.5 * v, 0.3 + 0.6 * u + 0.2 * v]),
        np.column_stack([1.2 + 0.2 * np.cos(turn), 3 + 0.2 * np.sin(turn), 2.5 * v]),
    ])  # fmt: skip
    area = np.array([20, 10, 12.5, 2.5, 3.1])
    return np.asarray(surfaces[rng.choice(5, n, p=area / area.sum()), np.arange(n)])


def simulate(points: int = 2000, seed: int = 1) -> Scans:
    """Two scans that overlap in part, with noise; someone stands in the second one."""
    rng = np.random.default_rng(seed)
    fixed = room(rng, 8 * points)
    fixed = fixed[fixed[:, 0] < 4]
    moved = room(rng, points)
    moved = moved[moved[:, 0] > 0.5]
    someone = rng.uniform([3, 2.5, 0], [3.4, 2.9, 1.8], (len(moved) // 12, 3))
    moved = np.vstack([moved, someone])
    fixed += rng.normal(0, NOISE, fixed.shape)
    moved += rng.normal(0, NOISE, moved.shape)
    t, v = np.array([0.25, -0.15, 0.1]), np.array([0.05, -0.04, 0.2])
    return Scans(fixed, (moved - t) @ rotation_from_vector(v), t, v)


def planes(points: Array) -> tuple[Array, Array]:
    """Centres (n, 3) and normals (n, 3) of the planes through the neighbours of each point.

    The normal is zero where the neighbourhood is not flat, at edges and on the pillar: the residual
    of a match with it is zero too, so that the match has no influence.
    """
    _, near = cKDTree(points).query(points, NEIGHBOURS)
    centres = points[near].mean(axis=1)
    off = points[near] - centres[:, None]
    spread, axes = np.linalg.eigh(np.swapaxes(off, 1, 2) @ off)
    flat = np.sqrt(spread[:, 0] / NEIGHBOURS) < FLAT * NOISE
    return centres, axes[:, :, 0] * flat[:, None]


@dataclass
class Found:
    """The end of the loop.

    Attributes
    ----------
    model : the solved instance, with its last matches
    reached : reach of the loss in each round [sigma]
    moves : change of the transform in each round: [m] and [rad] in one norm
    """

    model: Any
    reached: list[float]
    moves: list[float]


def align(scans: Scans, known: tuple[Array, Array], rounds: int = 50) -> Found:
    """Match and solve until the transform no longer changes.

    Parameters
    ----------
    scans : both scans
    known : `planes` of the fixed scan
    rounds : at most

    The reach of the loss follows the residuals, from far to 4 sigma, so that wrong matches lose
    their influence as the scans come together.
    """
    centres, normals = known
    tree = cKDTree(scans.fixed)
    model: Any = arael.load(MODEL)()
    model.matches.extend(p=scans.moved, q=[0, 0, 0], n=[0, 0, 1])
    reached, moves = [], []
    for _ in range(rounds):
        before = model.T.matrix
        at = scans.moved @ before[:3, :3].T + before[:3, 3]
        distance, near = tree.query(at)
        beside = distance < 3 * np.median(distance)  # not beyond the border of the fixed scan
        q, n = centres[near], normals[near] * beside[:, None]
        model.matches.q, model.matches.n = q, n
        apart = np.abs(np.sum(n * (at - q), axis=1)) / model.sigma
        model.reach = max(4.0, 3 * np.median(apart))
        model.solve(rel_precision=1e-6)
        reached.append(model.reach)
        moves.append(float(np.abs(model.T.matrix - before).max()))
        if moves[-1] < 1e-5:
            break
    return Found(model, reached, moves)


def error(model: Any, scans: Scans) -> Array:
    """Error (6,) in the tangent of the found transform, as its covariance: [m], [rad]."""
    turn = model.T.rotation_matrix
    off = turn.T @ rotation_from_vector(scans.v)
    return np.concatenate([turn.T @ (scans.t - model.T.translation), rotation_vector(off)])


def used(found: Found) -> NDArray[np.bool_]:
    """Matches (n,) that count: with a plane, and within reach of the loss."""
    near = np.abs(found.model.residual_values("Match.plane").whitened[:, 0]) < found.model.reach
    return np.asarray(near & np.any(found.model.matches.n != 0, axis=1))


def report(found: Found, scans: Scans) -> list[str]:
    """Lines on the loop and on its end."""
    off = np.abs(error(found.model, scans))
    sigma = np.sqrt(np.diag(found.model.covariance().marginal("T")))
    (place, turn), (place_sigma, turn_sigma) = (
        (1e3 * one[:3].max(), 1e3 * one[3:].max()) for one in (off, sigma)
    )
    return [
        f"{len(scans.moved)} points, {len(found.moves)} rounds, reach {found.reached[0]:.0f} to "
        f"{found.reached[-1]:.0f} sigma",
        f"{used(found).mean():.0%} of the points count at the end",
        f"translation  error {place:6.3f} mm    sigma {place_sigma:.3f} mm",
        f"rotation     error {turn:6.3f} mrad  sigma {turn_sigma:.3f} mrad",
    ]


def plot(found: Found, scans: Scans, path: Path) -> str:
    """Draw both scans from above, before and after, and the rounds."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    @styled
    def draw() -> Any:
        figure, (before, after, loop) = new_figure(10.5, 3.7, columns=3)
        at = scans.moved @ found.model.T.rotation_matrix.T + found.model.T.translation
        far = ~used(found)
        for axes, points, title in ((before, scans.moved, "start"), (after, at, "aligned")):
            axes.plot(*scans.fixed[::3, :2].T, ".", ms=1, color=GREY, label="fixed")
            axes.plot(*points[~far, :2].T, ".", ms=1.5, color=BLUE, label="moved")
            axes.plot(*points[far, :2].T, ".", ms=2.5, color=ORANGE, label="does not count")
            axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=title)
        after.legend(loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=3, markerscale=5)
        loop.semilogy(np.maximum(found.moves, 1e-9), "o-", ms=3, label="move [m, rad]")
        loop.semilogy(found.reached, "s-", ms=3, label="reach [sigma]")
        loop.set(xlabel="round", title="rounds")
        loop.legend()
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate two scans, align them, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the last matches, for `arael solve`")
    args = parser.parse_args(arguments)

    scans = simulate(args.points, args.seed)
    found = align(scans, planes(scans.fixed))
    print("\n".join(report(found, scans)))
    if args.data:
        found.model.write(args.data)
    if args.plot:
        print("wrote", plot(found, scans, args.plot))


if __name__ == "__main__":
    main()
