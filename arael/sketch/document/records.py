"""Records of a document: immutable, so that undo only has to put the old one back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

Style = Literal["solid", "dashed", "dashdot"]

STYLES: tuple[Style, ...] = ("solid", "dashed", "dashdot")

#: Option of a group: text, numbers, or lists of them.
Option = str | float | int | bool | None | tuple[str, ...] | tuple[float, ...]

_NO_OPTIONS: Mapping[str, Option] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Entity:
    """A piece of geometry; its numbers are ``document.values[at : at + size]``.

    Attributes
    ----------
    name : ``L0``
    kind : a key of `arael.sketch.document.kinds.ENTITIES`
    at : offset of its first number
    size : how many numbers it has
    construction : reference geometry, not part of the outline
    quiet : without its own dimensions and centre in the drawing
    style : of its line
    text : what is lettered along a line, the frame of a text; else empty
    clockwise : of an arc: it was drawn clockwise, so its ``start`` is where its numbers end. The
        numbers of every arc run counter-clockwise
    """

    name: str
    kind: str
    at: int
    size: int
    construction: bool = False
    quiet: bool = False
    style: Style = "solid"
    text: str = ""
    clockwise: bool = False


@dataclass(frozen=True, slots=True)
class Constraint:
    """A relation between entities and points that is to hold exactly.

    Attributes
    ----------
    name : ``C3``, or ``CL0H`` for a line's own horizontal
    kind : a key of `arael.sketch.document.kinds.CONSTRAINTS`
    args : handles, ``("L0", "A0.center")``
    numbers : of the form's `numbers`: where a point is locked, by how much an image is turned
    side : +1 or -1 for relations with two solutions: which of them; 0 where there is one
    mode : which of several meanings, as `kinds` says; mostly empty
    active : whether it acts; switched off it stays listed
    forced : let in although redundant
    """

    name: str
    kind: str
    args: tuple[str, ...]
    numbers: tuple[float, ...] = ()
    side: int = 0
    mode: str = ""
    active: bool = True
    forced: bool = False


@dataclass(frozen=True, slots=True)
class Amount:
    """A value of a dimension or parameter.

    Attributes
    ----------
    text : the expression as it was written, a literal included (``12``, ``width/2``)
    number : its last value, in the document's unit or in degrees
    """

    text: str
    number: float


@dataclass(frozen=True, slots=True)
class Dimension:
    """A quantity that is to have a value, to stay in a range, or is only shown.

    Attributes
    ----------
    name : ``d4``
    kind : a key of `arael.sketch.document.kinds.DIMENSIONS`
    args : handles
    value : what it is to be; None for a range
    low, high : bounds of a range; both None for a value
    derived : only measured (a reference dimension)
    side : +1 or -1 where the quantity has a sign that is kept, else 0
    mode : ``supplement`` for the other angle of two lines, else empty
    active : whether it acts
    forced : let in although redundant
    broken : why its expression has no value now, else empty; the last value stays
    offset, along : place of its text: away from the geometry and along it; None: automatic
    """

    name: str
    kind: str
    args: tuple[str, ...]
    value: Amount | None = None
    low: Amount | None = None
    high: Amount | None = None
    derived: bool = False
    side: int = 0
    mode: str = ""
    active: bool = True
    forced: bool = False
    broken: str = ""
    offset: float | None = None
    along: float | None = None

    @property
    def is_range(self) -> bool:
        """Whether it bounds its quantity in place of fixing it."""
        return self.low is not None or self.high is not None


@dataclass(frozen=True, slots=True)
class Parameter:
    """A named number that expressions read.

    Attributes
    ----------
    name : as written
    amount : its expression and last value
    broken : why the expression has no value now, else empty
    """

    name: str
    amount: Amount
    broken: str = ""


@dataclass(frozen=True, slots=True)
class Group:
    """Geometry made together by one command, which can edit it afterwards.

    Attributes
    ----------
    name : ``M0``
    kind : ``offset``, ``pattern``, ``slot``, ``polygon``
    sources : entities it was made of
    results : entities it made
    owned : constraints and dimensions it made
    options : what the command was given, by name
    """

    name: str
    kind: str
    sources: tuple[str, ...] = ()
    results: tuple[str, ...] = ()
    owned: tuple[str, ...] = ()
    options: Mapping[str, Option] = field(default_factory=lambda: _NO_OPTIONS)


Record = Entity | Constraint | Dimension | Parameter | Group
