"""Documents as JSON, with a version; reading checks everything, since files are untrusted input."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import write_whole
from arael.sketch.document.document import Document
from arael.sketch.document.handles import (
    LONGEST_NAME,
    can_name,
    point_offsets,
    split_handle,
    takes,
)
from arael.sketch.document.kinds import (
    CONSTRAINTS,
    DIMENSIONS,
    ENTITIES,
    GROUPS,
    PREFIXES,
    Form,
)
from arael.sketch.document.records import (
    STYLES,
    Amount,
    Constraint,
    Dimension,
    Entity,
    Group,
    Option,
    Parameter,
    Style,
)
from arael.sketch.document.texts import problem_of

FORMAT = "arael-sketch"
VERSION = 1
UNITS = ("mm", "cm", "m", "in")

#: Larger files are refused before they are read.
MAX_BYTES = 256 * 1024 * 1024

#: Numbers above this have squares that are no numbers.
LARGEST = 1e100

#: Where the radii are among the numbers of a kind.
_RADII = {
    "circle": slice(2, 3),
    "arc": slice(6, 7),
    "ellipse": slice(2, 4),
    "earc": slice(6, 8),
}


class _Entity(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    name: str
    kind: str
    values: list[float]
    construction: bool = False
    quiet: bool = False
    style: str = "solid"
    text: str = ""
    clockwise: bool = False


class _Group(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    name: str
    kind: str
    sources: tuple[str, ...] = ()
    results: tuple[str, ...] = ()
    owned: tuple[str, ...] = ()
    options: dict[str, Any] = {}


class _Saved(msgspec.Struct, forbid_unknown_fields=True):
    format: str
    version: int
    unit: str = "mm"
    counters: dict[str, int] = {}
    parameters: list[Parameter] = []
    entities: list[_Entity] = []
    constraints: list[Constraint] = []
    dimensions: list[Dimension] = []
    groups: list[_Group] = []


def to_json(document: Document) -> bytes:
    """A document as JSON; the same document always gives the same bytes.

    Its history is not part of it.
    """
    counters = {
        key.removeprefix("counter:"): value
        for key, value in sorted(document.settings.items())
        if key.startswith("counter:")
    }
    saved = _Saved(
        FORMAT,
        VERSION,
        document.unit,
        counters,
        list(document.parameters.values()),
        [
            _Entity(
                e.name,
                e.kind,
                document.numbers_of(e.name).tolist(),
                e.construction,
                e.quiet,
                e.style,
                e.text,
                e.clockwise,
            )
            for e in document.entities.values()
        ],
        list(document.constraints.values()),
        list(document.dimensions.values()),
        [
            _Group(g.name, g.kind, g.sources, g.results, g.owned, dict(g.options))
            for g in document.groups.values()
        ],
    )
    return msgspec.json.format(msgspec.json.encode(saved), indent=1) + b"\n"


def from_json(data: bytes, origin: str = "the sketch") -> Document:
    """A document from its JSON, without history.

    Raises
    ------
    AraelError
        E1210: not JSON of a sketch, or of a newer version; E1211: an entry that cannot be, with
        its place.
    """
    try:
        saved = msgspec.json.decode(data, type=_Saved)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise _unreadable(origin, str(error) or type(error).__name__) from None
    if saved.format != FORMAT:
        raise _unreadable(origin, f"`format` is `{saved.format[:40]}`, not `{FORMAT}`")
    if saved.version != VERSION:
        raise _unreadable(
            origin, f"version {saved.version} of the format; this arael reads version {VERSION}"
        )
    return _Reader(saved, origin).document


def save(document: Document, path: str | Path) -> None:
    """Write a document to a file, whole or not at all."""
    data = to_json(document)
    write_whole(path, lambda file: file.write(data))


def load(path: str | Path) -> Document:
    """Read a document from a file; AraelError as of `from_json`, OSError as of open."""
    size = Path(path).stat().st_size
    if size > MAX_BYTES:
        raise _unreadable(str(path), f"{size:,} bytes; at most {MAX_BYTES:,} are read")
    return from_json(Path(path).read_bytes(), str(path))


def _unreadable(origin: str, reason: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1210",
            f"cannot be read as a sketch: {reason}",
            origin=origin,
            help=("sketches are written by `save`; other drawings come in by `import`",),
        )
    )


class _Reader:
    """Puts what was saved into a new document, entry by entry."""

    def __init__(self, saved: _Saved, origin: str) -> None:
        self._origin = origin
        self.document = Document()
        self._check_names(saved)
        with self.document.transaction("load"):
            self._settings(saved)
            for number, entity in enumerate(saved.entities):
                self._entity(f"entities[{number}]", entity)
            for number, parameter in enumerate(saved.parameters):
                self._parameter(f"parameters[{number}]", parameter)
            for number, constraint in enumerate(saved.constraints):
                self._constraint(f"constraints[{number}]", constraint)
            for number, dimension in enumerate(saved.dimensions):
                self._dimension(f"dimensions[{number}]", dimension)
            for number, group in enumerate(saved.groups):
                self._group(f"groups[{number}]", group)
        self.document.history.done.clear()

    def _wrong(self, place: str, reason: str) -> AraelError:
        return AraelError(Diagnostic("E1211", f"{place}: {reason}", origin=self._origin))

    def _check_names(self, saved: _Saved) -> None:
        tables: tuple[Iterable[Any], ...] = (
            saved.entities,
            saved.constraints,
            saved.dimensions,
            saved.parameters,
            saved.groups,
        )
        names = Counter(one.name for table in tables for one in table)
        twice = next((name for name, count in names.items() if count > 1), None)
        if twice is not None:
            raise self._wrong("names", f"`{twice[:40]}` is used twice")

    def _settings(self, saved: _Saved) -> None:
        if saved.unit not in UNITS:
            raise self._wrong("unit", f"`{saved.unit[:40]}` is none of {', '.join(UNITS)}")
        self.document.set_setting("unit", saved.unit)
        for prefix, number in saved.counters.items():
            if prefix not in PREFIXES or number < 0:
                raise self._wrong("counters", f"`{prefix[:40]}`: {number} is not a counter")
            self.document.set_setting(f"counter:{prefix}", number)

    def _name(self, place: str, name: str, prefix: str, *, free: bool = False) -> None:
        """Check a name; `free`: it may have been given by the user."""
        own = name.rstrip("0123456789") == prefix
        if not can_name(name, prefix) or not (own or free):
            raise self._wrong(place, f"`{name[:LONGEST_NAME]}` is not a name of this kind")
        self.document.take_name(name, prefix)

    def _entity(self, place: str, saved: _Entity) -> None:
        kind = ENTITIES.get(saved.kind)
        if kind is None:
            raise self._wrong(place, f"`{saved.kind[:40]}` is not a kind of entity")
        self._name(place, saved.name, kind.prefix, free=True)
        style = saved.style
        if style not in STYLES:
            raise self._wrong(place, f"`{style[:40]}` is not a style")
        if saved.text and saved.kind != "line":
            raise self._wrong(place, f"a {saved.kind} has no text")
        if saved.text and (problem := problem_of(saved.text)):
            raise self._wrong(place, problem)
        if saved.clockwise and saved.kind not in ("arc", "earc"):
            raise self._wrong(place, f"a {saved.kind} has no direction")
        if kind.most and len(saved.values) > 2 * kind.most:
            raise self._wrong(place, f"a {saved.kind} has {2 * kind.most} numbers")
        if not all(abs(value) <= LARGEST for value in saved.values):
            raise self._wrong(place, f"a number is above {LARGEST:g}")
        radii = _RADII.get(saved.kind, slice(0))
        if not all(radius > 0.0 for radius in saved.values[radii]):
            raise self._wrong(place, f"a {saved.kind} has a radius above 0")
        try:
            self.document.add_entity(
                saved.kind,
                saved.values,
                name=saved.name,
                construction=saved.construction,
                quiet=saved.quiet,
                style=_style(style),
                text=saved.text,
                clockwise=saved.clockwise,
            )
        except ValueError as error:
            raise self._wrong(place, str(error)) from None

    def _parameter(self, place: str, parameter: Parameter) -> None:
        if not parameter.name.isidentifier() or len(parameter.name) > 100:
            raise self._wrong(place, f"`{parameter.name[:40]}` is not a name of a parameter")
        self._amount(place, parameter.amount)
        self.document.put("parameters", parameter)

    def _amount(self, place: str, amount: Amount | None) -> None:
        if amount is not None and not math.isfinite(amount.number):
            raise self._wrong(place, "the number of its value is not finite")

    def _operands(self, place: str, forms: tuple[Form, ...], args: tuple[str, ...]) -> Form:
        found: list[tuple[Entity, str]] = []
        for arg in args:
            parts = split_handle(arg)
            entity = self.document.entities.get(parts.name) if parts else None
            if parts is None or entity is None:
                raise self._wrong(place, f"no entity `{arg[:40]}`")
            if parts.point and parts.point not in point_offsets(entity):
                raise self._wrong(place, f"`{arg[:40]}` is not a point")
            found.append((entity, parts.point))
        for form in forms:
            operands = form.operands
            if operands[-1].endswith("*"):
                operands = operands[:-1] + operands[-1:] * max(1, len(found) - len(operands) + 1)
            if len(operands) == len(found) and all(
                takes(operand, *one) for operand, one in zip(operands, found, strict=True)
            ):
                return form
        raise self._wrong(place, f"does not take {', '.join(args)[:80] or 'nothing'}")

    def _constraint(self, place: str, constraint: Constraint) -> None:
        kind = CONSTRAINTS.get(constraint.kind)
        if kind is None:
            raise self._wrong(place, f"`{constraint.kind[:40]}` is not a kind of constraint")
        own = constraint.kind in ("horizontal", "vertical") and constraint.name == (
            f"C{constraint.args[0] if constraint.args else ''}{constraint.kind[0].upper()}"
        )
        if not own:
            self._name(place, constraint.name, "C")
        form = self._operands(place, kind.forms, constraint.args)
        if len(constraint.numbers) != len(form.numbers):
            raise self._wrong(place, f"has {len(form.numbers)} numbers")
        if not np.isfinite(constraint.numbers).all():
            raise self._wrong(place, "a number is not finite")
        if constraint.side not in (-1, 0, 1) or (kind.modes and constraint.mode not in kind.modes):
            raise self._wrong(place, "its side or mode means nothing")
        self.document.put("constraints", constraint)

    def _dimension(self, place: str, dimension: Dimension) -> None:
        kind = DIMENSIONS.get(dimension.kind)
        if kind is None:
            raise self._wrong(place, f"`{dimension.kind[:40]}` is not a kind of dimension")
        self._name(place, dimension.name, "d", free=True)
        self._operands(place, kind.forms, dimension.args)
        for amount in (dimension.value, dimension.low, dimension.high):
            self._amount(place, amount)
        if (dimension.value is None) != dimension.is_range:
            raise self._wrong(place, "has either a value or a range")
        if dimension.side not in (-1, 0, 1) or dimension.mode not in kind.modes:
            raise self._wrong(place, "its side or mode means nothing")
        if not all(math.isfinite(x) for x in (dimension.offset or 0.0, dimension.along or 0.0)):
            raise self._wrong(place, "the place of its text is not finite")
        self.document.put("dimensions", dimension)

    def _group(self, place: str, saved: _Group) -> None:
        if saved.kind not in GROUPS:
            raise self._wrong(place, f"`{saved.kind[:40]}` is not a kind of group")
        self._name(place, saved.name, "M")
        for name in (*saved.sources, *saved.results):
            if name not in self.document.entities:
                raise self._wrong(place, f"no entity `{name[:40]}`")
        for name in saved.owned:
            if name not in self.document.constraints and name not in self.document.dimensions:
                raise self._wrong(place, f"no constraint or dimension `{name[:40]}`")
        options = {
            key: self._option(f"{place}.options.{key[:40]}", value)
            for key, value in saved.options.items()
        }
        self.document.put(
            "groups",
            Group(saved.name, saved.kind, saved.sources, saved.results, saved.owned, options),
        )

    def _option(self, place: str, value: Any) -> Option:
        if isinstance(value, list):
            if all(isinstance(one, str) for one in value):
                return tuple(value)
            if all(isinstance(one, int | float) and math.isfinite(one) for one in value):
                return tuple(float(one) for one in value)
        elif not isinstance(value, float | dict) or (
            isinstance(value, float) and math.isfinite(value)
        ):
            return cast("Option", value)
        raise self._wrong(place, "is neither text, a number, nor a list of them")


def _style(style: str) -> Style:
    return next(one for one in STYLES if one == style)
