"""Degrees of freedom of a sketch from the Jacobian's singular vectors.

    python jacobian_demo.py [--plot jacobian_demo.png]

Dimensions are added to a quadrilateral one by one. After each, the script shows the cost by
constraint and the remaining degrees of freedom, at the end also the redundant dimensions. The model
is `sketch.arael` in this folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import arael

MODEL = Path(__file__).with_name("sketch.arael")
CORNERS = np.array([[0.0, 0.0], [4.0, 0.2], [4.3, 3.1], [0.2, 2.8]])
"""Initial corners; the dimensions change them."""


def four_sides() -> Any:
    """A quadrilateral whose sides are 4, 3, 4 and 3 long: free to move, to turn and to shear."""
    sketch: Any = arael.load(MODEL)()  # type: ignore[operator]
    sketch.points.extend(p=CORNERS)
    for k, length in enumerate([4.0, 3.0, 4.0, 3.0]):
        add_length(sketch, k, (k + 1) % 4, length)
    return sketch


def add_length(sketch: Any, a: int, b: int, length: float) -> None:
    """Fix the distance between two corners."""
    sketch.lengths.append(a=sketch.points[a], b=sketch.points[b], length=length)


def steps() -> Iterator[tuple[str, Any]]:
    """The sketch after each new dimension, solved."""
    sketch = four_sides()
    yield "four sides", settle(sketch)
    add_length(sketch, 0, 2, 5.0)
    yield "and a diagonal", settle(sketch)
    sketch.nails.append(point=sketch.points[0], at=[0.0, 0.0])
    yield "and a nail", settle(sketch)
    sketch.levels.append(a=sketch.points[0], b=sketch.points[1])
    yield "and level", settle(sketch)
    add_length(sketch, 1, 3, 5.0)
    yield "and the other diagonal", settle(sketch)


def settle(sketch: Any) -> Any:
    """Solve for the corners."""
    sketch.solve(cost_threshold=1e-20, abs_precision=0.0, rel_precision=1e-12)
    return sketch


def redundant(sketch: Any) -> list[str]:
    """Constraints that others imply: those that take part in a left singular vector of value 0."""
    jacobian = sketch.jacobian()
    u = np.linalg.svd(jacobian.dense())[0]
    idle = np.abs(u[:, jacobian.rank() :]).max(axis=1, initial=0.0)
    return list(
        dict.fromkeys(jacobian.instance(row.constraint)
                      for row, share in zip(jacobian, idle, strict=True) if share > 1e-6)
    )  # fmt: skip


def report(title: str, sketch: Any) -> Iterator[str]:
    """Lines on one state of the sketch."""
    jacobian = sketch.jacobian()
    values = jacobian.singular_values()
    yield f"{title}: {len(jacobian)} residuals, rank {jacobian.rank()} of {jacobian.shape[1]}"
    yield "  singular values " + " ".join(f"{value:.3f}" for value in values)
    for label, cost in sketch.cost_table().items():
        count = sketch.cost_table().instances[label]
        yield f"  {label:<14} {count} acting, cost {cost:.1e}"
    yield from (f"  free: {one}" for one in sketch.free_directions())
    yield from (f"  implied by others: {name}" for name in redundant(sketch))


def plot(sketch: Any, path: Path) -> str:
    """Draw a sketch and its free motions, except rigid ones."""
    from arael.plot.figure import save
    from arael.plot.motion import motion_figure

    others = [one for one in sketch.free_directions() if not one.gauge]
    shown = np.array(sketch.points.p.value)
    edges = [(k, (k + 1) % len(shown)) for k in range(len(shown))]
    moves = [one.vector.reshape(-1, 2) for one in others]
    return save(motion_figure(shown, edges, moves, "what four lengths leave free"), path)


def main() -> None:
    """Print the degrees of freedom after each dimension, and the rows of the last Jacobian."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    for title, sketch in steps():
        print("\n".join(report(title, sketch)))
        print()
    print("rows of the last Jacobian")
    for row in sketch.jacobian():
        entries = " ".join(f"{column}:{value:+.2f}" for column, value in row.entries)
        print(f"  {row.constraint} {row.label:<14} residual {row.residual:+.1e}  {entries}")
    if args.plot:
        print("wrote", plot(settle(four_sides()), args.plot))


if __name__ == "__main__":
    main()
