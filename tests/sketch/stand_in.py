"""An editor without a solver: what commands do to a document, for tests of the language alone."""

from __future__ import annotations

import types
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets, split_handle, takes
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from arael.sketch.document.records import Amount, Constraint, Dimension, Entity, Parameter
from arael.sketch.editing.checks import same_dimension
from arael.sketch.expressions.properties import property_of


@dataclass(frozen=True)
class Added:
    entity: Entity
    connected: tuple[Constraint, ...] = ()
    tangents: tuple[Constraint, ...] = ()


class StandIn:
    """Makes and deletes records as the editor does, but moves no geometry."""

    def __init__(self, document: Document | None = None) -> None:
        self.document = document if document is not None else Document()
        self.calls: list[tuple[Any, ...]] = []
        self.notices: list[str] = []

    def add(
        self,
        kind: str,
        numbers: Sequence[float],
        *,
        connect: bool = True,
        tangent: bool = True,
        construction: bool = False,
        quiet: bool = False,
        style: str = "solid",
        text: str = "",
        clockwise: bool = False,
    ) -> Added:
        if kind == "line" and tuple(numbers[:2]) == tuple(numbers[2:]):
            raise AraelError(Diagnostic("E1220", "a line of no length"))
        with self.document.transaction("add"):
            entity = self.document.add_entity(
                kind,
                numbers,
                construction=construction,
                quiet=quiet,
                style=style,
                text=text,
                clockwise=clockwise,
            )
            made = []
            if connect:
                for point, at in point_offsets(entity).items():
                    here = self.document.values[at : at + 2]
                    other = self._point_near(entity, here)
                    if other:
                        handle = entity.name if kind == "point" else f"{entity.name}.{point}"
                        made.append(self.constrain("coincident", (handle, other)))
            return Added(entity, tuple(made))

    def _point_near(self, entity: Entity, here: Any) -> str:
        for other in self.document.entities.values():
            if other.name != entity.name:
                for point, at in point_offsets(other).items():
                    if np.hypot(*(self.document.values[at : at + 2] - here)) < 1e-3:
                        return other.name if point == "pos" else f"{other.name}.{point}"
        return ""

    def constrain(
        self,
        kind: str,
        args: Sequence[str],
        *,
        numbers: Sequence[float] = (),
        mode: str = "",
        force: bool = False,
    ) -> Constraint:
        found = []
        for arg in args:
            parts = split_handle(arg)
            assert parts
            found.append((self.document.entity(parts.name), parts.point))
        if not any(
            len(form.operands) == len(found)
            and all(takes(o, *f) for o, f in zip(form.operands, found, strict=True))
            for form in CONSTRAINTS[kind].forms
        ):
            raise AraelError(Diagnostic("E1222", f"`{kind}` does not take {', '.join(args)}"))
        same = [c for c in self.document.constraints.values() if (c.kind, c.args) == (kind, args)]
        if same and not force:
            raise AraelError(Diagnostic("E1230", f"redundant: {same[0].name} holds it already"))
        with self.document.transaction("constrain"):
            flag = kind in ("horizontal", "vertical") and len(args) == 1
            name = f"C{args[0]}{kind[0].upper()}" if flag else self.document.next_name("C")
            record = Constraint(name, kind, tuple(args), tuple(numbers), mode=mode, forced=force)
            return self.document.put("constraints", record)

    def measure(self, kind: str, args: Sequence[str], mode: str = "") -> float:
        document = self.document
        if kind in ("length", "radius", "diameter", "sweep", "radius_b"):
            found = property_of(document, document.entity(args[0]), kind)
            assert found is not None
            return found
        if kind == "xangle":
            entity = document.entity(args[0])
            name = "angle" if entity.kind == "line" else "rotation"
            return property_of(document, entity, name) or 0.0
        if kind in ("distance", "hdistance", "vdistance") and len(args) == 2:
            try:
                a, b = (document.values[document.point_at(x) :][:2] for x in args)
            except AraelError:
                return 1.0
            dx, dy = b - a
            return float({"hdistance": abs(dx), "vdistance": abs(dy)}.get(kind, np.hypot(dx, dy)))
        return 45.0

    def known_dimension(self, kind: str, args: tuple[str, ...]) -> Dimension | None:
        return same_dimension(self.document, kind, args, self.document.dimensions)

    def dimension(
        self,
        kind: str,
        args: Sequence[str],
        *,
        value: Amount | None = None,
        low: Amount | None = None,
        high: Amount | None = None,
        derived: bool = False,
        mode: str = "",
        force: bool = False,
    ) -> Dimension:
        assert kind in DIMENSIONS
        if value is None and low is None and high is None:
            number = self.measure(kind, args, mode)
            value = Amount(repr(number), number)
        with self.document.transaction("dimension"):
            old = next(
                (
                    d
                    for d in self.document.dimensions.values()
                    if (d.kind, d.args) == (kind, tuple(args))
                ),
                None,
            )
            name = old.name if old else self.document.next_name("d")
            record = Dimension(
                name, kind, tuple(args), value, low, high, derived, mode=mode, forced=force
            )
            return self.document.put("dimensions", record)

    def set_dimension(self, name: str, **changes: Any) -> Dimension:
        with self.document.transaction("dimension"):
            record = replace(self.document.dimensions[name], **changes)
            return self.document.put("dimensions", record)

    def set_parameter(self, name: str, amount: Amount) -> Parameter:
        with self.document.transaction("parameter"):
            return self.document.put("parameters", Parameter(name, amount))

    def delete(self, names: Sequence[str]) -> Any:
        gone = list(names)
        tables = ("constraints", "dimensions")
        for table in tables:
            for record in getattr(self.document, table).values():
                if any(arg.split(".")[0] in names for arg in record.args):
                    gone.append(record.name)
        gone = list(dict.fromkeys(gone))
        with self.document.transaction("delete"):
            for name in gone:
                for table in ("constraints", "dimensions", "entities", "parameters", "groups"):
                    if name in getattr(self.document, table):
                        self.document.remove(table, name)
        return types.SimpleNamespace(names=tuple(gone), dissolved={})

    def place(self, offsets: Sequence[int], numbers: Sequence[float]) -> None:
        with self.document.transaction("place"):
            self.document.set_values(offsets, numbers)

    def drag(self, moves: dict[str, tuple[float, float]]) -> None:
        for handle, (x, y) in moves.items():
            at = self.document.point_at(handle)
            self.place([at, at + 1], [x, y])

    def solve(self, touched: Any = None) -> None:
        return None

    @contextmanager
    def together(self) -> Iterator[None]:
        yield

    def explain(self, function: Any) -> Any:
        class Back(Exception):
            pass

        result: list[Any] = []
        try:
            with self.document.transaction("explain"):
                result.append(function())
                raise Back
        except Back:
            return result[0]
