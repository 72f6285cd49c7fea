"""An arm of three joints whose tip follows a curve exactly, with limits and least accelerations.

    python arm_on_curve.py [--times 20] [--size 1.0] [--save arm.json] [--plot FILE]

The model is `arm_on_curve.arael` in this folder.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("arm_on_curve.arael")
LINKS = np.array([1.0, 1.0, 0.5])
"""Lengths [m]."""

Array = NDArray[np.float64]


def curve(times: int, size: float = 1.0) -> Array:
    """(times, 2) points of a quarter of an ellipse [m]."""
    angle = np.linspace(0, np.pi / 2, times)
    return size * np.column_stack([1.9 * np.cos(angle), 0.3 + 1.6 * np.sin(angle)])


def joints(q: Array) -> Array:
    """(times, 4, 2) the base, two joints and the tip [m] of angles (times, 3)."""
    turn = np.cumsum(q, axis=1)
    ends = LINKS[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=2)
    return np.concatenate([np.zeros((len(q), 1, 2)), np.cumsum(ends, axis=1)], axis=1)


def problem(times: int = 20, size: float = 1.0, interpret: bool | None = None) -> Any:
    """The problem at its start, which is not on the curve."""
    model: Any = arael.load(MODEL, interpret=interpret)()
    k = np.arange(times)
    angle = np.linspace(0, np.pi / 2, times)
    model.poses.extend(
        q=np.column_stack([angle - 0.5, np.full(times, 0.9), np.full(times, 0.4)]),
        target=curve(times, size),
        prev=k - 1,
        next=np.where(k + 1 < times, k + 1, -1),
    )
    return model


def report(model: Any, result: Any) -> list[str]:
    """Lines on the solution."""
    if result.conflict:
        return [f"{result.status}; these cannot hold together:", *result.conflict]
    q = model.poses.q.value
    away = np.linalg.norm(joints(q)[:, -1] - model.poses.target, axis=1).max()
    lines = [f"{result.status}: the tip is within {max(away, 1e-9):.0e} m of the curve"]
    acts = result.required["Pose.limits"].active.any(axis=1)
    lines.append(f"limits of joints act at {acts.sum()} of {len(q)} times")
    return lines


def plot(model: Any, result: Any, path: Path) -> str:
    """Draw the arm on its curve, and its joints with their limits."""
    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    q = model.poses.q.value
    points = joints(q)
    acts = result.required["Pose.limits"].active.reshape(len(q), -1)

    @styled
    def draw() -> Any:
        figure, (left, right) = new_figure(10.0, 4.2, columns=2)
        for k, arm in enumerate(points):
            left.plot(*arm.T, "o-", color=GREY if k % 6 else INK, ms=3, lw=1 if k % 6 else 2)
        left.plot(*np.asarray(model.poses.target).T, color=BLUE, lw=1.5, label="curve")
        left.set_aspect("equal", adjustable="datalim")
        left.set_xlabel("x [m]")
        left.set_ylabel("y [m]")
        left.set_title("the tip is on the curve")
        for j, (name, color) in enumerate((("elbow", BLUE), ("hand", ORANGE)), start=1):
            right.plot(q[:, j], "o-", color=color, ms=3, label=name)
            held = acts[:, [j, j + 3]].any(axis=1)
            right.plot(np.flatnonzero(held), q[held, j], "o", color=INK, ms=5)
        right.axhline(model.elbow, color=BLUE, lw=1, ls="--")
        right.set_xlabel("time")
        right.set_ylabel("angle [rad]")
        right.set_title("limits act where points are dark")
        right.legend(loc="best")
        return figure

    return save(draw(), path)


def main() -> None:
    """Solve, and compare with the curve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--size", type=float, default=1.0, help="of the curve")
    parser.add_argument("--interpret", action="store_true", help="do not compile the model")
    parser.add_argument("--save", type=Path, help="write the problem at its start")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    model = problem(args.times, args.size, args.interpret or None)
    if args.save:
        model.write(args.save)
    result = model.solve()
    print("\n".join(report(model, result)))
    if args.plot:
        print("wrote", plot(model, result, args.plot))


if __name__ == "__main__":
    main()
