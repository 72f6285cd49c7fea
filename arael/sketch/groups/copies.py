"""Rigid copies of entities, held to their sources."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint, Entity
from arael.sketch.editing.editor import Editor
from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.blocks import curve_of, numbers_of
from arael.sketch.groups.ties import classes, points_of


def image_numbers(document: Document, name: str, by: Affine) -> tuple[list[float], bool]:
    """Numbers of the image of an entity, and whether it runs clockwise."""
    entity = document.entities[name]
    numbers = document.values[entity.at : entity.at + entity.size].tolist()
    if entity.kind == "point":
        return list(by((numbers[0], numbers[1]))), False
    _, made = numbers_of(curve_of(entity.kind, numbers).transformed(by))
    if _reads_backwards(document, name, by):
        made = [*made[2:], *made[:2]]
    turned = entity.kind in ("arc", "earc") and by.determinant < 0.0
    return made, entity.clockwise != turned


def _reads_backwards(document: Document, name: str, by: Affine) -> bool:
    """Whether the image of a text has its ends exchanged so that it can be read.

    A mirrored text is not lettered in mirror writing; where its direction would turn to the left,
    it runs from the image of its end to the image of its start.
    """
    entity = document.entities[name]
    if not entity.text or by.determinant > 0.0:
        return False
    x1, y1, x2, y2 = document.numbers_of(name).tolist()
    dx, dy = by.direction((x2 - x1, y2 - y1))
    return dx < -1e-9 * abs(dy) or (dx < 1e-9 * abs(dy) and dy < 0.0)


def copied(editor: Editor, sources: Sequence[str], by: Affine) -> dict[str, str]:
    """New entities that are images of others, without constraints; source -> copy."""
    found: dict[str, str] = {}
    for name in sources:
        entity = editor.document.entities[name]
        numbers, clockwise = image_numbers(editor.document, name, by)
        found[name] = editor.add(
            entity.kind,
            numbers,
            connect=False,
            construction=entity.construction,
            quiet=entity.quiet,
            style=entity.style,
            text=entity.text,
            clockwise=clockwise,
        ).entity.name
    return found


def moved(editor: Editor, copies: dict[str, str], by: Affine) -> None:
    """Put copies that exist where the images of their sources are."""
    for source, copy in copies.items():
        numbers, _ = image_numbers(editor.document, source, by)
        at = editor.document.entities[copy].at
        editor.document.set_values(range(at, at + len(numbers)), numbers)


def handle_of_copy(handle: str, copies: dict[str, str], exchanged: Collection[str] = ()) -> str:
    """The point of a copy that is the image of a source's point.

    `exchanged` are the sources, frames of texts, whose copies run the other way.
    """
    name, dot, point = handle.partition(".")
    if name in exchanged:
        point = {"p1": "p2", "p2": "p1"}[point]
    return f"{copies[name]}{dot}{point}"


def ties(
    editor: Editor, sources: Sequence[str], copies: dict[str, str], exchanged: Collection[str] = ()
) -> dict[str, list[str]]:
    """Give copies the coincidences of their sources.

    Returns
    -------
    of every source, the names of its points that no coincidence places: the first of each class
    """
    open_: dict[str, list[str]] = {name: [] for name in sources}
    for members in classes(editor.document, sources):
        first, *others = members
        name, _, point = first.partition(".")
        open_[name].append(point or "pos")
        for other in others:
            args = tuple(handle_of_copy(one, copies, exchanged) for one in (first, other))
            editor.constrain("coincident", args)
    return open_


def sizes_of(entity: Entity) -> tuple[str, ...]:
    """Numbers of a curve that its points leave open."""
    if entity.kind == "circle":
        return ("radius",)
    if entity.kind in ("ellipse", "earc"):
        return ("radius", "radius_b", "rotation")
    return ()


def held_as_images(
    editor: Editor,
    sources: Sequence[str],
    copies: dict[str, str],
    about: str,
    numbers: tuple[float, float, float],
) -> None:
    """Hold copies to their sources by images, of the numbers that coincidences leave open.

    Parameters
    ----------
    about : handle of the centre or of the line of direction, or empty
    numbers : angle in degrees, then the shift
    """
    for name, points in ties(editor, sources, copies).items():
        mode = " ".join([*points, *sizes_of(editor.document.entities[name])])
        if mode:
            args = (name, copies[name], about) if about else (name, copies[name])
            editor.constrain("image", args, numbers=numbers, mode=mode)


def held_as_mirrored(
    editor: Editor, sources: Sequence[str], copies: dict[str, str], axis: str
) -> None:
    """Hold copies to their sources by symmetry about a line."""
    document = editor.document
    by = Affine.mirror(*(center_of(document, f"{axis}.{end}") for end in ("p1", "p2")))
    exchanged = {name for name in sources if _reads_backwards(document, name, by)}
    for name, points in ties(editor, sources, copies, exchanged).items():
        entity = document.entities[name]
        handles = points_of(entity)
        kind = entity.kind
        if kind == "circle" and points:
            editor.constrain("symmetry", (name, axis, copies[name]))
            continue
        for point in points:
            there = handle_of_copy(handles[point], copies, exchanged)
            editor.constrain("symmetry", (handles[point], axis, there))
        if kind in ("circle", "ellipse", "earc"):
            editor.constrain("equal", (name, copies[name]))
        if kind == "ellipse":
            # its centre says nothing of its direction, which mirrors to twice the axis less its own
            _hold_direction(editor, name, copies[name], axis)


def _hold_direction(editor: Editor, source: str, copy: str, axis: str) -> None:
    document = editor.document
    (x1, y1), (x2, y2) = (center_of(document, f"{axis}.{end}") for end in ("p1", "p2"))
    turn = 2.0 * math.atan2(y2 - y1, x2 - x1) - float(document.numbers_of(source)[4])
    value = Amount(f"2*{axis}.angle-{source}.rotation", math.degrees(turn))
    editor.dimension("xangle", (copy,), value=value)


def owned_since(document: Document, before: set[str]) -> tuple[str, ...]:
    """Constraints and dimensions that are newer than a set of names."""
    return tuple(
        name
        for table in (document.constraints, document.dimensions)
        for name in table
        if name not in before
    )


def names_of(document: Document) -> set[str]:
    """Names of all constraints and dimensions."""
    return {*document.constraints, *document.dimensions}


def is_image_of(constraint: Constraint, copies: set[str]) -> bool:
    """Whether a constraint holds one of these copies to its source."""
    return constraint.kind == "image" and constraint.args[1] in copies


def center_of(document: Document, handle: str) -> tuple[float, float]:
    """Where a point is."""
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y
