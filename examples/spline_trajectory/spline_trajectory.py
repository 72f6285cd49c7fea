"""A continuous trajectory on SE(3) from positions and attitudes that are measured at other times.

    python spline_trajectory.py [--seconds 10] [--seed 42] [--save spline.npz] [--plot FILE]

The model is `spline_trajectory.arael` in this folder: a uniform cubic B-spline in cumulative form.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import arael

MODEL = Path(__file__).with_name("spline_trajectory.arael")

STEP = 0.5
"""Time between knots [s]."""
POS_SIGMA, Q_SIGMA = 0.03, 0.02

Array = NDArray[np.float64]


def cross(v: Array) -> Array:
    """Matrices (n, 3, 3) of the cross product with vectors (n, 3)."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def logarithm(turn: Rotation, t: Array) -> Array:
    """Twists (n, 6), translation first, of rigid transforms."""
    phi = turn.as_rotvec()
    angle = np.maximum(np.linalg.norm(phi, axis=1), 1e-6)[:, None, None]
    k = cross(phi)
    inverse = np.eye(3) - k / 2 + (1 / angle**2 - 1 / (2 * angle * np.tan(angle / 2))) * (k @ k)
    return np.hstack([np.einsum("nij,nj->ni", inverse, t), phi])


def exponential(twist: Array) -> tuple[Rotation, Array]:
    """Rigid transforms of twists (n, 6): rotations, translations (n, 3)."""
    phi = twist[:, 3:]
    angle = np.maximum(np.linalg.norm(phi, axis=1), 1e-6)[:, None, None]
    k = cross(phi)
    v = np.eye(3) + 2 * (np.sin(angle / 2) / angle) ** 2 * k
    v = v + np.where(angle < 1e-3, 1 / 6, (angle - np.sin(angle)) / angle**3) * (k @ k)
    return Rotation.from_rotvec(phi), np.einsum("nij,nj->ni", v, twist[:, :3])


def evaluate(turns: Rotation, pos: Array, first: NDArray[Any], u: Array) -> tuple[Rotation, Array]:
    """Poses of the spline: rotations, positions (n, 3).

    Parameters
    ----------
    turns, pos : knots, rotations and positions (k, 3)
    first : (n,) numbers of the first of the four knots of each pose
    u : (n,) from 0 to 1 between the second and the third of them
    """
    weights = (5 + 3 * u - 3 * u**2 + u**3, 1 + 3 * u + 3 * u**2 - 2 * u**3, u**3)
    found, at = turns[first], pos[first]
    for j, weight in enumerate(weights):
        a, b = first + j, first + j + 1
        back = turns[a].inv()
        twist = logarithm(back * turns[b], back.apply(pos[b] - pos[a]))
        turn, move = exponential(weight[:, None] / 6 * twist)
        at = at + found.apply(move)
        found = found * turn
    return found, at


@dataclass(frozen=True)
class Flight:
    """Positions and attitudes with their times, and the knots that are the truth.

    Attributes
    ----------
    pos_times, pos : (n,) [s], (n, 3) [m]
    q_times, q : (m,) [s], unit quaternions (m, 4)
    true_turns, true_pos : rotations and positions (k, 3) of the knots
    """

    pos_times: Array
    pos: Array
    q_times: Array
    q: Array
    true_turns: Rotation
    true_pos: Array


def scalar_first(turn: Rotation) -> Array:
    """Quaternions (n, 4) w, x, y, z."""
    return np.roll(turn.as_quat(), 1, axis=1)


def place(times: Array) -> tuple[NDArray[np.int64], Array]:
    """First knots (n,) of times (n,) [s], and positions (n,) within their intervals."""
    first = (times / STEP).astype(np.int64)
    return first, times / STEP - first


def make_flight(seconds: float = 10.0, seed: int = 42) -> Flight:
    """Generate a flight: positions at 20 Hz, attitudes at 15 Hz, never at the same time."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(int(seconds / STEP) + 3)
    pos = np.column_stack([4 * np.cos(0.6 * t), 4 * np.sin(0.6 * t), 1 + 0.5 * np.sin(1.1 * t)])
    euler = np.column_stack([0.6 * t + np.pi / 2, 0.3 * np.sin(0.9 * t), 0.4 * np.cos(0.7 * t)])
    turns = Rotation.from_euler("ZYX", euler)
    pos_times = np.sort(rng.uniform(0, seconds, int(20 * seconds)))
    q_times = np.sort(rng.uniform(0, seconds, int(15 * seconds)))
    _, seen = evaluate(turns, pos, *place(pos_times))
    attitude, _ = evaluate(turns, pos, *place(q_times))
    attitude = attitude * Rotation.from_rotvec(rng.normal(0, Q_SIGMA, (len(q_times), 3)))
    seen = seen + rng.normal(0, POS_SIGMA, seen.shape)
    return Flight(pos_times, seen, q_times, scalar_first(attitude), turns, pos)


def start(flight: Flight) -> Array:
    """Knots (k, 7) from the measurements that are nearest in time."""
    t = STEP * (np.arange(len(flight.true_pos)) - 1)
    pos = flight.pos[np.abs(flight.pos_times - t[:, None]).argmin(axis=1)]
    q = flight.q[np.abs(flight.q_times - t[:, None]).argmin(axis=1)]
    return np.hstack([pos, q])


def problem(flight: Flight, interpret: bool | None = None) -> Any:
    """The problem at its start."""
    model: Any = arael.load(MODEL, interpret=interpret)()
    model.knots.extend(T=start(flight))
    for times, values in (
        (flight.pos_times, {"pos": flight.pos, "q": [1, 0, 0, 0], "pos_isigma": 1 / POS_SIGMA}),
        (flight.q_times, {"pos": [0, 0, 0], "q": flight.q, "q_isigma": 1 / Q_SIGMA}),
    ):
        first, u = place(times)
        model.samples.extend(u=u, knots=first[:, None] + np.arange(4), **values)
    return model


def solved_knots(model: Any) -> tuple[Rotation, Array]:
    """Rotations and positions (k, 3) of the knots."""
    knots = np.asarray(model.knots.T.value)
    return Rotation.from_quat(np.roll(knots[:, 3:], -1, axis=1)), knots[:, :3]


def report(model: Any, flight: Flight, result: Any) -> list[str]:
    """Lines on the solution, at a thousand times of the flight."""
    end = STEP * (len(flight.true_pos) - 3)
    at = place(np.linspace(0, end - 1e-9, 1000))
    turns, pos = evaluate(*solved_knots(model), *at)
    true_turns, true_pos = evaluate(flight.true_turns, flight.true_pos, *at)
    away = np.sqrt(np.mean(np.sum((pos - true_pos) ** 2, axis=1)))
    angle = np.sqrt(np.mean((true_turns.inv() * turns).magnitude() ** 2))
    return [
        f"{len(flight.true_pos)} knots, {len(flight.pos)} positions, {len(flight.q)} attitudes",
        f"{result.status} after {result.iterations} iterations: "
        f"{result.start_cost:.1f} -> {result.end_cost:.1f}",
        f"RMS of positions {1e3 * away:.1f} mm, measured to {1e3 * POS_SIGMA * 3**0.5:.1f} mm",
        f"RMS of attitudes {1e3 * angle:.1f} mrad, measured to {1e3 * Q_SIGMA * 3**0.5:.1f} mrad",
    ]


def plot(model: Any, flight: Flight, path: Path) -> str:
    """Draw the path, and the attitude with its measurements."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    t = np.linspace(0, STEP * (len(flight.true_pos) - 3) - 1e-9, 500)
    turns, pos = evaluate(*solved_knots(model), *place(t))
    euler = np.rad2deg(np.unwrap(turns.as_euler("ZYX"), axis=0))
    seen = np.rad2deg(Rotation.from_quat(np.roll(flight.q, -1, axis=1)).as_euler("ZYX"))
    knots = solved_knots(model)[1]

    @styled
    def draw() -> Any:
        figure, (left, right) = new_figure(10.0, 4.2, columns=2)
        left.plot(*flight.pos[:, :2].T, ".", color=GREY, ms=3, label="positions")
        left.plot(*pos[:, :2].T, color=BLUE, lw=1.5, label="spline")
        left.plot(*knots[:, :2].T, "o", color=INK, ms=3, label="knots")
        left.set_aspect("equal", adjustable="datalim")
        left.set_xlabel("x [m]")
        left.set_ylabel("y [m]")
        left.set_title("a trajectory as a spline on SE(3)")
        left.legend(loc="best")
        for k, (name, color) in enumerate((("pitch", BLUE), ("roll", ORANGE)), start=1):
            right.plot(flight.q_times, seen[:, k], ".", color=GREY, ms=3)
            right.plot(t, euler[:, k], color=color, lw=1.5, label=name)
        right.set_xlabel("time [s]")
        right.set_ylabel("angle [deg]")
        right.set_title("attitude between its measurements")
        right.legend(loc="best")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve a flight, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--interpret", action="store_true", help="do not compile the model")
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    flight = make_flight(args.seconds, args.seed)
    model = problem(flight, args.interpret or None)
    if args.save:
        model.write(args.save)
    result = model.solve()
    print("\n".join(report(model, flight, result)))
    if args.plot:
        print("wrote", plot(model, flight, args.plot))


if __name__ == "__main__":
    main()
