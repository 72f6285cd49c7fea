"""Dimensions, locks and relations to the axes of geometry that is moved, turned or scaled as one.

A similarity maps a point p to c + f R (p - c) + d with one factor f and one turn R. Lengths inside
of the moved set are multiplied by f, areas by its square, angles from the x axis grow by the turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.measures import signed
from arael.sketch.document.records import Amount, Constraint, Dimension, Entity
from arael.sketch.editing.editor import Editor
from arael.sketch.expressions.reading import literal

#: Quantities that a turn of the whole leaves alone, but not of what is measured along the axes.
_ALONG_AXES = {"hdistance": "vdistance", "vdistance": "hdistance"}
_OTHER_AXIS = {"horizontal": "vertical", "vertical": "horizontal"}


@dataclass(frozen=True, slots=True)
class Similarity:
    """A map that keeps shapes.

    Attributes
    ----------
    center : about which it scales and turns
    factor : of lengths, above 0
    turn : counter-clockwise, radians
    shift : added at the end
    """

    center: tuple[float, float] = (0.0, 0.0)
    factor: float = 1.0
    turn: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)

    def __call__(self, x: float, y: float) -> tuple[float, float]:
        """Image of a point."""
        c, s = _cosine_sine(self.turn)
        dx, dy = x - self.center[0], y - self.center[1]
        return (
            self.center[0] + self.factor * (c * dx - s * dy) + self.shift[0],
            self.center[1] + self.factor * (s * dx + c * dy) + self.shift[1],
        )

    @property
    def quarters(self) -> int | None:
        """Number of quarter turns from 0 to 3, None for other angles."""
        quarters = self.turn / (0.5 * math.pi)
        return round(quarters) % 4 if abs(quarters - round(quarters)) < 1e-12 else None


@dataclass(slots=True)
class Followed:
    """What became of the dimensions and relations of a set that was mapped.

    Attributes
    ----------
    changed : names of dimensions whose value, or whose axis, is another one now
    left : name -> why it could not follow
    freed : relations to the axes that were dropped
    added : relations that hold the set together in their place
    """

    changed: list[str] = field(default_factory=list)
    left: dict[str, str] = field(default_factory=dict)
    freed: list[str] = field(default_factory=list)
    added: list[str] = field(default_factory=list)


def mapped(editor: Editor, names: Sequence[str], by: Similarity) -> Followed:
    """Map entities; what is measured inside of them follows, then everything is solved.

    Raises
    ------
    AraelError
        E1231, E1233, E1234: constraints to the rest of the sketch do not let it
    """
    document = editor.document
    inside = set(names)
    followed = Followed()
    with document.transaction("map"):
        before, size = document.values.copy(), editor.layout.size
        tied = _tied_points(editor, inside)
        for name in names:
            _map_entity(document, document.entities[name], by)
        for at in tied - _own_points(document, inside):
            document.set_values([at, at + 1], by(*document.values[at : at + 2].tolist()))
        _locks(document, tied, by)
        relations = _axes(document, inside, tied, by, followed) if by.turn else []
        for dimension in list(document.dimensions.values()):
            _dimension(document, dimension, inside, tied, by, followed)
        editor.solve()
        editor.remaining.check_all(before, size)
        for kind, args in relations:
            try:
                with document.transaction(kind):
                    followed.added.append(editor.constrain(kind, args).name)
            except AraelError:
                continue  # follows from the rest
    return followed


def _cosine_sine(turn: float) -> tuple[float, float]:
    quarters = turn / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-12:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    return math.cos(turn), math.sin(turn)


def point_starts(entity: Entity) -> list[int]:
    """Offsets of the x of every point among an entity's numbers."""
    count = {"circle": 2, "arc": 6, "ellipse": 2, "earc": 6}.get(entity.kind, entity.size)
    return list(range(entity.at, entity.at + count, 2))


def _own_points(document: Document, inside: set[str]) -> set[int]:
    return {at for name in inside for at in point_starts(document.entities[name])}


def _tied_points(editor: Editor, inside: set[str]) -> set[int]:
    """Points of the set, and those that are one with them."""
    document = editor.document
    editor.layout.refresh()
    own = _own_points(document, inside)
    roots = {editor.layout.root_of(at) for at in own}
    found = set(own)
    for entity in document.entities.values():
        if entity.name not in inside:
            found |= {at for at in point_starts(entity) if editor.layout.root_of(at) in roots}
    return found


def _map_entity(document: Document, entity: Entity, by: Similarity) -> None:
    numbers = document.numbers_of(entity.name).tolist()
    for at in point_starts(entity):
        k = at - entity.at
        numbers[k], numbers[k + 1] = by(numbers[k], numbers[k + 1])
    radii = {"circle": (2,), "arc": (6,), "ellipse": (2, 3), "earc": (6, 7)}.get(entity.kind, ())
    for k in radii:
        numbers[k] *= by.factor
    if entity.kind in ("ellipse", "earc"):
        numbers[-1] += by.turn
    document.set_values(range(entity.at, entity.at + entity.size), numbers)


def _locks(document: Document, tied: set[int], by: Similarity) -> None:
    for one in list(document.constraints.values()):
        if one.kind == "lock" and document.point_at(one.args[0]) in tied:
            x, y = one.numbers[:2]
            document.put("constraints", replace(one, numbers=by(x, y)))


def _is_inside(document: Document, arg: str, inside: set[str], tied: set[int]) -> bool:
    name = arg.partition(".")[0]
    if name in inside:
        return True
    is_point = "." in arg or document.entities[name].kind == "point"
    return is_point and document.point_at(arg) in tied


def _axes(
    document: Document, inside: set[str], tied: set[int], by: Similarity, followed: Followed
) -> list[tuple[str, tuple[str, str]]]:
    """Horizontal and vertical of turned geometry: exchanged, or relations among its lines."""
    found = [
        one
        for one in list(document.constraints.values())
        if one.kind in _OTHER_AXIS
        and all(_is_inside(document, arg, inside, tied) for arg in one.args)
    ]
    if by.quarters is not None:
        if by.quarters % 2:
            for one in found:
                _exchange(document, one)
        return []
    lines = [one for one in found if len(one.args) == 1]
    relations = [
        ("parallel" if one.kind == lines[0].kind else "perpendicular", (lines[0].args[0], name))
        for one in lines[1:]
        for name in one.args
    ]
    for one in found:
        document.remove("constraints", one.name)
        followed.freed.append(one.name)
    return relations


def _exchange(document: Document, one: Constraint) -> None:
    """Horizontal to vertical or back."""
    kind = _OTHER_AXIS[one.kind]
    name = f"C{one.args[0]}{kind[0].upper()}" if len(one.args) == 1 else one.name
    if name == one.name:
        document.put("constraints", replace(one, kind=kind))
    else:
        document.rename("constraints", one.name, replace(one, name=name, kind=kind))


def _dimension(
    document: Document,
    one: Dimension,
    inside: set[str],
    tied: set[int],
    by: Similarity,
    followed: Followed,
) -> None:
    within = [_is_inside(document, arg, inside, tied) for arg in one.args]
    if not any(within):
        return
    quantity = DIMENSIONS[one.kind].quantity
    if one.derived:
        return
    if one.kind == "xangle":
        if by.turn:
            degrees = math.degrees(by.turn)
            _put(document, one, lambda v: math.remainder(v + degrees, 360.0), followed)
        return
    if one.kind in _ALONG_AXES and by.turn:
        if not all(within):
            followed.left[one.name] = "it spans geometry that stays"
            return
        one = _turned(document, one, by, followed)
        if one.derived:
            return
    power = {"length": 1, "area": 2}.get(quantity, 0)
    if not power or by.factor == 1.0:
        return
    if not all(within):
        followed.left[one.name] = "it spans geometry that stays"
        return
    _put(document, one, lambda v: v * by.factor**power, followed)


def _turned(document: Document, one: Dimension, by: Similarity, followed: Followed) -> Dimension:
    """A distance along an axis of turned points: along the other axis, or only measured."""
    if by.quarters is None:
        followed.left[one.name] = "it is measured along an axis: derived now"
        return document.put("dimensions", replace(one, derived=True))
    kind = _ALONG_AXES[one.kind] if by.quarters % 2 else one.kind
    side = -1 if signed(document, kind, one.args, one.mode) < 0.0 else 1
    followed.changed.append(one.name)
    return document.put("dimensions", replace(one, kind=kind, side=side))


def _exact(number: float) -> str:
    """A literal that is read back as the same number."""
    whole = number.is_integer() and abs(number) < 1e15
    return str(int(number)) if whole else repr(number)


def _put(document: Document, one: Dimension, change: Any, followed: Followed) -> None:
    amounts = {name: getattr(one, name) for name in ("value", "low", "high")}
    changes: dict[str, Amount] = {}
    for name, amount in amounts.items():
        if amount is None:
            continue
        if literal(amount.text) is None:
            what = "value" if name == "value" else "bound"
            followed.left[one.name] = f"its {what} is an expression: {amount.text}"
            return
        number = change(amount.number)
        changes[name] = Amount(_exact(number), number)
    document.put("dimensions", replace(one, **changes))  # type: ignore[arg-type]
    if one.name not in followed.changed:
        followed.changed.append(one.name)
