"""A sketch with dimensions as formulas, changed at run time.

    python runtime_sketch.py [--plot sketch.png]

A plate with a hole: the dimensions refer to each other, to the sketch's points and to its circle.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import arael

CORNERS = [(0.0, 0.0), (41.0, 1.0), (39.0, 22.0), (-1.0, 19.0)]
MEASURED = {
    "width": "norm(points[1].pos - points[0].pos)",
    "height": "norm(points[3].pos - points[0].pos)",
    "hole": "2 * circles[0].radius",
}


def make_sketch() -> arael.Model:
    """The plate with rough initial values and its dimensions."""
    sketch = arael.load(Path(__file__).with_name("sketch.arael"))()
    sketch.points.extend(pos=[*CORNERS, (18.0, 12.0)])
    sketch.circles.append(center=sketch.points[4], radius=3.0)
    residuals = sketch.residuals
    residuals.add("points[0].pos", label="origin")
    residuals.add("[points[1].pos.y, points[3].pos.x]", label="axes")
    residuals.add("points[1].pos + points[3].pos - points[2].pos - points[0].pos", label="parallel")
    residuals.add("points[4].pos - (points[0].pos + points[2].pos) / 2", label="centred")
    residuals.define("d0", "40")
    residuals.define("d1", "d0 / 2")
    residuals.define("d2", "min(d0, d1) / 4 + 3")
    for target, (name, formula) in zip(("d0", "d1", "d2"), MEASURED.items(), strict=True):
        residuals.define(name, formula)
        residuals.add(f"{name} - {target}", label=f"dim_{name}")
    return sketch


def dimensions(sketch: arael.Model) -> dict[str, float]:
    """Current width, height and hole of the sketch."""
    return {name: float(sketch.residuals.value(name)) for name in MEASURED}


def draw(sketches: list[tuple[str, list[list[float]], float]], path: Path) -> None:
    """Draw the states of the sketch side by side."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, len(sketches), figsize=(7.5, 2.8), dpi=90, sharey=True)
    for axis, (title, points, radius) in zip(axes, sketches, strict=True):
        corners = [*points[:4], points[0]]
        axis.plot([p[0] for p in corners], [p[1] for p in corners], "k-o", markersize=3)
        axis.add_patch(pyplot.Circle(points[4], radius, fill=False, color="C0"))
        axis.set_aspect("equal")
        axis.set_title(title, fontsize=9)
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)


def main(arguments: list[str] | None = None) -> list[dict[str, float]]:
    """Solve the sketch, change dimensions, solve again; print them each time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)
    sketch = make_sketch()
    states = [("drawn", sketch.points.pos.value.tolist(), float(sketch.circles[0].radius.value))]
    found = []
    for change, text in ((None, ""), ("d0", "60"), ("d1", "d0 / 3 + 5")):
        if change:
            sketch.residuals.definitions[change].text = text
        began = time.perf_counter()
        result = sketch.solve(rel_precision=1e-9, abs_precision=1e-12)
        milliseconds = 1e3 * (time.perf_counter() - began)
        now = dimensions(sketch)
        found.append(now)
        title = f"{change} = {text}" if change else "solved"
        print(
            f"{title:18}",
            *(f"{name} {value:.3f}" for name, value in now.items()),
            f"({result.iterations} iterations, {milliseconds:.1f} ms)",
        )
        radius = float(sketch.circles[0].radius.value)
        states.append((title, sketch.points.pos.value.tolist(), radius))
    if args.plot:
        draw(states, args.plot)
        print("wrote", args.plot)
    return found


if __name__ == "__main__":
    main()
