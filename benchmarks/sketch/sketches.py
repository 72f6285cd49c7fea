"""Sketches in no system's terms: points, what refers to them, and rules, by a name each.

A point is shared by all that meets there, as in ezpz, SolveSpace and planegcs; where ends are
points of their own (arael, the Rust framework) the writer of commands leaves it to the automatic
coincidences. Names: ``chain-COUNT``, ``polygon-SIDES``, ``plate``, ``links-COUNT``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np


@dataclass(frozen=True)
class Kind:
    """A kind of rule: classes of what it is about, and how many equations it is."""

    operands: tuple[str, ...]
    equations: int = 1


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "lock": Kind(("point",), 2),
        "horizontal": Kind(("line",)),
        "vertical": Kind(("line",)),
        "length": Kind(("line",)),
        "distance": Kind(("point", "point")),
        "equal": Kind(("line", "line")),
        "radius": Kind(("circle",)),
        "equal_radius": Kind(("circle", "circle")),
        "arc_radius": Kind(("arc",)),
        "equal_arcs": Kind(("arc", "arc")),
        "tangent": Kind(("line", "arc")),
    }
)
"""``tangent`` holds where a line and an arc share an end."""


@dataclass(frozen=True)
class Rule:
    """A constraint or a dimension: of what (numbers in the lists of a sketch), and its values."""

    kind: str
    of: tuple[int, ...]
    values: tuple[float, ...] = ()


@dataclass(frozen=True)
class Sketch:
    """A drawing with its rules.

    Attributes
    ----------
    name : by which `make` gives it
    points : where they are drawn, (n, 2)
    lines : pairs of points
    circles : a centre each; `radii` (k,) beside them
    arcs : centre, start, end; counter-clockwise
    rules : constraints and dimensions
    changed : number of the dimension that changes, to each of `targets` in turn
    candidates : further rules by what they are: ``helpful``, ``redundant``, ``contradicting``
    grabbed, path : the point that is dragged, and the cursor's places (frames, 2), out and back
    freedoms : degrees of freedom that the rules leave
    """

    name: str
    points: np.ndarray
    lines: tuple[tuple[int, int], ...]
    rules: tuple[Rule, ...]
    freedoms: int
    circles: tuple[int, ...] = ()
    radii: np.ndarray = field(default_factory=lambda: np.zeros(0))
    arcs: tuple[tuple[int, int, int], ...] = ()
    changed: int = -1
    targets: tuple[float, ...] = ()
    candidates: Mapping[str, Rule] = field(default_factory=dict)
    grabbed: int = -1
    path: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def equations(self) -> int:
        """Equations of the rules: what peers count as constraints (an arc is one by itself)."""
        return len(self.arcs) + sum(KINDS[rule.kind].equations for rule in self.rules)

    @property
    def unknowns(self) -> int:
        """Numbers that the rules can move."""
        return self.points.size + len(self.circles)

    def with_target(self, value: float) -> tuple[Rule, ...]:
        """The rules, the changed dimension having this value."""
        changed = self.rules[self.changed]
        rules = list(self.rules)
        rules[self.changed] = Rule(changed.kind, changed.of, (value,))
        return tuple(rules)


def make(name: str) -> Sketch:
    """The sketch of a name."""
    word, _, number = name.partition("-")
    if name == "plate":
        return plate()
    if word not in MAKERS or not number.isdigit():
        raise ValueError(f"no sketch {name!r}: expected chain-N, polygon-N, links-N or plate")
    return MAKERS[word](int(number))


WIDTH, HEIGHT, NOISE = 4.0, 3.0, 0.02


def chain(count: int) -> Sketch:
    """Rectangles corner to corner, fully defined, with `count` equations.

    Each has two horizontal and two vertical sides, a width and a height; the first is locked. What
    remains of the count is a tail: lines along x of a length each, and a circle of a radius.
    """
    rectangles, rest = divmod(count - 2, 6)
    if rectangles < 1:
        raise ValueError(f"a chain has at least 8 equations, not {count}")
    points: list[tuple[float, float]] = [(0.0, 0.0)]
    lines: list[tuple[int, int]] = []
    rules = [Rule("lock", (0,), (0.0, 0.0))]
    corner, at = 0, (0.0, 0.0)
    for _ in range(rectangles):
        x, y = at
        a, b, c, d = corner, *range(len(points), len(points) + 3)
        points += [(x + WIDTH, y), (x + WIDTH, y + HEIGHT), (x, y + HEIGHT)]
        first = len(lines)
        lines += [(a, b), (b, c), (d, c), (a, d)]
        rules += [Rule("horizontal", (first,)), Rule("vertical", (first + 1,))]
        rules += [Rule("horizontal", (first + 2,)), Rule("vertical", (first + 3,))]
        rules += [Rule("length", (first,), (WIDTH,)), Rule("length", (first + 3,), (HEIGHT,))]
        corner, at = c, (x + WIDTH, y + HEIGHT)
    for _ in range(rest // 2):
        at = (at[0] + 1, at[1])
        points.append(at)
        lines.append((corner, len(points) - 1))
        corner = len(points) - 1
        rules += [
            Rule("horizontal", (len(lines) - 1,)),
            Rule("length", (len(lines) - 1,), (1.0,)),
        ]
    circles = (corner,) if rest % 2 else ()
    rules += [Rule("radius", (0,), (0.5,))] if circles else []
    drawn = np.array(points)
    drawn[1:] += np.random.default_rng(0).uniform(-NOISE, NOISE, (len(points) - 1, 2))
    return Sketch(
        f"chain-{count}",
        drawn,
        tuple(lines),
        tuple(rules),
        freedoms=0,
        circles=circles,
        radii=np.full(len(circles), 0.5),
        changed=5,
        targets=(WIDTH, 5.0),
        candidates={
            "redundant": Rule("length", (2,), (WIDTH,)),
            "contradicting": Rule("length", (2,), (WIDTH + 1,)),
        },
    )


def polygon(sides: int) -> Sketch:
    """A closed polygon with a circle at each corner: lengths equal, radii equal.

    ``polygon-128`` takes 512 commands: 256 entities, 254 equalities, a length and a radius.
    """
    turns = 2 * np.pi * np.arange(sides) / sides
    size = 0.5 / np.sin(np.pi / sides)  # sides of length 1
    points = np.round(size * np.column_stack([np.cos(turns), np.sin(turns)]), 3)
    lines = tuple((i, (i + 1) % sides) for i in range(sides))
    rules = [Rule("equal", (i, i + 1)) for i in range(sides - 1)]
    rules += [Rule("equal_radius", (i, i + 1)) for i in range(sides - 1)]
    rules += [Rule("length", (0,), (1.0,)), Rule("radius", (0,), (0.25,))]
    return Sketch(
        f"polygon-{sides}",
        points,
        lines,
        tuple(rules),
        freedoms=sides,
        circles=tuple(range(sides)),
        radii=np.full(sides, 0.25),
        changed=len(rules) - 2,
        targets=(1.0, 1.1),
        candidates={
            "helpful": Rule("horizontal", (0,)),
            "redundant": Rule("equal", (0, sides - 1)),
            "contradicting": Rule("length", (sides - 1,), (2.0,)),
        },
    )


def plate() -> Sketch:
    """A plate with round corners, a hole in each, and a bore; fully defined."""
    wide, high, round_, hole, bore = 60.0, 40.0, 6.0, 2.5, 8.0
    centers = [(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)]
    out = [(0, -1), (1, 0), (0, 1), (-1, 0)]  # outward of the sides, in turn
    points: list[tuple[float, float]] = list(centers)
    arcs, lines = [], []
    for i, (x, y) in enumerate(centers):  # ends of an arc: those of the sides before and after
        for nx, ny in (out[i - 1], out[i]):
            points.append((x + round_ * nx, y + round_ * ny))
        arcs.append((i, 4 + 2 * i, 5 + 2 * i))
    for i in range(4):
        lines.append((5 + 2 * i, 4 + 2 * ((i + 1) % 4)))
    points.append((24.0, 18.0))
    across, along = np.hypot(24.0, 18.0), np.hypot(36.0, 18.0)
    rules = [
        Rule("lock", (0,), (0.0, 0.0)),
        *(Rule(("horizontal", "vertical")[i % 2], (i,)) for i in range(4)),
        *(Rule("tangent", (i, i)) for i in range(4)),
        *(Rule("tangent", (i, (i + 1) % 4)) for i in range(4)),
        Rule("arc_radius", (0,), (round_,)),
        *(Rule("equal_arcs", (0, i)) for i in range(1, 4)),
        Rule("radius", (0,), (hole,)),
        *(Rule("equal_radius", (0, i)) for i in range(1, 4)),
        Rule("radius", (4,), (bore,)),
        Rule("distance", (0, 12), (float(across),)),
        Rule("distance", (1, 12), (float(along),)),
        Rule("length", (1,), (high,)),
        Rule("length", (0,), (wide,)),
    ]
    drawn = np.array(points)
    drawn[12] += 0.3
    return Sketch(
        "plate",
        drawn,
        tuple(lines),
        tuple(rules),
        freedoms=0,
        circles=(0, 1, 2, 3, 12),
        radii=np.array([hole] * 4 + [bore]),
        arcs=tuple(arcs),
        changed=len(rules) - 1,
        targets=(wide, 62.0),
        candidates={
            "redundant": Rule("equal", (0, 2)),
            "contradicting": Rule("length", (2,), (wide + 5,)),
        },
    )


def links(count: int, frames: int = 40) -> Sketch:
    """A zigzag of links of length 1, its start locked, whose end is dragged out and back."""
    step = np.array([np.cos(0.8), np.sin(0.8)])
    signs = np.array([1 if i % 2 else -1 for i in range(count)])
    steps = np.column_stack([np.full(count, step[0]), signs * step[1]])
    points = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    reach = 0.1 * count
    turns = np.linspace(0, np.pi / 2, frames // 2 + 1)[1:]
    out = points[-1] + reach * np.column_stack([np.cos(turns) - 1, np.sin(turns)])
    return Sketch(
        f"links-{count}",
        points,
        tuple((i, i + 1) for i in range(count)),
        (Rule("lock", (0,), (0.0, 0.0)), *(Rule("length", (i,), (1.0,)) for i in range(count))),
        freedoms=count,
        changed=1,
        targets=(1.0, 1.1),
        grabbed=count,
        path=np.vstack([out, out[-2::-1], points[-1:]]),
    )


MAKERS = {"chain": chain, "polygon": polygon, "links": links}
