"""Patterns: cells of copies, what each is turned and shifted by, and their editing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace

from arael.diagnostics.records import AraelError
from arael.sketch.document.measures import measured
from arael.sketch.document.records import Group, Option
from arael.sketch.editing.editor import Editor
from arael.sketch.expressions.evaluation import number
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.geometry.affine import Affine
from arael.sketch.groups.copies import (
    center_of,
    copied,
    held_as_images,
    is_image_of,
    moved,
    names_of,
    owned_since,
)

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Pattern:
    """What a pattern was given.

    Attributes
    ----------
    form : ``circular`` or ``rect``
    about : of circular ones, handle of the centre
    count : instances, the source included; of rect ones along axis 1
    spread : of circular ones ``full``, ``partial`` or ``symmetric``
    angle : degrees that partial and symmetric ones span
    distance : along axis 1
    count2, distance2 : along axis 2
    along : handle of the line of axis 1; empty for x
    extent : distances span from the first to the last instance
    symmetric1, symmetric2 : instances on both sides of the source
    distance_text, distance2_text, angle_text : expressions that these follow, or empty
    """

    form: str
    about: str = ""
    count: int = 2
    spread: str = "full"
    angle: float = 360.0
    distance: float = 0.0
    count2: int = 1
    distance2: float = 0.0
    along: str = ""
    extent: bool = False
    symmetric1: bool = False
    symmetric2: bool = False
    distance_text: str = ""
    distance2_text: str = ""
    angle_text: str = ""

    @property
    def reference(self) -> str:
        """Handle of the centre or the line of direction, or empty."""
        return self.about if self.form == "circular" else self.along

    @property
    def options(self) -> dict[str, Option]:
        """As a group keeps them."""
        return asdict(self)

    @classmethod
    def of(cls, options: Mapping[str, Option]) -> Pattern:
        """From the options of a group."""
        known = {one.name for one in fields(cls)}
        return cls(**{key: value for key, value in options.items() if key in known})  # type: ignore[arg-type]

    def cells(self) -> dict[Cell, tuple[float, float, float]]:
        """Angle in degrees and shift along both axes, of every cell but the source's."""
        if self.form == "circular":
            step = self._angle_step()
            back = (self.count - 1) // 2 if self.spread == "symmetric" else 0
            turns = [i - back for i in range(self.count)]
            return {(i, 0): (i * step, 0.0, 0.0) for i in turns if i}
        first = _shifts(self.count, self.distance, self.extent, self.symmetric1)
        second = _shifts(self.count2, self.distance2, self.extent, self.symmetric2)
        return {
            (i, j): (0.0, u, v)
            for j, v in second.items()
            for i, u in first.items()
            if (i, j) != (0, 0)
        }

    def _angle_step(self) -> float:
        if self.spread == "full":
            return 360.0 / self.count
        return self.angle / max(self.count - 1, 1)

    def transform(self, editor: Editor, numbers: tuple[float, float, float]) -> Affine:
        """What an image with these numbers does to its source."""
        degrees, first, second = numbers
        if self.form == "circular":
            return Affine.rotation(math.radians(degrees), center_of(editor.document, self.about))
        if not self.along:
            return Affine.shift((first, second))
        x, y = (center_of(editor.document, f"{self.along}.{end}") for end in ("p1", "p2"))
        length = math.dist(x, y)
        c, s = (y[0] - x[0]) / length, (y[1] - x[1]) / length
        return Affine.shift((first * c - second * s, first * s + second * c))


def _shifts(count: int, distance: float, extent: bool, symmetric: bool) -> dict[int, float]:
    step = distance / (count - 1) if extent and count > 1 else distance
    back = (count - 1) // 2 if symmetric else 0
    return {i - back: (i - back) * step for i in range(count)}


def follow(editor: Editor) -> list[str]:
    """Give live patterns the values that their expressions have now; names of those that changed.

    What has no value any more keeps its last one.
    """
    changed: list[str] = []
    for group in list(editor.document.groups.values()):
        if group.kind == "pattern" and any(group.options.get(f"{key}_text") for key in _LIVE):
            changed += _followed(editor, group)
    return changed


_LIVE = ("distance", "distance2", "angle")


def _followed(editor: Editor, group: Group) -> list[str]:
    document = editor.document
    old = Pattern.of(group.options)
    scope = DocumentScope(document, lambda d: measured(document, d.kind, d.args, d.mode))
    values: dict[str, float] = {}
    for key in _LIVE:
        text = str(group.options.get(f"{key}_text") or "")
        try:
            value = number(text, scope) if text else 0.0
        except AraelError:
            continue
        # without extent copies would lie on each other
        if value and value != getattr(old, key):
            values[key] = value
    if not values:
        return []
    new = replace(old, **values)  # type: ignore[arg-type]
    cells = new.cells()
    for cell, copies in copies_of(group).items():
        moved(editor, copies, new.transform(editor, cells[cell]))
        _retarget(editor, group, new, copies, cells[cell])
    kept = {key: group.options[key] for key in ("cells", "rests_on")}
    document.put("groups", replace(group, options={**new.options, **kept}))
    return [group.name]


def copies_of(group: Group) -> dict[Cell, dict[str, str]]:
    """Copies of every cell: source -> copy."""
    found: dict[Cell, dict[str, str]] = {}
    keys = group.options["cells"]
    assert isinstance(keys, tuple)
    size = len(group.sources)
    for k, key in enumerate(keys):
        i, _, j = str(key).partition(",")
        mine = group.results[k * size : (k + 1) * size]
        found[int(i), int(j)] = dict(zip(group.sources, mine, strict=True))
    return found


def _record(
    name: str,
    pattern: Pattern,
    sources: tuple[str, ...],
    made: dict[Cell, dict[str, str]],
    owned: tuple[str, ...],
) -> Group:
    keys = tuple(f"{i},{j}" for i, j in made)
    results = tuple(copies[source] for copies in made.values() for source in sources)
    references = (pattern.reference.partition(".")[0],) if pattern.reference else ()
    options = {**pattern.options, "cells": keys, "rests_on": references}
    return Group(name, "pattern", sources, results, owned, options)


def make(editor: Editor, pattern: Pattern, sources: tuple[str, ...]) -> Group:
    """A new pattern."""
    document = editor.document
    with document.transaction("pattern"):
        before = names_of(document)
        made: dict[Cell, dict[str, str]] = {}
        with editor.together():
            for cell, numbers in pattern.cells().items():
                made[cell] = _cell(editor, pattern, sources, numbers)
        owned = owned_since(document, before)
        return document.put(
            "groups", _record(document.next_name("M"), pattern, sources, made, owned)
        )


def _cell(
    editor: Editor, pattern: Pattern, sources: tuple[str, ...], numbers: tuple[float, float, float]
) -> dict[str, str]:
    copies = copied(editor, sources, pattern.transform(editor, numbers))
    held_as_images(editor, sources, copies, pattern.reference, numbers)
    return copies


def change(editor: Editor, group: Group, pattern: Pattern) -> tuple[Group, list[str], list[str]]:
    """Give a pattern other options; copies of cells that stay are kept.

    Returns
    -------
    the group, entities that were added, and those that were deleted
    """
    document = editor.document
    with document.transaction(f"pattern {group.name}"):
        old = copies_of(group)
        wanted = pattern.cells()
        document.remove("groups", group.name)
        gone = [
            name for cell, copies in old.items() if cell not in wanted for name in copies.values()
        ]
        if gone:
            editor.delete(gone)
        kept = {cell: old[cell] for cell in wanted if cell in old}
        for cell, copies in kept.items():
            moved(editor, copies, pattern.transform(editor, wanted[cell]))
            _retarget(editor, group, pattern, copies, wanted[cell])
        owned = tuple(name for name in group.owned if document.find(name) is not None)
        before = names_of(document)
        made: dict[Cell, dict[str, str]] = {}
        with editor.together():
            for cell, numbers in wanted.items():
                made[cell] = kept.get(cell) or _cell(editor, pattern, group.sources, numbers)
        owned += owned_since(document, before)
        new = document.put("groups", _record(group.name, pattern, group.sources, made, owned))
        added = [name for name in new.results if name not in group.results]
    return new, added, gone


def _retarget(
    editor: Editor,
    group: Group,
    pattern: Pattern,
    copies: dict[str, str],
    numbers: tuple[float, float, float],
) -> None:
    """Give the images of a cell other numbers, and the reference of the pattern."""
    document = editor.document
    names = set(copies.values())
    for name in group.owned:
        one = document.constraints.get(name)
        if one is not None and is_image_of(one, names):
            about = (pattern.reference,) if pattern.reference else ()
            document.put("constraints", replace(one, args=(*one.args[:2], *about), numbers=numbers))
