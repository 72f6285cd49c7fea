"""A root with parameters, a struct held by value, and the blocks of their Hessian.

python single_root_demo.py [--plot single_root_demo.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import arael

MODEL = Path(__file__).with_name("single_root.arael")


def solved() -> tuple[Any, Any]:
    """The solved instance and the result of the solve."""
    instance = arael.load(MODEL)()
    instance.sub.target = 5.0
    result = instance.solve(config=arael.LmConfig(rel_precision=1e-12))
    return instance, result


def plot(instance: Any, path: Path) -> None:
    """Draw the Hessian with its blocks framed and named."""
    from matplotlib.patches import Rectangle

    from arael.plot.figure import BLUE, GREEN, ORANGE, new_figure, save, styled

    @styled
    def drawn() -> Any:
        figure, (axes,) = new_figure(5.2, 4.8)
        hessian = instance.hessian()
        names = instance.parameter_names()
        axes.imshow(np.abs(hessian), cmap="Greys", vmax=2.5 * np.abs(hessian).max())
        for (i, j), value in np.ndenumerate(hessian):
            axes.text(j, i, f"{value:.2f}", ha="center", va="center")
        frames = [("hb", 0, 0, 2, 2, BLUE), ("sub.hb", 2, 2, 1, 1, GREEN),
                  ("hb_sub", 2, 0, 1, 2, ORANGE)]  # fmt: skip
        for name, x, y, width, height, color in frames:
            axes.add_patch(
                Rectangle(
                    (x - 0.46, y - 0.46),
                    width - 0.08,
                    height - 0.08,
                    fill=False,
                    edgecolor=color,
                    linewidth=2.5,
                )
            )
            axes.text(x - 0.4, y - 0.3, name, color=color, fontsize=9)
        axes.set_xticks(range(len(names)), names)
        axes.set_yticks(range(len(names)), names)
        axes.set_title("Hessian of single_root, by its named blocks")
        return figure

    save(drawn(), path)


def main(arguments: list[str] | None = None) -> None:
    """Solve, and print the solution, the cost by constraint and the blocks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)

    instance, result = solved()
    print(f"{result.status}, cost {result.cost:.6f}")
    for name, value in (("x", instance.x), ("y", instance.y), ("sub.z", instance.sub.z)):
        print(f"{name:5} = {value.value:.6f}")
    print(instance.cost_table())
    print("hb     ", np.array2string(instance.hb, precision=3).replace("\n", ""))
    print("sub.hb ", np.array2string(instance.sub.hb, precision=3))
    print("hb_sub ", np.array2string(instance.hb_sub, precision=3).replace("\n", ""))
    if args.plot:
        plot(instance, args.plot)


if __name__ == "__main__":
    main()
