"""Curves end to end: their order, and in which direction each is passed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends
from arael.sketch.geometry.blocks import curve_of
from arael.sketch.geometry.curve import Curve
from arael.sketch.groups.ties import classes


class SequenceError(ValueError):
    """A set of curves that is not one sequence; the reason in words."""


@dataclass(frozen=True, slots=True)
class Link:
    """A curve of a sequence, and whether it is passed from its second end to its first."""

    name: str
    backwards: bool = False


@dataclass(frozen=True, slots=True)
class Chain:
    """Curves end to end, in the direction of the one that was named first."""

    links: tuple[Link, ...]
    closed: bool

    @property
    def names(self) -> tuple[str, ...]:
        """The curves."""
        return tuple(link.name for link in self.links)

    @property
    def directions(self) -> str:
        """A ``+`` or ``-`` for every curve."""
        return "".join("-" if link.backwards else "+" for link in self.links)

    @classmethod
    def of(cls, names: Sequence[str], directions: str, closed: bool) -> Chain:
        """From what a group keeps."""
        links = zip(names, directions, strict=True)
        return cls(tuple(Link(name, sign == "-") for name, sign in links), closed)

    def curves(self, document: Document) -> list[Curve]:
        """The curves as they are now, each in the direction of the sequence."""
        return [travelled(document, link) for link in self.links]


def travelled(document: Document, link: Link) -> Curve:
    """A curve in the direction in which it is passed."""
    entity = document.entities[link.name]
    curve = curve_of(entity.kind, document.numbers_of(link.name).tolist())
    return curve.reversed() if ends(entity) and entity.clockwise != link.backwards else curve


def end_of(document: Document, name: str, backwards: bool, last: bool) -> str:
    """Handle of the point where a curve is entered, or left."""
    first, second = ends(document.entities[name])
    return f"{name}.{second if last != backwards else first}"


def ordered(document: Document, names: Sequence[str]) -> Chain:
    """Curves as one sequence, in the direction of the first of them.

    Raises
    ------
    SequenceError
        a branch, a curve that is not connected, a closed curve beside others
    """
    for name in names:
        if not ends(document.entities[name]):
            if len(names) > 1:
                raise SequenceError(f"{name} is a closed curve, a sequence of its own")
            return Chain((Link(name),), True)
    place: dict[str, int] = {}
    at: list[list[str]] = []
    for members in classes(document, names):
        here = [one for one in members if one.partition(".")[2] in ("p1", "p2", "start", "end")]
        if len(here) > 2:
            raise SequenceError(f"{' '.join(here)} are one point: the sequence branches there")
        for handle in here:
            place[handle] = len(at)
        at.append(here)

    def walk(link: Link) -> list[Link]:
        found: list[Link] = []
        while True:
            left = end_of(document, link.name, link.backwards, True)
            others = [one for one in at[place[left]] if one != left]
            if not others:
                return found
            name = others[0].partition(".")[0]
            link = Link(name, others[0] != end_of(document, name, False, False))
            found.append(link)
            if name == names[0]:
                return found

    forward = walk(Link(names[0]))
    closed = bool(forward) and forward[-1].name == names[0]
    links = [Link(names[0]), *forward]
    if closed:
        links.pop()
    else:
        before = [Link(one.name, not one.backwards) for one in walk(Link(names[0], True))]
        links = [*reversed(before), *links]
    stray = [name for name in names if name not in {link.name for link in links}]
    if stray:
        raise SequenceError(f"{stray[0]} is not connected with {names[0]} end to end")
    return Chain(tuple(links), closed)
