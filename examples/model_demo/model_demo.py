"""A model from Python: values and flags of parameters, staged solves, and the cycle of updates.

python model_demo.py [--plot model_demo.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

MODEL = Path(__file__).with_name("walk.arael")
STEPS = 8
DELTA = [1.0, 0.0, 0.05]
TURN = [0.02, -0.03, 2 * np.pi / STEPS]

Floats = NDArray[np.float64]


def new_walk() -> Any:
    """An instance with every pose at the origin; the first is fixed."""
    walk = arael.load(MODEL)()
    known = {"value": [0, 0, 0], "fixed": True}
    walk.poses.append(pos=known, ea=known)
    for _ in range(STEPS):
        a = walk.poses[-1]
        b = walk.poses.append(pos=a.pos, ea=a.ea)
        walk.moves.append(a=a, b=b, delta=DELTA, turn=TURN)
    return walk


def positions_alone(walk: Any) -> Any:
    """Solve with fixed rotations."""
    walk.poses.ea.optimize = False
    result = walk.solve()
    walk.poses.ea.optimize = True
    return result


def everything(walk: Any) -> tuple[Any, list[Floats]]:
    """Solve for all parameters; also returns the model's last pose at each attempt."""
    seen: list[Floats] = []

    def observer(record: object) -> None:
        seen.append(walk.poses[-1].pos.value.copy())

    result = walk.solve(observer=observer, abs_precision=1e-18, rel_precision=1e-9)
    return result, seen


def plot(paths: dict[str, Floats], path: Path) -> None:
    """Draw the walk from above after each stage."""
    from arael.plot.figure import BLUE, GREEN, ORANGE, new_figure, save, styled

    @styled
    def drawn() -> Any:
        figure, (axes,) = new_figure(5.2, 4.8)
        for (label, pos), color in zip(paths.items(), (ORANGE, GREEN, BLUE), strict=False):
            axes.plot(pos[:, 0], pos[:, 1], "o-", color=color, label=label)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.set_title("A walk, solved in two stages")
        axes.legend()
        return figure

    save(drawn(), path)


def main(arguments: list[str] | None = None) -> None:
    """Solve in two stages and print the parameters."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)

    walk = new_walk()
    paths = {}
    print(f"start            cost {walk.cost():10.4f}")
    first = positions_alone(walk)
    paths["positions alone"] = walk.poses.pos.value.copy()
    print(f"positions alone  cost {first.cost:10.4f}  {walk.poses[-1].ea}")
    result, seen = everything(walk)
    paths["everything"] = walk.poses.pos.value.copy()
    print(f"everything       cost {result.cost:10.4f}  {walk.poses[-1].ea}")
    print(f"last pose while it was solved: {np.unique(seen, axis=0).round(3) + 0.0}")
    print(f"last pose when it was done:    {walk.poses[-1].pos.value.round(3) + 0.0}")
    print(f"its rotation matrix:\n{walk.poses[-1].ea.matrix.round(3) + 0.0}")
    if args.plot:
        plot(paths, args.plot)


if __name__ == "__main__":
    main()
