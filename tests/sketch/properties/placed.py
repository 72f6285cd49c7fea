"""Random commands as templates: the same sketch at another scale, at another place, turned."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from tests.sketch.properties.generator import _BY_HAND, Generator

_MARK = re.compile(r"<(\w):([^>]*)>")

#: What depends on the directions of the axes.
_OF_AXES = frozenset({"horizontal", "vertical", "hdistance", "vdistance", "xangle"})


@dataclass(frozen=True)
class Placing:
    """A similarity: times `scale`, turned by `turn` degrees, then shifted.

    Attributes
    ----------
    shift : in units of the scale
    """

    scale: float = 1.0
    turn: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)

    def point(self, x: float, y: float) -> tuple[float, float]:
        """Where a point comes to."""
        c, s = math.cos(math.radians(self.turn)), math.sin(math.radians(self.turn))
        dx, dy = self.shift
        return self.scale * (c * x - s * y + dx), self.scale * (s * x + c * y + dy)

    def line(self, template: str) -> str:
        """A command line from a template with ``<p:x,y>``, ``<l:length>``, ``<r:direction>``."""

        def put(found: re.Match[str]) -> str:
            if found[1] == "p":
                x, y = self.point(*map(float, found[2].split(",")))
                return f"{x:.17g},{y:.17g}"
            if found[1] == "r":
                return f"{float(found[2]) + self.turn:.17g}"
            return f"{float(found[2]) * self.scale:.17g}"

        return _MARK.sub(put, template)


class Templates(Generator):
    """Templates of lines that make sense at any scale; with `axes`, also what needs the axes."""

    axes = True

    def place(self) -> str:
        if self.document.entities and self.random.random() < 0.25:
            return self.random.choice(self.points())
        return f"<p:{self.number(-10, 10)},{self.number(-10, 10)}>"

    def line(self) -> str:
        """The next template."""
        if len(self.document.entities) < 4:
            return self.entity()
        ways = [(3.0 if len(self.document.entities) < self.most else 0.0, self.entity)]
        ways += [(6.0, self.constraint), (5.0, self.dimension), (1.0, self.delete)]
        weights, makers = zip(*ways, strict=True)
        return str(self.random.choices(makers, weights)[0]())

    def entity(self) -> str:
        n = self.number
        a, b, c, d = (self.place() for _ in range(4))
        kinds = {
            "line": f"add_line {a} {b}",
            "polyline": f"add_line {a} {b} {c} notangent",
            "point": f"add_point {a}",
            "circle": f"add_circle {a} <l:{n(0.5, 4)}>",
            "arc": f"add_arc {a} {b} {c} notangent",
            "ellipse": f"add_ellipse {a} <l:{n(2, 4)}> <l:{n(0.5, 1.5)}> <r:{n(0, 170)}>",
            "earc": f"add_earc_center {a} <l:{n(2, 4)}> <l:{n(1, 1.5)}> <r:{n(0, 90)}> "
            f"{n(0, 80)} {n(120, 300)} notangent",
            "bezier": f"add_spline {a} {b} {c} {d} bezier",
            "bspline": f"add_spline {a} {b} {c} {d} {self.place()}",
        }
        weights = [6, 2, 2, 3, 3, 1, 1, 1, 1]
        return self.random.choices(list(kinds.values()), weights)[0] + " noconnect"

    def _kinds(self, table: object) -> list[str]:
        left_out = _BY_HAND if self.axes else _BY_HAND | _OF_AXES
        return [kind for kind in table if kind not in left_out]  # type: ignore[attr-defined]

    def constraint(self) -> str:
        kind = self.random.choice([*self._kinds(CONSTRAINTS), "coincident", "tangent"])
        operands = self.operands(self.random.choice(CONSTRAINTS[kind].forms).operands)
        return f"{kind} {operands}" if operands else self.entity()

    def dimension(self) -> str:
        kind = self.random.choice([*self._kinds(DIMENSIONS), "length", "radius", "distance"])
        operands = self.operands(self.random.choice(DIMENSIONS[kind].forms).operands)
        if operands is None:
            return self.entity()
        if DIMENSIONS[kind].quantity == "angle" or self.random.random() < 0.4:
            return f"{kind} {operands} driven"
        return f"{kind} {operands} <l:{self.number(0.5, 8)}>"

    def delete(self) -> str:
        tables = [self.document.constraints, self.document.dimensions]
        names = [name for table in tables for name in table]
        return f"delete {self.random.choice(names)}" if names else self.entity()
