"""Small sketches for tests, and what constraints mean, written without the code under test."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets, split_handle
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.sides import side_of
from arael.sketch.solve.solver import Solver


class Drawing:
    """A document with a layout and a solver, and short ways to add to it."""

    def __init__(self) -> None:
        self.document = Document()
        self.layout = Layout(self.document)
        self.solver = Solver(self.layout)

    def add(self, kind: str, *numbers: float) -> str:
        with self.document.transaction("add"):
            return self.document.add_entity(kind, numbers).name

    def arc(self, x: float, y: float, r: float, start: float, end: float) -> str:
        """An arc by angles in degrees."""
        a, b = math.radians(start), math.radians(end)
        ends = (x + r * math.cos(a), y + r * math.sin(a), x + r * math.cos(b), y + r * math.sin(b))
        return self.add("arc", x, y, *ends, r)

    def earc(
        self, x: float, y: float, rx: float, ry: float, rot: float, start: float, end: float
    ) -> str:
        """An elliptic arc by parameters in degrees."""
        ends: list[float] = []
        for angle in (math.radians(start), math.radians(end)):
            u, v = rx * math.cos(angle), ry * math.sin(angle)
            c, s = math.cos(rot), math.sin(rot)
            ends += [x + c * u - s * v, y + s * u + c * v]
        return self.add("earc", x, y, *ends, rx, ry, rot)

    def constrain(self, kind: str, *args: str, side: int | None = None, **more: Any) -> str:
        document = self.document
        if side is None:
            side = side_of(document, kind, args, more.get("mode", ""))
        with document.transaction(kind):
            name = document.next_name("C")
            document.put("constraints", Constraint(name, kind, args, side=side, **more))
        return name

    def dimension(self, kind: str, *args: str, value: float | None = None, **more: Any) -> str:
        document = self.document
        side = more.pop("side", None)
        if side is None:
            side = side_of(document, kind, args)
        for bound in ("low", "high"):
            if more.get(bound) is not None:
                more[bound] = Amount(str(more[bound]), more[bound])
        amount = None if value is None else Amount(str(value), value)
        with document.transaction(kind):
            name = document.next_name("d")
            document.put("dimensions", Dimension(name, kind, args, amount, side=side, **more))
        return name

    def change(self, table: str, name: str, **fields: Any) -> None:
        """Replace fields of a record."""
        with self.document.transaction("change"):
            record = getattr(self.document, table)[name]
            self.document.put(table, replace(record, **fields))

    def set(self, name: str, value: float) -> None:
        """Another value of a dimension."""
        self.change("dimensions", name, value=Amount(str(value), value))

    def remove(self, table: str, name: str) -> None:
        with self.document.transaction("remove"):
            self.document.remove(table, name)

    def perturb(self, amount: float, seed: int = 0) -> None:
        """Move all numbers by up to `amount`."""
        values = self.document.values
        shift = np.random.default_rng(seed).uniform(-amount, amount, len(values))
        with self.document.transaction("perturb"):
            self.document.set_values(np.arange(len(values)), values + shift)

    # --- reading ----------------------------------------------------------------------------

    def numbers(self, name: str) -> np.ndarray:
        return self.document.numbers_of(name).copy()

    def point(self, handle: str) -> np.ndarray:
        parts = split_handle(handle)
        entity = self.document.entities[parts.name]
        at = point_offsets(entity)[parts.point or "pos"]
        return self.document.values[at : at + 2].copy()

    def line(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        v = self.numbers(name)
        return v[:2], v[2:]

    def direction(self, name: str) -> np.ndarray:
        a, b = self.line(name)
        return (b - a) / np.linalg.norm(b - a)

    def circle(self, name: str) -> tuple[np.ndarray, float]:
        v = self.numbers(name)
        return v[:2], float(v[2] if len(v) == 3 else v[6])

    def ellipse(self, name: str) -> tuple[np.ndarray, float, float, float]:
        v = self.numbers(name)
        return (v[:2], *map(float, v[2:] if len(v) == 5 else v[6:]))


def cross(u: np.ndarray, v: np.ndarray) -> float:
    return float(u[0] * v[1] - u[1] * v[0])


def off_line(drawing: Drawing, point: np.ndarray, line: str) -> float:
    """Signed distance of a point from a line, positive to its left."""
    a, _ = drawing.line(line)
    return cross(drawing.direction(line), point - a)


def off_ellipse(drawing: Drawing, point: np.ndarray, name: str) -> float:
    """0 on an ellipse."""
    center, rx, ry, rot = drawing.ellipse(name)
    d = point - center
    u = math.cos(rot) * d[0] + math.sin(rot) * d[1]
    v = math.cos(rot) * d[1] - math.sin(rot) * d[0]
    return (u / rx) ** 2 + (v / ry) ** 2 - 1


def ellipse_points(drawing: Drawing, name: str, count: int = 4000) -> np.ndarray:
    """Points all around an ellipse."""
    center, rx, ry, rot = drawing.ellipse(name)
    t = np.linspace(0, 2 * np.pi, count)
    u, v = rx * np.cos(t), ry * np.sin(t)
    c, s = math.cos(rot), math.sin(rot)
    return center + np.column_stack([c * u - s * v, s * u + c * v])


def spline_points(drawing: Drawing, name: str, count: int = 4001) -> np.ndarray:
    """Points along a spline, by SciPy."""
    poles = drawing.numbers(name).reshape(-1, 2)
    spans = len(poles) - 3
    knots = np.r_[[0.0] * 3, np.arange(spans + 1), [spans] * 3].astype(float)
    return BSpline(knots, poles, 3)(np.linspace(0, spans, count))


def python_calls(function: Callable[[], object]) -> int:
    """Python functions entered by a call: a measure that no other process disturbs."""
    count = 0

    def profile(frame: object, event: str, _: object) -> None:
        nonlocal count
        count += event == "call"

    sys.setprofile(profile)
    try:
        function()
    finally:
        sys.setprofile(None)
    return count
