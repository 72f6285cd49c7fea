"""Curves that a reader found, as a document."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from math import isfinite

from arael.sketch.document.document import Document
from arael.sketch.document.records import Style
from arael.sketch.exchange.imported import Imported
from arael.sketch.exchange.problems import MAX_ENTITIES, over_limit
from arael.sketch.exchange.recognition import recognised
from arael.sketch.geometry import Arc, Conic, Curve, EllipticArc, Line, Point, numbers_of


@dataclass(slots=True)
class Found:
    """A curve or point of a file; a line with a text is the frame of it."""

    shape: Curve | Point
    construction: bool = False
    style: Style = "solid"
    name: str = ""
    text: str = ""


@dataclass(slots=True)
class Collector:
    """Collects what a reader finds, within limits.

    Attributes
    ----------
    origin : name of the file
    found : curves and points in the order of the file
    left_out : kinds of things that a sketch has no place for, and how often
    """

    origin: str
    found: list[Found] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)

    def add(self, one: Found) -> None:
        """Keep a curve; one without extent is a point, one without finite numbers is left out."""
        if len(self.found) >= MAX_ENTITIES:
            raise over_limit(f"more than {MAX_ENTITIES:,} curves", MAX_ENTITIES, self.origin)
        shape = one.shape
        if isinstance(shape, Curve):
            numbers = numbers_of(shape)[1]
            if not all(isfinite(x) and abs(x) < 1e100 for x in numbers):
                self.left_out["curve without finite numbers"] += 1
                return
            if isinstance(shape, Line) and shape.p1 == shape.p2:
                one.shape, one.text = shape.p1, ""
            elif isinstance(shape, Conic) and not min(shape.radii) > 0.0:
                self.left_out["circle without radius"] += 1
                return
        elif not all(isfinite(x) and abs(x) < 1e100 for x in shape):
            self.left_out["point without finite numbers"] += 1
            return
        self.found.append(one)

    def imported(self, unit: str, tolerance: float | None = None) -> Imported:
        """A document of what was found, with constraints recognised."""
        document = Document()
        with document.transaction("import"):
            document.set_setting("unit", unit)
            for one in self.found:
                shape = one.shape
                if isinstance(shape, Arc | EllipticArc) and shape.sweep < 0:
                    kind, numbers = numbers_of(shape)
                    clockwise = True
                else:
                    kind, numbers = numbers_of(shape) if isinstance(shape, Curve) else (
                        "point", list(shape)
                    )  # fmt: skip
                    clockwise = False
                document.add_entity(
                    kind,
                    numbers,
                    construction=one.construction,
                    style=one.style,
                    text=one.text,
                    clockwise=clockwise,
                )
        document.history.done.clear()
        notes = [
            f"{count} {kind}{'' if count == 1 else 's'} left out"
            for kind, count in sorted(self.left_out.items())
        ]
        return Imported(document, recognised(document, tolerance), notes)
