"""Random commands of the language, some of which must be refused."""

from __future__ import annotations

import random
from collections.abc import Iterator

from benchmarks.sketch.sketches import Sketch


def random_commands(sketch: Sketch, draw: random.Random) -> Iterator[str]:
    """Commands about the entities of a sketch, without end; a seed gives one sequence."""
    lines = [f"L{i}" for i in range(len(sketch.lines))]
    circles = [f"A{i}" for i in range(len(sketch.circles))]
    arcs = [f"A{len(circles) + i}" for i in range(len(sketch.arcs))]
    ends = [f"{line}.{end}" for line in lines for end in ("p1", "p2")]
    ends += [f"{round_}.center" for round_ in circles + arcs]
    extremes = (sketch.points.min(axis=0).tolist(), sketch.points.max(axis=0).tolist())
    corners = list(zip(*extremes, strict=True))

    def place() -> str:
        return ",".join(repr(round(draw.uniform(a, b), 3)) for a, b in corners)

    def number(high: float = 50) -> str:
        return repr(round(draw.uniform(0.1, high), 3))

    def two(names: list[str]) -> str:
        return " ".join(draw.sample(names, 2)) if len(names) > 1 else f"{names[0]} {names[0]}"

    makers = [
        lambda: f"add_line {place()} {place()}",
        lambda: f"add_line {place()} {place()} {place()} noconnect",
        lambda: f"add_rect {place()} {place()}",
        lambda: f"add_point {place()}",
        lambda: f"horizontal {draw.choice(lines)}",
        lambda: f"vertical {draw.choice(lines)}",
        lambda: f"parallel {two(lines)}",
        lambda: f"perpendicular {two(lines)}",
        lambda: f"equal {two(lines)}",
        lambda: f"coincident {two(ends)}",
        lambda: f"lock {draw.choice(ends)} {place()}",
        lambda: f"length {draw.choice(lines)} {number()}",
        lambda: f"distance {two(ends)} {number()}",
        lambda: f"drag {draw.choice(ends)} {place()}",
        lambda: f"delete {draw.choice(lines + circles + arcs)}",
        lambda: f"constr {draw.choice(lines)}",
        lambda: f"param size {number()}",
    ]
    if circles:
        makers += [
            lambda: f"add_circle {place()} {number(10)}",
            lambda: f"radius {draw.choice(circles)} {number(10)}",
            lambda: f"tangent {draw.choice(lines)} {draw.choice(circles)}",
        ]
    while True:
        yield draw.choice(makers)()
